//! The glossy rungs (sections 4.2.4 and 4.2.5): the roughness by downhill simplex, and the anisotropy direction of
//! the re-rendering that differs least from the photograph.
//!
//! Every step of both is a re-rendering of the group, from the same samples of the light that arrives there
//! ([`Evidence`]): the sums for a lobe cost a thousandth of new paths, so 64 directions cost what a few paths do, and
//! two steps differ by their lobes and not by their noise. At each roughness the reflectances are those of the
//! paper's own linear system (section 4.2.3), so that the simplex has the roughness alone to search.

use crate::brushed::{DIRECTIONS, angle};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};
use unrender_recover::evidence::Evidence;
use unrender_recover::fit::linear::{self, Terms};
use unrender_recover::fit::simplex;
use unrender_recover::hypothesis::anisotropic::canonical;
use unrender_recover::observe::observation::Reading;
use unrender_recover::observe::sample::Observed;
use unrender_scene::{Material, Rgb};

/// Where the search for a round lobe starts if nothing is known of it.
const FIRST_ALPHA: f32 = 0.1;
/// A round lobe is made so many times as wide across the direction as it was, and as much narrower along it, before
/// directions are tried: while it is round all are alike.
const ELONGATION: f32 = 1.4;
/// The first step of the simplex, of the logarithms of the roughnesses.
const STEP: f64 = 0.2;
/// The simplex stops where the squared errors at its corners differ by less than this, relative to the photograph ...
const ALIKE: f64 = 1e-9;
/// ... or after so many steps.
const TURNS: u64 = 80;
/// Direction and roughness are found in turn at most so often; on Figure 8 the direction stays from the second time on.
const ROUNDS: usize = 6;
/// And until the direction changes by less than this, radians: a hundredth of the step between those that are sampled.
/// Half and double of it were not tried.
const SETTLED: f32 = 5e-4;

/// A material and the error of its re-rendering.
#[derive(Clone, Debug)]
pub struct Rerendered {
    /// The material.
    pub material: Material,
    /// The squared difference of photograph and re-rendering, relative to the squared photograph, without the rendering
    /// noise: it may fall below zero.
    pub error: f64,
}

/// One group's photograph, and the light to re-render it from.
#[derive(Clone, Debug)]
pub struct Lobes {
    evidence: Evidence,
    diffuse: [Vec<Rgb>; 2],
    /// The squared photograph, weighted.
    scale: f64,
}

impl Lobes {
    /// From what was gathered of the group; incident samples must have been kept.
    pub fn new(evidence: Evidence) -> Self {
        let squared = evidence
            .sample
            .pixels
            .iter()
            .map(|p| (p.weight * p.radiance * p.radiance).element_sum());
        let scale = squared.map(f64::from).sum::<f64>().max(f64::MIN_POSITIVE);
        Self { diffuse: evidence.light.diffuse(), evidence, scale }
    }

    /// The group with a lobe of the shape `[alpha_x, alpha_y, theta]` and the reflectances that fit best.
    pub fn rerender(&self, shape: [f32; 3]) -> Rerendered {
        let [alpha_x, alpha_y, theta_rad] = self.evidence.expected.bounds.nearest_shape(shape);
        let specular = self.evidence.light.lobe(alpha_x, alpha_y, theta_rad);
        let found = linear::fit(&self.evidence, &self.diffuse, Some(&specular), Terms::default());
        let diffuse = Material::diffuse(found.rho_d);
        let material = Material { rho_s: found.rho_s, alpha_x, alpha_y, theta_rad, ..diffuse };
        Rerendered { material, error: found.objective / self.scale }
    }

    /// The squared difference of photograph and re-rendering at every pixel, weighted, without the rendering noise;
    /// zero where the photograph is clipped.
    pub fn squares(&self, material: &Material) -> Vec<f64> {
        let [a, b] = self.evidence.light.radiance(material);
        let square = |(i, pixel): (usize, &Observed)| {
            let square = pixel.weight * (pixel.radiance - a[i]) * (pixel.radiance - b[i]);
            if pixel.reading == Reading::Value { f64::from(square.element_sum()) } else { 0.0 }
        };
        self.evidence.sample.pixels.iter().enumerate().map(square).collect()
    }

    /// Section 4.2.4: the round lobe that fits best, near the roughness of `start` if that has one; `rho_s = 1` is
    /// searched separately.
    pub fn isotropic(&mut self, start: &Material) -> Rerendered {
        let known = (start.alpha_x * start.alpha_y).sqrt();
        let alpha = if start.is_glossy() { known } else { FIRST_ALPHA };
        self.better(|lobes| {
            let round = |logs: &[f64]| {
                let alpha = lobes.evidence.expected.bounds.nearest_round(logs[0].exp() as f32);
                [alpha, alpha, 0.0]
            };
            lobes.downhill(&[alpha], &round)
        })
    }

