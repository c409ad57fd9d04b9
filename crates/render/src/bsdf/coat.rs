//! What the specular term reflects in a pair of directions, and what it leaves to the base under it
//! ([`unrender_scene::reflectance`]).
//!
//! With `c = wo . h` and the lobe `w` of unit reflectance:
//!
//! ```text
//! free        f = rho_d/pi                                 + rho_s w
//! dielectric  f = rho_d/pi (1 - E(o))                      + F(c; ior) w     albedo-scaled
//!             f = rho_d/pi T(i) T(o)/Tavg              + F(c; ior) w     coupled
//! metal       f = rho_d/pi                                 + (rho_s + (1 - rho_s)(1 - c)^5) m(o) w
//! ```
//!
//! `m(o) = 1 + Fms (1 - E1(o))/E1(o)` is the light that a rough metal scatters more than once, with `E1` the albedo of
//! the lobe that reflects everything and `Fms = Fss E1avg/(1 - Fss (1 - E1avg))`, where `Fss` is the mean reflectance
//! [Turquin 2019]; it is one without it. `m` and the albedo-scaled base depend on the direction of the viewer alone, so
//! that these are not reciprocal: `wo` is always the side of the camera.

use glam::Vec3;
use unrender_scene::lobe_albedo::AlbedoSlope;
use unrender_scene::reflectance::{self, fresnel, schlick};
use unrender_scene::{Layering, LobeAlbedo, Material, Reflectance, Rgb};

/// The least albedo that is left to a base, and that a lobe has: with double of it a base under a dielectric of a
/// refractive index above 1000 would change, with half of it nothing does; it keeps quotients finite.
const LEAST: f32 = 1e-4;

/// How the specular term of a BRDF reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coat {
    /// `rho_s` in every direction.
    Free,
    /// By Fresnel's equations, over a base.
    Dielectric(Dielectric),
    /// By Schlick's approximation.
    Metal(Option<Multiscatter>),
}

/// A dielectric, prepared for evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    ior: f32,
    layering: Layering,
    /// What its lobe takes from the base, and the mean of that.
    taken: LobeAlbedo,
    mean: AlbedoSlope,
}

/// The light that a rough metal scatters more than once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiscatter {
    albedo: LobeAlbedo,
    mean: AlbedoSlope,
}

/// The factor of `rho_d / pi`, and its derivative by the roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Base {
    pub(super) factor: f32,
    pub(super) by_alpha: f32,
}

/// The factor of the lobe, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor {
    pub(super) value: Rgb,
    pub(super) by_rho_s: Rgb,
    pub(super) by_alpha: Rgb,
}

impl Coat {
    /// That of `material`. The albedo of an anisotropic lobe is taken as that of the isotropic one of the mean roughness
    /// `sqrt(alpha_x alpha_y)`.
    pub fn new(material: &Material) -> Self {
        let alpha = (material.alpha_x * material.alpha_y).sqrt();
        match material.reflectance {
            Reflectance::Free => Self::Free,
            Reflectance::Dielectric { ior, layering } => {
                let taken = LobeAlbedo::over(layering, ior, alpha);
                Self::Dielectric(Dielectric { ior, layering, taken, mean: taken.mean() })
            }
            Reflectance::Metal { multiscatter } => {
                let albedo = LobeAlbedo::white(alpha);
                let rough = Multiscatter { albedo, mean: albedo.mean() };
                Self::Metal((multiscatter && alpha > 0.0).then_some(rough))
            }
        }
    }

    /// The factor of `rho_d / pi` for the light from `wi` that leaves towards `wo`, by their cosines.
    #[inline]
    pub fn base(&self, cos_o: f32, cos_i: f32) -> f32 {
        let Self::Dielectric(coat) = self else { return 1.0 };
        let out = 1.0 - coat.taken.at(cos_o);
        match coat.layering {
            Layering::AlbedoScaled => out,
            Layering::Coupled => {
                out * (1.0 - coat.taken.at(cos_i)) / (1.0 - coat.mean.value).max(LEAST)
            }
        }
    }

