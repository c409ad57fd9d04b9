//! What a glTF file says that no field of `document` asks for: collected by every element, and told.

use super::document::{Document, Material, Node, TextureInfo};
use super::extensions::{self, UNDERSTOOD};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use unrender_scene::Warnings;

/// What is not read of an element.
#[derive(Deserialize, Default)]
pub(super) struct Unread {
    /// Its extensions; empty where the element has a field for those that are read.
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, IgnoredAny>,
    /// Its other properties; of a list of extensions their names.
    #[serde(flatten)]
    pub(super) properties: BTreeMap<String, IgnoredAny>,
}

/// Properties without which everything is as it was: names of what has none here, what is for programs that wrote
/// it, and bounds, hints and kinds that follow from the rest. Of any element, or of those of the kind.
const SILENT: [(&str, &[&str]); 12] = [
    ("", &["name", "extras"]),
    // Skins and the weights of morph targets are told where a node or a mesh has them.
    ("file", &["skins"]),
    ("asset", &["copyright", "minVersion"]),
    ("nodes", &["weights"]),
    ("meshes", &["weights"]),
    ("materials", &["alphaCutoff"]),
    ("accessors", &["min", "max"]),
    ("bufferViews", &["target"]),
    ("images", &["mimeType"]),
    ("samplers", &["minFilter"]),
    ("cameras", &["type", "orthographic"]),
    ("perspective cameras", &["znear", "zfar"]),
];

impl Unread {
    /// Tells what is not read of an element of `kind`.
    pub(super) fn tell(&self, kind: &str, warnings: &mut Warnings) {
        self.tell_as(kind, &format!("Of the {kind}"), warnings);
    }

    /// As [`Unread::tell`], where `which` says whose it is.
    fn tell_as(&self, kind: &str, which: &str, warnings: &mut Warnings) {
        self.extensions.keys().for_each(|name| tell_extension(name, warnings));
        let is_silent = |key: &str| {
            let of_kind = SILENT.iter().filter(|(of, _)| of.is_empty() || *of == kind);
            of_kind.into_iter().any(|(_, keys)| keys.contains(&key))
        };
        for key in self.properties.keys().filter(|key| !is_silent(key)) {
            if key == "animations" && kind == "file" {
                warnings.push("Animations were ignored; everything stands as its node says.");
            } else {
                warnings.push(format!("{which} the property {key} is not read; it was ignored."));
            }
        }
    }

    /// Tells the extensions of a list of them that are not read.
    pub(super) fn tell_extensions(&self, warnings: &mut Warnings) {
        let names = self.properties.keys().chain(self.extensions.keys());
        names.for_each(|name| tell_extension(name, warnings));
    }
}

/// Tells that the extension `name` is not read, if it is not.
pub(super) fn tell_extension(name: &str, warnings: &mut Warnings) {
    if !UNDERSTOOD.contains(&name) {
        warnings.push(extensions::ignored(name));
    }
}

/// Tells what is not read of what all scenes of the file share.
pub(super) fn tell_document(document: &Document, warnings: &mut Warnings) {
    let mut tell = |unread: &Unread, kind: &str| unread.tell(kind, warnings);
    tell(&document.unread, "file");
    tell(&document.asset.unread, "asset");
    tell(&document.extensions.punctual.unread, "lights");
    document.textures.iter().for_each(|texture| tell(&texture.unread, "textures"));
    document.images.iter().for_each(|image| tell(&image.unread, "images"));
    document.samplers.iter().for_each(|sampler| tell(&sampler.unread, "samplers"));
    document.buffers.iter().for_each(|buffer| tell(&buffer.unread, "buffers"));
    document.buffer_views.iter().for_each(|view| tell(&view.unread, "bufferViews"));
    for accessor in &document.accessors {
        tell(&accessor.unread, "accessors");
        if let Some(sparse) = &accessor.sparse {
            tell(&sparse.unread, "sparse accessors");
            tell(&sparse.indices.unread, "sparse accessors");
            tell(&sparse.values.unread, "sparse accessors");
        }
    }
    if let Some(scene) = document.scenes.get(document.scene.unwrap_or(0)) {
        tell(&scene.unread, "scenes");
    }
    if document.scenes.len() > 1 {
        let count = document.scenes.len();
        warnings.push(format!("Of the {count} scenes of the file only the default one was read."));
    }
    document.extensions.unread.tell_extensions(warnings);
    document.extensions_used.iter().for_each(|name| tell_extension(name, warnings));
}

