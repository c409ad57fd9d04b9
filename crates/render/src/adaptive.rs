//! Adaptive sampling: more samples where the variance is high.
//!
//! With `sigma^2` the variance of one sample and `n` the number of samples of a tile of the
//! picture, the mean squared error of the picture is the mean of `sigma^2 / n`. For a given total
//! it is least where `n` is proportional to `sigma` [Neyman 1934]. A pilot rendering of [`PILOT`]
//! samples per pixel estimates `sigma` of every tile of [`TILE`] x [`TILE`] pixels. The share
//! [`UNIFORM_SHARE`] of all samples is allocated uniformly, since a short pilot misses rare bright
//! paths.
//!
//! The pilot has random numbers of its own and its samples are not part of the picture. So the
//! number of samples of a pixel is independent of their values, and the estimate is unbiased; it
//! would not be if a pixel stopped once its own samples look converged [Kirk and Arvo 1991]. One
//! dependence remains where a whole picture is rendered until its noise is below a limit: the
//! values of its pixels influence when that is, but less the more pixels there are.

use crate::film::Accumulator;
use std::ops::Range;

/// Samples per pixel of the pilot. With half of it the estimate of a tile's standard deviation is
/// itself noisy, with double of it the pilot takes a large part of short renderings.
pub const PILOT: u32 = 16;
/// The side of a tile, pixels. Not derived from the resolution: it sets how many samples (64 pixels
/// times [`PILOT`]) estimate a variance. Half of it has a quarter of the samples, double of it
/// blurs edges of shadows.
pub const TILE: usize = 8;
/// The share of the samples that is allocated uniformly. Half of it starves tiles whose bright
/// paths the pilot missed, double of it loses half of the gain.
pub const UNIFORM_SHARE: f64 = 0.25;

/// Separates the random numbers of the pilot from those of the picture under the same seed.
const STREAM: u64 = 0x9170_0000_0000_0000;

/// The seed of the pilot of a picture under `seed`.
pub fn pilot_seed(seed: u64) -> u64 {
    seed ^ STREAM
}

/// The number of samples of each pixel, relative to the mean over the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveSampling {
    width: usize,
    tiles_in_a_row: usize,
    /// One per tile, row by row; the mean over the pixels is one.
    densities: Vec<f64>,
}

impl AdaptiveSampling {
    /// The allocation by the standard deviations in `pilot`; uniform if they are all zero.
    pub fn from_pilot(pilot: &Accumulator) -> Self {
        let (width, height) = pilot.size();
        let tiles_in_a_row = width.div_ceil(TILE);
        let tiles = tiles_in_a_row * height.div_ceil(TILE);
        let (mut variance, mut pixels) = (vec![0.0; tiles], vec![0.0; tiles]);
        for (index, pixel) in pilot.image().pixels().iter().enumerate() {
            let tile = tile(index, width, tiles_in_a_row);
            variance[tile] += pixel.sample_variance().element_sum();
            pixels[tile] += 1.0;
        }
        let sigmas = variance.iter().zip(&pixels).map(|(s, n)| f64::sqrt(s / n));
        let sigmas: Vec<f64> = sigmas.collect();
        let total: f64 = sigmas.iter().zip(&pixels).map(|(s, n)| s * n).sum();
        let mean = total / (width * height) as f64;
        let density = |sigma: f64| {
            if mean > 0.0 { UNIFORM_SHARE + (1.0 - UNIFORM_SHARE) * sigma / mean } else { 1.0 }
        };
        Self { width, tiles_in_a_row, densities: sigmas.into_iter().map(density).collect() }
    }

    /// The sample numbers of pixel `index` while the mean number over the picture goes from
    /// `mean.start` to `mean.end`. Consecutive ranges give consecutive ranges. Every pixel has its
    /// first two samples before any of them is left out, so that its variance can be estimated.
    pub fn samples(&self, index: usize, mean: Range<u32>) -> Range<u32> {
        let density = self.densities[tile(index, self.width, self.tiles_in_a_row)];
        let count = |mean: u32| ((f64::from(mean) * density) as u32).max(mean.min(2));
        count(mean.start)..count(mean.end)
    }
}

/// Which samples every pixel takes.
#[derive(Clone, Debug)]
pub enum SampleAllocation<'a> {
    /// These sample numbers in all pixels.
    Uniform(Range<u32>),
    /// Adaptive: [`AdaptiveSampling::samples`] of this range.
    Adaptive(&'a AdaptiveSampling, Range<u32>),
    /// Every other sample number of an allocation, numbered on their own: the even ones for half 0, the odd ones
    /// for half 1. Halves with random numbers of their own are as well stratified as whole pictures
    /// ([`crate::denoise`]).
    Half(&'a SampleAllocation<'a>, usize),
}

impl SampleAllocation<'_> {
    /// The sample numbers of pixel `index`.
    pub fn of(&self, index: usize) -> Range<u32> {
        match self {
            Self::Uniform(samples) => samples.clone(),
            Self::Adaptive(sampling, mean) => sampling.samples(index, mean.clone()),
            Self::Half(whole, half) => {
                let numbered = |whole: u32| if *half == 0 { whole.div_ceil(2) } else { whole / 2 };
                let Range { start, end } = whole.of(index);
                numbered(start)..numbered(end)
            }
        }
    }
}

/// The tile of pixel `index`.
fn tile(index: usize, width: usize, tiles_in_a_row: usize) -> usize {
    (index / width / TILE) * tiles_in_a_row + index % width / TILE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::mix;
    use glam::DVec3;
    use unrender_scene::Rgb;

    const SIDE: usize = 16;

    /// Sample number `index` of a pixel: one in fifty is 50, the others zero; the mean is one.
    fn sample(stream: u64, pixel: usize, index: u32) -> Rgb {
        let random = mix(mix(stream) ^ ((pixel as u64) << 32 | u64::from(index)));
        Rgb::splat(if random.is_multiple_of(50) { 50.0 } else { 0.0 })
    }

    fn picture(stream: u64, samples: impl Fn(usize) -> Range<u32>) -> Accumulator {
        let mut picture = Accumulator::new(SIDE, SIDE);
        for (pixel, accumulator) in picture.image_mut().pixels_mut().iter_mut().enumerate() {
            samples(pixel).for_each(|index| accumulator.push(sample(stream, pixel, index)));
        }
        picture
    }

    /// Mean and its standard deviation over many pictures, whose pilots have the streams
    /// `pilot_of`.
    fn mean_of_many(pilot_of: impl Fn(u64) -> u64) -> (f64, f64) {
        let means: Vec<f64> = (0..10_000)
            .map(|seed| {
                let pilot = picture(pilot_of(seed), |_| 0..PILOT);
                let sampling = AdaptiveSampling::from_pilot(&pilot);
                let picture = picture(2 * seed, |pixel| sampling.samples(pixel, 0..24)).mean();
                let sum: DVec3 = picture.pixels().iter().map(|rgb| rgb.as_dvec3()).sum();
                sum.x / (SIDE * SIDE) as f64
            })
            .collect();
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    }

    #[test]
    fn an_independent_pilot_is_unbiased_and_one_among_the_samples_is_not() {
        let (mean, deviation) = mean_of_many(|seed| 2 * seed + 1);
        assert!((mean - 1.0).abs() < 4.5 * deviation, "{mean} +- {deviation}");
        assert!(deviation < 1.5e-3);
        let (mean, deviation) = mean_of_many(|seed| 2 * seed);
        assert!(mean < 1.0 - 6.0 * deviation, "samples that decide on themselves: {mean}");
    }
}
