//! Mitsuba 3 scenes (`.xml`): what our own export writes, exactly, and what others write with the common
//! plugins, of version 0.5 and later.
//!
//! Includes, paths, parameters, aliases and references are followed, in any order. Shapes: `ply`, `obj`,
//! `serialized`, `rectangle`, `cube`, `sphere`, `cylinder`, `disk`, `instance` of a `shapegroup`, `merge`. Emitters:
//! `area`, `point`, `spot`, `directional`, `constant`, `envmap`, `sunsky`, `sky`, `sun`. Reflectances: see `bsdf.rs`; colours and textures:
//! see `paint.rs`. Cameras: `perspective` and `thinlens`, each sensor becomes one. Plugins of other types are
//! refused, and each property that is not read is warned of; `plugins.rs` has the table of all.
//! [Jakob et al., Mitsuba 3 documentation, plugin reference]

mod behind;
mod bsdf;
mod colorimetry;
mod elements;
mod glass;
mod lights;
mod mesh_file;
mod metals;
mod motion;
mod oren_nayar;
mod paint;
mod parse;
pub(crate) mod plastics;
mod plugins;
mod references;
mod relief;
mod sensor;
mod serialized;
mod shapes;
mod sky;
mod solar;
mod spectrum;
mod spot;
mod tree;
mod upgrade;
mod wavefront;

use super::shapes::{bytes_of, here_from_mesh, in_mesh, turned_over};
use crate::FileError;
use crate::entry::Table;
use crate::input::{Input, Scope};
use crate::names::{DEFAULT, unique};
use crate::told::Told;
use bsdf::{Reflectance, Reflectances};
use glam::{DAffine3, DVec3, Vec3};
use lights::Emitter;
use paint::{Context, color};
use spectrum::Use;
use std::collections::BTreeSet;
use tree::{Node, Tree};
use unrender_scene::{
    BrdfModel, Glass, Group, Layering, Mesh, Object, Rgb, Scene, Ungrouped, Warnings,
};

/// The model of Mitsuba's own BSDFs.
const PRINCIPLED: BrdfModel = BrdfModel::Principled(Layering::Coupled);

/// Memory of an instance of a shape beside its mesh, bytes.
const SHAPE_BYTES: u64 = 1024;

/// What is read of Mitsuba's scenes.
pub(crate) fn tables() -> Vec<Table> {
    std::iter::once(elements::table()).chain(plugins::tables()).collect()
}

/// Reads the scene at `path` with the files that it names; it is not yet validated: see
/// [`load_scene`](crate::load_scene).
///
/// # Errors
/// If files are missing (one error lists them all) or damaged, if a reference has no target, or if there are plugins
/// that cannot be read.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let fail = |problem: String| FileError::new(input.path, problem);
    let scope = Scope::new(input);
    let tree = parse::read(&scope, input.path).map_err(fail)?;
    let context = Context::new(&scope);
    let mut reader = Reader {
        context: &context,
        reflectances: Reflectances::default(),
        surfaces: Vec::new(),
        scene: Scene::default(),
        microfacets: Vec::new(),
        exact: None,
        told: Told::default(),
        told_of_glass: Told::default(),
        glasses: BTreeSet::new(),
        object_names: BTreeSet::new(),
    };
    reader.scene(&tree).map_err(fail)?;
    scope.complete().map_err(fail)?;
    let scene = reader.finished(&tree);
    let mut warnings = context.warnings.into_inner();
    tree.unread().into_iter().chain(scene.glass_told()).for_each(|told| warnings.push(told));
    Ok((scene, warnings))
}

/// Where the reflectance of a surface comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Source {
    /// A BSDF by its place in the tree.
    Bsdf(usize),
    /// Of shapes without a BSDF: grey.
    Nobody,
    /// Of lamps without one: black.
    Lamp,
}

/// A surface's reflectance and emission before groups have their final names.
struct Surface {
    source: Source,
    name: String,
    reflectance: Reflectance,
    emission: Rgb,
    objects: Vec<Object>,
}

