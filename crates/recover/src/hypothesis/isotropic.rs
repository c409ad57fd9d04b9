//! Rung 5, isotropic Ward: `alpha` by a search over its logarithm, the reflectances inside it by
//! least squares (section 4.2.4).
//!
//! The paper searches `rho_d`, `rho_s` and `alpha` together by downhill simplex and treats
//! `rho_s = 1` apart, because the joint search gets stuck. With the reflectances solved for exactly
//! at every roughness (variable projection [Golub and Pereyra 1973]), one parameter is left, and
//! `rho_s = 1` is an edge of the box like any other.

use super::roughness::{STEPS, anywhere, downhill_by};
use super::{Fit, Hypothesis, Search, fitted, is_beaten, plastic, reflecting};
use crate::evidence::Evidence;
use crate::fit::linear::{self, Terms};
use unrender_scene::{Material, Rgb};

/// Roughness and reflectances that explain the evidence best; where the model has plastics, the plastic unless a free
/// reflectance is certainly better.
pub fn fit(evidence: &Evidence, start: &Material, search: Search) -> Fit {
    let is_plastic = !start.reflectance.is_free();
    if !evidence.light.model.is_principled()
        || (search == Search::Kept && start.is_glossy() && !is_plastic)
    {
        return free(evidence, start, search);
    }
    match plastic::fit(evidence, start, search) {
        Some(plastic) if search == Search::Kept && is_plastic => plastic,
        Some(plastic) => {
            let free = free(evidence, start, search);
            if is_beaten(&plastic, &free, evidence) { free } else { plastic }
        }
        None => free(evidence, start, search),
    }
}

/// The same with a free reflectance.
fn free(evidence: &Evidence, start: &Material, search: Search) -> Fit {
    let diffuse = evidence.light.diffuse();
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
        _ => {
            let part = evidence.thinned();
            let diffuse = part.light.diffuse();
            let deviance = |alpha: f32| deviance(&part, &diffuse, round(alpha));
            round(anywhere(&part, &deviance))
        }
    };
    finish(Hypothesis::Isotropic, evidence, &diffuse, shape)
}

/// The deviance of a lobe of the shape `[alpha_x, alpha_y, theta]` with the reflectances that fit
/// best. Searches go by it and not by the product of the residuals of two renderings, which may be
/// anything where a sharp lobe is hardly sampled: the deviance knows of the rendering noise.
pub(super) fn deviance(evidence: &Evidence, diffuse: &[Vec<Rgb>; 2], shape: [f32; 3]) -> f64 {
    let shape = evidence.expected.bounds.nearest_shape(shape);
    let specular = evidence.light.lobe(shape[0], shape[1], shape[2]);
    if shown_by(&specular) < SHOWN_MIN {
        return UNLIKELY;
    }
    with_lobe(evidence, diffuse, shape, &specular).likelihood.deviance
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
    let by = |shape: [f32; 3]| {
        let specular = evidence.light.lobe(shape[0], shape[1], shape[2]);
        with_lobe(evidence, diffuse, shape, &specular)
    };
    at(&downhill_by(evidence, &|p| by(at(p)), (first, size), steps))
}

/// The fit with the lobe's shape `[alpha_x, alpha_y, theta]` found.
pub(super) fn finish(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    shape: [f32; 3],
) -> Fit {
    let specular = evidence.light.lobe(shape[0], shape[1], shape[2]);
    reflecting(hypothesis, evidence, of_shape(shape), (diffuse, &specular), Terms::default())
}

/// The fit of a lobe of the `shape` with this specular term.
fn with_lobe(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    shape: [f32; 3],
    specular: &[Vec<Rgb>; 2],
) -> Fit {
    let bases = (diffuse, specular);
    let found = linear::fit(evidence, diffuse, Some(specular), Terms::default());
    fitted(Hypothesis::Isotropic, evidence, of_shape(shape), bases, &found)
}

/// A white lobe of the shape `[alpha_x, alpha_y, theta]`.
fn of_shape([alpha_x, alpha_y, theta_rad]: [f32; 3]) -> Material {
    Material { alpha_x, alpha_y, theta_rad, ..Material::mirror(Rgb::ONE) }
}
