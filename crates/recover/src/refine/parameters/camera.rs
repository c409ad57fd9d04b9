//! A parameter of the camera, relative to its value when the photograph was developed; all channels share it.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::unknown::Unknown;
use unrender_render::Parameter;

/// A number of [`crate::Problem::photometric_parameters`], which says what it is.
pub(super) struct Camera;

/// The standard deviation that is small enough, in the unit of the number: gammas and shares of light in the corners
/// are about one. Half of it takes four times the paths; double of it is half a pixel value of 8 bits.
const PRECISE: f64 = 1e-3;

impl ParameterKind for Camera {
    fn name(&self) -> &'static str {
        "camera"
    }

    fn is_nuisance(&self) -> bool {
        true
    }

    fn prior(&self, guess: &Guess<'_>, u: &Unknown) -> Prior {
        let parameter = &guess.problem.photometric_parameters[u.of];
        Prior { mean: Some(parameter.prior_mean), deviation: parameter.deviation }
    }

    fn precise_enough(&self, _: &Guess<'_>, _: &Unknown) -> f64 {
        PRECISE
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        at.guess.photometric.steps[u.of]
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        guess.photometric.steps[u.of] = value;
    }

    fn range(&self, guess: &Guess<'_>, u: &Unknown, _: f64) -> Range {
        let reach = guess.problem.photometric_parameters[u.of].reach;
        Range { low: -reach, high: reach, step: f64::INFINITY }
    }

    /// The cache of the photograph's radiance moves with it.
    fn parameters(&self, _: u32) -> [Parameter; 2] {
        [Parameter::Cache; 2]
    }

    /// It uses the rendered radiance, not the photograph's, whose noise is also in the residuals.
    fn derivative(&self, at: At<'_>, u: &Unknown, linear: &Linear<'_>) -> f64 {
        if at.guess.problem.photometric_parameters[u.of].photograph != linear.photograph {
            return 0.0;
        }
        let by_cache = linear.derivative * f64::from(at.start.relative[u.of][linear.channel]);
        by_cache - f64::from(linear.changes[u.of][linear.channel]) * linear.radiance
    }
}
