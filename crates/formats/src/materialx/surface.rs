//! The shaders `standard_surface`, `open_pbr_surface` and `gltf_pbr` as materials.
//!
//! All three are principled materials ([`crate::principled`]): a base colour, metal or dielectric, a roughness `r` with
//! `alpha = r^2`, and a dielectric's reflectance `F0 = ((ior - 1)/(ior + 1))^2` times a weight and a colour. They differ in
//! names, defaults and anisotropy [MaterialX specification 1.39; Autodesk Standard Surface; OpenPBR 1.1; glTF 2.0]. With
//! the anisotropy `a`:
//!
//! ```text
//! standard_surface   alpha/b along, alpha b across the tangent turned by specular_rotation, b = sqrt(1 - a)
//! open_pbr_surface   alpha sqrt(2/(1 + (1 - a)^2)) along the tangent, (1 - a) times that across
//! gltf_pbr           alpha + (1 - alpha) a^2 along the tangent turned by anisotropy_rotation, alpha across
//! ```

use super::inputs::Inputs;
use super::rows::{GLTF, OPEN_PBR, STANDARD};
use crate::entry::Entry;
use crate::principled::{Coat, Principled};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use unrender_scene::reflectance::f0_of_ior;
use unrender_scene::{BrdfModel, Mapped, Material, NormalMap, Rgb, Texture};

/// What a shader is in a scene.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) material: Material,
    /// The normals of a normal map.
    pub(super) normals: Option<Arc<NormalMap>>,
}

