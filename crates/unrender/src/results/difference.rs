//! Re-rendering minus photograph in luminance, as a share of the photograph's mean, smoothed by a Gaussian so that
//! noise does not hide what they differ in.
//!
//! ```text
//! share = sum w (r - p) / (mean sum w)     deviation = sqrt(sum w^2 sigma^2) / (mean sum w)
//! ```
//!
//! over pixels that are compared, with the noise sigma of both pictures together. Neighbours that share paths share
//! noise: the rendering's part of the variance is measured on a sample of its noise, half the difference of its two
//! halves, smoothed in the same way, whose squares are averaged over a wider kernel. Pixels beside edges are not compared,
//! as an error of a tenth of a pixel in the camera shows there; nor are those where the photograph is clipped, broken or
//! left out. What is not in the model is compared: it is a difference.

use crate::Job;
use crate::run::MissEntry;
use unrender_recover::{PixelStatus, Recovery};
use unrender_scene::color::luminance;
use unrender_scene::{Image, Rgb};

/// The standard deviation of the kernel, as a share of the picture's diagonal: five pixels on a page where the picture
/// is 960 pixels wide. At half of it a draft's noise speckles the picture; at double of it shadows and highlights of
/// small things blur away.
const KERNEL: f32 = 0.004;
/// The kernel over which the rendering's noise is measured, in kernels: about 30 independent values, which tell it to a
/// seventh. At half of it whiteness is patchy by chance; at double of it dark places get the noise of bright ones beside
/// them.
const NOISE_KERNEL: f32 = 6.0;
/// Where there is less light than this share of the photograph's mean, noise is taken as if there were as much. At half
/// of it black surfaces look certain by chance; at double of it dark ones get too much noise.
const DARK: f32 = 0.05;
/// The kernel ends here, in its standard deviations, where its weight is 1 %. At half of it, it is a box; double of it
/// costs twice the time and changes less than a code value.
const KERNEL_END: f32 = 3.0;
/// A difference is significant from here, in standard deviations: chance exceeds it in 5 % of all pixels. Half of it
/// colours a third of a perfect result; double of it hides errors of a noisy draft.
const SIGNIFICANT: f32 = 2.0;

/// A difference is certain from here, in standard deviations: its colour is that of its value, and from
/// [`SIGNIFICANT`] to here it fades in. At half of it chance speckles the picture; at double of it errors of a noisy draft
/// are pale.
const CERTAIN: f32 = 4.0;

/// A smoothed difference of a pixel, as shares of the photograph's mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Differs {
    /// Re-rendering minus photograph.
    pub(super) share: f32,
    /// Its standard deviation by noise.
    pub(super) deviation: f32,
}

impl Differs {
    /// In standard deviations, without sign.
    pub(super) fn sigmas(self) -> f32 {
        self.share.abs() / self.deviation.max(f32::MIN_POSITIVE)
    }

    /// How much of its colour the difference has: none where noise explains it, all where it is certain.
    pub(super) fn certainty(self) -> f32 {
        ((self.sigmas() - SIGNIFICANT) / (CERTAIN - SIGNIFICANT)).clamp(0.0, 1.0)
    }

    /// The difference; zero where noise explains it.
    pub(super) fn significant(self) -> f32 {
        if self.sigmas() > SIGNIFICANT { self.share } else { 0.0 }
    }
}

/// The difference of a photograph and its re-rendering.
pub(super) struct Difference {
    /// By pixel; none where they are not compared.
    pub(super) pixels: Image<Option<Differs>>,
    /// The kernel's standard deviation, pixels.
    pub(super) kernel: f32,
}

