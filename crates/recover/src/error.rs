//! How far a hypothesis is from the photograph, apart from all noise.
//!
//! `relative^2 = (sum W r_A r_B - sum W sigma^2) / sum W B^2`: the share of the photograph that
//! neither the model nor the noise explains. The products of residuals under two seeds are free of
//! our noise; the photograph's own is subtracted. `deviation` is the standard deviation of
//! `relative^2`, from the spread of the pixels' contributions.

use crate::evidence::Observed;
use unrender_scene::Rgb;

/// The unexplained part of a group's photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Relative square of the error that noise does not explain; may fall below zero by chance.
    pub squared: f64,
    /// Standard deviation of `squared`.
    pub deviation: f64,
    /// Relative square of the error with the photograph's noise left in.
    pub with_noise: f64,
}

impl Misfit {
    /// The relative error that noise does not explain: 0.01 is one percent.
    pub fn relative(&self) -> f64 {
        self.squared.max(0.0).sqrt()
    }

    /// The relative difference of photograph and re-rendering, our own noise taken out.
    pub fn total(&self) -> f64 {
        self.with_noise.max(0.0).sqrt()
    }

    /// Whether an error of `tolerance` or less, together with chance, explains the misfit.
    pub fn is_within(&self, tolerance: f64) -> bool {
        self.squared <= tolerance * tolerance + 2.0 * self.deviation
    }
}

/// The misfit of the radiances `model`, rendered twice.
pub fn misfit(pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> Misfit {
    misfit_by_pixel(pixels, model).0
}

/// The misfit, and what each pixel contributes to its square.
pub fn misfit_by_pixel(pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> (Misfit, Vec<f64>) {
    let (mut sum, mut noise, mut scale) = (0.0, 0.0, 0.0);
    let mut contributions = Vec::with_capacity(pixels.len());
    for (i, pixel) in pixels.iter().enumerate() {
        let mut contribution = 0.0;
        for channel in 0..3 {
            let f = |v: Rgb| f64::from(v[channel]);
            let (w, b) = (f(pixel.weight), f(pixel.radiance));
            contribution += w * (b - f(model[0][i])) * (b - f(model[1][i]));
            noise += w * f(pixel.variance);
            scale += w * b * b;
        }
        sum += contribution;
        contributions.push(contribution);
    }
    let scale = if scale > 0.0 { scale } else { f64::INFINITY };
    contributions.iter_mut().for_each(|c| *c /= scale);
    let misfit = Misfit {
        squared: (sum - noise) / scale,
        deviation: deviation_of_sum(&contributions),
        with_noise: sum / scale,
    };
    (misfit, contributions)
}

/// The standard deviation of a sum, from the spread of its terms.
pub fn deviation_of_sum(terms: &[f64]) -> f64 {
    let n = terms.len().max(1) as f64;
    let sum: f64 = terms.iter().sum();
    let squares: f64 = terms.iter().map(|t| t * t).sum();
    (squares - sum * sum / n).max(0.0).sqrt()
}
