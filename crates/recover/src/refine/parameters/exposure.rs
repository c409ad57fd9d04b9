//! The exposure, a number a channel, as a multiple of where it started.

use super::light::{DEVIATION, PRECISE, STEP};
use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::unknown::Unknown;
use unrender_render::Parameter;

/// The factor on the exposure. It may be as wrong as a lamp, and has to be as precise.
pub(super) struct Exposure;

impl ParameterKind for Exposure {
    fn name(&self) -> &'static str {
        "exposure"
    }

    fn is_nuisance(&self) -> bool {
        true
    }

    fn prior(&self, _: &Guess<'_>, _: &Unknown) -> Prior {
        Prior { mean: None, deviation: DEVIATION }
    }

    fn precise_enough(&self, _: &Guess<'_>, _: &Unknown) -> f64 {
        PRECISE
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        let channel = u.channel.unwrap_or(0);
        f64::from(at.guess.exposure[channel] / at.start.exposure[channel])
    }

    fn set(&self, guess: &mut Guess<'_>, start: &Start, u: &Unknown, value: f64) {
        let channel = u.channel.unwrap_or(0);
        guess.exposure[channel] = value as f32 * start.exposure[channel];
    }

    fn range(&self, _: &Guess<'_>, _: &Unknown, value: f64) -> Range {
        Range { low: 0.0, high: f64::INFINITY, step: STEP * value }
    }

    /// The photograph's radiance moves with the exposure, in the cache too.
    fn parameters(&self, _: u32) -> [Parameter; 2] {
        [Parameter::Cache; 2]
    }

    /// It uses the rendered radiance, not the photograph's, whose noise is also in the residuals.
    fn derivative(&self, at: At<'_>, u: &Unknown, linear: &Linear<'_>) -> f64 {
        (linear.derivative - linear.radiance) / self.value(at, u)
    }
}
