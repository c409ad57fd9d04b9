//! The signal that is denoised: the two halves of a picture without their known parts.
//!
//! With the mean radiance `L` of a pixel, its visible emission `E` and its reflectance `r`, the signal is
//! `u = (L - E) / r`: the incident light, roughly. It has no textures and no lamps. `E` and `r` are those of the half's
//! own samples, so that `u` does not depend on which share of a pixel with an edge they happened to see; the filtered
//! signal is multiplied by the `r` of the whole picture, and its `E` added.

use super::Halves;
use crate::features::PixelFeatures;
use crate::film::Accumulator;
use glam::Vec3;
use unrender_scene::Rgb;

/// The least reflectance that is divided by. With half of it or double of it nothing changes but in pixels that
/// are nearly black, whose light is not changed by it: it is multiplied again.
const REFLECTANCE_MIN: f32 = 0.01;
/// The ratio of variances is estimated from squares of this many pixels on either side of a pixel. With half of it
/// it is noisy, with double of it a shadow has the ratio of the light beside it.
const CALIBRATION_RADIUS: usize = 10;
/// Signals that differ by less than this share of the mean signal are alike, if there is no noise: below what an
/// 8-bit picture shows. With double of it or half of it only pictures nearly without noise change.
const INVISIBLE: f64 = 1e-3;

/// Outliers are looked for among the pixels of squares of this many pixels on either side, 121 of them. With half of it
/// too few show what is usual, with double of it a dark corner has the limit of the light beside it.
const OUTLIER_RADIUS: usize = 5;
/// Outliers are this many standard deviations of such a square above its mean: none of normal noise, and one pixel
/// in 64 at the very most of any distribution, by Chebyshev. Half of it darkens caustics, double of it keeps spots.
const OUTLIER_SIGMAS: f64 = 8.0;
/// What the other half has in the same place, times this, is no outlier. With half of it bright dots lose light by
/// noise, with double of it more of the outliers remain that are near each other.
const SEEN_TWICE: f32 = 2.0;

/// A picture as one plane a channel.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    width: usize,
    pub(super) channels: [Vec<f32>; 3],
}

impl Planes {
    pub(super) fn new(width: usize, pixels: impl Iterator<Item = Rgb> + Clone) -> Self {
        let channels = [0, 1, 2].map(|channel| pixels.clone().map(|rgb| rgb[channel]).collect());
        Self { width, channels }
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.width, self.channels[0].len() / self.width.max(1))
    }

    pub(super) fn at(&self, pixel: usize) -> Rgb {
        Vec3::from_array([0, 1, 2].map(|channel: usize| self.channels[channel][pixel]))
    }
}

/// The features of one pixel that the signal may depend on, dimensionless.
pub(super) type Guide = [f32; 5];

/// Both halves of a picture, ready to be filtered.
#[derive(Debug)]
pub(super) struct Signal {
    pub(super) halves: [Planes; 2],
    /// The variances of `halves`.
    pub(super) variances: [Planes; 2],
    /// Squared differences of signals that do not matter.
    pub(super) epsilon: f32,
    pub(super) guides: Vec<Guide>,
    /// What the filtered signal is multiplied by: the reflectance of the whole picture.
    pub(super) reflectance: Vec<Rgb>,
    /// The share of each half in the samples of a pixel.
    pub(super) shares: Vec<[f32; 2]>,
}

impl Signal {
    pub(super) fn new(halves: &Halves<'_>) -> Self {
        let (width, _) = halves.samples[0].size();
        let pixels = width * halves.samples[0].size().1;
        let counts = |half: usize, pixel: usize| halves.samples[half].image().pixels()[pixel].count;
        let shares: Vec<[f32; 2]> = (0..pixels)
            .map(|pixel| {
                let [a, b] = [counts(0, pixel), counts(1, pixel)].map(|n| n as f32);
                if a + b > 0.0 { [a / (a + b), b / (a + b)] } else { [0.5; 2] }
            })
            .collect();
        let divisor =
            |features: &PixelFeatures| features.reflectance.max(Rgb::splat(REFLECTANCE_MIN));
        let guide = |features: &PixelFeatures| {
            let [x, y, z] = features.normal.to_array();
            [x, y, z, features.nearness, features.reflectance.element_sum() / 3.0]
        };
        let reflectance: Vec<Rgb> = halves.finer.pixels().iter().map(divisor).collect();
        let guides = halves.finer.pixels().iter().map(guide).collect();
        let signals = [0, 1].map(|half| {
            let at = |pixel: usize| {
                // A half without samples is taken as the other one.
                let half = if counts(half, pixel) > 0 { half } else { 1 - half };
                let features = &halves.features[half].pixels()[pixel];
                let radiance = halves.samples[half].image().pixels()[pixel].mean();
                (radiance - features.emission) / divisor(features)
            };
            Planes::new(width, (0..pixels).map(at))
        });
        let signals = [0, 1].map(|half| limited(&signals[half], &signals[1 - half]));
        let is_mixed: Vec<bool> = halves.finer.pixels().iter().map(|f| f.is_mixed).collect();
        let variances = variances(halves.samples, &signals, &reflectance, &is_mixed);
        let mean =
            (0..pixels).map(|i| f64::from(signals[0].at(i).element_sum().abs())).sum::<f64>()
                / (3 * pixels) as f64;
        let epsilon = (INVISIBLE * mean).powi(2).max(1e-20) as f32;
        Self { halves: signals, variances, epsilon, guides, reflectance, shares }
    }

