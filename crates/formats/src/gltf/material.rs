//! glTF materials to groups.

use super::Problem;
use super::document::{Material as MaterialJson, TextureInfo};
use super::source::Source;
use super::texture::Encoded;
use super::{detailed, principled, tell, texture, ward};
use crate::numbers::color_and_factor;
use crate::texels;
use glam::DVec3;
use serde_json::{Value, json};
use std::sync::Arc;
use unrender_scene::{BrdfModel, Group, Image, Material, Rgb, Texture, Warnings, Wrap};

/// The reflectance of surfaces that have no material.
const ASSUMED_RHO_D: f32 = 0.5;

/// A texture whose file is missing is this grey, or this rough. Half of it would make a room of such textures three times
/// as dark; twice as much is white.
const UNKNOWN: f32 = 0.5;

/// The group of primitives without a material.
pub(super) fn default_group(name: &str, warnings: &mut Warnings) -> Group {
    warnings.push(format!(
        "Some meshes have no material; they are the group \"{name}\", taken as diffuse with \
         rho_d = {ASSUMED_RHO_D}."
    ));
    let material = Material::diffuse(Rgb::splat(ASSUMED_RHO_D));
    Group { name: name.to_owned(), material, emission: Rgb::ZERO }
}

/// The BRDF model that the material `json` was written for, if it says so.
pub(super) fn model(json: &MaterialJson) -> Option<BrdfModel> {
    let record = json.extras.get(ward::EXTRAS_KEY)?;
    let layering = record["layering"].as_str().and_then(|name| name.parse().ok());
    let named: BrdfModel = record["brdf"].as_str()?.parse().ok()?;
    Some(named.with_layering(layering))
}

/// The group of material `json` in a scene of the BRDF `model`.
pub(super) fn group(
    source: &Source,
    json: &MaterialJson,
    name: &str,
    model: BrdfModel,
    warnings: &mut Warnings,
) -> Result<Group, Problem> {
    warn_of_the_unread(json, name, warnings);
    let emission = emission(json).ok_or_else(|| {
        format!("material \"{name}\" has a negative or infinite emission; export the scene again")
    })?;
    let mut reader = Reader { source, name, warnings };
    let material = match json.extras.get(ward::EXTRAS_KEY) {
        Some(record) => reader.exact(json, record)?,
        None => reader.approximate(json, model)?,
    };
    Ok(Group { name: name.to_owned(), material, emission })
}

/// The radiance that the material emits; none if it is not a valid one.
pub(super) fn emission(json: &MaterialJson) -> Option<Rgb> {
    let strength = json
        .extensions
        .emissive_strength
        .as_ref()
        .map_or(1.0, |strength| strength.emissive_strength);
    let emission: Rgb = (DVec3::from_array(json.emissive_factor) * strength).as_vec3();
    (emission.is_finite() && emission.min_element() >= 0.0).then_some(emission)
}

/// Makes the material `json` emit `emission` all over.
pub(super) fn set_emission(json: &mut Value, emission: Rgb) {
    const STRENGTH: &str = "KHR_materials_emissive_strength";
    let (color, factor) = color_and_factor(emission);
    let root = ward::object(json);
    root.insert("emissiveFactor".into(), color);
    root.remove("emissiveTexture");
    let extensions = ward::object(root.entry("extensions").or_insert_with(|| json!({})));
    extensions.remove(STRENGTH);
    if factor != 1.0 {
        extensions.insert(STRENGTH.into(), json!({ "emissiveStrength": factor }));
    }
    if extensions.is_empty() {
        root.remove("extensions");
    }
}

fn warn_of_the_unread(json: &MaterialJson, name: &str, warnings: &mut Warnings) {
    tell::material(json, name, warnings);
    if json.emissive_texture.is_some() {
        warnings.push(format!(
            "material \"{name}\": its emissiveTexture was ignored; it emits emissiveFactor all over."
        ));
    }
}

struct Reader<'a> {
    source: &'a Source,
    name: &'a str,
    warnings: &'a mut Warnings,
}

