//! Other explanations: where a lobe of quite another shape explains the photograph as well, both
//! are reported.
//!
//! Gauss-Newton finds the local minimum near the answer of the ladder's global search. Here the
//! cost is computed on a grid of roughnesses (round lobes) or of directions (brushed ones) about
//! the answer; every other dip is followed down, and kept if it is not significantly worse on the
//! same light.

use crate::evidence::Evidence;
use crate::expected::ParameterBounds;
use crate::guess::Guess;
use crate::hypothesis::{self, Fit, Hypothesis, Search};
use crate::observe::model_error::ModelError;
use crate::problem::Options;
use crate::sample_budget::{self, Level};
use crate::selection;
use crate::streams::Stream;
use std::f32::consts::PI;
use unrender_scene::Material;

/// Pixels that are looked at. Half and double of it were not tried.
const PIXELS: usize = 2000;
/// Roughnesses about that of the answer, as factors.
const FACTORS: [f32; 7] = [0.15, 0.3, 0.55, 1.0, 1.8, 3.3, 6.0];
/// Directions about that of the answer, over half a turn.
const DIRECTIONS: usize = 8;
/// Shapes are the same if the logarithms of their roughnesses differ by less than this ...
const SAME_LN_ALPHA: f32 = 0.25;
/// ... and, where a lobe is not nearly round, the directions by less than this (radians).
const SAME_THETA: f32 = 0.25;

/// The evidence on `group`, under the refined light, by light samples that no search has used, weighted for its present
/// material; none where nothing was seen of it.
fn evidence(guess: &Guess<'_>, options: &Options, group: usize) -> Option<Evidence> {
    let other_noise = Options { seed: Stream::OtherMinima.change(options.seed), ..options.clone() };
    let pixels = &guess.observation.pixels_of_group[group];
    let mut budget = sample_budget::candidates(
        Level::Refined,
        &other_noise,
        &guess.problem.unknown_lights,
        pixels.len(),
    );
    budget.pixels = options.effort.pixels(PIXELS);
    budget.probe.max_bounces = options.max_bounces;
    let gathered = Evidence::gather(&guess.stage(), guess.appearance(), group, pixels, &budget);
    let mut evidence = gathered.expecting(guess.problem.groups[group].expected);
    if evidence.is_empty() {
        return None;
    }
    let error = guess.groups[group].likelihood.map_or(ModelError::START, |l| l.error);
    evidence.reweigh(&guess.materials[group], error);
    Some(evidence)
}

/// Looks for other explanations of the groups with a roughness, and notes them.
pub(crate) fn find(guess: &mut Guess<'_>, options: &Options) {
    for group in guess.visible_unknowns() {
        let hypothesis = guess.groups[group].hypothesis;
        if !matches!(hypothesis, Hypothesis::Isotropic | Hypothesis::Anisotropic) {
            continue;
        }
        let found = guess.steps.value("other minima", || {
            let evidence = evidence(guess, options, group)?;
            Some(others(hypothesis, &evidence, &guess.materials[group]))
        });
        let others = found.unwrap_or_default();
        if !others.is_empty() {
            guess.groups[group].add_note(
                "a lobe of another shape explains the photograph as well: see its alternatives"
                    .to_owned(),
            );
        }
        guess.groups[group].alternatives = others;
    }
}

/// Fits of `hypothesis` at other minima than `answer` that explain the evidence as well.
fn others(hypothesis: Hypothesis, evidence: &Evidence, answer: &Material) -> Vec<Fit> {
    let best = hypothesis::fit(hypothesis, evidence, answer, Search::Local);
    let starts = starts(hypothesis, answer, &evidence.expected.bounds);
    let costs: Vec<f64> =
        starts.iter().map(|start| hypothesis::deviance_of_shape(evidence, start)).collect();
    let n = starts.len();
    let ring = hypothesis == Hypothesis::Anisotropic;
    let cost = |i: usize, step: usize| match (i + n + step).checked_sub(1) {
        // Directions close in a ring; roughnesses have ends.
        Some(j) if ring => costs[j % n],
        Some(j) if (n..2 * n).contains(&j) => costs[j - n],
        _ => f64::INFINITY,
    };
    let dips = (0..n).filter(|&i| costs[i] < cost(i, 0) && costs[i] <= cost(i, 2));
    let mut found: Vec<Fit> = Vec::new();
    for dip in dips {
        let fit = hypothesis::fit(hypothesis, evidence, &starts[dip], Search::Local);
        let known = found.iter().chain([&best]).any(|f| is_same(&f.material, &fit.material));
        if !known
            && !is_same(answer, &fit.material)
            && selection::explains_alike(&fit, &best, evidence)
        {
            found.push(fit);
        }
    }
    found
}

/// Shapes about `answer` and within the `bounds`, in the order of what is varied.
fn starts(hypothesis: Hypothesis, answer: &Material, bounds: &ParameterBounds) -> Vec<Material> {
    if hypothesis == Hypothesis::Isotropic {
        let scaled = |f: &f32| bounds.nearest_round(f * answer.alpha_x);
        let with = |alpha: f32| Material { alpha_x: alpha, alpha_y: alpha, ..answer.clone() };
        return FACTORS.iter().map(|f| with(scaled(f))).collect();
    }
    let turned = |i: usize| {
        let theta_rad = answer.theta_rad + PI * i as f32 / DIRECTIONS as f32;
        Material { theta_rad, ..answer.clone() }
    };
    (0..DIRECTIONS).map(turned).collect()
}

fn is_same(a: &Material, b: &Material) -> bool {
    let near = |x: f32, y: f32| (x / y).ln().abs() < SAME_LN_ALPHA;
    let angle = (a.theta_rad - b.theta_rad).rem_euclid(PI);
    let aligned = angle.min(PI - angle) < SAME_THETA;
    let nearly_round = near(a.alpha_x, a.alpha_y) && near(b.alpha_x, b.alpha_y);
    near(a.alpha_x, b.alpha_x) && near(a.alpha_y, b.alpha_y) && (aligned || nearly_round)
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::Rgb;

    fn lobe(alpha_x: f32, alpha_y: f32, theta_rad: f32) -> Material {
        let round = Material::isotropic(Rgb::ZERO, Rgb::ONE, alpha_x);
        Material { alpha_y, theta_rad, ..round }
    }

    #[test]
    fn shapes_are_told_apart_but_for_half_turns_and_the_direction_of_round_ones() {
        assert!(is_same(&lobe(0.1, 0.2, 0.1), &lobe(0.11, 0.19, 0.1 + PI)));
        assert!(!is_same(&lobe(0.1, 0.2, 0.1), &lobe(0.1, 0.2, 0.1 + PI / 2.0)));
        assert!(!is_same(&lobe(0.1, 0.1, 0.0), &lobe(0.2, 0.2, 0.0)));
        assert!(is_same(&lobe(0.1, 0.11, 0.0), &lobe(0.1, 0.11, 1.0)));
    }
}
