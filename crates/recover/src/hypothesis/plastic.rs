//! The isotropic rung as a plastic: a dielectric's lobe over a diffuse base. Beside its base it has one number, the
//! roughness, since Fresnel's equations fix how strong its lobe is.
//!
//! With the roughness given, the base follows by least squares from `B - S = rho_d D`: `S` is the dielectric's lobe in the
//! light that arrives, `D` that of a white base under it.

use super::roughness::{STEPS, anywhere, downhill_by};
use super::{Fit, Hypothesis, Search, judged};
use crate::compare::{Explained, difference, independent_blocks};
use crate::evidence::Evidence;
use crate::expected::ParameterBounds;
use crate::fit::linear::{self, Terms};
use unrender_scene::reflectance::{IOR, f0_of_ior};
use unrender_scene::{BrdfModel, Material, Rgb};

/// The plastic that explains the evidence best; none if the user's bounds exclude a reflectance of 4 %.
pub(super) fn fit(evidence: &Evidence, start: &Material, search: Search) -> Option<Fit> {
    let bounds = &evidence.expected.bounds;
    if !is_within(bounds) {
        return None;
    }
    let round = |alpha: f32| bounds.nearest_round(alpha);
    let known = (start.alpha_x * start.alpha_y).sqrt();
    let alpha = match search {
        Search::Kept if start.is_glossy() => round(known),
        Search::Local if start.is_glossy() => {
            let by_log = |p: &[f64]| round(p[0].exp() as f32);
            let fitted = |p: &[f64]| at(evidence, by_log(p));
            let first = [f64::from(known).ln()];
            by_log(&downhill_by(evidence, &fitted, (&first, &[0.1]), STEPS[1]))
        }
        _ => {
            let part = evidence.thinned();
            let deviance = |alpha: f32| at(&part, round(alpha)).likelihood.deviance;
            round(anywhere(&part, &deviance))
        }
    };
    Some(at(evidence, alpha))
}

/// Whether a lobe of free reflectance, which has three numbers more, is certainly the better one.
pub(super) fn is_beaten(plastic: &Fit, free: &Fit, evidence: &Evidence) -> bool {
    let best = if free.likelihood.deviance < plastic.likelihood.deviance { free } else { plastic };
    let independent = independent_blocks(explained(best), evidence);
    let gain = difference([explained(plastic), explained(free)], evidence, independent);
    gain.least() > 3.0 * independent.max(1.0).ln()
}

fn explained(fit: &Fit) -> Explained<'_> {
    Explained { residuals: &fit.residuals, likelihood: &fit.likelihood }
}

/// Whether the user's bounds allow the lobe of a plastic, which reflects 4 % at normal incidence.
pub(crate) fn is_within(bounds: &ParameterBounds) -> bool {
    let f0 = Rgb::splat(f0_of_ior(IOR));
    let [low, high] = bounds.rho_s;
    low.cmple(f0).all() && f0.cmple(high).all()
}

/// The plastic of the roughness `alpha` over a black base, in a scene of `model`.
pub(crate) fn of_alpha(model: BrdfModel, alpha: f32) -> Material {
    Material::plastic(Rgb::ZERO, IOR, model.layering(), alpha)
}

/// The fit with the roughness given.
fn at(evidence: &Evidence, alpha: f32) -> Fit {
    let black = of_alpha(evidence.light.model, alpha);
    let (diffuse, specular) = (evidence.light.base(&black), evidence.light.specular(&black));
    let terms = Terms::Beside(black.rho_s.x);
    let rho_d = linear::fit(evidence, &diffuse, Some(&specular), terms).rho_d;
    let material = Material { rho_d, ..black };
    judged(Hypothesis::Isotropic, evidence, material, &diffuse, Some(&specular))
}
