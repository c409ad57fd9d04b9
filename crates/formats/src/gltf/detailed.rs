//! Normal maps and holes into a file.
//!
//! Holes are the alpha of the base colour's picture, with `alphaMode` MASK. Where a group has no picture, a white one
//! holds them, and the factor is the colour as without it.

use super::Problem;
use super::glb::Glb;
use super::transform;
use super::ward::{self, object};
use crate::texels;
use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use unrender_scene::{
    BrdfModel, Coverage, Detail, Image, Mapped, Material, NormalMap, Rgb, Texture,
};

impl Glb {
    /// Writes `material` into the glTF material `json`, its texture that of the `exact` one with the holes of `coverage`.
    pub(super) fn paint(
        &mut self,
        json: &mut Value,
        (material, exact): (&Material, &Material),
        brdf: BrdfModel,
        coverage: Option<&Coverage>,
    ) -> Result<(), Problem> {
        let former = json["pbrMetallicRoughness"].get("baseColorTexture").cloned();
        let own = match (&exact.texture, coverage) {
            (Some(texture), Some(coverage)) => Some(self.push_pierced(texture, coverage)?),
            (Some(texture), None) => Some(self.push_texture(texture)?),
            (None, _) => None,
        };
        ward::assign_material(json, material, brdf, own);
        let Some(coverage) = coverage else { return Ok(()) };
        let root = object(json);
        if root.get("alphaMode").is_none_or(|mode| mode == "OPAQUE") {
            root.insert("alphaMode".into(), json!("MASK"));
            root.insert("alphaCutoff".into(), json!(crate::numbers::number(coverage.cutoff)));
        }
        let pbr = &mut json["pbrMetallicRoughness"];
        if own.is_none() {
            let Mapped { image, wrap_u, wrap_v } = &coverage.alpha;
            let image = image.map(|_| Rgb::ONE);
            let white = Texture { image, wrap_u: *wrap_u, wrap_v: *wrap_v };
            let index = self.push_pierced(&white, coverage)?;
            pbr["baseColorTexture"] = transform::texture_info(index, former.as_ref());
        }
        // The picture holds all of the alpha.
        pbr["baseColorFactor"][3] = json!(1.0);
        Ok(())
    }

    /// Gives the material `json` the normals of `detail`.
    pub(super) fn emboss(&mut self, json: &mut Value, detail: &Detail) -> Result<(), Problem> {
        if let Some(NormalMap { normals, .. }) = detail.normals.as_deref() {
            let unit = normals.image.map(|normal| normal.try_normalize().unwrap_or(Vec3::Z));
            let png = texels::png_of_normals(&unit)?;
            let index = self.push_picture(&png, [normals.wrap_u, normals.wrap_v]);
            json["normalTexture"] = json!({ "index": index });
        }
        Ok(())
    }

    /// Embeds `texture` as a PNG that has the coverage as its alpha.
    fn push_pierced(&mut self, texture: &Texture, coverage: &Coverage) -> Result<usize, Problem> {
        let alpha = &coverage.alpha;
        let width = texture.image.width().max(alpha.image.width());
        let height = texture.image.height().max(alpha.image.height());
        let colors = in_size(texture, (width, height), Mapped::<Rgb>::sample);
        let alphas = in_size(alpha, (width, height), Mapped::<f32>::sample);
        let png = texels::png_with_alpha(&colors, &alphas)?;
        Ok(self.push_picture(&png, [texture.wrap_u, texture.wrap_v]))
    }
}

/// The picture in `(width, height)` texels.
fn in_size<T: Copy>(
    mapped: &Mapped<T>,
    (width, height): (usize, usize),
    sample: impl Fn(&Mapped<T>, Vec2) -> T,
) -> Image<T> {
    if (mapped.image.width(), mapped.image.height()) == (width, height) {
        return mapped.image.clone();
    }
    let size = Vec2::new(width as f32, height as f32);
    Image::from_fn(width, height, |x, y| {
        sample(mapped, (Vec2::new(x as f32, y as f32) + 0.5) / size)
    })
}

/// Whether `texture` is a white picture, coloured by `factor`, that is there for its holes.
pub(super) fn is_for_holes(texture: &Texture, factor: Rgb, alpha_mode: Option<&str>) -> bool {
    let is_pierced = alpha_mode.is_some_and(|mode| mode != "OPAQUE");
    is_pierced && texture.image.pixels().iter().all(|texel| *texel == factor)
}
