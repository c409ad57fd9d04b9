//! Rung 6, anisotropic Ward: the anisotropy direction, then `alpha_x` and `alpha_y` (section 4.2.5).
//!
//! The paper reads the direction off the photograph and keeps it. Here the search starts from a ring of directions (while
//! both alphas are alike the direction hardly matters, so a single start can reach a wrong minimum); then direction and
//! roughness are refined together by downhill simplex, the reflectances inside by least squares.

use super::{Fit, Hypothesis, Search};
use super::{isotropic, roughness};
use crate::evidence::Evidence;
use crate::expected::Expected;
use crate::fit::simplex;
use rayon::prelude::*;
use std::f32::consts::PI;
use unrender_scene::reflectance::ALPHA_RANGE;
use unrender_scene::{Material, Rgb};

/// Directions that the global search starts from, over half a turn. With half as many, the nearest is up to 45 degrees
/// off and the minimum is missed; double costs twice the time.
const DIRECTIONS: usize = 5;
/// The elongations that it starts with: `alpha_y / alpha_x` is their square. With the first alone, lobes
/// that are three times as wide as long are not found.
const ELONGATIONS: [f32; 2] = [1.4, 2.0];
/// The mean roughnesses that it starts with, beside that of the isotropic answer: where a round lobe
/// explains nothing, its roughness says nothing of an elongated one's.
const ALPHAS: [f32; 3] = [0.05, 0.15, 0.4];

/// The first step of a local search, of the logarithms of both roughnesses.
const STEP: f64 = 0.04;
/// Steps of a global and of a local search.
const STEPS: [u64; 2] = [100, 40];

/// Direction, roughness and reflectances that explain the evidence best. `start` carries an
/// isotropic roughness, or with [`Search::Local`] an earlier answer.
pub fn fit(evidence: &Evidence, start: &Material, search: Search) -> Fit {
    let known = [start.alpha_x, start.alpha_y, start.theta_rad];
    let diffuse = evidence.light.diffuse();
    let bounds = evidence.expected.bounds;
    let shape_of =
        |p: &[f64]| bounds.nearest_shape([p[0].exp() as f32, p[1].exp() as f32, p[2] as f32]);
    let shape = match search {
        Search::Kept => bounds.nearest_shape(known),
        Search::Local => {
            let first = [known[0].ln(), known[1].ln(), known[2]].map(f64::from);
            let start = (&first[..], &[STEP, STEP, 1.5 * STEP][..]);
            isotropic::downhill((evidence, &diffuse), &shape_of, start, STEPS[1])
        }
        Search::Global => {
            let part = evidence.thinned();
            let diffuse = part.light.diffuse();
            anywhere((&part, &diffuse), &shape_of, start)
        }
    };
    isotropic::finish(Hypothesis::Anisotropic, evidence, &diffuse, canonical(shape))
}

/// The most likely shape: the best of a ring of directions, and downhill from there; or from the values that
/// the user starts from, if they lead to one as likely. `shape_of` maps the searched numbers to a shape.
fn anywhere(
    (evidence, diffuse): (&Evidence, &[Vec<Rgb>; 2]),
    shape_of: &dyn Fn(&[f64]) -> [f32; 3],
    start: &Material,
) -> [f32; 3] {
    let known = (start.alpha_x * start.alpha_y).sqrt().clamp(ALPHA_RANGE[0], ALPHA_RANGE[1]);
    let first = [known / ELONGATIONS[0], known * ELONGATIONS[0], start.theta_rad];
    let shapes = std::iter::once(known).chain(ALPHAS).flat_map(|alpha| {
        ELONGATIONS.into_iter().flat_map(move |longer| {
            let ring = (0..DIRECTIONS).map(|i| PI * i as f32 / DIRECTIONS as f32);
            ring.map(move |theta| [alpha / longer, alpha * longer, theta])
        })
    });
    let cost = |p: &[f64]| isotropic::deviance(evidence, diffuse, shape_of(p));
    let downhill = |best: [f32; 3]| {
        let first = [f64::from(best[0]).ln(), f64::from(best[1]).ln(), f64::from(best[2])];
        let size = [0.2, 0.2, 0.3];
        let (best, cost) = simplex::minimise(cost, &first, &size, roughness::LIKELY, STEPS[0]);
        (cost, shape_of(&best))
    };
    let best_of = |shapes: Vec<[f32; 3]>| {
        let ranked = shapes.into_par_iter();
        let ranked = ranked.map(|shape| (isotropic::deviance(evidence, diffuse, shape), shape));
        let ranked: Vec<(f64, [f32; 3])> = ranked.collect();
        ranked.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    };
    let usual = best_of(std::iter::once(first).chain(shapes).collect()).unwrap_or(first);
    let started = best_of(started(&evidence.expected)).map(downhill);
    roughness::preferred(downhill(usual), started)
}