    /// Section 4.2.5: both roughnesses, with the direction of `start`.
    pub fn along(&mut self, start: &Material) -> Rerendered {
        let [x, y, theta] = elongated(start);
        let found = self.better(|lobes| {
            lobes.downhill(&[x, y], &|logs: &[f64]| {
                [logs[0].exp() as f32, logs[1].exp() as f32, theta]
            })
        });
        let [alpha_x, alpha_y, theta_rad] =
            canonical([found.material.alpha_x, found.material.alpha_y, found.material.theta_rad]);
        Rerendered { material: Material { alpha_x, alpha_y, theta_rad, ..found.material }, ..found }
    }

    /// The same with the direction of the least error, which is found again for each pair of roughnesses.
    pub fn anisotropic(&mut self, start: &Material) -> Rerendered {
        let [alpha_x, alpha_y, theta_rad] = elongated(start);
        let mut found = Rerendered {
            material: Material { alpha_x, alpha_y, theta_rad, ..start.clone() },
            error: f64::INFINITY,
        };
        for _ in 0..ROUNDS {
            let theta_rad = self.direction([found.material.alpha_x, found.material.alpha_y]);
            let turned =
                (theta_rad - found.material.theta_rad + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2;
            if found.error.is_finite() && turned.abs() < SETTLED {
                break;
            }
            found = self.along(&Material { theta_rad, ..found.material });
        }
        found
    }

    /// The direction along which a lobe of these roughnesses, with the reflectances that fit best, differs least from the
    /// photograph: of those that are sampled, and between these the lowest point of the parabola through the least error and
    /// both beside it. Radians from the tangent, in [0, pi).
    pub fn direction(&self, alphas: [f32; 2]) -> f32 {
        lowest(&self.errors(alphas))
    }

    /// The errors of all sampled directions.
    pub fn errors(&self, [x, y]: [f32; 2]) -> Vec<f64> {
        let directions = (0..DIRECTIONS).into_par_iter();
        directions.map(|i| self.rerender([x, y, angle(i)]).error).collect()
    }

    /// The better of what `search` finds with `rho_s` free, and with `rho_s = 1` where that is allowed.
    fn better(&mut self, search: impl Fn(&Self) -> Rerendered) -> Rerendered {
        let free = search(self);
        let bounds = self.evidence.expected.bounds.rho_s;
        if bounds[1] != Rgb::ONE {
            return free;
        }
        self.evidence.expected.bounds.rho_s = [Rgb::ONE; 2];
        let full = search(self);
        self.evidence.expected.bounds.rho_s = bounds;
        if full.error < free.error { full } else { free }
    }

    /// Downhill from these roughnesses; `shape` maps their logarithms to a lobe.
    fn downhill(&self, alphas: &[f32], shape: &dyn Fn(&[f64]) -> [f32; 3]) -> Rerendered {
        let first: Vec<f64> = alphas.iter().map(|alpha| f64::from(*alpha).ln()).collect();
        let steps = vec![STEP; first.len()];
        let cost = |logs: &[f64]| self.rerender(shape(logs)).error;
        let (best, _) = simplex::minimise(cost, &first, &steps, ALIKE, TURNS);
        self.rerender(shape(&best))
    }
}

/// The direction of the lowest point of the errors of all sampled directions, radians in [0, pi).
fn lowest(errors: &[f64]) -> f32 {
    let n = errors.len();
    let least = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    let Some((i, least)) = least else { return 0.0 };
    let (before, after) = (errors[(i + n - 1) % n], errors[(i + 1) % n]);
    let curvature = before - 2.0 * least + after;
    let beside = if curvature > 0.0 { 0.5 * (before - after) / curvature } else { 0.0 };
    (angle(i) + beside as f32 * angle(1)).rem_euclid(PI)
}

/// The shape of `start`, longer than wide.
fn elongated(start: &Material) -> [f32; 3] {
    let Material { alpha_x, alpha_y, theta_rad, .. } = *start;
    if !start.is_glossy() {
        [FIRST_ALPHA / ELONGATION, FIRST_ALPHA * ELONGATION, theta_rad]
    } else if alpha_x == alpha_y {
        [alpha_x / ELONGATION, alpha_y * ELONGATION, theta_rad]
    } else {
        [alpha_x, alpha_y, theta_rad]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_point_is_found_between_the_directions() {
        for degrees in [0.3f32, 35.0, 89.0, 179.5] {
            let theta = degrees.to_radians();
            let error = |i: usize| 0.01 - 0.004 * f64::from((2.0 * (angle(i) - theta)).cos());
            let found = lowest(&(0..DIRECTIONS).map(error).collect::<Vec<f64>>()).to_degrees();
            let off = (found - degrees + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() < 0.01, "{degrees} came out as {found}");
        }
        assert_eq!(lowest(&[1.0; DIRECTIONS]), 0.0);
    }
}
