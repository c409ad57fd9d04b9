//! Camera samples: the ray and the random numbers of each sample of a pixel.

use crate::accel::Ray;
use crate::sampler::Sampler;
use unrender_scene::Camera;

/// Separates the random numbers of pictures from those of probes under the same seed.
const STREAM: u64 = 0x0F11_0000_0000_0000;

/// The side of a block of pixels, a power of two.
const SIDE: u32 = 8;

/// The samples of the pixels of a picture, stratified together with those of the other pixels of their block of 8 x 8:
/// means over blocks are less noisy than those of independent pixels.
///
/// The pixels of a block share one sequence, in which the first samples of all of them come one pixel after the other
/// along a Z-curve [Ahmed and Wonka 2020], and then the next ones.
#[derive(Clone, Copy, Debug)]
pub struct PixelSamples {
    /// The seed of the random numbers.
    pub seed: u64,
    /// The number of columns of the picture.
    pub width: usize,
    /// So many samples of a pixel follow each other in the sequence; a power of two.
    pub together: u32,
}

impl PixelSamples {
    /// The random numbers of the sample number `index` of a pixel.
    pub fn sampler(&self, pixel: u32, index: u32) -> Sampler {
        let width = self.width as u32;
        let (x, y) = (pixel % width, pixel / width);
        let block = u64::from(y / SIDE) << 32 | u64::from(x / SIDE);
        let rank = along_z_curve(x % SIDE, y % SIDE);
        let (round, within) = (index / self.together, index % self.together);
        let index = (round * SIDE * SIDE + rank) * self.together + within;
        Sampler::new(self.seed ^ STREAM, block, index)
    }
}

/// The place of `(x, y)` on a Z-curve through its block.
fn along_z_curve(x: u32, y: u32) -> u32 {
    let apart = |v: u32| (v & 1) | (v & 2) << 1 | (v & 4) << 2;
    apart(x) | apart(y) << 1
}

/// A ray through a random point of a pixel, from the near clipping plane on: the reconstruction filter is a box over the pixel.
pub fn camera_ray(
    camera: &Camera,
    (width, height): (usize, usize),
    pixel: u32,
    sampler: &mut Sampler,
) -> Ray {
    let [dx, dy, ..] = sampler.next4();
    let x = (pixel as usize % width) as f32 + dx;
    let y = (pixel as usize / width) as f32 + dy;
    let direction = camera.direction(x, y, width, height);
    Ray::new(camera.start(direction), direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over a block of 8 x 8 pixels of a function with an edge, of the samples in `range`.
    fn block_mean(samples: &PixelSamples, range: std::ops::Range<u32>) -> f64 {
        let mut sum = 0.0;
        for pixel in (0..8).flat_map(|row| (0..8).map(move |column| row * 24 + column)) {
            for index in range.clone() {
                let mut sampler = samples.sampler(pixel, index);
                sampler.next4();
                let [a, b, c, d] = sampler.next4();
                let inside = (a - 0.3).powi(2) + (b - 0.6).powi(2) < 0.05;
                sum += if inside { f64::from(4.0 * c * d) } else { 0.0 };
            }
        }
        sum / (64.0 * f64::from(range.end - range.start))
    }

    /// Mean and variance over seeds of the mean of samples that come `part` by `part`, each part with its own seed or,
    /// if `goes_on`, all with one.
    fn over_seeds(parts: &[std::ops::Range<u32>], goes_on: bool) -> (f64, f64) {
        let values: Vec<f64> = (0..400u64)
            .map(|number| {
                let of_part = |(part, range): (usize, &std::ops::Range<u32>)| {
                    let part = if goes_on { 0 } else { part as u64 };
                    let seed = crate::sampler::mix(number * 8 + part);
                    let samples = PixelSamples { seed, width: 24, together: 16 };
                    block_mean(&samples, range.clone()) * f64::from(range.end - range.start)
                };
                let count: u32 = parts.iter().map(|range| range.end - range.start).sum();
                parts.iter().enumerate().map(of_part).sum::<f64>() / f64::from(count)
            })
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        (mean, squares / (values.len() - 1) as f64)
    }

    #[test]
    fn blocks_are_stratified_over_pixels_and_what_goes_on() {
        // Of a circle of area 0.05 pi, and the mean of 4 c d, which is one.
        let area = 0.05 * std::f64::consts::PI;
        let (mean, one) = over_seeds(std::slice::from_ref(&(0..16)), true);
        assert!((mean - area).abs() < 4.0 * (one / 400.0).sqrt(), "{mean}, not {area}");
        // Independent samples: E f^2 is 16/9 of the area.
        let independent = (16.0 / 9.0 * area - area * area) / (64.0 * 16.0);
        assert!(one < 0.1 * independent, "{one} beside {independent}");
        let parts = [0..16, 16..48, 48..96];
        let (mean, on) = over_seeds(&parts, true);
        assert!((mean - area).abs() < 4.0 * (on / 400.0).sqrt(), "{mean}, not {area}");
        let (_, anew) = over_seeds(&[0..16, 0..32, 0..48], false);
        assert!(on < 0.8 * anew, "{on} beside {anew}");
    }
}
