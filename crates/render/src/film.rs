//! The film: the accumulated samples of every pixel, and the picture that they make.
//!
//! Each pixel accumulates the sum of its samples' radiances and of their squares, by channel:
//!
//! ```text
//! mean = sum / n,      variance of the mean = (sum of squares / n - mean^2) / (n - 1)
//! ```
//!
//! Floating-point sums depend on the order of addition. A picture that is rendered in shards, on
//! several machines or with an interruption, would then differ from the whole one in its last bits.
//! The sums here are integers, multiples of [`QUANTISATION_STEP`]: integer addition is associative, so the
//! accumulator of the samples A..B plus that of B..C equals that of A..C to the bit.
//!
//! Each sample is truncated to a multiple of the step: 1e-10 keeps all digits of single
//! precision, smaller values lose digits, and the error of a sum is at most one step per sample.
//! Sums saturate at [`PixelAccumulator::MAX`].

use glam::{DVec3, Vec3};
use unrender_scene::{Image, Rgb, RgbImage};

/// The unit of all sums: 2^-64, in W sr^-1 m^-2 for radiances and in its square for squares. It
/// divides the 128 bits of a sum evenly: the largest sum is 2^64. With 2^-32 dark pixels would lose
/// digits, with 2^-96 sums would saturate at 2^32.
pub const QUANTISATION_STEP: f64 = 1.0 / (1u128 << 64) as f64;

/// A picture with the variance of its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub mean: RgbImage,
    /// Variance of `mean`, estimated from the sample variance. The samples of a pixel are
    /// stratified, so the true variance is at most this. Zero with a single sample.
    pub variance: RgbImage,
}

/// The accumulated samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelAccumulator {
    /// The sum of the radiances, by channel, in units of [`QUANTISATION_STEP`].
    pub sum: [u128; 3],
    /// The sum of their squares, likewise.
    pub squares: [u128; 3],
    /// The number of samples.
    pub count: u32,
    /// The number of samples that were not finite. They count as black.
    pub faulty: u32,
}

impl PixelAccumulator {
    /// The greatest sum, in units of [`QUANTISATION_STEP`]; as a number 2^64 = 1.8e19.
    pub const MAX: u128 = u128::MAX;

    /// Adds one sample.
    #[inline]
    pub fn push(&mut self, radiance: Rgb) {
        self.count = self.count.saturating_add(1);
        if !radiance.is_finite() {
            self.faulty = self.faulty.saturating_add(1);
            return;
        }
        for (channel, value) in radiance.to_array().into_iter().enumerate() {
            let value = f64::from(value);
            self.sum[channel] = self.sum[channel].saturating_add(steps(value));
            self.squares[channel] = self.squares[channel].saturating_add(steps(value * value));
        }
    }

    /// Adds the samples of `other`, a disjoint set.
    pub fn add(&mut self, other: &Self) {
        for channel in 0..3 {
            self.sum[channel] = self.sum[channel].saturating_add(other.sum[channel]);
            self.squares[channel] = self.squares[channel].saturating_add(other.squares[channel]);
        }
        self.count = self.count.saturating_add(other.count);
        self.faulty = self.faulty.saturating_add(other.faulty);
    }

    /// The samples without those of `part`, a subset of them.
    #[must_use]
    pub fn without(&self, part: &Self) -> Self {
        let less = |all: [u128; 3], part: [u128; 3]| {
            std::array::from_fn(|channel| all[channel].saturating_sub(part[channel]))
        };
        Self {
            sum: less(self.sum, part.sum),
            squares: less(self.squares, part.squares),
            count: self.count.saturating_sub(part.count),
            faulty: self.faulty.saturating_sub(part.faulty),
        }
    }

    /// The mean radiance, W sr^-1 m^-2 per channel; zero without samples.
    pub fn mean(&self) -> Rgb {
        self.mean_f64().as_vec3()
    }

    /// The variance of the mean; zero for fewer than two samples.
    pub fn variance(&self) -> Rgb {
        (self.sample_variance() / f64::from(self.count).max(1.0)).as_vec3()
    }

