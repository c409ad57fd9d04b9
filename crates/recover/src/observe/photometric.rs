//! Photometric parameters of the camera, estimated together with the materials: a gamma, say, or
//! the coefficients of vignetting.
//!
//! The effect of such a parameter on the photograph is known without any rendering. Near the values `c` with which it
//! was developed, `B(c + s) = B(c) + sum_k s_k dB/dc_k`, and `s` joins the unknowns of the refinement. The caller
//! develops the photograph again with `c + s`, until `s` is small.

use crate::observe::observation::Observation;
use serde::{Deserialize, Serialize};
use unrender_scene::{Rgb, RgbImage};

/// One parameter of the camera that is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotometricParameter {
    /// The photograph that it is of, in the order of their sheet.
    pub photograph: usize,
    /// How that photograph's values change with it, before the exposure is applied.
    pub derivative: RgbImage,
    /// Its prior mean, counted from where it is now.
    pub prior_mean: f64,
    /// The standard deviation of that prior, which decides only where the photograph does not.
    pub deviation: f64,
    /// How far it may go from where it is now, because the derivative holds no further.
    pub reach: f64,
}

/// The estimates of the camera's parameters, in the order of [`crate::Problem::photometric_parameters`].
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PhotometricEstimate {
    /// How far each is from where it was.
    pub steps: Vec<f64>,
    /// The covariance of them; empty if nothing was refined.
    pub covariance: Vec<Vec<f64>>,
}

impl PhotometricParameter {
    /// The relative change of its whole photograph per unit of it.
    pub(crate) fn relative(&self, observation: &Observation) -> Rgb {
        let values = observation.picture.values.pixels();
        let value =
            |local: usize| values[observation.sheet.pixel(self.photograph, local as u32) as usize];
        let derivatives = self.derivative.pixels();
        let whole: Rgb = (0..derivatives.len()).map(value).sum();
        derivatives.iter().copied().sum::<Rgb>() / whole.max(Rgb::splat(f32::MIN_POSITIVE))
    }

    /// How a pixel's value changes with it.
    pub(crate) fn change(&self, observation: &Observation, pixel: u32) -> Rgb {
        let sheet = &observation.sheet;
        if sheet.photograph_of(pixel) != self.photograph {
            return Rgb::ZERO;
        }
        let here = sheet.in_photograph(pixel).map(|here| self.derivative.pixels()[here as usize]);
        here.unwrap_or(Rgb::ZERO)
    }
}
