//! glTF's metallic-roughness materials as plastics and metals.
//!
//! Of base colour `c`, metallic `m` and roughness `r`, with `alpha = r^2`:
//!  - `m = 0` is a dielectric over a base `rho_d = c`. `F0 = ((ior - 1)/(ior + 1))^2 specularColor specular`, of which
//!    the mean counts, and `ior` is that of this `F0`, as Blender has it. Without reflectance (`specular = 0`) it is
//!    diffuse.
//!  - `m = 1` is a metal of `F0 = c`.
//!  - In between, and for `F0` beyond that of a refractive index of 3, the reflectance is free: `rho_d = (1 - m) c`,
//!    `rho_s = m c + (1 - m) F0`.
//!  - A clearcoat over a base that is diffuse (no lobe, or a roughness of one) is the dielectric's lobe.

use super::document::MaterialExtensions;
use super::ward;
use unrender_scene::reflectance::{IOR, IOR_MAX, f0_of_ior, ior_of_f0};
use unrender_scene::{Layering, Material, Rgb};

/// Metallic up to this is none, and one less this is all: rounding of eight bits. Half of it would make mixtures of materials
/// whose texture of metallic is noisy, double of it changes colours by 2 %.
const MIXED: f32 = 0.01;

/// A material, and in what it differs from glTF's.
pub(super) struct Reading {
    pub(super) material: Material,
    /// The end of a sentence about the material.
    pub(super) doubt: Option<&'static str>,
}

/// The material of glTF's parameters.
pub(super) fn from_gltf(
    base: Rgb,
    metallic: f32,
    roughness: f32,
    extensions: &MaterialExtensions,
) -> Reading {
    let certain = |material: Material| Reading { material, doubt: None };
    if metallic > 1.0 - MIXED {
        let metal = Material::metal(base, true, roughness * roughness);
        return certain(ward::turned(metal, extensions));
    }
    let f0 = ward::dielectric_f0(extensions);
    let mean = f0.element_sum() / 3.0;
    if metallic > MIXED {
        let free = ward::from_gltf(base, metallic, roughness, extensions);
        let doubt = "is between a metal and a dielectric; its reflectance was taken as that at normal incidence";
        return Reading { material: free, doubt: Some(doubt) };
    }
    if let Some(coat) = coat(extensions).filter(|_| mean <= 0.0 || roughness >= 1.0) {
        let Coat { f0, alpha } = coat;
        return certain(plastic(base, f0, alpha));
    }
    if mean <= 0.0 {
        return certain(Material::diffuse(base));
    }
    if mean > f0_of_ior(IOR_MAX) {
        return certain(ward::from_gltf(base, 0.0, roughness, extensions));
    }
    let is_grey = (f0 - Rgb::splat(mean)).abs().max_element() < 1e-3;
    let doubt = "has a coloured specular reflectance; its mean was taken";
    Reading {
        material: ward::turned(plastic(base, mean, roughness * roughness), extensions),
        doubt: (!is_grey).then_some(doubt),
    }
}

/// A clearcoat: the reflectance at normal incidence, and the roughness.
struct Coat {
    f0: f32,
    alpha: f32,
}

fn coat(extensions: &MaterialExtensions) -> Option<Coat> {
    let coat = extensions.clearcoat.as_ref()?;
    let factor = coat.clearcoat_factor.clamp(0.0, 1.0) as f32;
    let roughness = coat.clearcoat_roughness_factor.clamp(0.0, 1.0) as f32;
    let coat = Coat { f0: factor * f0_of_ior(IOR), alpha: roughness * roughness };
    (factor > 0.0).then_some(coat)
}

/// Whether there is a clearcoat that is not the material's lobe.
pub(super) fn leaves_coat_out(material: &Material, extensions: &MaterialExtensions) -> bool {
    let is_left_out = |coat: Coat| {
        material.reflectance.is_free()
            || material.rho_s != plastic(Rgb::ZERO, coat.f0, coat.alpha).rho_s
            || material.alpha_x != coat.alpha
    };
    coat(extensions).is_some_and(is_left_out)
}

fn plastic(base: Rgb, f0: f32, alpha: f32) -> Material {
    // The usual index by its own digits, which rounding would lose.
    let ior = if (f0 - f0_of_ior(IOR)).abs() < 1e-6 { IOR } else { ior_of_f0(f0) };
    Material::plastic(base, ior, Layering::AlbedoScaled, alpha)
}
