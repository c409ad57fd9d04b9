//! The glossy lobe of a scene: Ward's or GGX, by the scene's [`BrdfModel`].

use super::ggx::GgxLobe;
use super::ward::{LobeDerivatives, WardLobe};
use glam::Vec3;
use unrender_scene::{BrdfModel, Layering};

/// A rough lobe, for `rho_s = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GlossyLobe {
    /// Ward's.
    Ward(WardLobe),
    /// GGX.
    Ggx(GgxLobe),
}

impl GlossyLobe {
    /// A lobe with roughness `alpha_x` along and `alpha_y` across the anisotropy direction; both
    /// are raised to [`ALPHA_MIN`](super::ward::ALPHA_MIN).
    pub fn new(model: impl Into<BrdfModel>, alpha_x: f32, alpha_y: f32) -> Self {
        match model.into() {
            BrdfModel::Ward(form) => Self::Ward(WardLobe::new(form, alpha_x, alpha_y)),
            BrdfModel::Principled(Layering::Coupled) => {
                Self::Ggx(GgxLobe::new(alpha_x, alpha_y).masked_apart())
            }
            BrdfModel::Ggx | BrdfModel::Principled(Layering::AlbedoScaled) => {
                Self::Ggx(GgxLobe::new(alpha_x, alpha_y))
            }
        }
    }

    /// `w`, sr^-1, for two directions above the surface.
    #[inline]
    pub fn value(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Ward(lobe) => lobe.value(wo, wi),
            Self::Ggx(lobe) => lobe.value(wo, wi),
        }
    }

    /// The derivatives of the mean roughness `sqrt(alpha_x alpha_y)` by `alpha_x` and by `alpha_y`.
    #[inline]
    pub(super) fn mean_alpha_slopes(&self) -> [f32; 2] {
        let [x, y] = match self {
            Self::Ward(lobe) => lobe.alphas(),
            Self::Ggx(lobe) => lobe.alphas(),
        };
        [0.5 * (y / x).sqrt(), 0.5 * (x / y).sqrt()]
    }

    /// [`GlossyLobe::value`] with its derivatives.
    #[inline]
    pub fn derivatives(&self, wo: Vec3, wi: Vec3) -> LobeDerivatives {
        match self {
            Self::Ward(lobe) => lobe.derivatives(wo, wi),
            Self::Ggx(lobe) => lobe.derivatives(wo, wi),
        }
    }

    /// The density over solid angle with which [`GlossyLobe::sample`] draws `wi`.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Ward(lobe) => lobe.pdf(wo, wi),
            Self::Ggx(lobe) => lobe.pdf(wo, wi),
        }
    }

    /// [`GlossyLobe::value`] and [`GlossyLobe::pdf`], which share most of the work.
    #[inline]
    pub fn value_and_pdf(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        match self {
            Self::Ward(lobe) => lobe.value_and_pdf(wo, wi),
            Self::Ggx(lobe) => lobe.value_and_pdf(wo, wi),
        }
    }

    /// Draws `wi` for `wo` from two numbers in [0, 1); it may lie below the surface.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Ward(lobe) => lobe.sample(wo, u),
            Self::Ggx(lobe) => lobe.sample(wo, u),
        }
    }
}

/// The directional albedo of the lobe, `integral w(wo, wi) cos_i dwi`, by quadrature over the half
/// vector with `n` x `n` points. Slow: for tests and tables.
pub fn albedo(lobe: &GlossyLobe, wo: Vec3, n: usize) -> f64 {
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let u = [(i as f32 + 0.5) / n as f32, (j as f32 + 0.5) / n as f32];
            let wi = lobe.sample(wo, u);
            let pdf = lobe.pdf(wo, wi);
            if wi.z > 0.0 && pdf > 0.0 {
                sum += f64::from(lobe.value(wo, wi) * wi.z / pdf);
            }
        }
    }
    sum / (n * n) as f64
}
