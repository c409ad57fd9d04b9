//! Warns of what varies over surfaces and is not read: normals, roughness and metal, colours of vertices.

use super::document::Document;
use super::elements;
use crate::entry::Taken;
use crate::told::Told;
use unrender_scene::Warnings;

const NORMALS: &str = "the normalTexture is not read: the surface is taken as smooth as its mesh, so that highlights on \
                       its bumps differ from the photograph's";
const ROUGHNESS: &str = "of the metallicRoughnessTexture only the mean was taken: the surface is as rough and as metallic \
                         everywhere";

/// Warns of it by group, of those that are `used`.
pub(super) fn tell(
    document: &Document,
    (names, used): (&[String], &[bool]),
    warnings: &mut Warnings,
) {
    let mut told = Told::default();
    let slots = || (0..names.len()).filter(|&slot| used[slot]);
    for slot in slots() {
        let Some(json) = document.materials.get(slot) else { continue };
        if json.normal_texture.is_some() {
            told.note(NORMALS, &names[slot]);
        }
        let pbr = json.pbr_metallic_roughness.as_ref();
        if pbr.is_some_and(|pbr| pbr.metallic_roughness_texture.is_some()) {
            told.note(ROUGHNESS, &names[slot]);
        }
    }
    for slot in slots() {
        let primitives = document.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let own = primitives.filter(|p| p.material.unwrap_or(document.materials.len()) == slot);
        let keys = own.flat_map(|primitive| primitive.attributes.others.keys());
        let is_unread = |key: &&String| {
            elements::attribute(key).is_some_and(|row| row.taken == Taken::WarnedOf)
        };
        if let Some(key) = keys.filter(is_unread).min() {
            let what = format!(
                "the vertex colours ({key}) of its meshes are not read: what they paint or shade is missing here, and \
                 a recovery finds their mean"
            );
            told.note(&what, &names[slot]);
        }
    }
    told.sentences().for_each(|sentence| warnings.push(sentence + "."));
}