impl Reader<'_> {
    /// The material from the exact numbers that [`ward::assign_material`] wrote.
    fn exact(
        &mut self,
        json: &MaterialJson,
        record: &serde_json::Value,
    ) -> Result<Material, Problem> {
        let name = self.name;
        let fault = |what: &dyn std::fmt::Display| {
            format!("material \"{name}\": extras.unrender {what}; remove or repair it")
        };
        let record: crate::record::Record = serde_json::from_value(record.clone())
            .map_err(|e| fault(&format!("is not valid: {e}")))?;
        let (mut material, _) = record.to_material().map_err(|e| fault(&e))?;
        if let Some(pbr) = &json.pbr_metallic_roughness {
            let factor = self.base_color(pbr.base_color_factor);
            let texture = self.base_texture(pbr.base_color_texture.as_ref(), factor)?;
            let mode = json.alpha_mode.as_deref();
            material.texture = texture.filter(|own| !detailed::is_for_holes(own, factor, mode));
        }
        Ok(material)
    }

    /// The material from glTF's own parameters.
    fn approximate(&mut self, json: &MaterialJson, model: BrdfModel) -> Result<Material, Problem> {
        let Some(pbr) = &json.pbr_metallic_roughness else {
            return Ok(self.unstated(json));
        };
        let factor = self.base_color(pbr.base_color_factor);
        let stated = self.metallic_roughness(pbr)?;
        let metallic = stated.map_or(0.0, |(metallic, _)| metallic);
        let texture = self.base_texture(pbr.base_color_texture.as_ref(), factor)?;
        let base = texture.as_ref().map_or(factor, |texture| texels::mean(&texture.image));
        let mut material = match stated {
            Some((_, roughness)) => self.lobe((base, metallic, roughness), json, model),
            None => Material::diffuse(base),
        };
        material.texture = match texture {
            Some(texture) if metallic == 0.0 => Some(texture),
            Some(texture) if metallic < 1.0 => {
                let image = texture.image.map(|texel| *texel * (1.0 - metallic));
                Some(Arc::new(Texture { image, ..*texture }))
            }
            _ => None,
        };
        Ok(material)
    }

    /// The material of a base colour, metallic and roughness, without a texture.
    fn lobe(
        &mut self,
        (base, metallic, roughness): (Rgb, f32, f32),
        json: &MaterialJson,
        model: BrdfModel,
    ) -> Material {
        let name = self.name;
        let extensions = &json.extensions;
        // An emission shader of Blender's is exported so; it reflects nothing.
        let is_lamp = emission(json).is_some_and(|emission| emission != Rgb::ZERO);
        if is_lamp && base == Rgb::ZERO && roughness >= 1.0 {
            return Material::diffuse(Rgb::ZERO);
        }
        let reading = principled::from_gltf((base, metallic, roughness), extensions, model);
        if let Some(doubt) = reading.doubt {
            self.warnings.push(format!("material \"{name}\" {doubt}."));
        }
        let material = reading.material;
        if principled::leaves_coat_out(&material, extensions) {
            self.warnings.push(format!(
                "material \"{name}\": its clearcoat was left out; there is one specular lobe a surface."
            ));
        }
        material
    }

    /// A material that says nothing about reflectance: black if it is a lamp, else grey.
    fn unstated(&mut self, json: &MaterialJson) -> Material {
        if emission(json).is_some_and(|emission| emission != Rgb::ZERO) {
            return Material::diffuse(Rgb::ZERO);
        }
        let name = self.name;
        self.warnings.push(format!(
            "material \"{name}\" states no reflectance; it was taken as diffuse with \
             rho_d = {ASSUMED_RHO_D}."
        ));
        Material::diffuse(Rgb::splat(ASSUMED_RHO_D))
    }

    fn base_color(&mut self, factor: [f64; 4]) -> Rgb {
        let color = Rgb::new(factor[0] as f32, factor[1] as f32, factor[2] as f32);
        let clamped = color.clamp(Rgb::ZERO, Rgb::ONE);
        if clamped != color {
            let name = self.name;
            self.warnings.push(format!(
                "material \"{name}\": its baseColorFactor lies outside 0 to 1; it was clamped."
            ));
        }
        clamped
    }

    /// Metallic and roughness; the mean of a texture of them. A material that states neither is
    /// diffuse.
    fn metallic_roughness(
        &mut self,
        pbr: &super::document::Pbr,
    ) -> Result<Option<(f32, f32)>, Problem> {
        let name = self.name;
        let stated = [pbr.metallic_factor, pbr.roughness_factor];
        if stated == [None; 2] && pbr.metallic_roughness_texture.is_none() {
            self.warnings.push(format!(
                "material \"{name}\" states neither metallicFactor nor roughnessFactor; it was \
                 taken as diffuse."
            ));
            return Ok(None);
        }
        let [mut metallic, mut roughness] =
            stated.map(|factor| (factor.unwrap_or(1.0) as f32).clamp(0.0, 1.0));
        if let Some(info) = &pbr.metallic_roughness_texture {
            match texture::encoded(self.source, info.index)? {
                Encoded::Texels(values, ..) => {
                    let mean = texels::mean(&values);
                    metallic *= mean.z;
                    roughness *= mean.y;
                }
                Encoded::Missing => {
                    let what = "its metallicRoughnessTexture is missing; no metal and a roughness of a half were taken";
                    self.warnings.push(format!("material \"{name}\": {what}."));
                    metallic = 0.0;
                    roughness *= UNKNOWN;
                }
                Encoded::Other => {}
            }
        }
        Ok(Some((metallic, roughness)))
    }

    /// The texture of the base colour, `factor` multiplied in.
    fn base_texture(
        &mut self,
        info: Option<&TextureInfo>,
        factor: Rgb,
    ) -> Result<Option<Arc<Texture>>, Problem> {
        let Some(info) = info else { return Ok(None) };
        let name = self.name;
        let (encoded, wrap_u, wrap_v) = match texture::encoded(self.source, info.index)? {
            Encoded::Texels(encoded, wrap_u, wrap_v) => (encoded, wrap_u, wrap_v),
            Encoded::Missing => {
                self.warnings.push(format!(
                    "material \"{name}\": its texture is missing; grey was taken for it."
                ));
                let image = Image::new(1, 1, vec![UNKNOWN * factor]);
                let wrap = Wrap::Repeat;
                return Ok(Some(Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap })));
            }
            Encoded::Other => {
                self.warnings.push(format!(
                    "material \"{name}\": its texture has no PNG or JPEG picture and was ignored."
                ));
                return Ok(None);
            }
        };
        if texture::is_in_blocks(self.source, info.index) {
            self.warnings.push(format!(
                "material \"{name}\": its texture is to be shown as blocks (magFilter NEAREST); it \
                 was interpolated between texels."
            ));
        }
        let image = texels::linear(&encoded).map(|texel| *texel * factor);
        Ok(Some(Arc::new(Texture { image, wrap_u, wrap_v })))
    }
}