    /// The sample variance, by channel; zero for fewer than two samples.
    pub(crate) fn sample_variance(&self) -> DVec3 {
        let n = f64::from(self.count);
        let mean = self.mean_f64();
        let squares = DVec3::from_array(self.squares.map(value)) / n.max(1.0);
        (squares - mean * mean).max(DVec3::ZERO) * (n / (n - 1.0).max(1.0))
    }

    fn mean_f64(&self) -> DVec3 {
        DVec3::from_array(self.sum.map(value)) / f64::from(self.count).max(1.0)
    }
}

/// A number of at least zero in units of [`QUANTISATION_STEP`], truncated, saturating.
#[inline]
fn steps(value: f64) -> u128 {
    (value * (1.0 / QUANTISATION_STEP)) as u128
}

fn value(steps: u128) -> f64 {
    steps as f64 * QUANTISATION_STEP
}

/// The [`PixelAccumulator`]s of a picture, 112 bytes per pixel.
///
/// Sums are of integers, so shards add up to the same bits in any order:
///
/// ```
/// use unrender_render::{Accumulator, PixelAccumulator};
/// use unrender_scene::{Image, Rgb};
///
/// let shard = |samples: &[f32]| {
///     let mut pixel = PixelAccumulator::default();
///     samples.iter().for_each(|&sample| pixel.push(Rgb::splat(sample)));
///     Accumulator::from_image(Image::new(1, 1, vec![pixel]))
/// };
/// let mut sum = shard(&[0.3]);
/// sum.add(&shard(&[0.1, 0.2]));
/// assert_eq!(sum, shard(&[0.1, 0.2, 0.3]));
/// assert!((sum.mean().at(0, 0).x - 0.2).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Accumulator {
    pub(crate) pixels: Image<PixelAccumulator>,
}

impl Accumulator {
    /// A picture of `width` x `height` pixels without any samples.
    pub fn new(width: usize, height: usize) -> Self {
        Self::from_image(Image::from_fn(width, height, |_, _| PixelAccumulator::default()))
    }

    /// A picture from the accumulators of its pixels.
    pub fn from_image(pixels: Image<PixelAccumulator>) -> Self {
        Self { pixels }
    }

    /// The accumulators of all pixels.
    pub fn image(&self) -> &Image<PixelAccumulator> {
        &self.pixels
    }

