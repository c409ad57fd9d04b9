//! A `.glb` in the making: its JSON, its one buffer, and what is put into them.

use super::extensions::{TEXTURE_TRANSFORM, understood};
use super::source::Source;
use super::ward::object;
use super::{Problem, container, texture, transform};
use crate::texels;
use serde_json::{Value, json};
use unrender_scene::{Texture, Wrap};

/// The extension of lamps by photometric profiles.
pub(super) const PROFILES: &str = "EXT_lights_ies";
/// The media type of their files.
pub(super) const PROFILE_MIME: &str = "application/x-ies-lm-63";

/// A glTF file in the making.
pub(super) struct Glb {
    /// The JSON.
    pub(super) root: Value,
    /// The one buffer.
    bin: Vec<u8>,
}

impl Glb {
    /// An empty one.
    pub(super) fn empty() -> Self {
        Self { root: json!({}), bin: Vec::new() }
    }

    /// Everything that is in `source`, buffers and pictures inside.
    pub(super) fn embedding(source: &Source) -> Self {
        let mut glb = Self { root: source.json.clone(), bin: Vec::new() };
        embed_buffers(&mut glb, source);
        embed_images(&mut glb, source);
        embed_profiles(&mut glb, source);
        glb
    }

    /// Appends `item` to the list `key` of the JSON and returns its index.
    pub(super) fn push(&mut self, key: &str, item: Value) -> usize {
        let list = object(&mut self.root).entry(key).or_insert_with(|| json!([]));
        if !list.is_array() {
            *list = json!([]);
        }
        list.as_array_mut().map_or(0, |items| {
            items.push(item);
            items.len() - 1
        })
    }

    /// Appends `light` to the lights of the file's `extension` and returns its index.
    pub(super) fn push_light(&mut self, extension: &str, light: Value) -> usize {
        let extensions = object(&mut self.root).entry("extensions").or_insert_with(|| json!({}));
        let lights = object(extensions).entry(extension).or_insert_with(|| json!({ "lights": [] }));
        lights["lights"].as_array_mut().map_or(0, |lights| {
            lights.push(light);
            lights.len() - 1
        })
    }

    /// Appends `bytes` to the buffer and returns the index of their view.
    pub(super) fn push_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    /// Embeds `texture` as a PNG and returns the index of the glTF texture.
    pub(super) fn push_texture(&mut self, texture: &Texture) -> Result<usize, Problem> {
        let png = texels::png(&texture.image)?;
        Ok(self.push_picture(&png, [texture.wrap_u, texture.wrap_v]))
    }

    /// Embeds the picture `png` and returns the index of the glTF texture.
    pub(super) fn push_picture(&mut self, png: &[u8], [wrap_u, wrap_v]: [Wrap; 2]) -> usize {
        let view = self.push_view(png, None);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        let sampler = self.push(
            "samplers",
            json!({
                "wrapS": texture::wrap_code(wrap_u),
                "wrapT": texture::wrap_code(wrap_v),
            }),
        );
        self.push("textures", json!({ "sampler": sampler, "source": image }))
    }

    /// Lists the extensions in use, adds the buffer to the JSON, and packs both.
    pub(super) fn finish(mut self) -> Result<Vec<u8>, Problem> {
        list_extensions(&mut self.root);
        if !self.bin.is_empty() {
            self.bin.resize(self.bin.len().next_multiple_of(4), 0);
            self.root["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        let text = serde_json::to_vec(&self.root).map_err(|error| error.to_string())?;
        container::join(&text, &self.bin)
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

/// Embeds the pictures that can be read; missing ones stay missing.
fn embed_images(glb: &mut Glb, source: &Source) {
    for (index, image) in source.document.images.iter().enumerate() {
        if image.uri.is_none() || image.buffer_view.is_some() {
            continue;
        }
        let Ok(Some(bytes)) = source.image(index) else { continue };
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

/// Embeds the profiles that can be read; missing ones stay missing.
fn embed_profiles(glb: &mut Glb, source: &Source) {
    for (index, profile) in source.document.extensions.profiles.lights.iter().enumerate() {
        if profile.uri.is_none() || profile.buffer_view.is_some() {
            continue;
        }
        let Ok(Some(bytes)) = source.profile(index) else { continue };
        let view = glb.push_view(&bytes, None);
        let json = object(&mut glb.root["extensions"][PROFILES]["lights"][index]);
        json.remove("uri");
        json.insert("bufferView".into(), json!(view));
        json.insert("mimeType".into(), json!(PROFILE_MIME));
    }
}

/// Brings `extensionsUsed` and `extensionsRequired` up to what the materials and lights use.
fn list_extensions(root: &mut Value) {
    let is_used = |root: &Value, name: &str| {
        let materials = root["materials"].as_array();
        root["extensions"].get(name).is_some()
            || materials.is_some_and(|all| all.iter().any(|m| m["extensions"].get(name).is_some()))
            || name == TEXTURE_TRANSFORM && transform::is_used_in(&root["materials"])
    };
    // These belong to meshes and nodes, which stay as they were.
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
