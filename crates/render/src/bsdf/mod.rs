//! How a surface reflects: `f = rho_d/pi + rho_s w` [Boivin & Gagalowicz 2002, section 4.2].
//!
//! One BRDF is one file. To add another: give it `value`, `pdf`, `sample` and the derivatives of its
//! shape in a file of its own, let [`Bsdf`] choose it, and run it through `tests/bsdf_laws.rs`.
//!
//! All directions here are unit vectors in the *brushed frame*: x along the brushed direction, z
//! the shading normal on the viewer's side. Both point away from the surface. `wo` is where the
//! light goes (towards the camera), `wi` where it comes from.

pub mod ggx;
pub mod lambert;
pub mod lobe;
pub mod mirror;
pub mod ward;

use crate::caustic::Images;
use glam::Vec3;
use lobe::GlossyLobe;
use unrender_scene::color::luminance;
use unrender_scene::{BrdfModel, Material, Rgb};
use ward::LobeDerivatives;

/// The specular part of a reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// There is none.
    None,
    /// A perfect mirror.
    Mirror,
    /// A lobe with a roughness.
    Glossy(GlossyLobe),
}

/// What `f` is made of in one pair of directions: `f = rho_d diffuse + rho_s specular.value`. So
/// `diffuse` is `df/d rho_d`, `specular.value` is `df/d rho_s`, and `rho_s` times the other members
/// of `specular` are the derivatives of `f` by the shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// Of the diffuse reflectance, sr^-1.
    pub diffuse: f32,
    /// Of the specular reflectance, sr^-1.
    pub specular: LobeDerivatives,
}

impl Terms {
    /// The reflectance that they make, sr^-1.
    pub fn value(&self, rho_d: Rgb, rho_s: Rgb) -> Rgb {
        rho_d * self.diffuse + rho_s * self.specular.value
    }
}

impl Specular {
    /// The terms of `f` without the cosine, for two directions above a surface with this specular
    /// part. A perfect mirror counts nothing here.
    #[inline]
    pub fn terms(&self, wo: Vec3, wi: Vec3) -> Terms {
        let specular = match self {
            Self::Glossy(lobe) => lobe.derivatives(wo, wi),
            _ => LobeDerivatives::default(),
        };
        Terms { diffuse: lambert::VALUE, specular }
    }
}

/// A reflectance at one point, ready to be evaluated and sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf<'a> {
    /// Diffuse reflectance.
    pub rho_d: Rgb,
    /// Specular reflectance.
    pub rho_s: Rgb,
    /// The shape of the specular part.
    pub specular: Specular,
    /// The probability with which sampling takes the specular part.
    specular_share: f32,
    /// Where the diffuse part looks for light beside the cosine.
    images: &'a Images,
}

/// A direction drawn from a [`Bsdf`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where the light comes from.
    pub wi: Vec3,
    /// `f cos_i / pdf`.
    pub weight: Rgb,
    /// Density of `wi` over solid angle; infinite for a perfect mirror.
    pub pdf: f32,
}

impl<'a> Bsdf<'a> {
    /// The reflectance of `material` with the given diffuse part.
    pub fn new(material: &Material, rho_d: Rgb, model: impl Into<BrdfModel>) -> Self {
        let specular = if material.is_delta() {
            Specular::Mirror
        } else if material.is_glossy() {
            Specular::Glossy(GlossyLobe::new(model, material.alpha_x, material.alpha_y))
        } else {
            Specular::None
        };
        Self::with(rho_d, material.rho_s, specular)
    }

    /// The reflectance of these two parts.
    pub fn with(rho_d: Rgb, rho_s: Rgb, specular: Specular) -> Self {
        let (diffuse_power, specular_power) = (luminance(rho_d), luminance(rho_s));
        let specular_share = match specular {
            Specular::None => 0.0,
            _ if diffuse_power <= 0.0 => 1.0,
            _ => (specular_power / (diffuse_power + specular_power)).clamp(0.1, 0.9),
        };
        Self { rho_d, rho_s, specular, specular_share, images: &Images::NONE }
    }

    /// The same reflectance, sampled towards `images` too, which are given in its frame.
    pub fn looking_at(self, images: &'a Images) -> Self {
        Self { images, ..self }
    }

    /// True if the surface reflects nothing.
    pub fn is_black(&self) -> bool {
        self.rho_d.max_element() <= 0.0 && self.specular == Specular::None
    }

    /// True if nothing but a perfect mirror is there, which no light sample can meet.
    pub fn is_pure_mirror(&self) -> bool {
        self.specular == Specular::Mirror && self.specular_share >= 1.0
    }

    /// The probability with which sampling takes the specular part.
    pub fn specular_share(&self) -> f32 {
        self.specular_share
    }

    /// `f` without the cosine, sr^-1. A perfect mirror counts nothing here.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.value_and_pdf(wo, wi).0
    }

    /// The density over solid angle with which [`Bsdf::sample`] draws `wi`, mirrors aside.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.value_and_pdf(wo, wi).1
    }

    /// [`Bsdf::value`] and [`Bsdf::pdf`], which share most of the work.
    pub fn value_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let share = self.images.share();
        let mut diffuse = (1.0 - share) * lambert::pdf(wi);
        if share > 0.0 {
            diffuse += share * self.images.pdf(wi);
        }
        let value = self.rho_d * lambert::VALUE;
        let pdf = (1.0 - self.specular_share) * diffuse;
        match self.specular {
            Specular::Glossy(lobe) => {
                let (specular, density) = lobe.value_and_pdf(wo, wi);
                (value + self.rho_s * specular, pdf + self.specular_share * density)
            }
            Specular::None | Specular::Mirror => (value, pdf),
        }
    }

    /// Draws `wi` from three numbers in [0, 1); none if the direction falls below the surface.
    // Out of line, as the compiler would have it with several callers, pictures take 2 % longer.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let take_specular = u[0] < self.specular_share;
        let wi = match self.specular {
            Specular::Mirror if take_specular => {
                let weight = self.rho_s / self.specular_share;
                return Some(BsdfSample { wi: mirror::reflect(wo), weight, pdf: f32::INFINITY });
            }
            Specular::Glossy(lobe) if take_specular => lobe.sample(wo, [u[1], u[2]]),
            _ => self.sample_diffuse(u),
        };
        let (value, pdf) = self.value_and_pdf(wo, wi);
        if wi.z <= 0.0 || pdf <= 0.0 || !pdf.is_finite() {
            return None;
        }
        Some(BsdfSample { wi, weight: value * (wi.z / pdf), pdf })
    }

    /// A direction for the diffuse part, given that `u[0]` chose it.
    fn sample_diffuse(&self, u: [f32; 3]) -> Vec3 {
        let share = self.images.share();
        let pick = (u[0] - self.specular_share) / (1.0 - self.specular_share);
        if pick < share {
            return self.images.sample(pick / share, [u[1], u[2]]);
        }
        lambert::sample([u[1], u[2]])
    }
}
