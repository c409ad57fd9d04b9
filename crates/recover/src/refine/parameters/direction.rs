//! The anisotropy direction of a group, radians; all channels share it.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::unknown::Unknown;
use unrender_render::Parameter;

/// The angle from the tangent.
pub(super) struct Direction;

/// The standard deviation of the prior, radians: any direction is likely, they repeat after pi. Half of
/// it pulls lobes that are nearly round towards the start; double of it changes nothing.
const DEVIATION: f64 = 1.0;
/// No step turns it by more than this, radians, which is less than the half width of most brushed lobes.
/// Half of it takes more passes, double of it passes over the minimum.
const STEP: f64 = 0.3;
/// The standard deviation that is small enough, radians: 0.11 degrees. With half of it and of the other blocks' a room
/// of 11 groups takes half as long again and comes no nearer; double was not tried.
const PRECISE: f64 = 2e-3;

impl ParameterKind for Direction {
    fn name(&self) -> &'static str {
        "theta"
    }

    fn prior(&self, _: &Guess<'_>, _: &Unknown) -> Prior {
        Prior { mean: None, deviation: DEVIATION }
    }

    fn precise_enough(&self, _: &Guess<'_>, _: &Unknown) -> f64 {
        PRECISE
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        f64::from(at.guess.materials[u.of].theta_rad)
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        guess.materials[u.of].theta_rad = value as f32;
    }

    fn range(&self, _: &Guess<'_>, _: &Unknown, _: f64) -> Range {
        Range { low: f64::NEG_INFINITY, high: f64::INFINITY, step: STEP }
    }

    fn parameters(&self, of: u32) -> [Parameter; 2] {
        [Parameter::Theta(of); 2]
    }

    fn derivative(&self, _: At<'_>, _: &Unknown, linear: &Linear<'_>) -> f64 {
        linear.derivative
    }
}
