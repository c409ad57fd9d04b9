//! The rungs of the ladder: what a group's reflectance might be, from simple to complex
//! [Boivin and Gagalowicz 2002, section 4.2].
//!
//! One rung is one file with one public function `fit`, which finds the parameters that explain the
//! evidence best under that hypothesis. To add a rung: write its file, name it in [`Hypothesis`] at
//! its place in the order, and here say how it is fitted ([`fit`]), which numbers it has free
//! (`quantities`), which materials are of it ([`of`]), and whether it is uniform ([`UNIFORM`]).

pub mod anisotropic;
pub mod diffuse;
pub mod diffuse_specular;
pub mod isotropic;
pub mod mirror;
pub mod partial_mirror;
pub(crate) mod plastic;
mod roughness;

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::BlockResiduals;
use crate::compare::residual::{ResidualStats, residual_stats};
use crate::evidence::Evidence;
use crate::unknown::Quantity;
use serde::{Deserialize, Serialize};
pub use unrender_scene::Hypothesis;
use unrender_scene::{Material, Rgb};

/// The rungs without a texture, from simple to complex.
pub const UNIFORM: [Hypothesis; 6] = [
    Hypothesis::Diffuse,
    Hypothesis::Mirror,
    Hypothesis::PartialMirror,
    Hypothesis::DiffuseSpecular,
    Hypothesis::Isotropic,
    Hypothesis::Anisotropic,
];

/// Fits a uniform hypothesis to the evidence, near `start` where it has a roughness to find.
/// The textured hypothesis needs more than a sample of pixels: see [`crate::texture`].
pub fn fit(rung: Hypothesis, evidence: &Evidence, start: &Material, search: Search) -> Fit {
    match rung.of_paper() {
        Hypothesis::Diffuse | Hypothesis::Textured => diffuse::fit(evidence),
        Hypothesis::Mirror => mirror::fit(evidence),
        Hypothesis::PartialMirror => partial_mirror::fit(evidence),
        Hypothesis::DiffuseSpecular => diffuse_specular::fit(evidence),
        Hypothesis::Isotropic => isotropic::fit(evidence, start, search),
        _ => anisotropic::fit(evidence, start, search),
    }
}

/// The free numbers of a rung with a `material` of it, which model selection counts and the joint refinement refines; of a
/// texture its mean. The reflectance of a plastic's lobe is fixed.
pub(crate) fn quantities(rung: Hypothesis, material: &Material) -> &'static [Quantity] {
    use Quantity::{Alpha, AlphaX, AlphaY, RhoD, RhoS, Theta};
    match rung.of_paper() {
        Hypothesis::Isotropic if !material.reflectance.is_free() => &[RhoD, Alpha],
        Hypothesis::Diffuse | Hypothesis::Textured => &[RhoD],
        Hypothesis::Mirror => &[],
        Hypothesis::PartialMirror => &[RhoS],
        Hypothesis::DiffuseSpecular => &[RhoD, RhoS],
        Hypothesis::Isotropic => &[RhoD, RhoS, Alpha],
        _ => &[RhoD, RhoS, AlphaX, AlphaY, Theta],
    }
}

/// The simplest hypothesis that can hold `material`.
///
/// ```
/// use unrender_recover::hypothesis::{self, Hypothesis};
/// use unrender_scene::{Material, Rgb};
///
/// let matt = Material::diffuse(Rgb::splat(0.5));
/// assert_eq!(hypothesis::of(&matt), Hypothesis::Diffuse);
/// let glossy = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.1), 0.05);
/// assert_eq!(hypothesis::of(&glossy), Hypothesis::Isotropic);
/// let brushed = Material { alpha_y: 0.2, ..glossy };
/// assert_eq!(hypothesis::of(&brushed), Hypothesis::Anisotropic);
/// ```
pub fn of(material: &Material) -> Hypothesis {
    let diffuse = material.rho_d.max_element() > 0.0;
    match material.is_delta() {
        _ if material.texture.is_some() => Hypothesis::Textured,
        _ if plastic::is_dull(material) => Hypothesis::Diffuse,
        true if diffuse => Hypothesis::DiffuseSpecular,
        true if material.rho_s == Rgb::ONE => Hypothesis::Mirror,
        true => Hypothesis::PartialMirror,
        false if material.alpha_x == material.alpha_y => Hypothesis::Isotropic,
        false => Hypothesis::Anisotropic,
    }
}

/// How widely a rung with a roughness looks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Over all roughnesses and directions, on a part of the pixels.
    Global,
    /// Downhill from the parameters that are known, on all pixels.
    Local,
    /// Not at all: the lobe's shape is kept, and only the reflectances are fitted.
    Kept,
}

/// A hypothesis with its best parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The rung.
    pub hypothesis: Hypothesis,
    /// Its parameters.
    pub material: Material,
    /// What they leave unexplained.
    pub residual: ResidualStats,
    /// The residuals, block by block.
    pub residuals: BlockResiduals,
    /// How likely these are.
    pub likelihood: Likelihood,
}

impl Fit {
    /// Whether its numbers are finite: squares overflow where wrong hypotheses of other groups amplify the light
    /// without bounds.
    pub fn is_finite(&self) -> bool {
        let Material { rho_d, rho_s, alpha_x, alpha_y, theta_rad, .. } = &self.material;
        let shape = [alpha_x, alpha_y, theta_rad];
        let Likelihood { deviance, error, .. } = &self.likelihood;
        let numbers = [*deviance, error.share, self.residual.relative()];
        rho_d.is_finite()
            && rho_s.is_finite()
            && shape.into_iter().all(|number| number.is_finite())
            && numbers.iter().all(|number| number.is_finite())
    }
}

/// The fit of `material`, with the bases that it was found with.
fn judged(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    material: Material,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
) -> Fit {
    let half = |h: usize| -> Vec<Rgb> {
        let specular_at = |i: usize| specular.map_or(Rgb::ZERO, |s| s[h][i]);
        let at = |i: usize| material.rho_d * diffuse[h][i] + material.rho_s * specular_at(i);
        (0..diffuse[h].len()).map(at).collect()
    };
    let model = [half(0), half(1)];
    let residuals = BlockResiduals::of(evidence, &model);
    let likelihood = Likelihood::of(&residuals, &evidence.sample.field, evidence.allowance.floor);
    let residual = residual_stats(&evidence.sample.pixels, &model);
    Fit { hypothesis, material, residual, residuals, likelihood }
}

/// The deviance of the lobe of `material` with the reflectances that fit best beside it.
pub(crate) fn deviance_of_shape(evidence: &Evidence, material: &Material) -> f64 {
    let Material { alpha_x, alpha_y, theta_rad, .. } = *material;
    isotropic::deviance(evidence, &evidence.light.diffuse(), [alpha_x, alpha_y, theta_rad])
}
