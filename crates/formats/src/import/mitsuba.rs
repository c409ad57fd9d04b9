//! Mitsuba 3 scenes (`.xml`): what our own export writes, exactly, and the common plugins.
//!
//! Shapes: `ply`, `obj`, `rectangle`, `cube`, `sphere`, `cylinder`, `disk`. Emitters: `area`, `point`, `spot`,
//! `directional`. Reflectances: see `reflectance.rs`. The camera is `perspective`. Everything else is
//! left out with a warning. [Jakob et al., Mitsuba 3 documentation, plugin reference]

mod lights;
mod properties;
mod reflectance;

use super::{ply, shapes};
use crate::input::{Input, Scope};
use crate::names::unique;
use crate::record::Note;
use crate::{FileError, obj};
use glam::{Affine3A, DVec3, Mat3, Vec2, Vec3};
use properties::Element;
use reflectance::{Place, Reflectance};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::path::Path;
use unrender_scene::{BrdfModel, Camera, Group, Lens, Mesh, Object, Rgb, Scene, Warnings};

/// The tree of an XML text takes at most so many times its memory: `<a/>` becomes a node of 80 bytes.
const TEXT_TO_TREE: u64 = 32;

/// Elements lie in one another at most so deep. Scenes have up to ten; each level takes a kilobyte of
/// the stack, which has 2 MiB in threads.
const DEPTH: u32 = 100;

/// Refuses elements that lie too deep, as they are read by recursion.
fn check_depth(document: &Document) -> Result<(), String> {
    let mut depths: Vec<u32> = Vec::new();
    for node in document.descendants() {
        let parent = node.parent().and_then(|parent| depths.get(parent.id().get_usize()));
        let depth = parent.map_or(0, |depth| depth + 1);
        if depth > DEPTH {
            return Err(format!("has elements within elements, {DEPTH} deep and deeper"));
        }
        depths.push(depth);
    }
    Ok(())
}

/// Reads the scene at `path` with the files that it names; it is not yet validated: see
/// [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or damaged, or if something refers to what is not there.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let fail = |problem: String| FileError::new(input.path, problem);
    let scope = Scope::new(input);
    let text = scope.text(input.path).map_err(fail)?;
    scope.charge(TEXT_TO_TREE * text.len() as u64).map_err(fail)?;
    let document = Document::parse(&text).map_err(|error| fail(format!("is no XML: {error}")))?;
    check_depth(&document).map_err(fail)?;
    let folder = input.path.parent().unwrap_or(Path::new(""));
    let mut reader = Reader {
        place: (&scope, folder),
        surfaces: Vec::new(),
        scene: Scene::default(),
        warnings: Warnings::default(),
        microfacets: Vec::new(),
    };
    let root = document.root_element();
    reader.scene(root, &defaults(root)).map_err(fail)?;
    Ok((reader.finished(), reader.warnings))
}

/// A surface's reflectance and emission before groups have their final names.
struct Surface {
    /// The `id` of its BSDF; empty for one that stands in its shape.
    id: String,
    name: String,
    reflectance: Reflectance,
    emission: Rgb,
    objects: Vec<Object>,
}

struct Reader<'a> {
    place: Place<'a>,
    surfaces: Vec<Surface>,
    scene: Scene,
    warnings: Warnings,
    /// Surfaces with microfacets that are not known exactly: the name, and whether they are GGX.
    microfacets: Vec<(String, bool)>,
}

/// The `<default>` values of the document.
fn defaults(root: Node) -> BTreeMap<String, String> {
    let defaults = root.children().filter(|n| n.has_tag_name("default"));
    let value = |n: Node, key: &str| n.attribute(key).unwrap_or_default().to_owned();
    defaults.map(|n| (value(n, "name"), value(n, "value"))).collect()
}