    pub(super) fn size(&self) -> (usize, usize) {
        self.halves[0].size()
    }
}

/// `half` without outliers, the rare samples that are far brighter than all others: each channel of a pixel is at most
/// what is usual there in the `other` half, or twice its value in the same place. This removes light, but less of a
/// window full of bright pixels.
fn limited(half: &Planes, other: &Planes) -> Planes {
    let (width, height) = half.size();
    let channels = [0, 1, 2].map(|channel: usize| {
        let other = &other.channels[channel];
        let values: Vec<f64> = other.iter().map(|v| f64::from(*v)).collect();
        let squares: Vec<f64> = values.iter().map(|v| v * v).collect();
        let mean = boxed(&values, width, OUTLIER_RADIUS);
        let squares = boxed(&squares, width, OUTLIER_RADIUS);
        let limit = |pixel: usize| {
            let deviation = (squares[pixel] - mean[pixel] * mean[pixel]).max(0.0).sqrt();
            let (x, y) = (pixel % width, pixel / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let near = rows.flat_map(|y| other[y * width..][columns.clone()].iter().copied());
            let brightest = near.fold(0.0, f32::max);
            (mean[pixel] + OUTLIER_SIGMAS * deviation).max(f64::from(SEEN_TWICE * brightest)) as f32
        };
        half.channels[channel].iter().enumerate().map(|(i, v)| v.min(limit(i))).collect()
    });
    Planes { width, channels }
}

/// The variances of the signals: sample variances, scaled to the squared differences of the halves in the region
/// [Rousselle et al. 2012]. The sample variance is too large, as samples are stratified: most so in pixels with the edge of a
/// lamp, which are scaled by themselves, since their variance is many times that of the wall beside them.
fn variances(
    samples: [&Accumulator; 2],
    signals: &[Planes; 2],
    reflectance: &[Rgb],
    is_mixed: &[bool],
) -> [Planes; 2] {
    let (width, height) = samples[0].size();
    let sample = |half: usize, pixel: usize| {
        let variance = samples[half].image().pixels()[pixel].variance();
        variance / (reflectance[pixel] * reflectance[pixel])
    };
    let expected: Vec<f64> = (0..width * height)
        .map(|i| f64::from((sample(0, i) + sample(1, i)).element_sum()))
        .collect();
    let found: Vec<f64> = (0..width * height)
        .map(|i| f64::from((signals[0].at(i) - signals[1].at(i)).length_squared()))
        .collect();
    let expected = boxed_within(&expected, is_mixed, width, CALIBRATION_RADIUS);
    let found = boxed_within(&found, is_mixed, width, CALIBRATION_RADIUS);
    let ratio = |i: usize| {
        if expected[i] > 0.0 { (found[i] / expected[i]).clamp(0.0, 2.0) as f32 } else { 1.0 }
    };
    [0, 1].map(|half| Planes::new(width, (0..width * height).map(|i| sample(half, i) * ratio(i))))
}

/// As [`boxed`], over those pixels of the square for which `class` is the same as for the pixel itself.
fn boxed_within(values: &[f64], class: &[bool], width: usize, radius: usize) -> Vec<f64> {
    let means = [false, true].map(|class_of_mean| {
        let is = |own: &bool| f64::from(u8::from(*own == class_of_mean));
        let members: Vec<f64> = class.iter().map(is).collect();
        let own: Vec<f64> = values.iter().zip(&members).map(|(value, is)| value * is).collect();
        [boxed(&own, width, radius), boxed(&members, width, radius)]
    });
    let mean = |(pixel, class): (usize, &bool)| {
        let [sum, members] = &means[usize::from(*class)];
        sum[pixel] / members[pixel]
    };
    class.iter().enumerate().map(mean).collect()
}

/// The mean of `values` over the square of `radius` pixels on either side of each pixel, within the picture.
pub(super) fn boxed(values: &[f64], width: usize, radius: usize) -> Vec<f64> {
    let height = values.len() / width.max(1);
    let mut across = vec![0.0; values.len()];
    for (row, out) in values.chunks(width.max(1)).zip(across.chunks_mut(width.max(1))) {
        for x in 0..width {
            let window = x.saturating_sub(radius)..(x + radius + 1).min(width);
            out[x] = row[window.clone()].iter().sum::<f64>() / window.len() as f64;
        }
    }
    let mut down = vec![0.0; values.len()];
    for y in 0..height {
        let window = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let out = &mut down[y * width..(y + 1) * width];
        for row in window.clone() {
            let row = &across[row * width..(row + 1) * width];
            out.iter_mut().zip(row).for_each(|(out, value)| *out += value / window.len() as f64);
        }
    }
    down
}