/// The starting shapes with the user's numbers; where none is stated, those of the usual search. Empty if none at all
/// is stated.
fn started(expected: &Expected) -> Vec<[f32; 3]> {
    let start = expected.start;
    if start.alpha_x.is_none() && start.alpha_y.is_none() && start.theta_rad.is_none() {
        return Vec::new();
    }
    let longer = ELONGATIONS.map(|longer| longer * longer);
    let alphas: Vec<[f32; 2]> = match (start.alpha_x, start.alpha_y) {
        (Some(x), Some(y)) => vec![[x, y]],
        (Some(x), None) => longer.map(|longer| [x, x * longer]).to_vec(),
        (None, Some(y)) => longer.map(|longer| [y / longer, y]).to_vec(),
        (None, None) => {
            let both = |alpha: f32| ELONGATIONS.map(|longer| [alpha / longer, alpha * longer]);
            ALPHAS.into_iter().flat_map(both).collect()
        }
    };
    let ring = (0..DIRECTIONS).map(|i| PI * i as f32 / DIRECTIONS as f32);
    let thetas: Vec<f32> = start.theta_rad.map_or(ring.collect(), |theta| vec![theta]);
    let turned = |[x, y]: [f32; 2]| thetas.iter().map(move |theta| [x, y, *theta]);
    alphas.into_iter().flat_map(turned).collect()
}

/// The same lobe with `alpha_x <= alpha_y` and theta in [0, pi): the anisotropy direction is the one
/// along which the surface is smoother.
pub fn canonical([x, y, theta]: [f32; 3]) -> [f32; 3] {
    if x <= y { [x, y, theta.rem_euclid(PI)] } else { [y, x, (theta + PI / 2.0).rem_euclid(PI)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expected::{ParameterBounds, StartValues};

    const SIDE: usize = 20;

    /// A brushed surface, seen and lit symmetrically: a direction and its mirror image explain it equally well.
    fn ambiguous(truth: [f32; 3]) -> Evidence {
        let (evidence, lit) = Evidence::under_lamps(SIDE);
        let [shown, _] = evidence.light.lobe(truth[0], truth[1], truth[2]);
        evidence.showing(shown.into_iter().map(|s| 0.2 * lit + 0.3 * s).collect())
    }

    fn found(start: StartValues, bounds: ParameterBounds) -> [f32; 3] {
        let evidence = ambiguous([0.1, 0.3, 0.6]).expecting(Expected { bounds, start, like: None });
        let first = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.3), 0.2);
        let Material { alpha_x, alpha_y, theta_rad, .. } =
            fit(&evidence, &first, Search::Global).material;
        [alpha_x, alpha_y, theta_rad]
    }

    #[test]
    fn of_directions_that_explain_alike_the_one_is_taken_that_the_start_leads_to() {
        for theta in [0.6, PI - 0.6] {
            let start = StartValues { theta_rad: Some(theta + 0.2), ..StartValues::default() };
            let [x, y, found] = found(start, ParameterBounds::default());
            assert!((x - 0.1).abs() < 0.015 && (y - 0.3).abs() < 0.03, "{x} {y}");
            assert!((found - theta).abs() < 0.05, "{found} instead of {theta}");
        }
    }

    #[test]
    fn a_start_that_is_wrong_does_no_harm() {
        let start =
            StartValues { alpha_x: Some(0.5), alpha_y: Some(0.9), ..StartValues::default() };
        let [x, y, _] = found(start, ParameterBounds::default());
        assert!((x - 0.1).abs() < 0.015 && (y - 0.3).abs() < 0.03, "{x} {y}");
    }

    #[test]
    fn a_lobe_across_the_direction_is_told_from_the_minimum() {
        let evidence = ambiguous([0.1, 0.3, 0.6]);
        let at = |theta_rad: f32| {
            let lobe = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.3), 0.1);
            fit(&evidence, &Material { alpha_y: 0.3, theta_rad, ..lobe }, Search::Kept)
        };
        let (right, near, across) = (at(0.6), at(0.605), at(0.6 + PI / 2.0));
        assert!(crate::selection::explains_alike(&near, &right, &evidence));
        assert!(!crate::selection::explains_alike(&across, &right, &evidence));
    }

    #[test]
    fn shapes_are_searched_within_the_bounds() {
        let bounds = ParameterBounds { alpha_x: [0.14, 0.4], ..ParameterBounds::default() };
        let [x, y, _] = found(StartValues::default(), bounds);
        assert!((0.14..0.16).contains(&x) && y >= x, "{x} {y}");
    }
}