impl Reader<'_> {
    fn scene(&mut self, root: Node, defaults: &BTreeMap<String, String>) -> Result<(), String> {
        let mut note = Note::default();
        for node in root.children() {
            if node.is_comment() {
                let origin = self.place.0.origin();
                let parsed = node.text().and_then(|text| Note::parse(text, origin));
                note = parsed.unwrap_or_default();
                continue;
            }
            if !node.is_element() {
                continue;
            }
            let placed = |problem| {
                let line = node.document().text_pos_at(node.range().start).row;
                format!("line {line}: {problem}")
            };
            self.element(&Element::new(node, defaults), &note).map_err(placed)?;
            note = Note::default();
        }
        Ok(())
    }

    fn element(&mut self, element: &Element, note: &Note) -> Result<(), String> {
        match element.tag() {
            "bsdf" => self.bsdf(element, note).map(|_| ()),
            "shape" => self.shape(element, note),
            "sensor" => self.sensor(element, note),
            "emitter" => self.emitter(element, note),
            "default" | "integrator" => Ok(()),
            other => {
                self.warnings.push(format!("<{other}> was left out"));
                Ok(())
            }
        }
    }

    fn bsdf(&mut self, element: &Element, note: &Note) -> Result<usize, String> {
        let id = element.attribute("id");
        let number = self.surfaces.len();
        let name = note.name.clone().filter(|n| !n.is_empty()).unwrap_or_else(|| match &id[..] {
            "" => format!("material {number}"),
            id => id.to_owned(),
        });
        let mut reflectance = reflectance::read(element, self.place, &name, &mut self.warnings)?;
        if let Some((material, brdf)) = &note.material {
            // Our export lets u grow along the anisotropy direction.
            let theta_rad =
                if material.alpha_x == material.alpha_y { material.theta_rad } else { 0.0 };
            let texture = reflectance.material.texture.take();
            let theta_rad = if texture.is_some() { material.theta_rad } else { theta_rad };
            reflectance.material =
                unrender_scene::Material { theta_rad, texture, ..material.clone() };
            self.scene.brdf = *brdf;
        } else if reflectance.material.is_glossy() {
            self.microfacets.push((name.clone(), reflectance.is_ggx));
        }
        reflectance.warn(&name, note.material.is_some(), &mut self.warnings);
        self.surfaces.push(Surface {
            id,
            name,
            reflectance,
            emission: Rgb::ZERO,
            objects: Vec::new(),
        });
        Ok(number)
    }

    fn shape(&mut self, element: &Element, note: &Note) -> Result<(), String> {
        let kind = element.attribute("type");
        let Some(mesh) = self.mesh(element, &kind)? else {
            self.warnings.push(format!("a shape of type \"{kind}\" was left out"));
            return Ok(());
        };
        let surface = match (element.child("bsdf"), element.reference()) {
            (Some(inside), _) => self.bsdf(&inside, &Note::default())?,
            (None, Some(id)) => self
                .surfaces
                .iter()
                .position(|s| s.id == id)
                .ok_or_else(|| format!("a shape refers to \"{id}\", which is not there"))?,
            // Mitsuba's own reflectance of a shape that names none.
            (None, None) => self.grey(),
        };
        let emission = match element.child("emitter") {
            Some(emitter) if emitter.attribute("type") == "area" => {
                emitter.rgb("radiance", Rgb::ONE)?
            }
            _ => Rgb::ZERO,
        };
        let surface = self.emitting(surface, emission);
        let name = note.name.clone().unwrap_or_else(|| element.attribute("id"));
        self.surfaces[surface].objects.push(Object { name, group: 0, mesh });
        Ok(())
    }

    fn grey(&mut self) -> usize {
        let found = self.surfaces.iter().position(|s| s.id == "default");
        found.unwrap_or_else(|| {
            let reflectance = Reflectance::diffuse(Rgb::splat(0.5));
            let (id, name) = ("default".to_owned(), "default".to_owned());
            let (emission, objects) = (Rgb::ZERO, Vec::new());
            self.surfaces.push(Surface { id, name, reflectance, emission, objects });
            self.surfaces.len() - 1
        })
    }

    /// The surface like `like` that emits `emission`.
    fn emitting(&mut self, like: usize, emission: Rgb) -> usize {
        let unused = self.surfaces[like].objects.is_empty();
        if unused || self.surfaces[like].emission == emission {
            self.surfaces[like].emission = emission;
            return like;
        }
        let Surface { name, reflectance, .. } = &self.surfaces[like];
        let (name, reflectance) = (name.clone(), reflectance.clone());
        let (id, objects) = (String::new(), Vec::new());
        self.surfaces.push(Surface { id, name, reflectance, emission, objects });
        self.surfaces.len() - 1
    }

    fn mesh(&mut self, element: &Element, kind: &str) -> Result<Option<Mesh>, String> {
        let to_world = element.to_world()?;
        let origin = self.place.0.origin();
        // Where the zero of the scene lies in the shape's own coordinates: those of files and of points may be
        // far from their zero, those of the others are at it.
        let zero = shapes::in_mesh(origin, &to_world);
        let zero = if matches!(kind, "disk" | "rectangle" | "cube") { DVec3::ZERO } else { zero };
        let point = |name, default| (element.point(name).unwrap_or(default) - zero).as_vec3();
        let mesh = match kind {
            "ply" | "obj" => self.file(element, kind, zero)?,
            "disk" => shapes::ring(Vec3::ZERO, Vec3::Z, [0.0, 1.0]),
            "cylinder" => {
                let ends = [point("p0", DVec3::ZERO), point("p1", DVec3::Z)];
                shapes::frustum(ends, [element.float("radius", 1.0)?; 2])
            }
            "rectangle" => shapes::rectangle(),
            "cube" => shapes::cube(),
            "sphere" => Mesh::sphere(point("center", DVec3::ZERO), element.float("radius", 1.0)?),
            _ => return Ok(None),
        };
        self.place.0.charge(shapes::bytes_of(&mesh))?;
        let mesh = shapes::moved(mesh, &shapes::here_from_mesh(&to_world, zero, origin));
        let flips = element.value("flip_normals").as_deref() == Some("true");
        Ok(Some(if flips { shapes::turned_over(mesh) } else { mesh }))
    }

    /// The mesh of a file, counted from `zero`.
    fn file(&mut self, element: &Element, kind: &str, zero: DVec3) -> Result<Mesh, String> {
        let name = element.value("filename").ok_or("a shape has no filename")?;
        let (scope, folder) = self.place;
        let within = |problem: String| format!("\"{name}\" {problem}");
        let path = scope.beside(folder, &name).map_err(within)?;
        // Mitsuba counts v from the top of a picture, as we do; OBJ counts from the bottom, so that
        // its reader there (and ours) turns v over, if it is not told otherwise.
        let flip = element.value("flip_tex_coords");
        let (mut mesh, flips) = if kind == "obj" {
            let (scene, _) = obj::read_in(scope, &path, zero).map_err(|error| error.to_string())?;
            let mesh = shapes::joined(scene.objects.into_iter().map(|o| o.mesh));
            (mesh, flip.as_deref() == Some("false"))
        } else {
            let bytes = scope.read(&path).map_err(within)?;
            (ply::mesh(scope, &bytes, zero).map_err(within)?, flip.as_deref() == Some("true"))
        };
        if flips {
            mesh.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(uv.x, 1.0 - uv.y));
        }
        Ok(mesh)
    }

    /// The camera. Mitsuba's looks along its own +z, with +x to the left.
    fn sensor(&mut self, element: &Element, note: &Note) -> Result<(), String> {
        let kind = element.attribute("type");
        if kind != "perspective" {
            self.warnings.push(format!("a sensor of type \"{kind}\" was left out"));
            return Ok(());
        }
        let film = element.child("film");
        let side = |name: &str, default| {
            film.as_ref().map_or(Ok(default), |film| film.float(name, default))
        };
        let aspect = side("width", 768.0)? / side("height", 576.0)?.max(1.0);
        let half = (0.5 * element.float("fov", 45.0)?.to_radians()).tan();
        let axis = element.value("fov_axis").unwrap_or_else(|| "x".into());
        let half_height = match axis.as_str() {
            "y" => half,
            "smaller" => half / aspect.min(1.0),
            "larger" => half / aspect.max(1.0),
            "diagonal" => half / (1.0 + aspect * aspect).sqrt(),
            _ => half / aspect,
        };
        let world = element.to_world()?;
        let axes = world.matrix3.as_mat3();
        let eye = (world.translation - self.place.0.origin()).as_vec3();
        let [left, up, ahead] = [axes.x_axis, axes.y_axis, axes.z_axis].map(Vec3::normalize);
        let axes = Mat3::from_cols(-left, up, -ahead);
        let offset = |axis: &str| element.float(&format!("principal_point_offset_{axis}"), 0.0);
        let principal_point = [-offset("x")? * aspect, -offset("y")?];
        self.scene.cameras.push(Camera {
            name: note.name.clone().unwrap_or_else(|| "camera".into()),
            world_from_camera: Affine3A::from_mat3_translation(axes, eye),
            fov_y_rad: 2.0 * half_height.atan(),
            aspect: Some(aspect),
            lens: Lens { principal_point, ..Lens::default() },
        });
        Ok(())
    }

    fn emitter(&mut self, element: &Element, note: &Note) -> Result<(), String> {
        match lights::read(element, note, self.place.0.origin(), &mut self.warnings)? {
            Some(light) => self.scene.lights.push(light),
            None => self
                .warnings
                .push(format!("an emitter of type \"{}\" was left out", element.attribute("type"))),
        }
        Ok(())
    }

    /// GGX, if all microfacets are; else Ward's, and those of GGX are doubtful.
    fn choose_lobe(&mut self) {
        if !self.microfacets.is_empty() && self.microfacets.iter().all(|(_, is_ggx)| *is_ggx) {
            self.scene.brdf = BrdfModel::Ggx;
            return;
        }
        for (name, _) in self.microfacets.iter().filter(|(_, is_ggx)| *is_ggx) {
            self.warnings.push(format!(
                "group \"{name}\": the roughness of its GGX was taken as Ward's, as others are no GGX"
            ));
        }
    }

    /// The scene with its groups, each with a name of its own.
    fn finished(&mut self) -> Scene {
        self.choose_lobe();
        let wanted: Vec<String> = self.surfaces.iter().map(|s| s.name.clone()).collect();
        let names = unique(&wanted, &mut self.warnings);
        let mut scene = std::mem::take(&mut self.scene);
        for (group, (surface, name)) in self.surfaces.drain(..).zip(names).enumerate() {
            let material = surface.reflectance.material;
            scene.groups.push(Group { name, material, emission: surface.emission });
            let objects = surface.objects.into_iter();
            scene.objects.extend(objects.map(|object| Object { group, ..object }));
        }
        scene
    }
}
