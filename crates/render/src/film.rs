//! Sums that come out the same however they are cut into parts: whole numbers for every pixel.
//!
//! Floating-point sums depend on their order, so a picture that is rendered in parts, on several
//! machines or with a break, would differ from the whole one in its last bits. A [`Tally`] keeps
//! for every pixel the sum of its paths' radiances and of their squares as multiples of one
//! [`QUANTUM`], and how many paths there were. Whole numbers add up alike in any order: tallies of
//! the samples A..B and B..C, added, are to the bit the tally of A..C.
//!
//! Of each number, what is below the quantum is cut off: a value of 1e-10 keeps all digits of
//! single precision, smaller ones fewer, and sums are too small by at most a quantum a path. Sums
//! stay at [`Moments::MAX`] once they have come there.

use crate::film::Film;
use glam::{DVec3, Vec3};
use unrender_scene::{Image, Rgb, RgbImage};

/// The unit of all sums: 2^-64, in W sr^-1 m^-2 for radiances and in its square for squares.
pub const QUANTUM: f64 = 1.0 / (1u128 << 64) as f64;

/// What the paths of one pixel have brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments {
    /// The sum of the radiances, by channel, in units of [`QUANTUM`].
    pub sum: [u128; 3],
    /// The sum of their squares, likewise.
    pub squares: [u128; 3],
    /// The number of paths.
    pub count: u32,
    /// How many of them brought something that is no finite number, and were counted as black.
    pub faulty: u32,
}

impl Moments {
    /// The greatest sum, in units of [`QUANTUM`]; as a number 2^64 = 1.8e19.
    pub const MAX: u128 = u128::MAX;

    /// Counts one more path, which brought `radiance`.
    #[inline]
    pub fn push(&mut self, radiance: Rgb) {
        self.count = self.count.saturating_add(1);
        if !radiance.is_finite() {
            self.faulty = self.faulty.saturating_add(1);
            return;
        }
        for (channel, value) in radiance.to_array().into_iter().enumerate() {
            let value = f64::from(value);
            self.sum[channel] = self.sum[channel].saturating_add(quanta(value));
            self.squares[channel] = self.squares[channel].saturating_add(quanta(value * value));
        }
    }

    /// Counts all paths of `other`, which are not among these.
    pub fn add(&mut self, other: &Self) {
        for channel in 0..3 {
            self.sum[channel] = self.sum[channel].saturating_add(other.sum[channel]);
            self.squares[channel] = self.squares[channel].saturating_add(other.squares[channel]);
        }
        self.count = self.count.saturating_add(other.count);
        self.faulty = self.faulty.saturating_add(other.faulty);
    }

    /// The mean radiance, W sr^-1 m^-2 per channel; zero without paths.
    pub fn mean(&self) -> Rgb {
        self.mean_f64().as_vec3()
    }

    /// The variance of the mean, from the spread of the paths; zero for fewer than two.
    pub fn variance(&self) -> Rgb {
        (self.spread() / f64::from(self.count).max(1.0)).as_vec3()
    }

    /// The variance of one path, by channel; zero for fewer than two.
    pub(crate) fn spread(&self) -> DVec3 {
        let n = f64::from(self.count);
        let mean = self.mean_f64();
        let squares = DVec3::from_array(self.squares.map(value)) / n.max(1.0);
        (squares - mean * mean).max(DVec3::ZERO) * (n / (n - 1.0).max(1.0))
    }

    fn mean_f64(&self) -> DVec3 {
        DVec3::from_array(self.sum.map(value)) / f64::from(self.count).max(1.0)
    }
}

/// A number of at least zero in units of [`QUANTUM`], cut off; the greatest one for what is above.
#[inline]
fn quanta(value: f64) -> u128 {
    (value * (1.0 / QUANTUM)) as u128
}

fn value(quanta: u128) -> f64 {
    quanta as f64 * QUANTUM
}

/// A picture in the making: the [`Moments`] of every pixel, 112 bytes each.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    pub(crate) moments: Image<Moments>,
}

impl Tally {
    /// A picture of `width` x `height` pixels without any paths.
    pub fn new(width: usize, height: usize) -> Self {
        Self::from_moments(Image::from_fn(width, height, |_, _| Moments::default()))
    }

    /// A picture from what its pixels have brought.
    pub fn from_moments(moments: Image<Moments>) -> Self {
        Self { moments }
    }

    /// What every pixel has brought.
    pub fn moments(&self) -> &Image<Moments> {
        &self.moments
    }