struct Reader<'a> {
    context: &'a Context<'a>,
    reflectances: Reflectances,
    surfaces: Vec<Surface>,
    scene: Scene,
    /// Surfaces with microfacets whose numbers are not known exactly: the name, and whether they
    /// are GGX.
    microfacets: Vec<(String, bool)>,
    /// The model of surfaces that are known exactly, if any of them has a lobe.
    exact: Option<BrdfModel>,
    /// In what groups differ from their BSDFs.
    told: Told,
    /// In what glass differs from its BSDFs.
    told_of_glass: Told,
    /// The places of the BSDFs of glass in the tree.
    glasses: BTreeSet<usize>,
    /// The names of the objects so far.
    object_names: BTreeSet<String>,
}

/// What a BSDF is.
enum Found {
    /// The surface is not there.
    Nothing,
    /// It lets light through.
    Glass(Box<Clear>),
    /// One of [`Reader::surfaces`].
    Surface(usize),
}

/// A BSDF of glass.
struct Clear {
    /// Its place in the tree.
    index: usize,
    /// The name of the material.
    name: String,
    glass: Glass,
    reflectance: Reflectance,
}

impl Reader<'_> {
    fn scene(&mut self, tree: &Tree) -> Result<(), String> {
        let root = tree.node(0);
        let shapes = root.children("shape");
        let used = reachable(tree, shapes.iter().map(|shape| shape.index));
        // Shapes cannot refer to what has no name: they are as if the file did not have it.
        let may_be_used = |node: &Node| node.is_named() || used.contains(&node.index);
        for node in root.children("bsdf").into_iter().filter(may_be_used) {
            match self.bsdf(node, None) {
                Err(problem) if !used.contains(&node.index) => {
                    self.context.warn(format!("{problem}; no shape has it"));
                }
                read => read.map(|_| ())?,
            }
        }
        for node in root.children("sensor") {
            self.scene.cameras.extend(sensor::read(self.context, node)?);
        }
        for node in shapes {
            self.shape(node, (&DAffine3::IDENTITY, None))?;
        }
        // Shapes refer to area emitters at the root.
        for node in root.children("emitter") {
            if node.kind() == "area" && used.contains(&node.index) {
                continue;
            }
            for emitter in lights::read(self.context, node)? {
                self.emitter(node, emitter)?;
            }
        }
        Ok(())
    }

    fn emitter(&mut self, node: Node, emitter: Emitter) -> Result<(), String> {
        match emitter {
            Emitter::Light(light) => self.scene.lights.push(light),
            Emitter::Environment(_) if self.scene.environment.is_some() => {
                return Err(node.fail("there are two environments; leave one of them out"));
            }
            Emitter::Environment(around) => self.scene.environment = Some(around),
        }
        Ok(())
    }

    /// What the BSDF `node` is, which stands in or at `shape`.
    fn bsdf(&mut self, node: Node, shape: Option<Node>) -> Result<Found, String> {
        let source = Source::Bsdf(node.index);
        if let Some(known) = self.surfaces.iter().position(|s| s.source == source) {
            return Ok(Found::Surface(known));
        }
        let mut reflectance = self.reflectances.read(self.context, node)?;
        let name = node.material_name(shape);
        if reflectance.is_nothing {
            return Ok(Found::Nothing);
        }
        if let Some(glass) = reflectance.glass {
            let index = node.index;
            return Ok(Found::Glass(Box::new(Clear { index, name, glass, reflectance })));
        }
        if let Some((material, brdf)) = &node.note().material {
            // Our export lets u grow along the anisotropy direction.
            let texture = reflectance.material.texture.take();
            let is_even = material.alpha_x == material.alpha_y;
            let theta_rad = if is_even || texture.is_some() { material.theta_rad } else { 0.0 };
            reflectance.material =
                unrender_scene::Material { theta_rad, texture, ..material.clone() };
            self.exact = Some(*brdf);
        } else if let Some(model) = reflectance.model.filter(|_| reflectance.material.is_glossy()) {
            self.exact = Some(model);
        } else if reflectance.material.is_glossy() {
            self.microfacets.push((name.clone(), reflectance.is_ggx));
        }
        for doubt in reflectance.doubts(node.note().material.is_some()) {
            self.told.note(doubt, &name);
        }
        Ok(Found::Surface(self.push(source, name, reflectance)))
    }

    fn push(&mut self, source: Source, name: String, reflectance: Reflectance) -> usize {
        let (emission, objects) = (Rgb::ZERO, Vec::new());
        self.surfaces.push(Surface { source, name, reflectance, emission, objects });
        self.surfaces.len() - 1
    }

    /// The surface of shapes that have no BSDF.
    fn without_bsdf(&mut self, source: Source) -> usize {
        let found = self.surfaces.iter().position(|s| s.source == source);
        let (name, rho_d) = if source == Source::Lamp { ("lamp", 0.0) } else { (DEFAULT, 0.5) };
        found.unwrap_or_else(|| {
            self.push(source, name.to_owned(), Reflectance::diffuse(Rgb::splat(rho_d)))
        })
    }

    /// The surface like `like` that emits `emission`.
    fn emitting(&mut self, like: usize, emission: Rgb) -> usize {
        if self.surfaces[like].objects.is_empty() {
            self.surfaces[like].emission = emission;
            return like;
        }
        let source = self.surfaces[like].source;
        let found = self.surfaces.iter().position(|s| s.source == source && s.emission == emission);
        found.unwrap_or_else(|| {
            let Surface { name, reflectance, .. } = &self.surfaces[like];
            let (name, reflectance) = (name.clone(), reflectance.clone());
            let new = self.push(source, name, reflectance);
            self.surfaces[new].emission = emission;
            new
        })
    }

    /// Adds the shape `node`, with `around` behind its own transform; `instance` is that which shows it, if it is in a
    /// group of shapes.
    fn shape(
        &mut self,
        node: Node,
        (around, instance): (&DAffine3, Option<Node>),
    ) -> Result<(), String> {
        let scope = self.context.scope;
        scope.charge(SHAPE_BYTES).map_err(|problem| node.fail(problem))?;
        match node.kind() {
            // Only its instances are seen.
            "shapegroup" => return Ok(()),
            "merge" => {
                let mut inside = node.children("shape").into_iter();
                return inside.try_for_each(|shape| self.shape(shape, (around, instance)));
            }
            "instance" => {
                let world = *around * node.motion("to_world")?;
                let group = node.child("shape")?.filter(|group| group.kind() == "shapegroup");
                let group =
                    group.ok_or_else(|| node.fail("an instance has no shapegroup in it"))?;
                let mut inside = group.children("shape").into_iter();
                return inside.try_for_each(|shape| self.shape(shape, (&world, Some(node))));
            }
            _ => {}
        }
        let world = *around * node.motion("to_world")?;
        let emission = self.emission(node)?;
        let bsdf = node.child("bsdf")?.map(|bsdf| self.bsdf(bsdf, Some(node))).transpose()?;
        let surface = match (bsdf, emission) {
            (Some(Found::Surface(surface)), _) => surface,
            (Some(Found::Nothing), None) => {
                node.pass_all();
                return Ok(());
            }
            (Some(Found::Glass(clear)), None) => return self.glass(node, &world, *clear),
            (None, None) => self.without_bsdf(Source::Nobody),
            (_, Some(_)) => self.without_bsdf(Source::Lamp),
        };
        let Surface { reflectance, name, .. } = &self.surfaces[surface];
        let (to_uv, wants_uvs) = (reflectance.to_uv, reflectance.wants_uvs());
        let mut relief = reflectance.relief.clone();
        if emission.is_some_and(|emission| emission != Rgb::ZERO) && relief.holes.take().is_some() {
            self.told.note("it is a lamp with holes, which was taken as one without", name);
        }
        let Some(mut mesh) = self.mesh(node, &world, wants_uvs)? else { return Ok(()) };
        let charged =
            scope.charge(bytes_of(&mesh)).and_then(|()| relief.lay(&mut mesh, to_uv, scope));
        charged.map_err(|problem| node.fail(problem))?;
        let surface = self.emitting(surface, emission.unwrap_or(Rgb::ZERO));
        let name = self.object_name(node, instance);
        self.surfaces[surface].objects.push(Object { name, group: 0, mesh });
        Ok(())
    }

    /// Adds the shape `node` of glass, `world` behind its own transform.
    fn glass(&mut self, node: Node, world: &DAffine3, clear: Clear) -> Result<(), String> {
        let Clear { index, name, glass, reflectance } = clear;
        if self.glasses.insert(index) {
            reflectance.doubts(false).for_each(|doubt| self.told_of_glass.note(doubt, &name));
        }
        let scope = self.context.scope;
        let Some(mut mesh) = self.mesh(node, world, reflectance.wants_uvs())? else {
            return Ok(());
        };
        let charged = scope.charge(bytes_of(&mesh));
        let laid =
            charged.and_then(|()| reflectance.relief.lay(&mut mesh, reflectance.to_uv, scope));
        laid.map_err(|problem| node.fail(problem))?;
        let glass = Some(glass::on(glass, &mesh));
        self.scene.ungrouped.push(Ungrouped { material: name, mesh, glass });
        Ok(())
    }

    /// The name of the object of a shape. What instances repeat, or shapes without names of one file, is told apart
    /// by the line: objects of one name can only be removed together.
    fn object_name(&mut self, shape: Node, instance: Option<Node>) -> String {
        let name = shape.shape_name();
        if self.object_names.insert(name.clone()) {
            return name;
        }
        match instance {
            Some(instance) => format!("{name} ({})", instance.shape_name()),
            None if shape.is_named() || shape.note().name.is_some() => name,
            None => format!("{name} ({})", shape.at_line()),
        }
    }

    /// The radiance of a shape that is a lamp.
    fn emission(&self, node: Node) -> Result<Option<Rgb>, String> {
        let Some(emitter) = node.child("emitter")? else { return Ok(None) };
        if emitter.kind() != "area" {
            return Err(emitter.refused("emitters of shapes are of type \"area\""));
        }
        color(self.context, emitter, "radiance", Use::Emission, 1.0).map(Some)
    }

    /// The mesh of the shape `node`; none if its file is missing.
    fn mesh(&self, node: Node, world: &DAffine3, wants_uvs: bool) -> Result<Option<Mesh>, String> {
        let check_round = |world: &DAffine3, axes: [DVec3; 2]| {
            if shapes::stretches(world, axes) {
                let kind = node.kind();
                let what =
                    format!("a {kind} is stretched, which Mitsuba takes for a uniform scale");
                self.context.warn(node.fail(what));
            }
        };
        let origin = self.context.scope.origin();
        // Where the zero of the scene lies in the shape's own coordinates: those of files and of points may be
        // far from their zero, the others are near it.
        let zero = in_mesh(origin, world);
        let here = here_from_mesh(world, zero, origin);
        let here_from_unit = here_from_mesh(world, DVec3::ZERO, origin);
        let point = |name, default: DVec3| -> Result<Vec3, String> {
            Ok((node.point(name)?.unwrap_or(default) - zero).as_vec3())
        };
        let mesh = match node.kind() {
            "ply" | "obj" | "serialized" => {
                match mesh_file::read(self.context, node, (&here, zero), wants_uvs)? {
                    Some(mesh) => mesh,
                    None => return Ok(None),
                }
            }
            "rectangle" => shapes::moved(shapes::rectangle(), &here_from_unit),
            "cube" => shapes::moved(shapes::cube(), &here_from_unit),
            "disk" => shapes::moved(shapes::disk(), &here_from_unit),
            "cylinder" => {
                let (p0, p1) = (point("p0", DVec3::ZERO)?, point("p1", DVec3::Z)?);
                let own = shapes::along(p0, p1, node.number("radius", 1.0)?);
                let world = here * own.map_err(|problem| node.fail(problem))?;
                check_round(&world, [DVec3::X, DVec3::Y]);
                shapes::moved(shapes::cylinder(), &world)
            }
            "sphere" => {
                let centre = point("center", DVec3::ZERO)?.as_dvec3();
                let radius = DVec3::splat(node.number("radius", 1.0)?.into());
                let own = DAffine3::from_translation(centre) * DAffine3::from_scale(radius);
                let world = here * own;
                check_round(&world, [DVec3::X, DVec3::Z]);
                shapes::sphere(&world)
            }
            _ => {
                let why = "supported are ply, obj, serialized, rectangle, cube, sphere, cylinder, \
                           disk, instance and merge";
                return Err(node.refused(why));
            }
        };
        Ok(Some(if node.flag("flip_normals", false)? { turned_over(mesh) } else { mesh }))
    }

    /// Chooses the model: the one that is exact for some; else principled; where the caller wants a model of free
    /// reflectances, GGX if all microfacets are, and Ward's with a warning for those of GGX if not.
    fn choose_lobe(&mut self) {
        let wanted = self.context.scope.brdf().unwrap_or(PRINCIPLED);
        if let Some(model) = self.exact {
            self.scene.brdf = model;
        } else if wanted.is_principled() {
            self.scene.brdf = wanted;
        } else if !self.microfacets.is_empty() && self.microfacets.iter().all(|(_, is_ggx)| *is_ggx)
        {
            self.scene.brdf = BrdfModel::Ggx;
            return;
        }
        if self.scene.brdf.is_principled() {
            return;
        }
        let is_coated = |s: &&mut Surface| !s.reflectance.material.reflectance.is_free();
        for surface in self.surfaces.iter_mut().filter(is_coated) {
            let material = &mut surface.reflectance.material;
            *material = material.clone().freed();
            let doubt = "it was taken to reflect at all angles as at normal incidence, as the brdf is not principled";
            self.told.note(doubt, &surface.name);
        }
        for (name, _) in self.microfacets.iter().filter(|(_, is_ggx)| *is_ggx) {
            let doubt = "the roughness of its GGX was taken as Ward's, as other groups are not GGX";
            self.told.note(doubt, name);
        }
    }

    /// The scene with its groups, each with a name of its own.
    fn finished(&mut self, tree: &Tree) -> Scene {
        self.choose_lobe();
        self.told.sentences().for_each(|sentence| self.context.warn(sentence));
        let of_glass = self.told_of_glass.sentences_of("material");
        of_glass.for_each(|sentence| self.context.warn(sentence));
        // BSDFs that stand in others or have no name are no groups, unless shapes have them, too.
        let others = tree.plugins.iter().enumerate().filter(|(_, plugin)| plugin.tag == "bsdf");
        let inner: BTreeSet<usize> = others.flat_map(|(i, _)| tree.node(i).inside()).collect();
        self.surfaces.retain(|surface| match surface.source {
            Source::Bsdf(index) => {
                let is_named = tree.node(index).is_named();
                !surface.objects.is_empty() || is_named && !inner.contains(&index)
            }
            _ => true,
        });
        let wanted: Vec<String> = self.surfaces.iter().map(|s| s.name.clone()).collect();
        let names = unique(&wanted, &mut self.context.warnings.borrow_mut());
        let mut scene = std::mem::take(&mut self.scene);
        let mut one_sided = Vec::new();
        for (group, (surface, name)) in self.surfaces.drain(..).zip(names).enumerate() {
            let material = surface.reflectance.material;
            let reflects = (material.rho_d + material.rho_s).max_element() > 0.0;
            one_sided.push(reflects && !surface.reflectance.is_two_sided);
            scene.groups.push(Group { name, material, emission: surface.emission });
            let objects = surface.objects.into_iter();
            scene.objects.extend(objects.map(|object| Object { group, ..object }));
        }
        let mut behind = Told::default();
        for (group, camera) in behind::seen(&scene, &one_sided) {
            let doubt = format!(
                "camera \"{camera}\" sees some of it from behind, where it is black in Mitsuba (its BSDF is in no \
                 twosided); here it reflects from behind, too"
            );
            behind.note(&doubt, &scene.groups[group].name);
        }
        behind.sentences().for_each(|sentence| self.context.warn(sentence));
        scene
    }
}

/// The plugins that are in `starts` or in what is in them.
fn reachable(tree: &Tree, starts: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut open: Vec<usize> = starts.collect();
    while let Some(index) = open.pop() {
        if found.insert(index) {
            open.extend(tree.node(index).inside());
        }
    }
    found
}
