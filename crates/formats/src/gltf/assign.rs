//! The file that a scene came from, in which materials and lights are what the scene says.

use super::Problem;
use super::extensions::understood;
use super::names::group_names;
use super::source::Source;
use super::ward::{self, object};
use super::write::Glb;
use super::{lights, material, transform};
use crate::{FileError, Input};
use serde_json::{Value, json};
use unrender_scene::{Rgb, Scene, Warnings};

/// The bytes of a `.glb` with everything that is in the glTF file `source` (hierarchy, names,
/// extras, animations), in which every material that is a group of `scene` gets that group's
/// reflectance and emission, and the lights of `scene` are as bright as they are there, in
/// the units of the file. Buffers and
/// pictures beside the file are embedded.
///
/// # Errors
/// If `source` cannot be read, or if the result would be larger than 4 GiB.
pub fn assign_materials<'a>(
    source: impl Into<Input<'a>>,
    scene: &Scene,
) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    let fail = |problem| FileError::new(source.path, problem);
    let opened = Source::open(source).map_err(fail)?;
    with_materials(&opened, scene).map_err(fail)
}

fn with_materials(source: &Source, scene: &Scene) -> Result<Vec<u8>, Problem> {
    let mut glb = Glb::embedding(source);
    let names = group_names(&source.document, &mut Warnings::default());
    if let Some(name) = names.last().filter(|name| scene.group_index(name).is_some()) {
        name_the_nameless(&mut glb, name);
    }
    let count = glb.root["materials"].as_array().map_or(0, Vec::len);
    for (index, name) in names.iter().enumerate().take(count) {
        let Some(group) = scene.group_index(name) else { continue };
        let material = &scene.groups[group].material;
        let texture = material.texture.as_ref();
        let texture = texture.map(|texture| glb.push_texture(texture)).transpose()?;
        let json = &mut glb.root["materials"][index];
        ward::assign_material(json, material, scene.brdf, texture);
        let emission = scene.groups[group].emission;
        // What has no material in the file is black.
        let in_file = source.document.materials.get(index);
        if in_file.map_or(Some(Rgb::ZERO), material::emission) != Some(emission) {
            material::set_emission(json, emission);
        }
    }
    lights::assign_lights(&mut glb, source, scene)?;
    glb.finish()
}

impl Glb {
    /// Everything that is in `source`, buffers and pictures inside.
    pub(super) fn embedding(source: &Source) -> Self {
        let mut glb = Self { root: source.json.clone(), bin: Vec::new() };
        embed_buffers(&mut glb, source);
        embed_images(&mut glb, source);
        glb
    }
}

/// Joins all buffers into one.
fn embed_buffers(glb: &mut Glb, source: &Source) {
    let mut starts = Vec::new();
    for buffer in &source.buffers {
        // Some accessors have elements of 16 bytes; readers like these aligned.
        glb.bin.resize(glb.bin.len().next_multiple_of(16), 0);
        starts.push(glb.bin.len());
        glb.bin.extend_from_slice(buffer);
    }
    for (index, view) in source.document.buffer_views.iter().enumerate() {
        let Some(&start) = starts.get(view.buffer) else { continue };
        let json = object(&mut glb.root["bufferViews"][index]);
        json.insert("buffer".into(), json!(0));
        if start + view.byte_offset > 0 {
            json.insert("byteOffset".into(), json!(start.saturating_add(view.byte_offset)));
        }
    }
}

/// Embeds the pictures that can be read; what is missing stays missing.
fn embed_images(glb: &mut Glb, source: &Source) {
    for (index, image) in source.document.images.iter().enumerate() {
        if image.uri.is_none() || image.buffer_view.is_some() {
            continue;
        }
        let Ok(bytes) = source.image(index) else { continue };
        let view = glb.push_view(&bytes, None);
        let is_jpeg = bytes.starts_with(&[0xFF, 0xD8]);
        let is_png = bytes.starts_with(b"\x89PNG");
        let json = object(&mut glb.root["images"][index]);
        json.remove("uri");
        json.insert("bufferView".into(), json!(view));
        if is_png || is_jpeg || !json.contains_key("mimeType") {
            let kind = if is_jpeg { "image/jpeg" } else { "image/png" };
            json.insert("mimeType".into(), json!(kind));
        }
    }
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

/// Brings `extensionsUsed` and `extensionsRequired` up to what the materials and lights use.
pub(super) fn list_extensions(root: &mut Value) {
    let is_used = |root: &Value, name: &str| {
        let materials = root["materials"].as_array();
        root["extensions"].get(name).is_some()
            || materials.is_some_and(|all| all.iter().any(|m| m["extensions"].get(name).is_some()))
            || name == transform::EXTENSION && transform::is_used_in(&root["materials"])
    };
    // Meshes and nodes, of which these are, stay as they were.
    let kept = ["KHR_mesh_quantization", "KHR_node_visibility"];
    let ours = understood().filter(|name| !kept.contains(name));
    let dropped = ["KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit"];
    let mut lists = ["extensionsUsed", "extensionsRequired"].map(|key| {
        let list = root[key].as_array().cloned().unwrap_or_default();
        (key, list.iter().filter_map(|v| v.as_str().map(str::to_owned)).collect::<Vec<_>>())
    });
    for name in ours.chain(dropped) {
        let used = is_used(root, name);
        if !used {
            lists.iter_mut().for_each(|(_, list)| list.retain(|n| n != name));
        } else if !lists[0].1.iter().any(|n| n == name) {
            lists[0].1.push(name.to_owned());
        }
    }
    for (key, list) in lists {
        if list.is_empty() {
            object(root).remove(key);
        } else {
            root[key] = json!(list);
        }
    }
}
