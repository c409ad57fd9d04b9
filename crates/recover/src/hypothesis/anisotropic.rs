//! Rung 6, anisotropic Ward: the anisotropy direction, then `alpha_x` and `alpha_y` (section 4.2.5).
//!
//! The paper reads the direction off the photograph ([`super::brushed`]) and keeps it. Here it is
//! where the search starts, beside a ring of directions (while both alphas are alike the direction
//! hardly matters, so a single start can fall into the wrong basin); then direction and roughness
//! are refined together by downhill simplex, the reflectances inside by least squares.

use super::isotropic::{self, ALPHA_RANGE};
use super::{Fit, Hypothesis, Search};
use crate::evidence::Evidence;
use crate::fit::simplex;
use std::f32::consts::PI;
use unrender_scene::{Material, Rgb};

/// Directions that the global search starts from, over half a turn. With half as many, the nearest is up
/// to 45 degrees off and its basin is missed; double costs twice the time.
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

/// Direction, roughness and reflectances that explain the evidence best. `start` carries the
/// paper's direction and an isotropic roughness, or with [`Search::Local`] an earlier answer.
pub fn fit(evidence: &Evidence, start: &Material, search: Search) -> Fit {
    let known = [start.alpha_x, start.alpha_y, start.theta_rad];
    let diffuse = evidence.diffuse();
    let shape = match search {
        Search::Kept => known,
        Search::Local => {
            let first = [known[0].ln(), known[1].ln(), known[2]].map(f64::from);
            let start = (&first[..], &[STEP, STEP, 1.5 * STEP][..]);
            isotropic::downhill((evidence, &diffuse), &shape_of, start, STEPS[1])
        }
        Search::Global => {
            let part = evidence.thinned();
            let diffuse = part.diffuse();
            anywhere(&part, &diffuse, start)
        }
    };
    isotropic::finish(Hypothesis::Anisotropic, evidence, &diffuse, canonical(shape))
}

fn shape_of(p: &[f64]) -> [f32; 3] {
    let alpha = |log: f64| (log.exp() as f32).clamp(ALPHA_RANGE[0], ALPHA_RANGE[1]);
    [alpha(p[0]), alpha(p[1]), p[2] as f32]
}

/// The most likely shape: the best of a ring of directions, and downhill from there.
fn anywhere(evidence: &Evidence, diffuse: &[Vec<Rgb>; 2], start: &Material) -> [f32; 3] {
    let known = (start.alpha_x * start.alpha_y).sqrt().clamp(ALPHA_RANGE[0], ALPHA_RANGE[1]);
    let first = [known / ELONGATIONS[0], known * ELONGATIONS[0], start.theta_rad];
    let shapes = std::iter::once(known).chain(ALPHAS).flat_map(|alpha| {
        ELONGATIONS.into_iter().flat_map(move |longer| {
            let ring = (0..DIRECTIONS).map(|i| PI * i as f32 / DIRECTIONS as f32);
            ring.map(move |theta| [alpha / longer, alpha * longer, theta])
        })
    });
    let ranked = std::iter::once(first)
        .chain(shapes)
        .map(|shape| (isotropic::deviance(evidence, diffuse, shape), shape));
    let best = ranked.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(first, |b| b.1);
    let cost = |p: &[f64]| isotropic::deviance(evidence, diffuse, shape_of(p));
    let first = [f64::from(best[0]).ln(), f64::from(best[1]).ln(), f64::from(best[2])];
    let size = [0.2, 0.2, 0.3];
    let (best, _) = simplex::minimise(cost, &first, &size, isotropic::LIKELY, STEPS[0]);
    shape_of(&best)
}

/// The same lobe with `alpha_x <= alpha_y` and theta in [0, pi): the anisotropy direction is the one
/// along which the surface is smoother.
pub fn canonical([x, y, theta]: [f32; 3]) -> [f32; 3] {
    if x <= y { [x, y, theta.rem_euclid(PI)] } else { [y, x, (theta + PI / 2.0).rem_euclid(PI)] }
}