/// Tells what is not read of a node and of what it holds.
pub(super) fn tell_node(document: &Document, node: &Node, warnings: &mut Warnings) {
    node.unread.tell("nodes", warnings);
    node.extensions.unread.tell_extensions(warnings);
    if let Some(visibility) = &node.extensions.visibility {
        visibility.unread.tell("nodes", warnings);
    }
    if let Some(punctual) = &node.extensions.punctual {
        punctual.unread.tell("nodes", warnings);
        if let Some(light) = document.extensions.punctual.lights.get(punctual.light) {
            light.unread.tell("lights", warnings);
            light.spot.unread.tell("lights", warnings);
        }
    }
    if let Some(camera) = node.camera.and_then(|index| document.cameras.get(index)) {
        camera.unread.tell("cameras", warnings);
        if let Some(perspective) = &camera.perspective {
            perspective.unread.tell("perspective cameras", warnings);
        }
    }
    let Some(mesh) = node.mesh.and_then(|index| document.meshes.get(index)) else { return };
    mesh.unread.tell("meshes", warnings);
    for primitive in &mesh.primitives {
        primitive.unread.tell("meshes", warnings);
        let material = primitive.material.and_then(|index| document.materials.get(index));
        let material = material.and_then(|material| material.name.as_deref()).unwrap_or("");
        primitive.attributes.others.keys().for_each(|key| tell_attribute(key, material, warnings));
    }
}

/// Tells that the vertices of meshes of `material` have a `key` that is not read. Sets of texture coordinates
/// that no texture uses, the words of skins, and what a program keeps for itself (`_KEY`) are no loss.
fn tell_attribute(key: &str, material: &str, warnings: &mut Warnings) {
    if key.starts_with("COLOR_") {
        warnings.push(format!(
            "material \"{material}\": the vertex colours ({key}) of its meshes were ignored; a surface has the \
             colour of its material and its texture."
        ));
        return;
    }
    let is_silent = |of: &str| key.starts_with(of);
    if !["TEXCOORD_", "JOINTS_", "WEIGHTS_", "_"].into_iter().any(is_silent) {
        warnings.push(format!("Of the meshes the attribute {key} is not read; it was ignored."));
    }
}

/// Tells what is not read of the material called `name`.
pub(super) fn tell_material(json: &Material, name: &str, warnings: &mut Warnings) {
    let mut tell = |unread: &Unread, of: &str| {
        unread.tell_as("materials", &format!("Of material \"{name}\"{of}"), warnings);
    };
    tell(&json.unread, "");
    let extensions = &json.extensions;
    let of_extensions = [
        ("emissive_strength", extensions.emissive_strength.as_ref().map(|e| &e.unread)),
        ("ior", extensions.ior.as_ref().map(|e| &e.unread)),
        ("specular", extensions.specular.as_ref().map(|e| &e.unread)),
        ("anisotropy", extensions.anisotropy.as_ref().map(|e| &e.unread)),
    ];
    for (extension, unread) in of_extensions {
        if let Some(unread) = unread {
            tell(unread, &format!("'s KHR_materials_{extension}"));
        }
    }
    let mut lists = vec![&extensions.unread];
    if let Some(pbr) = &json.pbr_metallic_roughness {
        tell(&pbr.unread, "");
        let infos = [&pbr.base_color_texture, &pbr.metallic_roughness_texture];
        for TextureInfo { extensions, unread, .. } in infos.into_iter().flatten() {
            tell(unread, "'s texture");
            if let Some(transform) = &extensions.transform {
                tell(&transform.unread, "'s texture");
            }
            lists.push(&extensions.unread);
        }
    }
    lists.into_iter().for_each(|list| list.tell_extensions(warnings));
}
