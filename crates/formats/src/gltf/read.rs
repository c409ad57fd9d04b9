//! A glTF file to a scene.

use super::graph::{Placed, placed_nodes};
use super::names::{ObjectNames, group_names, holder};
use super::source::{Source, get};
use super::{Problem, detail, geometry, glass, lights, material, profiles, tell, two_sided, units};
use crate::{FileError, Input, relief};
use std::collections::BTreeMap;
use unrender_scene::{BrdfModel, Layering, Object, Scene, Warnings};

/// Reads the default scene of the `.glb` or `.gltf` at `path` into world space, with the origin that the input
/// states.
///
/// Groups are the materials that some triangle has, in the order of the file; objects are the
/// pairs of a node and a material. The scene is not yet validated:
/// see [`load_scene`](crate::load_scene).
///
/// # Errors
/// If the file or a file it needs is missing, damaged, or requires an extension that is not
/// understood.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let fail = |problem| FileError::new(input.path, problem);
    let source = Source::open(input).map_err(fail)?;
    let (scene, mut warnings) = scene(&source).map_err(fail)?;
    if input.light_units.is_none() {
        warnings.0.extend(units::warning(&source.document, source.light_units));
    }
    Ok((scene, warnings))
}

fn scene(source: &Source) -> Result<(Scene, Warnings), Problem> {
    let document = &source.document;
    let mut warnings = Warnings::default();
    tell::document(document, &mut warnings);
    let names = group_names(document, &mut warnings);
    let mut scene = Scene::default();
    let placed = placed_nodes(document)?;
    let objects = ObjectNames::of(document, &placed);
    for mut placed in placed {
        placed.world_from_node.translation -= source.scope().origin();
        read_node(source, (&placed, &objects), &mut scene, &mut warnings)?;
    }
    glass::set_apart(document, &names, &mut scene);
    scene.brdf = sort_into_groups(source, &names, &mut scene, &mut warnings)?;
    source.scope().complete()?;
    scene.glass_told().into_iter().for_each(|told| warnings.push(told + "."));
    warn_of_missing_uvs(&scene, &mut warnings);
    Ok((scene, warnings))
}

fn read_node(
    source: &Source,
    (placed, names): (&Placed, &ObjectNames<'_>),
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(), Problem> {
    let document = &source.document;
    let node = get(&document.nodes, placed.node, "node")?;
    let name = holder(document, placed);
    tell::node(document, node, warnings);
    if node.skin.is_some() {
        warnings.push("Skins were ignored; their meshes stand as they were modelled.");
    }
    if node.mesh.is_some() {
        scene.objects.extend(objects(source, (placed, names), warnings)?);
    }
    if let Some(index) = node.camera {
        let json = get(&document.cameras, index, "camera")?;
        let camera = lights::camera(json, name, &placed.world_from_node, warnings)?;
        scene.cameras.extend(camera);
    }
    if let Some(punctual) = &node.extensions.punctual {
        let json = get(&document.extensions.punctual.lights, punctual.light, "light")?;
        let written = (source.light_units, units::has_blenders_cones(&document.asset));
        scene.lights.push(lights::light(json, name, placed, written, warnings)?);
    }
    if let Some(profiled) = &node.extensions.profiled {
        scene.lights.extend(profiles::light(source, profiled, name, placed, warnings)?);
    }
    Ok(())
}

/// The objects of a node, one per material; `Object::group` is still the index of the material, or
/// the number of materials for those without one.
fn objects(
    source: &Source,
    (placed, names): (&Placed, &ObjectNames<'_>),
    warnings: &mut Warnings,
) -> Result<Vec<Object>, Problem> {
    let document = &source.document;
    let node = get(&document.nodes, placed.node, "node")?;
    let Some(mesh_index) = node.mesh else { return Ok(Vec::new()) };
    let json = get(&document.meshes, mesh_index, "mesh")?;
    let name = names.name(placed);
    let mut objects: Vec<Object> = Vec::new();
    // The object of a material, with uvs and tangents or without.
    let mut places: BTreeMap<(usize, bool, bool), usize> = BTreeMap::new();
    for primitive in &json.primitives {
        if !primitive.targets.is_empty() {
            warnings.push("Morph targets were ignored; their meshes stand as they were modelled.");
        }
        let without = document.materials.len();
        let group = primitive.material.unwrap_or(without);
        if group > without || (primitive.material == Some(without)) {
            get(&document.materials, group, "material")?;
        }
        let in_node = |p: Problem| format!("\"{name}\": {p}");
        let mesh = geometry::world_mesh(source, primitive, &placed.world_from_node, warnings)
            .map_err(in_node)?;
        let Some(mut mesh) = mesh.filter(|mesh| !mesh.triangles.is_empty()) else { continue };
        geometry::repair_handedness(&mut mesh.tangents, warnings);
        if document.materials.get(group).is_some_and(two_sided::emits) {
            two_sided::add_back(&mut mesh).map_err(in_node)?;
        }
        let kind = (group, mesh.uvs.is_empty(), mesh.tangents.is_empty());
        match places.get(&kind) {
            Some(&place) => {
                geometry::append(&mut objects[place].mesh, mesh).map_err(in_node)?;
            }
            None => {
                places.insert(kind, objects.len());
                objects.push(Object { name: name.clone(), group, mesh });
            }
        }
    }
    Ok(objects)
}

/// The model of glTF's own materials.
const PRINCIPLED: BrdfModel = BrdfModel::Principled(Layering::AlbedoScaled);

/// Makes the materials that objects have into groups; returns the BRDF model that they were written for.
fn sort_into_groups(
    source: &Source,
    names: &[String],
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<BrdfModel, Problem> {
    let mut group_of = vec![None; names.len()];
    let mut used = vec![false; names.len()];
    scene.objects.iter().for_each(|object| used[object.group] = true);
    let written_for = (0..names.len()).filter(|&slot| used[slot]);
    let mut written_for =
        written_for.filter_map(|slot| material::model(source.document.materials.get(slot)?));
    let first = written_for.next();
    if first.is_some_and(|first| written_for.any(|other| other != first)) {
        warnings.push("The materials were written for different brdfs; the first one's was taken.");
    }
    let model = first.or(source.scope().brdf()).unwrap_or(PRINCIPLED);
    for slot in (0..names.len()).filter(|&slot| used[slot]) {
        group_of[slot] = Some(scene.groups.len());
        let Some(json) = source.document.materials.get(slot) else {
            scene.groups.push(material::default_group(&names[slot], warnings));
            continue;
        };
        scene.groups.push(material::group(source, json, &names[slot], model, warnings)?);
        let detail = detail::of_material(source, json, &names[slot], warnings)?;
        for object in scene.objects.iter_mut().filter(|object| object.group == slot) {
            if object.mesh.uvs.is_empty() && !detail.is_none() {
                warnings.push(missing_uvs(&object.name));
            }
            relief::give(&mut object.mesh, &detail);
        }
    }
    if !model.is_principled() {
        scene.free();
    }
    detail::tell(&source.document, (names, &used), warnings);
    for object in &mut scene.objects {
        object.group = group_of[object.group].unwrap_or_default();
    }
    Ok(model)
}

fn warn_of_missing_uvs(scene: &Scene, warnings: &mut Warnings) {
    for object in &scene.objects {
        if object.mesh.uvs.is_empty() && scene.groups[object.group].material.texture.is_some() {
            warnings.push(missing_uvs(&object.name));
        }
    }
}

fn missing_uvs(object: &str) -> String {
    format!(
        "object \"{object}\" has no texture coordinates for the texture of its material; unwrap it and export the scene \
         again."
    )
}
