//! Radiance scenes (`.rad`): what our own export writes, exactly, and the common primitives.
//!
//! Surfaces: `polygon`, what is round (`sphere`, `cylinder`, `cone`, `ring` and those inside out), and
//! `mesh` where the OBJ lies beside it that it was compiled from.
//! Materials: see `materials.rs`. Lights: surfaces of `light`, `glow` and `illum` shine; a `source`
//! is a directional light. The camera is that of `view.vf`, or of the scene's name and `.vf`, if there
//! is such a file. Everything else is left out with a warning.
//! ["The RADIANCE 5.4 Synthetic Imaging System" (reference manual), section 2.1]

mod materials;
mod primitives;
mod view;

use super::shapes;
use crate::input::{Input, Scope};
use crate::names::unique;
use crate::record::Note;
use crate::{FileError, obj, polygon};
use glam::Vec3;
use materials::Materials;
use primitives::Primitive;
use std::f32::consts::PI;
use std::path::Path;
use unrender_scene::{Group, Light, LightKind, Mesh, Object, Scene, Warnings};

/// Reads the scene at `path` with the files that it names; it is not yet validated: see
/// [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or damaged, or if something is made of what is not there.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let path = input.path;
    let fail = |problem: String| FileError::new(path, problem);
    let scope = Scope::new(input);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut warnings = Warnings::default();
    let primitives = primitives::read(&scope, path, &mut warnings).map_err(fail)?;
    let mut reader = Reader {
        place: (&scope, folder),
        materials: Materials::default(),
        objects: Vec::new(),
        lights: Vec::new(),
        warnings,
    };
    for (primitive, note) in &primitives {
        let placed = |problem| fail(format!("{}: {problem}", primitive.place));
        reader.primitive(primitive, note.as_ref()).map_err(placed)?;
    }
    let mut scene = reader.finished();
    scene.cameras.extend(view::beside(&scope, path).map_err(fail)?);
    Ok((scene, reader.warnings))
}

/// An object in the making: what has one name and one material.
struct ObjectMeshes {
    name: String,
    material: usize,
    meshes: Vec<Mesh>,
}

struct Reader<'a> {
    /// What bounds the reading of the scene, and its folder.
    place: (&'a Scope, &'a Path),
    materials: Materials,
    objects: Vec<ObjectMeshes>,
    lights: Vec<Light>,
    warnings: Warnings,
}

