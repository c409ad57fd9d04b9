//! How far a group's reflectances go towards their fits in an iteration.
//!
//! Groups light each other and themselves: where the camera does not see most of a bright room's walls, a
//! brighter wall makes more light, in which the fit is a darker one. Steps that are too long then swing from
//! bright to dark and back. How the fit answers to the reflectance, `J`, is the secant through this iteration
//! and the last; the fixed point lies at the share `1 / (1 - J)` of the way [Wegstein 1958].

use crate::hypothesis::Hypothesis;
use serde::{Deserialize, Serialize};
use unrender_scene::{Material, Rgb};

/// The share of the way to the fitted reflectances that an iteration goes at most: a little less than the full
/// step, for what the secant does not know yet. Half of it takes three times as many iterations.
const MOST: f32 = 0.9;
/// The least share: a noisy secant stops nothing.
const LEAST: f32 = 0.1;
/// Reflectances that moved by less say nothing of how the fit answers: light samples are noisy. At half of it
/// noise makes steps shorter, at double small swings stay.
const MOVED: f32 = 0.01;

/// Where a group's reflectances stood and where its fit had them, in one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Way {
    hypothesis: Hypothesis,
    /// `rho_d` and `rho_s`.
    from: [Rgb; 2],
    to: [Rgb; 2],
}

impl Way {
    /// From `now` to `fitted`.
    pub(crate) fn new(hypothesis: Hypothesis, now: &Material, fitted: &Material) -> Self {
        Self { hypothesis, from: [now.rho_d, now.rho_s], to: [fitted.rho_d, fitted.rho_s] }
    }

    /// The `fitted` material with its reflectances part of the way there, by what became of the `last` way.
    pub(crate) fn go(&self, last: Option<&Self>, fitted: Material) -> Material {
        let last = last.filter(|last| last.hypothesis == self.hypothesis);
        let [rho_d, rho_s] = [0, 1].map(|term| {
            let next = |channel: usize| {
                let at = |rgb: &[Rgb; 2]| rgb[term][channel];
                let (from, to) = (at(&self.from), at(&self.to));
                let share =
                    last.map_or(MOST, |last| share([from, to], [at(&last.from), at(&last.to)]));
                from + share * (to - from)
            };
            Rgb::new(next(0), next(1), next(2))
        });
        Material { rho_d, rho_s, ..fitted }
    }
}

/// The share of the way for one number.
fn share([from, to]: [f32; 2], [last_from, last_to]: [f32; 2]) -> f32 {
    let moved = from - last_from;
    if moved.abs() < MOVED {
        return MOST;
    }
    let slope = (to - last_to) / moved;
    (1.0 - slope).recip().clamp(LEAST, MOST)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A group whose fit answers to its reflectance with the `slope`, about the fixed point 0.6.
    fn iterate(slope: f32) -> f32 {
        let mut now = Material::diffuse(Rgb::splat(0.5));
        let mut last = None;
        for _ in 0..6 {
            let fitted = Material::diffuse(Rgb::splat(0.6) + slope * (now.rho_d - Rgb::splat(0.6)));
            let way = Way::new(Hypothesis::Diffuse, &now, &fitted);
            now = way.go(last.as_ref(), fitted);
            last = Some(way);
        }
        (now.rho_d - Rgb::splat(0.6)).abs().max_element()
    }

    #[test]
    fn swings_end() {
        for slope in [0.0, -0.5, -1.1, -1.5, -3.0] {
            let left = iterate(slope);
            assert!(left < 0.005, "{slope}: {left}");
        }
    }
}
