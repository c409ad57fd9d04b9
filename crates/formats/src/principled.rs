//! Principled materials, as several formats state them, as plastics and metals.
//!
//! Of base colour `c`, metallic `m`, roughness `alpha` and a dielectric's reflectance `F0` at normal incidence:
//!  - `m = 0` is a dielectric over a base `rho_d = c`. Of `F0` the mean counts, and the refractive index is that of this
//!    mean, as Blender has it. Without reflectance it is diffuse.
//!  - `m = 1` is a metal of `F0 = c`.
//!  - In between, and for `F0` beyond that of a refractive index of 3, the reflectance is free: `rho_d = (1 - m) c`,
//!    `rho_s = m c + (1 - m) F0`.
//!  - A clearcoat over a base that is diffuse (no lobe, or a roughness of one) is the dielectric's lobe.

use unrender_scene::reflectance::{IOR, IOR_MAX, f0_of_ior, ior_of_f0};
use unrender_scene::{BrdfModel, Layering, Material, Rgb};

/// Metallic up to this is none, and one less this is all: rounding of eight bits. Half of it would make mixtures of materials
/// whose texture of metallic is noisy, double of it changes colours by 2 %.
const MIXED: f32 = 0.01;

/// The parameters of a principled material, without its anisotropy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Principled {
    /// The base colour, 0 to 1.
    pub(crate) base: Rgb,
    /// How much of it is metal, 0 to 1.
    pub(crate) metallic: f32,
    /// The roughness of the lobe, Blender's *Roughness* squared.
    pub(crate) alpha: f32,
    /// The reflectance of the dielectric at normal incidence.
    pub(crate) f0: Rgb,
    /// The clearcoat, if there is one.
    pub(crate) coat: Option<Coat>,
}

/// A clearcoat: the reflectance at normal incidence, and the roughness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coat {
    pub(crate) f0: f32,
    pub(crate) alpha: f32,
}

/// A material, and in what it differs from the file's.
pub(crate) struct Reading {
    pub(crate) material: Material,
    /// The end of a sentence about the material.
    pub(crate) doubt: Option<&'static str>,
    /// Whether the lobe is the base's, which may be brushed, and not that of the coat.
    pub(crate) is_own_lobe: bool,
}

impl Principled {
    /// The material in a scene of the BRDF `model`.
    pub(crate) fn material(&self, model: BrdfModel) -> Reading {
        if model.is_principled() { self.principled() } else { own(self.free(), None) }
    }

    /// As a plastic or a metal.
    fn principled(&self) -> Reading {
        let Self { base, metallic, alpha, f0, coat } = *self;
        if metallic > 1.0 - MIXED {
            return own(Material::metal(base, true, alpha), None);
        }
        let mean = f0.element_sum() / 3.0;
        if metallic > MIXED {
            let doubt = "is between a metal and a dielectric; its reflectance was taken as that at normal incidence";
            return own(self.free(), Some(doubt));
        }
        if let Some(Coat { f0, alpha }) = coat.filter(|_| mean <= 0.0 || self.alpha >= 1.0) {
            let material = plastic(base, f0, alpha);
            return Reading { material, doubt: None, is_own_lobe: false };
        }
        if mean <= 0.0 {
            return own(Material::diffuse(base), None);
        }
        if mean > f0_of_ior(IOR_MAX) {
            return own(Self { metallic: 0.0, ..*self }.free(), None);
        }
        let is_grey = (f0 - Rgb::splat(mean)).abs().max_element() < 1e-3;
        let doubt = "has a coloured specular reflectance; its mean was taken";
        own(plastic(base, mean, alpha), (!is_grey).then_some(doubt))
    }

    /// With the reflectance at normal incidence for all directions. A dielectric of roughness one is plainly diffuse.
    pub(crate) fn free(&self) -> Material {
        let Self { base, metallic, alpha, f0, .. } = *self;
        let rho_d = base * (1.0 - metallic);
        let mut rho_s = base * metallic;
        if alpha < 1.0 {
            rho_s += (1.0 - metallic) * f0;
        }
        if rho_s.max_element() <= 0.0 {
            Material::diffuse(rho_d)
        } else {
            Material::isotropic(rho_d, rho_s, alpha)
        }
    }

    /// Whether `material` has not the clearcoat as its lobe, if there is one.
    pub(crate) fn leaves_coat_out(&self, material: &Material) -> bool {
        let is_left_out = |coat: Coat| {
            material.reflectance.is_free()
                || material.rho_s != plastic(Rgb::ZERO, coat.f0, coat.alpha).rho_s
                || material.alpha_x != coat.alpha
        };
        self.coat.is_some_and(is_left_out)
    }
}

fn own(material: Material, doubt: Option<&'static str>) -> Reading {
    Reading { material, doubt, is_own_lobe: true }
}

fn plastic(base: Rgb, f0: f32, alpha: f32) -> Material {
    // The usual index by its own digits, which rounding would lose.
    let ior = if (f0 - f0_of_ior(IOR)).abs() < 1e-6 { IOR } else { ior_of_f0(f0) };
    Material::plastic(base, ior, Layering::AlbedoScaled, alpha)
}
