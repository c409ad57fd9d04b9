//! Reflectance: `f = rho_d/pi + rho_s w` [Boivin and Gagalowicz 2002, section 4.2], or with the reflectance of a
//! dielectric or a metal in the place of `rho_s` ([`coat`]).
//!
//! One lobe is one file. To add another: give it `value`, `pdf`, `sample` and the derivatives by
//! its shape parameters in a file of its own, let [`Bsdf`] choose it, and run it through
//! `tests/bsdf_laws.rs`.
//!
//! All directions are unit vectors in the *anisotropy frame*: x along the anisotropy direction (the
//! direction of brushing), z the shading normal on the viewer's side. Both `wo`, towards the
//! camera, and `wi`, towards the light, point away from the surface.

pub mod coat;
pub mod ggx;
pub mod lambert;
pub mod lobe;
pub mod mirror;
pub mod ward;

use crate::guiding::VmfMixture;
use coat::{Base, Coat};
use glam::Vec3;
use lobe::GlossyLobe;
use unrender_scene::color::luminance;
use unrender_scene::{BrdfModel, Material, Rgb};
use ward::LobeDerivatives;

/// The specular term of a BRDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// None.
    None,
    /// A perfect mirror.
    Mirror,
    /// A rough lobe.
    Glossy(GlossyLobe),
}

/// `f` for one pair of directions, and its derivatives; sr^-1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// `f`.
    pub value: Rgb,
    /// `df / d rho_d`.
    pub by_rho_d: f32,
    /// `df / d rho_s`.
    pub by_rho_s: Rgb,
    /// `df / d alpha_x`.
    pub by_alpha_x: Rgb,
    /// `df / d alpha_y`.
    pub by_alpha_y: Rgb,
    /// `df / d theta`, per radian.
    pub by_theta: Rgb,
}

/// The BRDF at one point, prepared for evaluation and sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf<'a> {
    /// Diffuse reflectance.
    pub rho_d: Rgb,
    /// Specular reflectance.
    pub rho_s: Rgb,
    /// The specular term.
    pub specular: Specular,
    /// How it reflects.
    pub coat: Coat,
    /// The probability with which sampling chooses the specular term.
    specular_share: f32,
    /// Guides the sampling of the diffuse term, beside the cosine.
    guide: &'a VmfMixture,
    /// The normal of the mesh below bumps that shade themselves, in the anisotropy frame.
    mesh: Option<Vec3>,
}

/// A direction drawn from a [`Bsdf`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// `f cos_i / pdf`.
    pub weight: Rgb,
    /// What `weight` would be had the direction been drawn without a guide.
    pub unguided: Rgb,
    /// Density of `wi` over solid angle; infinite for a perfect mirror.
    pub pdf: f32,
}

impl<'a> Bsdf<'a> {
    /// The BRDF of `material` with the diffuse reflectance `rho_d`.
    pub fn new(material: &Material, rho_d: Rgb, model: impl Into<BrdfModel>) -> Self {
        let specular = if material.is_delta() {
            Specular::Mirror
        } else if material.is_glossy() {
            Specular::Glossy(GlossyLobe::new(model, material.alpha_x, material.alpha_y))
        } else {
            Specular::None
        };
        // Without a specular term nothing lies over the base.
        let coat = if specular == Specular::None { Coat::Free } else { Coat::new(material) };
        Self { coat, ..Self::with(rho_d, material.rho_s, specular) }
    }

    /// The BRDF of a diffuse and a specular term of free reflectance.
    pub fn with(rho_d: Rgb, rho_s: Rgb, specular: Specular) -> Self {
        let (coat, guide) = (Coat::Free, &VmfMixture::NONE);
        let specular_share = specular_share(rho_d, rho_s, specular);
        Self { rho_d, rho_s, specular, coat, specular_share, guide, mesh: None }
    }

    /// The same BRDF over another base.
    #[inline]
    pub fn over(self, rho_d: Rgb) -> Self {
        Self { rho_d, specular_share: specular_share(rho_d, self.rho_s, self.specular), ..self }
    }

    /// The same BRDF, with the sampling of its diffuse term guided by `guide`, given in its frame.
    pub fn guided_by(self, guide: &'a VmfMixture) -> Self {
        Self { guide, ..self }
    }

    /// The same BRDF on bumps that shade themselves, where `mesh` is the unit normal of the mesh below, in its frame.
    pub fn bumped(self, mesh: Vec3) -> Self {
        Self { mesh: Some(mesh), ..self }
    }

    /// The normal of [`Bsdf::bumped`].
    pub fn mesh(&self) -> Option<Vec3> {
        self.mesh
    }

    /// Whether it is the same in all directions.
    pub fn is_lambertian(&self) -> bool {
        self.specular == Specular::None && self.mesh.is_none()
    }

    /// The factor of the base for light from `wi`: one, but for bumps that shade themselves.
    #[inline]
    fn lit(&self, wi: Vec3) -> f32 {
        self.mesh.map_or(1.0, |mesh| lambert::lit(mesh, wi))
    }

    /// True if the surface reflects nothing.
    pub fn is_black(&self) -> bool {
        self.rho_d.max_element() <= 0.0 && self.specular == Specular::None
    }

    /// True if the surface is a perfect mirror without diffuse term, for which light samples are
    /// useless.
    pub fn is_pure_mirror(&self) -> bool {
        self.specular == Specular::Mirror && self.specular_share >= 1.0
    }

    /// The probability with which sampling chooses the specular term.
    pub fn specular_share(&self) -> f32 {
        self.specular_share
    }