    /// [`Coat::base`] with its derivative by the mean roughness.
    #[inline]
    pub(super) fn base_slope(&self, cos_o: f32, cos_i: f32) -> Base {
        let Self::Dielectric(coat) = self else { return Base { factor: 1.0, by_alpha: 0.0 } };
        let out = coat.taken.slope_at(cos_o);
        let left = (1.0 - out.value).max(LEAST);
        match coat.layering {
            Layering::AlbedoScaled => Base { factor: 1.0 - out.value, by_alpha: -out.by_alpha },
            Layering::Coupled => {
                let into = coat.taken.slope_at(cos_i);
                let (entering, mean) =
                    ((1.0 - into.value).max(LEAST), (1.0 - coat.mean.value).max(LEAST));
                let factor = (1.0 - out.value) * (1.0 - into.value) / mean;
                let relative =
                    coat.mean.by_alpha / mean - out.by_alpha / left - into.by_alpha / entering;
                Base { factor, by_alpha: factor * relative }
            }
        }
    }

    /// The reflectance of the lobe for the light from `wi` that leaves towards `wo`.
    #[inline]
    pub fn reflectance(&self, rho_s: Rgb, wo: Vec3, wi: Vec3) -> Rgb {
        match self {
            Self::Free => rho_s,
            Self::Dielectric(coat) => Rgb::splat(fresnel(half_cosine(wo, wi), coat.ior)),
            Self::Metal(rough) => {
                let once = rho_s + (Rgb::ONE - rho_s) * schlick(half_cosine(wo, wi));
                rough.map_or(once, |rough| once * rough.factor(rho_s, wo.z).value)
            }
        }
    }

    /// The reflectance as a perfect mirror, at the cosine `cos`.
    #[inline]
    pub fn mirror(&self, rho_s: Rgb, cos: f32) -> Rgb {
        match self {
            Self::Free => rho_s,
            Self::Dielectric(coat) => Rgb::splat(fresnel(cos, coat.ior)),
            Self::Metal(_) => rho_s + (Rgb::ONE - rho_s) * schlick(cos),
        }
    }

    /// The derivative of [`Coat::mirror`] by `rho_s`.
    #[inline]
    pub(crate) fn mirror_by_rho_s(&self, cos: f32) -> f32 {
        match self {
            Self::Free => 1.0,
            Self::Dielectric(_) => 0.0,
            Self::Metal(_) => 1.0 - schlick(cos),
        }
    }

    /// [`Coat::reflectance`] with its derivatives.
    #[inline]
    pub(super) fn factor(&self, rho_s: Rgb, wo: Vec3, wi: Vec3) -> Factor {
        match self {
            Self::Free => Factor { value: rho_s, by_rho_s: Rgb::ONE, by_alpha: Rgb::ZERO },
            Self::Dielectric(coat) => {
                let value = Rgb::splat(fresnel(half_cosine(wo, wi), coat.ior));
                Factor { value, by_rho_s: Rgb::ZERO, by_alpha: Rgb::ZERO }
            }
            Self::Metal(rough) => {
                let white = schlick(half_cosine(wo, wi));
                let once = rho_s + (Rgb::ONE - rho_s) * white;
                let by_rho_s = Rgb::splat(1.0 - white);
                let Some(rough) = rough else {
                    return Factor { value: once, by_rho_s, by_alpha: Rgb::ZERO };
                };
                let more = rough.factor(rho_s, wo.z);
                Factor {
                    value: once * more.value,
                    by_rho_s: by_rho_s * more.value + once * more.by_rho_s,
                    by_alpha: once * more.by_alpha,
                }
            }
        }
    }
}

impl Multiscatter {
    /// `m` towards the cosine `cos_o`.
    #[inline]
    fn factor(&self, rho_s: Rgb, cos_o: f32) -> Factor {
        let AlbedoSlope { value, by_alpha } = self.albedo.slope_at(cos_o);
        let value = value.max(LEAST);
        let missing = (1.0 - value) / value;
        let missing_by_alpha = -by_alpha / (value * value);
        // Fss, Fms and their derivatives.
        let mean = reflectance::metal_mean(rho_s);
        let all = self.mean.value;
        let rest = Rgb::ONE - mean * (1.0 - all);
        let rest = rest.max(Rgb::splat(LEAST));
        let several = mean * all / rest;
        let by_mean = Rgb::splat(all) / (rest * rest);
        let by_all = mean * (Rgb::ONE - mean) / (rest * rest);
        Factor {
            value: Rgb::ONE + several * missing,
            by_rho_s: by_mean * (20.0 / 21.0 * missing),
            by_alpha: several * missing_by_alpha + by_all * (self.mean.by_alpha * missing),
        }
    }
}

/// `wo . h`, with `h` the unit half vector: half the length of the sum of the two unit vectors.
#[inline]
fn half_cosine(wo: Vec3, wi: Vec3) -> f32 {
    0.5 * (wo + wi).length()
}