impl Difference {
    /// Of the photograph of `job` and its re-rendering.
    pub(super) fn of(job: &Job, recovery: &Recovery) -> Self {
        let fixed = matches!(job.project.exposure, unrender_photo::Exposure::Fixed(_));
        let scale = if fixed { Rgb::ONE } else { recovery.exposure };
        let photo = job.photo.radiance.map(|value| luminance(*value * scale));
        let count = photo.pixels().len().max(1) as f32;
        let mean = (photo.pixels().iter().sum::<f32>() / count).max(f32::MIN_POSITIVE);
        let (width, height) = (photo.width(), photo.height());
        let samples = Image::from_fn(width, height, |x, y| {
            let status = *recovery.status.at(x, y);
            let left_out =
                matches!(status, PixelStatus::Clipped | PixelStatus::Edge | PixelStatus::Nothing);
            if left_out || !*job.photo.valid.at(x, y) {
                return Sums::default();
            }
            let off = luminance(*recovery.rerendered.at(x, y)) - photo.at(x, y);
            let noise = *recovery.noise_sample.at(x, y);
            let of_photo = (recovery.noise.at(x, y).powi(2) - noise * noise) / (mean * mean);
            let shown = luminance(*recovery.rerendered.at(x, y)) / mean;
            Sums { weight: 1.0, off: off / mean, noise: noise / mean, shown, variance: of_photo }
        });
        Self::smoothed(&samples)
    }

    fn smoothed(samples: &Image<Sums>) -> Self {
        let kernel = KERNEL * (samples.width() as f32).hypot(samples.height() as f32);
        let means = over(samples, kernel).map(Sums::mean);
        // Noise is about proportional to the light, of which there is ten times as much beside a window.
        let light = |mean: &Sums| mean.shown.max(0.0) + DARK;
        let squares = Image::from_fn(samples.width(), samples.height(), |x, y| {
            let (weight, mean) = (samples.at(x, y).weight, means.at(x, y));
            Sums { weight, off: weight * (mean.noise / light(mean)).powi(2), ..Sums::default() }
        });
        let of_rendering = over(&squares, NOISE_KERNEL * kernel).map(Sums::mean);
        let pixels = Image::from_fn(samples.width(), samples.height(), |x, y| {
            let mean = means.at(x, y);
            let of_rendering = of_rendering.at(x, y).off * light(mean).powi(2);
            let deviation = (mean.variance.max(0.0) + of_rendering).sqrt();
            (samples.at(x, y).weight > 0.0).then_some(Differs { share: mean.off, deviation })
        });
        Self { pixels, kernel }
    }

    /// The root mean square of the difference beyond noise, that of the noise, and the share of compared pixels.
    pub(super) fn means(&self) -> [f64; 3] {
        let compared = self.pixels.pixels().iter().flatten();
        let (mut square, mut variance, mut count) = (0.0, 0.0, 0.0);
        for differs in compared {
            square += f64::from(differs.share.powi(2));
            variance += f64::from(differs.deviation.powi(2));
            count += 1.0;
        }
        let all = self.pixels.pixels().len().max(1) as f64;
        let least = f64::max(count, 1.0);
        let beyond = ((square - variance) / least).max(0.0).sqrt();
        [beyond, (variance / least).sqrt(), count / all]
    }

    /// What the group with this index misses in the photograph of this number; none if it is not compared.
    pub(super) fn miss(
        &self,
        groups: &Image<u32>,
        group: usize,
        photograph: usize,
    ) -> Option<Missed> {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        let mut missed = Missed { photograph, ..Missed::default() };
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let Some(differs) = self.pixels.at(x, y).filter(|_| *groups.at(x, y) as usize == group)
            else {
                continue;
            };
            missed.compared += 1;
            let share = differs.significant();
            missed.too_bright += usize::from(share > 0.0);
            missed.too_dark += usize::from(share < 0.0);
            if share.abs() > missed.largest.abs() {
                missed.largest = share;
                let [x, y] = [(x, width), (y, height)].map(|(at, n)| (at as f64 + 0.5) / n as f64);
                missed.place = [x, y];
            }
        }
        (missed.compared > 0).then_some(missed)
    }
}

/// What a group misses, in numbers of pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Missed {
    compared: usize,
    too_bright: usize,
    too_dark: usize,
    largest: f32,
    place: [f64; 2],
    photograph: usize,
}

impl Missed {
    /// With another photograph of the same group.
    pub(super) fn and(self, other: Self) -> Self {
        let worse = if other.largest.abs() > self.largest.abs() { other } else { self };
        Self {
            compared: self.compared + other.compared,
            too_bright: self.too_bright + other.too_bright,
            too_dark: self.too_dark + other.too_dark,
            ..worse
        }
    }

