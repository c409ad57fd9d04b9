//! The detail of surfaces below their triangles: normal maps and holes; and warnings of what varies over surfaces and is
//! not read: roughness and metal, colours of vertices.

use super::Problem;
use super::document::{Document, Material};
use super::elements;
use super::material;
use super::source::Source;
use super::texture::{self, Encoded};
use super::transform::Layout;
use crate::entry::Taken;
use crate::relief::CUTOFF;
use crate::told::Told;
use std::sync::Arc;
use unrender_scene::{Coverage, Detail, Mapped, NormalMap, Rgb, Warnings};

const ROUGHNESS: &str = "of the metallicRoughnessTexture only the mean was taken: the surface is as rough and as metallic \
                         everywhere";
const BLENDED: &str = "its alphaMode is BLEND: where its texture covers less than half there are holes, elsewhere it is \
                       opaque";
const ELSEWHERE: &str = "the normalTexture lies on other texture coordinates than the base colour and is not read: the \
                         surface is taken as smooth as its mesh";

/// The detail of surfaces of the material `json`.
pub(super) fn of_material(
    source: &Source,
    json: &Material,
    name: &str,
    warnings: &mut Warnings,
) -> Result<Detail, Problem> {
    let mut told = |what: &str| warnings.push(format!("material \"{name}\": {what}."));
    let normals = normals(source, json, &mut told)?;
    Ok(Detail { normals, coverage: coverage(source, json, &mut told)? })
}

fn normals(
    source: &Source,
    json: &Material,
    told: &mut impl FnMut(&str),
) -> Result<Option<Arc<NormalMap>>, Problem> {
    let Some(info) = &json.normal_texture else { return Ok(None) };
    if !Layout::of_material(json)?.is_of(info)? {
        told(ELSEWHERE);
        return Ok(None);
    }
    match texture::encoded(source, info.index)? {
        Encoded::Texels(image, wrap_u, wrap_v) => {
            let picture = Mapped { image, wrap_u, wrap_v };
            Ok(Some(Arc::new(NormalMap::decoded(&picture, info.scale.unwrap_or(1.0) as f32, true))))
        }
        Encoded::Missing => {
            told("its normalTexture is missing; the surface is taken as smooth as its mesh");
            Ok(None)
        }
        Encoded::Other => Ok(None),
    }
}

/// Holes. Lamps have none: what is cut out of them is light.
fn coverage(
    source: &Source,
    json: &Material,
    told: &mut impl FnMut(&str),
) -> Result<Option<Arc<Coverage>>, Problem> {
    let mode = json.alpha_mode.as_deref().unwrap_or("OPAQUE");
    if mode == "OPAQUE" {
        return Ok(None);
    }
    let pbr = json.pbr_metallic_roughness.as_ref();
    let texture = pbr.and_then(|pbr| Some((pbr.base_color_texture.as_ref()?, pbr)));
    let Some((info, pbr)) = texture else {
        told("it is transparent all over, which is taken as opaque");
        return Ok(None);
    };
    if material::emission(json) != Some(Rgb::ZERO) {
        told("it is a lamp with holes, which is taken as one without");
        return Ok(None);
    }
    let Some(alpha) = texture::alpha(source, info.index)? else { return Ok(None) };
    if mode == "BLEND" {
        told(BLENDED);
    }
    let factor = pbr.base_color_factor[3] as f32;
    let stated = json.alpha_cutoff.map_or(CUTOFF, |cutoff| cutoff as f32);
    let cutoff = if mode == "BLEND" { CUTOFF } else { stated };
    let Mapped { image, wrap_u, wrap_v } = alpha;
    let alpha = Mapped { image: image.map(|alpha| alpha * factor), wrap_u, wrap_v };
    Ok(Some(Arc::new(Coverage { alpha, cutoff })))
}

/// Warns of what varies and is not read by group, of those that are `used`.
pub(super) fn tell(
    document: &Document,
    (names, used): (&[String], &[bool]),
    warnings: &mut Warnings,
) {
    let mut told = Told::default();
    let slots = || (0..names.len()).filter(|&slot| used[slot]);
    for slot in slots() {
        let Some(json) = document.materials.get(slot) else { continue };
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
