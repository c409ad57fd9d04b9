//! Rung 5, isotropic Ward: `alpha` by a search over its logarithm, the reflectances inside it by
//! least squares (section 4.2.4).
//!
//! The paper searches `rho_d`, `rho_s` and `alpha` together by downhill simplex and treats
//! `rho_s = 1` apart, because the joint search gets stuck. With the reflectances solved for exactly
//! at every roughness (variable projection [Golub and Pereyra 1973]), one parameter is left, and
//! `rho_s = 1` is an edge of the box like any other.

use super::{Fit, Hypothesis, Search, judged};
use crate::evidence::Evidence;
use crate::fit::simplex;
use crate::likelihood::Likelihood;
use rayon::prelude::*;
use unrender_scene::{Material, Rgb};

/// The steps of the global search: each about 1.6 times the one before.
const GLOBAL: [f32; 10] = [0.01, 0.016, 0.025, 0.04, 0.065, 0.1, 0.16, 0.25, 0.4, 0.65];

/// Steps of a global and of a local search.
const STEPS: [u64; 2] = [30, 15];

/// Roughness and reflectances that explain the evidence best.
pub fn fit(evidence: &Evidence, start: &Material, search: Search) -> Fit {
    let diffuse = evidence.diffuse();
    let known = (start.alpha_x * start.alpha_y).sqrt();
    let round = |alpha: f32| {
        let alpha = evidence.expected.bounds.nearest_round(alpha);
        [alpha, alpha, 0.0]
    };
    let by_log = |p: &[f64]| round(p[0].exp() as f32);
    let first = [f64::from(known).ln()];
    let shape = match search {
        Search::Kept if start.is_glossy() => round(known),
        Search::Local if start.is_glossy() => {
            downhill((evidence, &diffuse), &by_log, (&first, &[0.1]), STEPS[1])
        }
        _ => round(anywhere(&evidence.thinned())),
    };
    finish(Hypothesis::Isotropic, evidence, &diffuse, shape)
}

/// The most likely roughness: the best of [`GLOBAL`], and downhill from there; or from the value that the
/// user starts from, if that leads to one as likely.
fn anywhere(evidence: &Evidence) -> f32 {
    let diffuse = evidence.diffuse();
    let bounds = &evidence.expected.bounds;
    let deviance = |alpha: f32| {
        let alpha = bounds.nearest_round(alpha);
        deviance(evidence, &diffuse, [alpha, alpha, 0.0])
    };
    let by_log = |p: &[f64]| deviance(p[0].exp() as f32);
    let downhill = |from: f32| {
        let from = f64::from(from).ln();
        let (best, cost) = simplex::minimise(by_log, &[from], &[0.2], LIKELY, STEPS[0]);
        (cost, bounds.nearest_round(best[0].exp() as f32))
    };
    let costs: Vec<_> = GLOBAL.into_par_iter().map(|alpha| (deviance(alpha), alpha)).collect();
    let best = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.1, |best| best.1);
    preferred(downhill(best), evidence.expected.start.alpha_x.map(downhill))
}

/// The usual minimum takes the place of the one that the user's start leads to if its deviance is lower by
/// this, which is strong evidence [Kass and Raftery 1995]. At half of it noise overrules the user, at double a
/// start that is wrong stays.
const STRONGER: f64 = 6.0;

/// The minimum that the user's start leads to, unless the `usual` one is strongly more likely; both with
/// their deviances.
pub(super) fn preferred<T>(usual: (f64, T), started: Option<(f64, T)>) -> T {
    match started {
        Some(started) if started.0 <= usual.0 + STRONGER => started.1,
        _ => usual.1,
    }
}

/// Global searches stop when the deviances at the corners of the simplex differ by less than this: a
/// tenth of what counts as evidence.
pub(super) const LIKELY: f64 = 0.5;

/// The deviance of a lobe of the shape `[alpha_x, alpha_y, theta]` with the reflectances that fit
/// best. Searches go by it and not by the product of the residuals of two renderings, which may be
/// anything where a sharp lobe is hardly sampled: the deviance knows of the rendering noise.
pub(super) fn deviance(evidence: &Evidence, diffuse: &[Vec<Rgb>; 2], shape: [f32; 3]) -> f64 {
    let shape = evidence.expected.bounds.nearest_shape(shape);
    let specular = evidence.lobe(shape[0], shape[1], shape[2]);
    if shown_by(&specular) < SHOWN_MIN {
        return UNLIKELY;
    }
    with_lobe(Hypothesis::Isotropic, evidence, diffuse, shape, &specular).likelihood.deviance
}

/// A lobe is a candidate if at least so many sampled pixels show it: with fewer than its shape and strength have
/// numbers it fits any highlight. At half of it, single bright pixels become mirrors; at double, small highlights are
/// missed.
const SHOWN_MIN: f64 = 3.0;
/// The deviance of a shape that is no candidate.
const UNLIKELY: f64 = 1e30;

/// How many pixels show the specular term, about: `(sum S)^2 / sum S^2`.
fn shown_by(specular: &[Vec<Rgb>; 2]) -> f64 {
    let pixels = || specular[0].iter().zip(&specular[1]);
    let sums = pixels().map(|(a, b)| f64::from((*a + *b).element_sum()));
    let (sum, squares) = sums.fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// The shape downhill from `known`, by the deviance under the model error that `known` leaves: `at` maps the searched
/// numbers to a shape, `first` where they begin, and `size` how far the first steps go.
pub(super) fn downhill(
    (evidence, diffuse): (&Evidence, &[Vec<Rgb>; 2]),
    at: &dyn Fn(&[f64]) -> [f32; 3],
    (first, size): (&[f64], &[f64]),
    steps: u64,
) -> [f32; 3] {
    let fitted = |shape: [f32; 3]| {
        let specular = evidence.lobe(shape[0], shape[1], shape[2]);
        with_lobe(Hypothesis::Isotropic, evidence, diffuse, shape, &specular)
    };
    let Likelihood { light, error, .. } = fitted(at(first)).likelihood;
    let cost = |p: &[f64]| {
        Likelihood::given(&fitted(at(p)).residuals, &evidence.field, (light, error)).deviance
    };
    let (best, _) = simplex::minimise(cost, first, size, SETTLED, steps);
    at(&best)
}

/// Local searches stop when the deviances at the corners of the simplex differ by less than this: a
/// hundredth of what one standard deviation of a number costs.
const SETTLED: f64 = 0.01;

/// The fit with the lobe's shape `[alpha_x, alpha_y, theta]` found.
pub(super) fn finish(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    shape: [f32; 3],
) -> Fit {
    let specular = evidence.lobe(shape[0], shape[1], shape[2]);
    with_lobe(hypothesis, evidence, diffuse, shape, &specular)
}

/// The same with the lobe's specular term.
fn with_lobe(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    [alpha_x, alpha_y, theta_rad]: [f32; 3],
    specular: &[Vec<Rgb>; 2],
) -> Fit {
    let found =
        crate::fit::linear::fit(evidence, diffuse, Some(specular), crate::fit::linear::Terms::Both);
    let material = Material {
        rho_s: found.rho_s,
        alpha_x,
        alpha_y,
        theta_rad,
        ..Material::diffuse(found.rho_d)
    };
    judged(hypothesis, evidence, material, diffuse, Some(specular))
}