    pub(super) fn entry(self) -> MissEntry {
        let share = |count: usize| count as f64 / self.compared.max(1) as f64;
        MissEntry {
            too_bright: share(self.too_bright),
            too_dark: share(self.too_dark),
            largest: f64::from(self.largest),
            place: self.place,
            photograph: self.photograph,
        }
    }
}

/// Weighted sums over pixels, or means of them.
#[derive(Clone, Copy, Default)]
struct Sums {
    weight: f32,
    off: f32,
    /// Of the sample of the rendering's noise.
    noise: f32,
    /// Luminance of the re-rendering.
    shown: f32,
    /// Of noise that is independent from pixel to pixel.
    variance: f32,
}

impl Sums {
    fn mean(&self) -> Self {
        let weight = self.weight.max(f32::MIN_POSITIVE);
        let [off, noise, shown] = [self.off, self.noise, self.shown].map(|sum| sum / weight);
        Self { weight, off, noise, shown, variance: self.variance / (weight * weight) }
    }
}

/// The weighted sums over a Gaussian around each pixel.
fn over(samples: &Image<Sums>, kernel: f32) -> Image<Sums> {
    let (width, height, weights) = (samples.width(), samples.height(), weights(kernel));
    let rows = Image::from_fn(width, height, |x, y| {
        along(&weights, x, width, |column| *samples.at(column, y))
    });
    Image::from_fn(width, height, |x, y| along(&weights, y, height, |row| *rows.at(x, row)))
}

/// The weights of a Gaussian by distance, pixels.
fn weights(kernel: f32) -> Vec<f32> {
    let reach = (KERNEL_END * kernel).ceil() as usize;
    let weight = |distance: usize| (-0.5 * (distance as f32 / kernel.max(0.1)).powi(2)).exp();
    (0..=reach).map(weight).collect()
}

/// The weighted sums around the pixel `at` of a line of `length` pixels.
fn along(weights: &[f32], at: usize, length: usize, of: impl Fn(usize) -> Sums) -> Sums {
    let reach = weights.len() - 1;
    let mut sums = Sums::default();
    for pixel in at.saturating_sub(reach)..(at + reach + 1).min(length) {
        let (weight, sample) = (weights[pixel.abs_diff(at)], of(pixel));
        sums.weight += weight * sample.weight;
        sums.off += weight * sample.off;
        sums.noise += weight * sample.noise;
        sums.shown += weight * sample.shown;
        sums.variance += weight * weight * sample.variance;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_a_constant_and_pixels_left_out_do_not_count() {
        let samples = Image::from_fn(200, 150, |x, _| match x {
            100.. => Sums::default(),
            _ => Sums { weight: 1.0, off: 0.05, variance: 0.01, ..Sums::default() },
        });
        let difference = Difference::smoothed(&samples);
        let inside = difference.pixels.at(50, 70).unwrap();
        assert!((inside.share - 0.05).abs() < 1e-6);
        // A Gaussian of standard deviation s averages over about 4 pi s^2 pixels.
        let averaged = 4.0 * std::f32::consts::PI * difference.kernel.powi(2);
        assert!((0.1 / inside.deviation - averaged.sqrt()).abs() < 0.1 * averaged.sqrt());
        assert!((difference.pixels.at(99, 70).unwrap().share - 0.05).abs() < 1e-6);
        assert_eq!(*difference.pixels.at(100, 70), None);
        let [beyond, noise, compared] = difference.means();
        assert!((beyond.hypot(noise) - 0.05).abs() < 1e-6 && (compared - 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_group_misses_what_is_significant_at_its_pixels() {
        let differs = |x: usize| Differs { share: 0.01 * x as f32, deviation: 0.02 };
        let pixels = Image::from_fn(10, 1, |x, _| Some(differs(x)));
        let difference = Difference { pixels, kernel: 1.0 };
        let groups = Image::from_fn(10, 1, |x, _| u32::from(x >= 8));
        let first = difference.miss(&groups, 0, 1).unwrap().entry();
        assert_eq!((first.too_bright, first.too_dark), (3.0 / 8.0, 0.0));
        assert!((first.largest - 0.07).abs() < 1e-6 && (first.place[0] - 0.75).abs() < 1e-9);
        assert!(difference.miss(&groups, 2, 1).is_none());
    }
}
