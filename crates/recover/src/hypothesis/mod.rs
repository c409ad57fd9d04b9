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
use crate::compare::residual::{BlockResiduals, ResidualStats, residual_stats};
use crate::compare::{Explained, difference, independent_blocks};
use crate::evidence::Evidence;
use crate::fit::linear::{self, LinearFit, Terms};
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

/// Free parameters of a hypothesis with a `material` of it; of a texture those of its mean. The reflectance of a lobe without
/// colour is one number, that of one with a colour three.
pub(crate) fn parameters(hypothesis: Hypothesis, material: &Material) -> f64 {
    let is_colourless = material.is_glossy() && material.rho_s == Rgb::splat(material.rho_s.x);
    let numbers = |quantity: &Quantity| match quantity {
        Quantity::RhoS if is_colourless => 1.0,
        _ if quantity.has_channels() => 3.0,
        _ => 1.0,
    };
    quantities(hypothesis, material).iter().map(numbers).sum()
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
    /// What it leaves unexplained.
    pub(crate) fn explained(&self) -> Explained<'_> {
        Explained { residuals: &self.residuals, likelihood: &self.likelihood }
    }

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

/// The fit of a mirror or a lobe like `white`, with the diffuse and the specular basis. A lobe has no colour unless one with a
/// colour certainly is better: the surface of all but metals reflects all of the light alike. In scenes of plastics those are
/// they, and what is free has a colour. A mirror keeps its three numbers: with one it is taken for what a lobe explains.
fn reflecting(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    white: Material,
    bases: (&[Vec<Rgb>; 2], &[Vec<Rgb>; 2]),
    terms: Terms,
) -> Fit {
    let (diffuse, specular) = bases;
    let found = linear::fit(evidence, diffuse, Some(specular), terms);
    let coloured = fitted(hypothesis, evidence, white.clone(), bases, &found);
    if !white.is_glossy() || evidence.light.model.is_principled() {
        return coloured;
    }
    let found = linear::colourless(evidence, diffuse, specular, terms);
    let colourless = found.map(|found| fitted(hypothesis, evidence, white, bases, &found));
    colourless.filter(|simple| !is_beaten(simple, &coloured, evidence)).unwrap_or(coloured)
}

/// The fit of a mirror or a lobe like `white` with the reflectances that were `found`.
fn fitted(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    white: Material,
    (diffuse, specular): (&[Vec<Rgb>; 2], &[Vec<Rgb>; 2]),
    found: &LinearFit,
) -> Fit {
    let material = Material { rho_d: found.rho_d, rho_s: found.rho_s, ..white };
    judged(hypothesis, evidence, material, diffuse, Some(specular))
}

/// Whether `complex`, which has more numbers than `simple`, certainly is the better one.
fn is_beaten(simple: &Fit, complex: &Fit, evidence: &Evidence) -> bool {
    let is_likelier = complex.likelihood.deviance < simple.likelihood.deviance;
    let best = if is_likelier { complex } else { simple };
    let independent = independent_blocks(best.explained(), evidence);
    let gain = difference([simple.explained(), complex.explained()], evidence, independent);
    let [more, fewer] = [complex, simple].map(|fit| parameters(fit.hypothesis, &fit.material));
    gain.least() > (more - fewer) * independent.max(1.0).ln()
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

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::sampler::mix;

    const SIDE: usize = 20;

    /// A glossy surface under some lamps with a specular reflectance of `rho_s`, where the photograph is off by up to
    /// `noise` of the light.
    fn glossy(rho_s: Rgb, noise: f32) -> Evidence {
        let (evidence, lit) = Evidence::under_lamps(SIDE);
        let [shown, _] = evidence.light.lobe(0.15, 0.15, 0.0);
        let scatter = |i: usize, channel: u64| {
            let uniform = (mix(3 * i as u64 + channel) >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
            1.0 + noise * uniform
        };
        let value = |(i, shown): (usize, Rgb)| {
            let noise = Rgb::new(scatter(i, 0), scatter(i, 1), scatter(i, 2));
            (Rgb::new(0.3, 0.2, 0.1) * lit + rho_s * shown) * noise
        };
        evidence.showing(shown.into_iter().enumerate().map(value).collect())
    }

    #[test]
    fn a_lobe_has_a_colour_only_where_that_shows() {
        let lobe = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.3), 0.15);
        let found = |rho_s: Rgb| {
            let fit = fit(Hypothesis::Isotropic, &glossy(rho_s, 0.02), &lobe, Search::Kept);
            (fit.material.rho_s, parameters(fit.hypothesis, &fit.material))
        };
        let (grey, numbers) = found(Rgb::splat(0.3));
        assert!((grey - Rgb::splat(0.3)).abs().max_element() < 0.005, "{grey}");
        assert_eq!(numbers, 5.0, "three of the base, the lobe's strength and roughness");
        let colour = Rgb::new(0.3, 0.25, 0.2);
        let (found, numbers) = found(colour);
        assert!((found - colour).abs().max_element() < 0.005, "{found}");
        assert_eq!(numbers, 7.0);
    }

    #[test]
    fn the_strength_without_a_colour_is_that_which_explains_all_channels_best() {
        let evidence = glossy(Rgb::new(0.3, 0.25, 0.2), 0.0);
        let bases = (evidence.light.diffuse(), evidence.light.lobe(0.15, 0.15, 0.0));
        let with = |rho_s: f64| {
            linear::fit(&evidence, &bases.0, Some(&bases.1), Terms::beside(rho_s)).objective
        };
        let found = linear::colourless(&evidence, &bases.0, &bases.1, Terms::default()).unwrap();
        assert_eq!(found.rho_s, Rgb::splat(found.rho_s.x));
        let strength = f64::from(found.rho_s.x);
        let least = with(strength);
        assert!(least < with(strength - 0.001) && least < with(strength + 0.001), "{strength}");
    }
}
