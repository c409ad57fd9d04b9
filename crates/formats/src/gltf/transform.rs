//! `KHR_texture_transform`: how the base colour lies on the texture coordinates.
//!
//! With the offset `o`, the angle `r` and the scale `s` of the file, a texture is looked up at
//!
//! ```text
//! u' = o_u + cos(r) s_u u + sin(r) s_v v
//! v' = o_v - sin(r) s_u u + cos(r) s_v v
//! ```
//!
//! (counter-clockwise, as v grows downwards). A mesh has one set of texture coordinates, here `(u',
//! v')` of its material's base colour; primitives of other materials have their own. The record of
//! the transform stays in files that are written back, since a texture that was recovered lies in
//! `(u', v')`, too. The emissive texture is not read, and only the mean of others counts.

use super::Problem;
use super::document::{Document, Material, TextureInfo};
use super::extensions::TEXTURE_TRANSFORM;
use crate::relief::along_u;
use glam::{DAffine2, DMat2, DVec2};
use serde_json::{Value, json};
use unrender_scene::Mesh;

/// Which texture coordinates a material uses, and how they are transformed.
#[derive(PartialEq)]
pub(super) struct Layout {
    /// The number of the set, n of `TEXCOORD_n`.
    pub(super) set: usize,
    transform: Option<DAffine2>,
}

impl Layout {
    const PLAIN: Self = Self { set: 0, transform: None };

    /// The layout of material `index`; plain `TEXCOORD_0` without textures.
    pub(super) fn of(document: &Document, index: Option<usize>) -> Result<Self, Problem> {
        let material = index.and_then(|index| document.materials.get(index));
        material.map_or(Ok(Self::PLAIN), Self::of_material)
    }

    /// That of the base colour texture, or of the normals where there is none.
    pub(super) fn of_material(json: &Material) -> Result<Self, Problem> {
        let pbr = json.pbr_metallic_roughness.as_ref();
        let info = pbr.and_then(|pbr| pbr.base_color_texture.as_ref());
        let info = info.or(json.normal_texture.as_ref());
        info.map_or(Ok(Self::PLAIN), Self::of_texture)
    }

    /// Whether it is the layout of `info`.
    pub(super) fn is_of(&self, info: &TextureInfo) -> Result<bool, Problem> {
        Ok(*self == Self::of_texture(info)?)
    }

    fn of_texture(info: &TextureInfo) -> Result<Self, Problem> {
        let Some(json) = &info.extensions.transform else {
            return Ok(Self { set: info.tex_coord, transform: None });
        };
        let (scale, (sin, cos)) = (DVec2::from_array(json.scale), json.rotation.sin_cos());
        let matrix =
            DMat2::from_cols(scale.x * DVec2::new(cos, -sin), scale.y * DVec2::new(sin, cos));
        let transform = DAffine2::from_mat2_translation(matrix, DVec2::from_array(json.offset));
        if !transform.to_cols_array().iter().all(|number| (*number as f32).is_finite()) {
            return Err(format!(
                "the {TEXTURE_TRANSFORM} of its material is not finite; export the scene again"
            ));
        }
        let transform = (transform != DAffine2::IDENTITY).then_some(transform);
        Ok(Self { set: json.tex_coord.unwrap_or(info.tex_coord), transform })
    }

    /// Transforms the texture coordinates of `mesh`. Where that turns the direction of growing u, from
    /// which anisotropy is measured, a mesh without tangents gets the former direction as its
    /// tangents.
    pub(super) fn apply(&self, mesh: &mut Mesh) {
        let Some(transform) = self.transform.filter(|_| !mesh.uvs.is_empty()) else { return };
        // Surfaces where u grows in the same direction as u': the first row is (positive, 0).
        let matrix = transform.matrix2;
        let is_turned = matrix.x_axis.x <= 0.0 || matrix.x_axis.y != 0.0 || matrix.y_axis.x != 0.0;
        if mesh.tangents.is_empty() && is_turned {
            mesh.tangents = along_u(mesh);
        }
        for uv in &mut mesh.uvs {
            *uv = transform.transform_point2(uv.as_dvec2()).as_vec2();
        }
    }
}

/// The JSON in a material for glTF texture `index`, with the transform of the texture `former`.
pub(super) fn texture_info(index: usize, former: Option<&Value>) -> Value {
    let mut info = json!({ "index": index });
    let Some(former) = former else { return info };
    if let Some(set) = former["texCoord"].as_u64().filter(|set| *set != 0) {
        info["texCoord"] = json!(set);
    }
    if let Some(transform) = former["extensions"].get(TEXTURE_TRANSFORM) {
        info["extensions"] = json!({ TEXTURE_TRANSFORM: transform });
    }
    info
}

/// Whether `json`, or something in it, has the extension.
pub(super) fn is_used_in(json: &Value) -> bool {
    match json {
        Value::Object(map) => {
            map.iter().any(|(key, value)| key == TEXTURE_TRANSFORM || is_used_in(value))
        }
        Value::Array(items) => items.iter().any(is_used_in),
        _ => false,
    }
}
