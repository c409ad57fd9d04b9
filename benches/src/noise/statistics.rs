//! Computes the noise from two pictures that differ only by noise.

use crate::statistics::median;
use serde::{Deserialize, Serialize};

/// The standard deviation of a Gaussian over the median of its absolute value.
const DEVIATION_OF_MEDIAN: f64 = 1.482_602_218_505_602;
/// One pixel in this many is among the worst, at least one in all. It is as rare as fireflies are; at half of it a
/// group of 1000 pixels has twice as many and Gaussian noise alone is 2 % of the variance, at double it has the same
/// one.
const WORST_ONE_IN: usize = 1000;

/// The noise of a set of pixels in one rendering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Noise {
    /// The number of pixels.
    pub(super) pixels: usize,
    /// Their mean radiance, W sr^-1 m^-2.
    pub(super) mean: f64,
    /// The root mean square of the noise, over the mean radiance.
    pub(super) rms: f64,
    /// The same, from the median.
    pub(super) robust: f64,
    /// The share of the variance that is in the worst pixels.
    pub(super) worst: f64,
}

impl Noise {
    /// The noise of pixels with these values in two renderings; zero if they are black, or if there
    /// are none.
    pub(super) fn of(pixels: &[[f64; 2]]) -> Self {
        let count = pixels.len().max(1) as f64;
        let mean = pixels.iter().flatten().sum::<f64>() / (2.0 * count);
        // The difference of two pictures has twice the variance of one.
        let differences = pixels.iter().map(|[a, b]| (a - b).abs() / 2f64.sqrt());
        let mut differences: Vec<f64> = differences.collect();
        differences.sort_by(|a, b| b.total_cmp(a));
        let squares = |part: &[f64]| part.iter().map(|d| d * d).sum::<f64>();
        let all = squares(&differences);
        let worst = (pixels.len() / WORST_ONE_IN).max(1).min(pixels.len());
        Self {
            pixels: pixels.len(),
            mean,
            rms: over((all / count).sqrt(), mean),
            robust: if pixels.is_empty() {
                0.0
            } else {
                over(DEVIATION_OF_MEDIAN * median(differences.iter().copied()), mean)
            },
            worst: over(squares(&differences[..worst]), all),
        }
    }

    /// The heaviness of the tail: the root mean square over the robust standard deviation. None if half of the
    /// pixels have no noise.
    pub(super) fn ratio(&self) -> Option<f64> {
        (self.robust > 0.0).then(|| self.rms / self.robust)
    }
}

/// A quotient, zero if the divisor is not positive.
fn over(value: f64, by: f64) -> f64 {
    if by > 0.0 { value / by } else { 0.0 }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use unrender::render::sampler::mix;

    /// A Gaussian number of variance one, different for each `index` [Box and Muller 1958].
    fn gaussian(index: u64) -> f64 {
        let uniform = |i: u64| ((mix(i) >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let (u, v) = (uniform(2 * index), uniform(2 * index + 1));
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Pixels of the radiance `mean` with Gaussian noise of the relative standard deviation
    /// `sigma`.
    pub(in super::super) fn noisy(count: u64, mean: f64, sigma: f64) -> Vec<[f64; 2]> {
        let value = |index: u64| mean * (1.0 + sigma * gaussian(index));
        (0..count).map(|i| [value(2 * i), value(2 * i + 1)]).collect()
    }

    #[test]
    fn a_gaussian_has_its_deviation_in_both_numbers() {
        let noise = Noise::of(&noisy(40_000, 3.0, 0.1));
        assert_eq!(noise.pixels, 40_000);
        // Standard deviations: 0.1 / sqrt(80000) of the mean, 1 / sqrt(80000) and 1.17 / sqrt(40000) of the others.
        assert!((noise.mean / 3.0 - 1.0).abs() < 2e-3, "{noise:?}");
        assert!((noise.rms / 0.1 - 1.0).abs() < 0.02, "{noise:?}");
        assert!((noise.robust / 0.1 - 1.0).abs() < 0.03, "{noise:?}");
        assert!((noise.ratio().unwrap() - 1.0).abs() < 0.04);
        // The worst in a thousand lie beyond 3.29 deviations: 1.2 % of the variance.
        assert!((noise.worst - 0.012).abs() < 0.003, "{noise:?}");
    }

    #[test]
    fn one_bright_pixel_makes_the_ratio_and_has_the_variance() {
        let mut pixels = noisy(1999, 1.0, 0.01);
        let quiet = Noise::of(&pixels);
        pixels.push([1.0, 41.0]);
        let loud = Noise::of(&pixels);
        // The difference of 40 is that of one of the two pictures: 40 / sqrt 2 of noise in 2000 pixels.
        let expected = 40.0 / 2f64.sqrt() / 2000f64.sqrt() / loud.mean;
        assert!((loud.rms / expected - 1.0).abs() < 1e-3, "{loud:?}");
        assert!((loud.robust / quiet.robust - 1.0).abs() < 0.02, "{loud:?}");
        assert!(loud.ratio().unwrap() > 50.0 && loud.worst > 0.99, "{loud:?}");
    }

    #[test]
    fn equal_pictures_have_no_noise() {
        let noise = Noise::of(&[[2.0, 2.0]; 500]);
        let expected = Noise { pixels: 500, mean: 2.0, rms: 0.0, robust: 0.0, worst: 0.0 };
        assert_eq!(noise, expected);
        assert_eq!(noise.ratio(), None);
    }

    #[test]
    fn black_pixels_and_none_are_numbers_too() {
        for pixels in [&[[0.0; 2]; 3][..], &[]] {
            let Noise { mean, rms, robust, worst, .. } = Noise::of(pixels);
            assert_eq!([mean, rms, robust, worst], [0.0; 4]);
        }
    }
}
