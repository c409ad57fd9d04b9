//! Warns of what is in a glTF file and is not read: in the document, in each node and its contents, in each
//! material.

use super::document::{Document, Material, Node, TextureInfo};
use super::elements;
use super::unread::{Unread, tell_extension};
use unrender_scene::Warnings;

/// Warns of what is not read in the parts that all scenes of the file share.
pub(super) fn document(document: &Document, warnings: &mut Warnings) {
    let mut tell = |unread: &Unread, kind: &str| unread.tell(kind, warnings);
    tell(&document.unread, "file");
    tell(&document.asset.unread, "asset");
    tell(&document.extensions.punctual.unread, "lights");
    tell(&document.extensions.profiles.unread, "lights");
    document.extensions.profiles.lights.iter().for_each(|profile| tell(&profile.unread, "lights"));
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

/// Warns of what is not read in a node and its contents.
pub(super) fn node(document: &Document, node: &Node, warnings: &mut Warnings) {
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
    if let Some(profiled) = &node.extensions.profiled {
        profiled.unread.tell("nodes", warnings);
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
        primitive.attributes.others.keys().for_each(|key| tell_attribute(key, warnings));
    }
}

/// Warns that vertices have an attribute `key` that is not known; of colours, see `detail.rs`.
fn tell_attribute(key: &str, warnings: &mut Warnings) {
    if elements::attribute(key).is_none() {
        warnings.push(format!("glTF meshes: the attribute {key} is not read; it was ignored."));
    }
}

/// Warns of what is not read in the material called `name`.
pub(super) fn material(json: &Material, name: &str, warnings: &mut Warnings) {
    let mut tell = |unread: &Unread, of: &str| {
        unread.tell_as("materials", &format!("material \"{name}\"{of}"), warnings);
    };
    tell(&json.unread, "");
    let extensions = &json.extensions;
    let of_extensions = [
        ("emissive_strength", extensions.emissive_strength.as_ref().map(|e| &e.unread)),
        ("ior", extensions.ior.as_ref().map(|e| &e.unread)),
        ("specular", extensions.specular.as_ref().map(|e| &e.unread)),
        ("anisotropy", extensions.anisotropy.as_ref().map(|e| &e.unread)),
        ("clearcoat", extensions.clearcoat.as_ref().map(|e| &e.unread)),
        ("transmission", extensions.transmission.as_ref().map(|e| &e.unread)),
        ("volume", extensions.volume.as_ref().map(|e| &e.unread)),
    ];
    for (extension, unread) in of_extensions {
        if let Some(unread) = unread {
            tell(unread, &format!("'s KHR_materials_{extension}"));
        }
    }
    let mut lists = vec![&extensions.unread];
    let mut infos: Vec<&TextureInfo> = json.normal_texture.iter().collect();
    if let Some(pbr) = &json.pbr_metallic_roughness {
        tell(&pbr.unread, "");
        infos.extend(
            [&pbr.base_color_texture, &pbr.metallic_roughness_texture].into_iter().flatten(),
        );
    }
    for TextureInfo { extensions, unread, .. } in infos {
        tell(unread, "'s texture");
        if let Some(transform) = &extensions.transform {
            tell(&transform.unread, "'s texture");
        }
        lists.push(&extensions.unread);
    }
    lists.into_iter().for_each(|list| list.tell_extensions(warnings));
}