impl Reader<'_> {
    fn primitive(&mut self, primitive: &Primitive, note: Option<&Note>) -> Result<(), String> {
        if let Some(light) = note.and_then(|note| note.light.clone()) {
            // What follows only says the same in Radiance's words.
            if note.is_some_and(|note| note.is_first) {
                self.lights.push(light);
            }
            return Ok(());
        }
        match primitive.kind.as_str() {
            "polygon" => {
                // The backs of mirrors are our own doing.
                if !primitive.id.ends_with(".back") {
                    self.surface(primitive, note, polygon(primitive)?)?;
                }
            }
            "sphere" | "bubble" | "cylinder" | "tube" | "cone" | "cup" | "ring" => {
                self.surface(primitive, note, round(primitive)?)?;
            }
            "mesh" => self.mesh(primitive, note)?,
            "source" => self.distant(primitive)?,
            "instance" => {
                let id = &primitive.id;
                self.warnings.push(format!("the instance \"{id}\" was left out"));
            }
            _ => self.materials.add(primitive, note, self.place, &mut self.warnings)?,
        }
        Ok(())
    }

    fn surface(&mut self, p: &Primitive, note: Option<&Note>, mesh: Mesh) -> Result<(), String> {
        self.place.0.charge(shapes::bytes_of(&mesh))?;
        let material = self.materials.find(&p.modifier)?;
        let name = note.and_then(|note| note.name.clone()).unwrap_or_else(|| p.id.clone());
        let starts = note.is_none_or(|note| note.is_first);
        match self
            .objects
            .last_mut()
            .filter(|o| !starts && o.name == name && o.material == material)
        {
            Some(part) => part.meshes.push(mesh),
            None => self.objects.push(ObjectMeshes { name, material, meshes: vec![mesh] }),
        }
        Ok(())
    }

    /// A compiled mesh, by the OBJ that it comes from.
    fn mesh(&mut self, primitive: &Primitive, note: Option<&Note>) -> Result<(), String> {
        let compiled = primitive.strings.first().ok_or("a mesh names no file")?;
        let (scope, folder) = self.place;
        let source = Path::new(compiled).with_extension("obj");
        if !folder.join(&source).exists() {
            let id = &primitive.id;
            self.warnings.push(format!(
                "the mesh \"{id}\" was left out: there is no {} beside it",
                folder.join(source).display()
            ));
            return Ok(());
        }
        let named = |problem: String| format!("{} {problem}", source.display());
        let source = scope.beside(folder, &source.to_string_lossy()).map_err(named)?;
        let text = scope.text(&source).map_err(named)?;
        // Of several materials the first: ours differ in the anisotropy direction only.
        let named = text.lines().find_map(|line| line.strip_prefix("usemtl "));
        let modifier = match (primitive.modifier.as_str(), named) {
            ("void", Some(name)) => name.trim().to_owned(),
            (modifier, _) => modifier.to_owned(),
        };
        let (scene, _) =
            obj::read_in(scope, &source, scope.origin()).map_err(|error| error.to_string())?;
        let mesh = shapes::joined(scene.objects.into_iter().map(|object| object.mesh));
        self.surface(&Primitive { modifier, ..primitive.clone() }, note, mesh)
    }

    /// A disk infinitely far away, as a direction.
    fn distant(&mut self, primitive: &Primitive) -> Result<(), String> {
        let [x, y, z, angle] = primitive.reals()?;
        let material = self.materials.find(&primitive.modifier)?;
        let sin = (0.5 * angle.to_radians()).sin();
        let irradiance = self.materials.emission(material) * PI * sin * sin;
        if angle > 5.0 {
            let id = &primitive.id;
            self.warnings.push(format!(
                "the source \"{id}\", {angle} degrees across, was taken as a directional light"
            ));
        }
        let direction = -Vec3::new(x, y, z).normalize_or(Vec3::Y);
        let kind = LightKind::Directional { direction, irradiance };
        self.lights.push(Light { name: primitive.id.clone(), kind });
        Ok(())
    }

    /// The scene, with the groups that emit or that an object has, each with a name of its own.
    fn finished(&mut self) -> Scene {
        let mut scene = Scene { lights: std::mem::take(&mut self.lights), ..Scene::default() };
        let groups = self.materials.groups(self.objects.iter().map(|o| o.material));
        let wanted: Vec<String> = groups.iter().map(|(_, group)| group.name.clone()).collect();
        let names = unique(&wanted, &mut self.warnings);
        for part in self.objects.drain(..) {
            let group = groups.iter().position(|(index, _)| *index == part.material).unwrap_or(0);
            let mesh = shapes::joined(part.meshes.into_iter());
            scene.objects.push(Object { name: part.name, group, mesh });
        }
        scene.brdf = self.materials.brdf();
        scene.groups = groups
            .into_iter()
            .zip(names)
            .map(|((_, group), name)| Group { name, ..group })
            .collect();
        scene
    }
}

/// What is round, as a mesh.
fn round(primitive: &Primitive) -> Result<Mesh, String> {
    let ends = |n: &[f32]| [Vec3::from_slice(&n[..3]), Vec3::from_slice(&n[3..6])];
    let kind = primitive.kind.as_str();
    let mesh = match kind {
        "sphere" | "bubble" => {
            let [x, y, z, radius] = primitive.reals()?;
            Mesh::sphere(Vec3::new(x, y, z), radius)
        }
        "cylinder" | "tube" => {
            let reals: [f32; 7] = primitive.reals()?;
            shapes::frustum(ends(&reals), [reals[6]; 2])
        }
        _ => {
            let reals: [f32; 8] = primitive.reals()?;
            let ([from, to], radii) = (ends(&reals), [reals[6], reals[7]]);
            if kind == "ring" {
                shapes::ring(from, to, radii)
            } else {
                shapes::frustum([from, to], radii)
            }
        }
    };
    let is_inside_out = matches!(kind, "bubble" | "tube" | "cup");
    Ok(if is_inside_out { shapes::turned_over(mesh) } else { mesh })
}

/// A polygon, convex or not, as triangles.
fn polygon(primitive: &Primitive) -> Result<Mesh, String> {
    let corners: Vec<Vec3> = primitive.reals.chunks_exact(3).map(Vec3::from_slice).collect();
    if corners.len() < 3 || !primitive.reals.len().is_multiple_of(3) {
        return Err(format!("the polygon \"{}\" has no three corners", primitive.id));
    }
    let all: Vec<u32> = (0..corners.len() as u32).collect();
    let mut triangles = Vec::new();
    polygon::split(&all, |&i| corners[i as usize], &mut triangles)
        .map_err(|problem| format!("\"{}\" {problem}", primitive.id))?;
    Ok(Mesh::flat(&corners, &[], &triangles))
}