    /// The accumulators of all pixels, to add samples to.
    pub fn image_mut(&mut self) -> &mut Image<PixelAccumulator> {
        &mut self.pixels
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.pixels.width(), self.pixels.height())
    }

    /// Adds the samples of `other`, a disjoint set.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub fn add(&mut self, other: &Self) {
        assert_eq!(self.size(), other.size(), "accumulators of one picture have one size");
        let pairs = self.pixels.pixels_mut().iter_mut().zip(other.pixels.pixels());
        pairs.for_each(|(mine, theirs)| mine.add(theirs));
    }

    /// The samples without those of `part`, a subset of them.
    ///
    /// # Panics
    /// If the pictures differ in size.
    #[must_use]
    pub fn without(&self, part: &Self) -> Self {
        assert_eq!(self.size(), part.size(), "accumulators of one picture have one size");
        let pairs = self.pixels.pixels().iter().zip(part.pixels.pixels());
        let pixels = pairs.map(|(all, part)| all.without(part)).collect();
        Self::from_image(Image::new(self.size().0, self.size().1, pixels))
    }

    /// The mean radiance of every pixel, W sr^-1 m^-2 per channel.
    pub fn mean(&self) -> RgbImage {
        self.pixels.map(PixelAccumulator::mean)
    }

    /// The picture with the variance of its noise.
    pub fn film(&self) -> Film {
        Film { mean: self.mean(), variance: self.pixels.map(PixelAccumulator::variance) }
    }

    /// The number of samples that were not finite. They count as black.
    pub fn faulty(&self) -> u64 {
        self.pixels.pixels().iter().map(|m| u64::from(m.faulty)).sum()
    }

    /// The relative standard error of the picture: the root mean square of the pixels' standard
    /// errors ([`Film::variance`]) over their mean radiance, both over all pixels and channels.
    /// Zero for a black picture, infinite if a pixel has fewer than two samples.
    pub fn noise(&self) -> f64 {
        let pixels = self.pixels.pixels();
        if pixels.iter().any(|m| m.count < 2) {
            return f64::INFINITY;
        }
        let sum = |f: fn(&PixelAccumulator) -> Vec3| -> f64 {
            pixels.iter().map(|m| f(m).as_dvec3().element_sum()).sum()
        };
        let (variance, radiance) = (sum(PixelAccumulator::variance), sum(PixelAccumulator::mean));
        let n = 3.0 * pixels.len() as f64;
        if radiance > 0.0 { (variance / n).sqrt() / (radiance / n) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::mix;

    /// Radiances of many magnitudes.
    fn radiances() -> Vec<Rgb> {
        let number = |i: u64| {
            let bits = mix(i);
            (bits as u32 as f32 / 2f32.powi(32)) * 10f32.powi((bits >> 40) as i32 % 12 - 6)
        };
        (0..999).map(|i| Rgb::new(number(3 * i), number(3 * i + 1), number(3 * i + 2))).collect()
    }

    fn accumulated(radiances: &[Rgb]) -> PixelAccumulator {
        let mut pixel = PixelAccumulator::default();
        radiances.iter().for_each(|r| pixel.push(*r));
        pixel
    }

    #[test]
    fn shards_add_up_to_the_whole_in_any_order() {
        let all = radiances();
        let whole = accumulated(&all);
        let (a, b, c) =
            (accumulated(&all[..100]), accumulated(&all[100..700]), accumulated(&all[700..]));
        for shards in [[a, b, c], [c, a, b], [b, c, a]] {
            let mut sum = PixelAccumulator::default();
            shards.iter().for_each(|shard| sum.add(shard));
            assert_eq!(sum, whole);
            let mut last_two = shards[1];
            last_two.add(&shards[2]);
            let mut grouped = shards[0];
            grouped.add(&last_two);
            assert_eq!(grouped, whole);
            assert_eq!(whole.without(&last_two), shards[0]);
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_samples() {
        let all = radiances();
        let n = all.len() as f64;
        let mean = all.iter().map(|r| r.as_dvec3()).sum::<DVec3>() / n;
        let squares: DVec3 = all.iter().map(|r| (r.as_dvec3() - mean).powf(2.0)).sum();
        let found = accumulated(&all);
        let off = |found: Rgb, expected: DVec3| {
            (found.as_dvec3() / expected - DVec3::ONE).abs().max_element()
        };
        assert!(off(found.mean(), mean) < 1e-7);
        assert!(off(found.variance(), squares / (n * (n - 1.0))) < 1e-7);
        assert_eq!(accumulated(&all[..1]).variance(), Rgb::ZERO);
        assert_eq!(PixelAccumulator::default().mean(), Rgb::ZERO);
    }

    #[test]
    fn values_out_of_range_saturate_and_nan_is_black() {
        let odd = [Rgb::splat(f32::MAX), Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY)];
        let found = accumulated(&odd);
        assert_eq!((found.count, found.faulty), (3, 2));
        assert_eq!(
            (found.sum, found.squares),
            ([PixelAccumulator::MAX; 3], [PixelAccumulator::MAX; 3])
        );
        assert!(found.mean().is_finite() && found.variance().is_finite());
        let mut twice = found;
        twice.add(&found);
        assert_eq!((twice.sum, twice.count), ([PixelAccumulator::MAX; 3], 6));
        // Values near the step lose digits, values below it vanish.
        assert_eq!(accumulated(&[Rgb::splat(1e-10)]).mean(), Rgb::splat(1e-10));
        assert_eq!(accumulated(&[Rgb::splat(1e-20)]).mean(), Rgb::ZERO);
    }

    #[test]
    fn noise_is_the_standard_error_over_the_mean() {
        let mut accumulator = Accumulator::new(2, 1);
        assert_eq!(accumulator.noise(), f64::INFINITY);
        for value in [1.0, 3.0] {
            accumulator.pixels.pixels_mut().iter_mut().for_each(|m| m.push(Rgb::splat(value)));
        }
        // Of 1 and 3: the mean 2, the sample variance 2, the variance of the mean 1.
        assert!((accumulator.noise() - 0.5).abs() < 1e-12);
    }
}