/// The names of a shader's inputs with their defaults.
struct Words {
    base: Option<&'static str>,
    base_color: (&'static str, f32),
    metallic: (&'static str, f32),
    specular: &'static str,
    specular_color: &'static str,
    roughness: (&'static str, f32),
    ior: &'static str,
    anisotropy: &'static str,
    rotation: Option<&'static str>,
    coat: &'static str,
    coat_roughness: (&'static str, f32),
    coat_ior: Option<(&'static str, f32)>,
    normal: &'static str,
    brushed: fn(f32, f32) -> [f32; 2],
    /// Radians of the rotation's unit.
    turn: f32,
}

/// A shader that is read.
pub(super) struct Shader {
    pub(super) tag: &'static str,
    pub(super) rows: &'static [Entry],
    words: Words,
}

const STANDARD_SURFACE: Words = Words {
    base: Some("base"),
    base_color: ("base_color", 0.8),
    metallic: ("metalness", 0.0),
    specular: "specular",
    specular_color: "specular_color",
    roughness: ("specular_roughness", 0.2),
    ior: "specular_IOR",
    anisotropy: "specular_anisotropy",
    rotation: Some("specular_rotation"),
    coat: "coat",
    coat_roughness: ("coat_roughness", 0.1),
    coat_ior: Some(("coat_IOR", 1.5)),
    normal: "normal",
    brushed: |alpha, a| {
        let aspect = (1.0 - a).max(MOST_BRUSHED).sqrt();
        [alpha / aspect, alpha * aspect]
    },
    turn: TAU,
};

const OPEN_PBR_SURFACE: Words = Words {
    base: Some("base_weight"),
    base_color: ("base_color", 0.8),
    metallic: ("base_metalness", 0.0),
    specular: "specular_weight",
    specular_color: "specular_color",
    roughness: ("specular_roughness", 0.3),
    ior: "specular_ior",
    anisotropy: "specular_roughness_anisotropy",
    rotation: None,
    coat: "coat_weight",
    coat_roughness: ("coat_roughness", 0.0),
    coat_ior: Some(("coat_ior", 1.6)),
    normal: "geometry_normal",
    brushed: |alpha, a| {
        let across = (1.0 - a).max(MOST_BRUSHED);
        let along = alpha * (2.0 / (1.0 + across * across)).sqrt();
        [along, along * across]
    },
    turn: 0.0,
};

const GLTF_PBR: Words = Words {
    base: None,
    base_color: ("base_color", 1.0),
    metallic: ("metallic", 1.0),
    specular: "specular",
    specular_color: "specular_color",
    roughness: ("roughness", 1.0),
    ior: "ior",
    anisotropy: "anisotropy_strength",
    rotation: Some("anisotropy_rotation"),
    coat: "clearcoat",
    coat_roughness: ("clearcoat_roughness", 0.0),
    coat_ior: None,
    normal: "normal",
    brushed: |alpha, a| [alpha + (1.0 - alpha) * a * a, alpha],
    turn: 1.0,
};

/// The least of one minus the anisotropy: without it the rougher alpha would be infinite. At half of it lobes are sharper
/// across than any that is rendered; double of it would change files that state 0.998.
const MOST_BRUSHED: f32 = 1e-3;
/// The refractive index of shaders that state none, by their definitions. At half of the difference from one (1.25) they
/// would reflect 1.2 % instead of 4 %, at double of it (2.0) 11 %.
const IOR: f32 = 1.5;

/// The shaders that are read.
pub(super) const SHADERS: [Shader; 3] = [
    Shader { tag: "standard_surface", rows: &STANDARD, words: STANDARD_SURFACE },
    Shader { tag: "open_pbr_surface", rows: &OPEN_PBR, words: OPEN_PBR_SURFACE },
    Shader { tag: "gltf_pbr", rows: &GLTF, words: GLTF_PBR },
];

impl Shader {
    /// The surface of `inputs` in a scene of the BRDF `model`.
    pub(super) fn surface(&self, inputs: &mut Inputs, model: BrdfModel) -> Surface {
        let words = &self.words;
        inputs.tell_of_the_unread(self.rows);
        let weight = words.base.map_or(1.0, |name| inputs.number((name, 1.0)));
        let metallic = inputs.number(words.metallic);
        let (base, texture) = base(inputs, words.base_color, (weight, metallic));
        let roughness = inputs.number(words.roughness);
        let alpha = roughness * roughness;
        let ior = inputs.positive((words.ior, IOR));
        let weight = inputs.number((words.specular, 1.0));
        let color = inputs.color((words.specular_color, 1.0));
        let f0 = (f0_of_ior(ior) * color).min(Rgb::ONE) * weight;
        let stated = Principled { base, metallic, alpha, f0, coat: coat(inputs, words) };
        let reading = stated.material(model);
        if let Some(doubt) = reading.doubt {
            inputs.tell(doubt);
        }
        if stated.leaves_coat_out(&reading.material) {
            inputs.tell("its coat was left out; there is one specular lobe a surface");
        }
        let mut material = reading.material;
        material.texture = texture;
        if reading.is_own_lobe && material.rho_s.max_element() > 0.0 {
            brush(inputs, words, &mut material);
        }
        Surface { material, normals: normals(inputs, words.normal) }
    }
}

/// The base colour: the mean, and the texture of what is no metal.
fn base(
    inputs: &mut Inputs,
    name: (&'static str, f32),
    (weight, metallic): (f32, f32),
) -> (Rgb, Option<Arc<Texture>>) {
    let (mean, picture) = inputs.color_or_picture(name);
    let mean = (mean * weight).clamp(Rgb::ZERO, Rgb::ONE);
    let Some(Mapped { image, wrap_u, wrap_v }) = picture else { return (mean, None) };
    if metallic >= 1.0 {
        inputs.tell("its base_color is a picture, of which a metal has the mean");
        return (mean, None);
    }
    let scaled = |texel: &Rgb| (*texel * weight * (1.0 - metallic)).clamp(Rgb::ZERO, Rgb::ONE);
    (mean, Some(Arc::new(Texture { image: image.map(scaled), wrap_u, wrap_v })))
}

fn coat(inputs: &mut Inputs, words: &Words) -> Option<Coat> {
    let weight = inputs.number((words.coat, 0.0));
    if weight <= 0.0 {
        return None;
    }
    let roughness = inputs.number(words.coat_roughness);
    let ior = words.coat_ior.map_or(IOR, |name| inputs.positive(name));
    Some(Coat { f0: weight * f0_of_ior(ior), alpha: roughness * roughness })
}

/// Brushes the isotropic lobe of `material`; as everywhere, `alpha_x` becomes the lesser roughness.
fn brush(inputs: &mut Inputs, words: &Words, material: &mut Material) {
    let anisotropy = inputs.number((words.anisotropy, 0.0));
    if anisotropy <= 0.0 || material.alpha_x <= 0.0 {
        return;
    }
    let turn = words.rotation.map_or(0.0, |name| inputs.any_number((name, 0.0)) * words.turn);
    let [along, across] = (words.brushed)(material.alpha_x, anisotropy);
    (material.alpha_x, material.alpha_y) = (across, along);
    material.theta_rad = (turn + FRAC_PI_2).rem_euclid(PI);
}

fn normals(inputs: &mut Inputs, name: &'static str) -> Option<Arc<NormalMap>> {
    let (picture, scale) = inputs.normals(name)?;
    Some(Arc::new(NormalMap::decoded(&picture, scale, true)))
}