    /// What every pixel has brought, to be added to.
    pub fn moments_mut(&mut self) -> &mut Image<Moments> {
        &mut self.moments
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.moments.width(), self.moments.height())
    }

    /// Adds the paths of `other`, which are not among these.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub fn add(&mut self, other: &Self) {
        assert_eq!(self.size(), other.size(), "tallies of one picture have one size");
        let pairs = self.moments.pixels_mut().iter_mut().zip(other.moments.pixels());
        pairs.for_each(|(mine, theirs)| mine.add(theirs));
    }

    /// The mean of the paths in every pixel, W sr^-1 m^-2 per channel.
    pub fn mean(&self) -> RgbImage {
        self.moments.map(Moments::mean)
    }

    /// The picture with the variance of its noise.
    pub fn film(&self) -> Film {
        Film { mean: self.mean(), variance: self.moments.map(Moments::variance) }
    }

    /// The paths that brought no finite number and were counted as black.
    pub fn faulty(&self) -> u64 {
        self.moments.pixels().iter().map(|m| u64::from(m.faulty)).sum()
    }

    /// The relative standard error of the picture: the root of the mean over pixels and channels of
    /// the mean's variance ([`Film::variance`]), over the mean over pixels and channels of the
    /// radiance. Zero for a black picture, infinite if a pixel has fewer than two paths.
    pub fn noise(&self) -> f64 {
        let pixels = self.moments.pixels();
        if pixels.iter().any(|m| m.count < 2) {
            return f64::INFINITY;
        }
        let sum = |f: fn(&Moments) -> Vec3| -> f64 {
            pixels.iter().map(|m| f(m).as_dvec3().element_sum()).sum()
        };
        let (variance, radiance) = (sum(Moments::variance), sum(Moments::mean));
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

    fn moments(radiances: &[Rgb]) -> Moments {
        let mut moments = Moments::default();
        radiances.iter().for_each(|r| moments.push(*r));
        moments
    }

    #[test]
    fn parts_add_up_to_the_whole_in_any_order() {
        let all = radiances();
        let whole = moments(&all);
        let (a, b, c) = (moments(&all[..100]), moments(&all[100..700]), moments(&all[700..]));
        for parts in [[a, b, c], [c, a, b], [b, c, a]] {
            let mut sum = Moments::default();
            parts.iter().for_each(|part| sum.add(part));
            assert_eq!(sum, whole);
            let mut last_two = parts[1];
            last_two.add(&parts[2]);
            let mut grouped = parts[0];
            grouped.add(&last_two);
            assert_eq!(grouped, whole);
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_paths() {
        let all = radiances();
        let n = all.len() as f64;
        let mean = all.iter().map(|r| r.as_dvec3()).sum::<DVec3>() / n;
        let squares: DVec3 = all.iter().map(|r| (r.as_dvec3() - mean).powf(2.0)).sum();
        let found = moments(&all);
        let off = |found: Rgb, expected: DVec3| {
            (found.as_dvec3() / expected - DVec3::ONE).abs().max_element()
        };
        assert!(off(found.mean(), mean) < 1e-7);
        assert!(off(found.variance(), squares / (n * (n - 1.0))) < 1e-7);
        assert_eq!(moments(&all[..1]).variance(), Rgb::ZERO);
        assert_eq!(Moments::default().mean(), Rgb::ZERO);
    }

    #[test]
    fn numbers_out_of_range_saturate_and_no_number_is_black() {
        let odd = [Rgb::splat(f32::MAX), Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY)];
        let found = moments(&odd);
        assert_eq!((found.count, found.faulty), (3, 2));
        assert_eq!((found.sum, found.squares), ([Moments::MAX; 3], [Moments::MAX; 3]));
        assert!(found.mean().is_finite() && found.variance().is_finite());
        let mut twice = found;
        twice.add(&found);
        assert_eq!((twice.sum, twice.count), ([Moments::MAX; 3], 6));
        // Small ones lose digits, smaller ones all of them.
        assert_eq!(moments(&[Rgb::splat(1e-10)]).mean(), Rgb::splat(1e-10));
        assert_eq!(moments(&[Rgb::splat(1e-20)]).mean(), Rgb::ZERO);
    }

    #[test]
    fn noise_is_the_standard_error_over_the_mean() {
        let mut tally = Tally::new(2, 1);
        assert_eq!(tally.noise(), f64::INFINITY);
        for value in [1.0, 3.0] {
            tally.moments.pixels_mut().iter_mut().for_each(|m| m.push(Rgb::splat(value)));
        }
        // Of 1 and 3: the mean 2, the variance of a path 2, of the mean 1.
        assert!((tally.noise() - 0.5).abs() < 1e-12);
    }
}