    /// `f` without the cosine, sr^-1. A perfect mirror has the value zero.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Rgb {
        self.value_and_pdf(wo, wi).0
    }

    /// The density over solid angle with which [`Bsdf::sample`] draws `wi`, without perfect
    /// mirrors.
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.value_and_pdf(wo, wi).1
    }

    /// [`Bsdf::value`] and [`Bsdf::pdf`], which share most of the work.
    pub fn value_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let (value, unguided) = self.value_and_unguided_pdf(wo, wi);
        (value, self.guided(unguided, wi))
    }

    /// [`Bsdf::value`], and the density of `wi` if directions were drawn without the guide.
    #[inline]
    fn value_and_unguided_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let value = self.rho_d * (lambert::VALUE * self.coat.base(wo.z, wi.z) * self.lit(wi));
        let pdf = (1.0 - self.specular_share) * lambert::pdf(wi);
        match self.specular {
            Specular::Glossy(lobe) => {
                let (specular, density) = lobe.value_and_pdf(wo, wi);
                let reflectance = self.coat.reflectance(self.rho_s, wo, wi);
                (value + reflectance * specular, pdf + self.specular_share * density)
            }
            Specular::None | Specular::Mirror => (value, pdf),
        }
    }

    /// `f` and its derivatives for two directions above the surface, over a base of the reflectance `rho_d`. A
    /// perfect mirror, a delta distribution, has the value zero.
    #[inline]
    pub fn terms(&self, rho_d: Rgb, wo: Vec3, wi: Vec3) -> Terms {
        let Base { factor, by_alpha: base_by_alpha } = self.coat.base_slope(wo.z, wi.z);
        let lit = self.lit(wi);
        let by_rho_d = lambert::VALUE * factor * lit;
        let base = Terms { value: rho_d * by_rho_d, by_rho_d, ..Terms::default() };
        let Specular::Glossy(lobe) = self.specular else { return base };
        let LobeDerivatives { value, by_alpha_x, by_alpha_y, by_theta } = lobe.derivatives(wo, wi);
        let factor = self.coat.factor(self.rho_s, wo, wi);
        let terms = Terms {
            value: base.value + factor.value * value,
            by_rho_d,
            by_rho_s: factor.by_rho_s * value,
            by_alpha_x: factor.value * by_alpha_x,
            by_alpha_y: factor.value * by_alpha_y,
            by_theta: factor.value * by_theta,
        };
        if self.coat == Coat::Free {
            return terms;
        }
        // The coat knows the mean roughness alone, whose derivatives by the two are these.
        let by_mean = rho_d * (lambert::VALUE * base_by_alpha * lit) + factor.by_alpha * value;
        let [by_x, by_y] = lobe.mean_alpha_slopes();
        Terms {
            by_alpha_x: terms.by_alpha_x + by_mean * by_x,
            by_alpha_y: terms.by_alpha_y + by_mean * by_y,
            ..terms
        }
    }

    /// The reflectance as a perfect mirror towards `wo`, with its derivative by `rho_s`; zero if it is none.
    #[inline]
    pub fn mirror_terms(&self, cos: f32) -> Terms {
        if self.specular != Specular::Mirror {
            return Terms::default();
        }
        Terms {
            value: self.coat.mirror(self.rho_s, cos),
            by_rho_s: Rgb::splat(self.coat.mirror_by_rho_s(cos)),
            ..Terms::default()
        }
    }

    /// The density of a direction that has the density `unguided` without the guide, which draws a
    /// share of the diffuse directions instead of the cosine.
    #[inline]
    fn guided(&self, unguided: f32, wi: Vec3) -> f32 {
        let share = self.guide.share();
        if share <= 0.0 || unguided <= 0.0 {
            return unguided;
        }
        let moved = share * (self.guide.pdf(wi) - lambert::pdf(wi));
        unguided + (1.0 - self.specular_share) * moved
    }

    /// Draws `wi` from three numbers in [0, 1); none if the direction falls below the surface.
    // Without this the compiler does not inline it where there are several callers, and pictures
    // take 2 % longer.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let take_specular = u[0] < self.specular_share;
        let wi = match self.specular {
            Specular::Mirror if take_specular => {
                let reflectance = self.coat.mirror(self.rho_s, wo.z);
                let (wi, weight) = (mirror::reflect(wo), reflectance / self.specular_share);
                return Some(BsdfSample { wi, weight, unguided: weight, pdf: f32::INFINITY });
            }
            Specular::Glossy(lobe) if take_specular => lobe.sample(wo, [u[1], u[2]]),
            _ => self.sample_diffuse(u),
        };
        let (value, unguided) = self.value_and_unguided_pdf(wo, wi);
        let pdf = self.guided(unguided, wi);
        if wi.z <= 0.0 || pdf <= 0.0 || !pdf.is_finite() {
            return None;
        }
        let value = value * wi.z;
        Some(BsdfSample { wi, weight: value / pdf, unguided: value / unguided, pdf })
    }

    /// A direction for the diffuse term, given that `u[0]` chose it.
    fn sample_diffuse(&self, u: [f32; 3]) -> Vec3 {
        let share = self.guide.share();
        let pick = (u[0] - self.specular_share) / (1.0 - self.specular_share);
        if pick < share {
            return self.guide.sample(pick / share, [u[1], u[2]]);
        }
        lambert::sample([u[1], u[2]])
    }
}

/// The probability with which sampling chooses the specular term.
fn specular_share(rho_d: Rgb, rho_s: Rgb, specular: Specular) -> f32 {
    let (diffuse_power, specular_power) = (luminance(rho_d), luminance(rho_s));
    match specular {
        Specular::None => 0.0,
        _ if diffuse_power <= 0.0 => 1.0,
        _ => (specular_power / (diffuse_power + specular_power)).clamp(0.1, 0.9),
    }
}
