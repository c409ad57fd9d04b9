//! The file that a scene came from, in which materials and lights are what the scene says.

use super::Problem;
use super::glb::Glb;
use super::graph::placed_nodes;
use super::names::group_names;
use super::source::{Source, get};
use super::ward::object;
use super::{lights, material, place, profiles, units};
use crate::{FileError, Input, group_detail};
use serde_json::{Value, json};
use unrender_scene::{Camera, Rgb, Scene, Warnings};

/// The bytes of a `.glb` with everything that is in the glTF file `source` (hierarchy, names,
/// extras, animations), in which every material that is a group of `scene` gets that group's
/// reflectance and emission, and the lights of `scene` are as bright as they are there, in
/// the units of the file. `added`, whose positions count from the origin of `scene`, are put into its
/// default scene, if it has one; cameras of the same names are replaced. Buffers and pictures beside the file are embedded.
///
/// # Errors
/// If `source` cannot be read, or if the result would be larger than 4 GiB.
pub fn assign_materials<'a>(
    source: impl Into<Input<'a>>,
    scene: &Scene,
    added: &[Camera],
) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    let fail = |problem| FileError::new(source.path, problem);
    let opened = Source::open(source).map_err(fail)?;
    with_materials(&opened, scene, added).map_err(fail)
}

fn with_materials(source: &Source, scene: &Scene, added: &[Camera]) -> Result<Vec<u8>, Problem> {
    let mut glb = Glb::embedding(source);
    let names = group_names(&source.document, &mut Warnings::default());
    if let Some(name) = names.last().filter(|name| scene.group_index(name).is_some()) {
        name_the_nameless(&mut glb, name);
    }
    let count = glb.root["materials"].as_array().map_or(0, Vec::len);
    for (index, name) in names.iter().enumerate().take(count) {
        let Some(group) = scene.group_index(name) else { continue };
        let material = &scene.groups[group].material;
        let coverage = group_detail::of_group(scene, group).coverage;
        let mut json = glb.root["materials"][index].take();
        glb.paint(&mut json, (material, material), scene.brdf, coverage.as_deref())?;
        let emission = scene.groups[group].emission;
        // A group without a material in the file emits nothing there.
        let in_file = source.document.materials.get(index);
        if in_file.map_or(Some(Rgb::ZERO), material::emission) != Some(emission) {
            material::set_emission(&mut json, emission);
        }
        glb.root["materials"][index] = json;
    }
    assign_lights(&mut glb, source, scene)?;
    for camera in added {
        place::put(&mut glb, source, camera, scene.origin)?;
    }
    glb.finish()
}

/// Makes the lights in `glb` as bright as those of `scene`, which was read from `source`, in the
/// file's own units.
fn assign_lights(glb: &mut Glb, source: &Source, scene: &Scene) -> Result<(), Problem> {
    let document = &source.document;
    if source.light_units != units::of(&document.asset, None) {
        units::note(&mut glb.root, source.light_units);
    }
    let mut wanted = scene.lights.iter();
    for placed in placed_nodes(document)? {
        let extensions = &get(&document.nodes, placed.node, "node")?.extensions;
        if let Some(punctual) = &extensions.punctual {
            lights::assign(glb, source, (&placed, punctual.light), &mut wanted)?;
        }
        if let Some(profiled) = &extensions.profiled {
            profiles::assign(glb, source, (&placed, profiled), &mut wanted)?;
        }
    }
    Ok(())
}

/// Gives primitives without a material one called `name`.
fn name_the_nameless(glb: &mut Glb, name: &str) {
    let index = glb.push("materials", json!({ "name": name }));
    let meshes = glb.root.get_mut("meshes").and_then(Value::as_array_mut);
    for mesh in meshes.into_iter().flatten() {
        let primitives = mesh.get_mut("primitives").and_then(Value::as_array_mut);
        for primitive in primitives.into_iter().flatten() {
            object(primitive).entry("material").or_insert_with(|| json!(index));
        }
    }
}
