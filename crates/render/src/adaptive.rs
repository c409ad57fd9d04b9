//! More samples where the noise is.
//!
//! With `sigma` the standard deviation of a path's radiance and `n` the number of paths in a tile
//! of the picture, the mean square of the picture's noise is the mean of `sigma^2/n`, and for a
//! given number of paths in all it is least where `n` is proportional to `sigma` [Neyman 1934]. A
//! pilot picture of [`PILOT`] paths a pixel measures `sigma` for every tile of [`TILE`] x [`TILE`]
//! pixels. A share of [`EVEN`] of all paths goes to all pixels alike, since a pilot of few paths
//! does not see everything.
//!
//! The pilot's paths are drawn from numbers of their own and do not go into the picture. So the
//! number of paths in a pixel does not depend on what they bring, and their mean is without bias.
//! (It would not be if a pixel could stop as soon as its own paths look calm.) One dependence
//! remains where a whole picture is rendered until its own noise is below a limit: its pixels'
//! values have a little say in when it ends, each the less the more of them there are.

use crate::film::Settings;
use crate::tally::Tally;
use crate::tracer::{Appearance, Tracer};
use std::ops::Range;
use unrender_scene::Camera;

/// Paths a pixel of the picture that the noise is measured in.
pub const PILOT: u32 = 16;
/// The side of a tile, pixels.
pub const TILE: usize = 8;
/// The share of the paths that all pixels get alike.
pub const EVEN: f64 = 0.25;

/// Keeps the pilot's numbers apart from those of the picture under the same seed.
const STREAM: u64 = 0x9170_0000_0000_0000;

/// The seed of the pilot of a picture under `seed`.
pub fn pilot_seed(seed: u64) -> u64 {
    seed ^ STREAM
}

/// How many paths each pixel gets, relative to the mean over the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    width: usize,
    tiles_in_a_row: usize,
    /// One for each tile, row by row; their mean over the pixels is one.
    shares: Vec<f64>,
}

impl Shares {
    /// The shares by the noise of `pilot`; all alike if it has none.
    pub fn by_noise(pilot: &Tally) -> Self {
        let (width, height) = pilot.size();
        let tiles_in_a_row = width.div_ceil(TILE);
        let tiles = tiles_in_a_row * height.div_ceil(TILE);
        let (mut spread, mut pixels) = (vec![0.0; tiles], vec![0.0; tiles]);
        for (index, moments) in pilot.moments().pixels().iter().enumerate() {
            let tile = tile(index, width, tiles_in_a_row);
            spread[tile] += moments.spread().element_sum();
            pixels[tile] += 1.0;
        }
        let sigmas = spread.iter().zip(&pixels).map(|(s, n)| f64::sqrt(s / n));
        let sigmas: Vec<f64> = sigmas.collect();
        let total: f64 = sigmas.iter().zip(&pixels).map(|(s, n)| s * n).sum();
        let mean = total / (width * height) as f64;
        let share = |sigma: f64| if mean > 0.0 { EVEN + (1.0 - EVEN) * sigma / mean } else { 1.0 };
        Self { width, tiles_in_a_row, shares: sigmas.into_iter().map(share).collect() }
    }

    /// The numbers of the paths that pixel `index` gets while the mean number over the picture goes
    /// from `mean.start` to `mean.end`. Ranges that follow each other give ranges that do; each
    /// pixel has its first two paths before any of them is left out.
    pub fn samples(&self, index: usize, mean: Range<u32>) -> Range<u32> {
        let share = self.shares[tile(index, self.width, self.tiles_in_a_row)];
        let count = |mean: u32| ((f64::from(mean) * share) as u32).max(mean.min(2));
        count(mean.start)..count(mean.end)
    }
}

/// Which paths every pixel gets.
#[derive(Clone, Debug)]
pub enum Samples<'a> {
    /// Those of these numbers, in all pixels alike.
    Even(Range<u32>),
    /// More where the noise is: what [`Shares::samples`] says of this range.
    ByNoise(&'a Shares, Range<u32>),
}

impl Samples<'_> {
    /// The numbers of the paths that pixel `index` gets.
    pub fn of(&self, index: usize) -> Range<u32> {
        match self {
            Self::Even(samples) => samples.clone(),
            Self::ByNoise(shares, mean) => shares.samples(index, mean.clone()),
        }
    }
}

/// The tile of the pixel `index`.
fn tile(index: usize, width: usize, tiles_in_a_row: usize) -> usize {
    (index / width / TILE) * tiles_in_a_row + index % width / TILE
}

impl Tracer {
    /// Renders the pilot of a picture of `size` and says how many paths each pixel should get.
    /// Depends on the seed and not on `settings.spp`.
    pub fn shares<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        (width, height): (usize, usize),
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Shares {
        let settings = Settings { seed: pilot_seed(settings.seed), ..*settings };
        let mut pilot = Tally::new(width, height);
        self.accumulate(
            appearance,
            camera,
            &settings,
            &Samples::Even(0..PILOT),
            &mut pilot,
            progress,
        );
        Shares::by_noise(&pilot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::mix;
    use glam::DVec3;
    use unrender_scene::Rgb;

    const SIDE: usize = 16;

    /// Path number `index` of a pixel: one in fifty brings 50, the others nothing; the mean is one.
    fn path(stream: u64, pixel: usize, index: u32) -> Rgb {
        let random = mix(mix(stream) ^ ((pixel as u64) << 32 | u64::from(index)));
        Rgb::splat(if random.is_multiple_of(50) { 50.0 } else { 0.0 })
    }

    fn picture(stream: u64, samples: impl Fn(usize) -> Range<u32>) -> Tally {
        let mut tally = Tally::new(SIDE, SIDE);
        for (pixel, moments) in tally.moments.pixels_mut().iter_mut().enumerate() {
            samples(pixel).for_each(|index| moments.push(path(stream, pixel, index)));
        }
        tally
    }

    /// Mean and deviation of the mean over many pictures whose pilots have the paths that
    /// `pilot_of` says.
    fn mean_of_many(pilot_of: impl Fn(u64) -> u64) -> (f64, f64) {
        let means: Vec<f64> = (0..10_000)
            .map(|seed| {
                let shares = Shares::by_noise(&picture(pilot_of(seed), |_| 0..PILOT));
                let picture = picture(2 * seed, |pixel| shares.samples(pixel, 0..24)).mean();
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
    fn a_pilot_of_its_own_biases_nothing_where_one_among_the_paths_would() {
        let (mean, deviation) = mean_of_many(|seed| 2 * seed + 1);
        assert!((mean - 1.0).abs() < 4.5 * deviation, "{mean} +- {deviation}");
        assert!(deviation < 1.5e-3);
        let (mean, deviation) = mean_of_many(|seed| 2 * seed);
        assert!(mean < 1.0 - 6.0 * deviation, "paths that decide on themselves: {mean}");
    }
}
