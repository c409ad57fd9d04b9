//! Residual statistics: how far a hypothesis is from the photograph, apart from all noise.
//!
//! `relative^2 = (sum W r_A r_B - sum W sigma^2) / sum W B^2`: the share of the photograph that
//! neither the model nor the noise explains. The products of residuals under two seeds are free of
//! the rendering noise; the photograph's own is subtracted. `deviation` is the standard deviation of
//! `relative^2`, from the spread of the pixels' contributions.
//!
//! A difference like this may be anything when its own noise is large. It is therefore never shown
//! as less than its standard deviation, and hypotheses are not compared by it, but by their
//! likelihoods ([`crate::likelihood`]).

use crate::evidence::Observed;
use crate::observation::Reading;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// The unexplained part of a group's photograph.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualStats {
    /// Relative square of the error that noise does not explain; may fall below zero by chance.
    pub squared: f64,
    /// Standard deviation of `squared`.
    pub deviation: f64,
    /// Relative square of the error with the photograph's noise left in.
    pub with_noise: f64,
}

impl ResidualStats {
    /// Of pixels with these weighted terms: the product of both residuals, the photograph's noise, and the squared
    /// photograph.
    pub(crate) fn of(terms: &[[f64; 3]]) -> Self {
        let [sum, noise, scale] = [0, 1, 2].map(|k: usize| terms.iter().map(|t| t[k]).sum::<f64>());
        let scale = if scale > 0.0 { scale } else { f64::INFINITY };
        let shares: Vec<f64> = terms.iter().map(|t| t[0] / scale).collect();
        Self {
            squared: (sum - noise) / scale,
            deviation: deviation_of_sum(&shares),
            with_noise: sum / scale,
        }
    }

    /// The relative error that noise does not explain, 0.01 is one percent; where it is not
    /// significant, its standard deviation.
    pub fn relative(&self) -> f64 {
        self.squared.max(self.deviation).max(0.0).sqrt()
    }

    /// The relative difference of photograph and re-rendering, without the rendering noise.
    pub fn total(&self) -> f64 {
        self.with_noise.max(0.0).sqrt()
    }
}

/// The residual statistics of the radiances `model`, rendered twice.
pub fn residual_stats(pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> ResidualStats {
    let of_pixel = |(i, pixel): (usize, &Observed)| {
        let [mut product, mut noise, mut scale] = [0.0; 3];
        for channel in 0..3 {
            let f = |v: Rgb| f64::from(v[channel]);
            let (w, b) = (f(pixel.weight), f(pixel.radiance));
            let light = 0.5 * (f(model[0][i]) + f(model[1][i]));
            if pixel.reading == Reading::AtLeast && light >= b {
                // A clipped pixel has no residual where the model is brighter.
                continue;
            }
            product += w * (b - f(model[0][i])) * (b - f(model[1][i]));
            noise += w * f(pixel.variance);
            scale += w * b * b;
        }
        [product, noise, scale]
    };
    let terms: Vec<[f64; 3]> = pixels.iter().enumerate().map(of_pixel).collect();
    ResidualStats::of(&terms)
}

/// The standard deviation of a sum, from the spread of its terms.
pub fn deviation_of_sum(terms: &[f64]) -> f64 {
    let n = terms.len().max(1) as f64;
    let sum: f64 = terms.iter().sum();
    let squares: f64 = terms.iter().map(|t| t * t).sum();
    (squares - sum * sum / n).max(0.0).sqrt()
}
