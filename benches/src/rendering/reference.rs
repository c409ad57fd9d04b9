//! The pictures to which renderers converge.

use super::contender::Contender;
use crate::Failure;
use std::collections::HashMap;
use unrender::scene::{Image, RgbImage};

/// Pictures by the names of [`Contender::truth`].
#[derive(Default)]
pub(crate) struct References(HashMap<String, Reference>);

/// The mean of two pictures with independent noise, and the mean square of its remaining noise.
struct Reference {
    mean: RgbImage,
    noise: f64,
}

impl References {
    /// Makes the picture to which `contender` converges, unless another one has made it.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn add(&mut self, contender: &mut dyn Contender) -> Result<(), Failure> {
        let truth = contender.truth();
        if self.0.contains_key(&truth) {
            return Ok(());
        }
        let halves = [contender.converged(1_000_001)?, contender.converged(1_000_002)?];
        let reference = Reference::new(&halves);
        eprintln!("{truth}: the reference's own RMSE is {:.6}", reference.noise.sqrt());
        self.0.insert(truth, reference);
        Ok(())
    }

    /// The root mean square of `picture` minus the reference called `truth`.
    pub(crate) fn error(&self, truth: &str, picture: &RgbImage) -> f64 {
        self.0.get(truth).map_or(f64::NAN, |reference| reference.error(picture))
    }
}

impl Reference {
    fn new(halves: &[RgbImage; 2]) -> Self {
        let [a, b] = halves;
        let pixels = a.pixels().iter().zip(b.pixels()).map(|(a, b)| 0.5 * (*a + *b)).collect();
        let mean = Image::new(a.width(), a.height(), pixels);
        Self { mean, noise: 0.25 * mean_square(a, b) }
    }

    fn error(&self, picture: &RgbImage) -> f64 {
        (mean_square(picture, &self.mean) - self.noise).max(0.0).sqrt()
    }
}

/// The mean square of the difference, over all pixels and channels.
fn mean_square(a: &RgbImage, b: &RgbImage) -> f64 {
    let pairs = a.pixels().iter().zip(b.pixels());
    let sum: f64 = pairs.map(|(a, b)| (a.as_dvec3() - b.as_dvec3()).length_squared()).sum();
    sum / (3 * a.pixels().len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::scene::Rgb;

    #[test]
    fn the_noise_of_the_reference_is_taken_out() {
        let noise = |seed: usize| {
            Image::from_fn(200, 200, |x, y| {
                let mut hash = (x * 200 + y + 40_000 * seed) as u64;
                for _ in 0..3 {
                    hash = (hash ^ (hash >> 29)).wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
                }
                Rgb::splat((hash >> 40) as f32 / (1 << 24) as f32)
            })
        };
        let reference = Reference::new(&[noise(0), noise(1)]);
        let error = reference.error(&noise(2));
        // The standard deviation of a uniform number.
        assert!((error - (1.0f64 / 12.0).sqrt()).abs() < 0.01, "{error}");
    }
}
