//! The average of the frames with inverse variances.
//!
//! A frame counts in a channel of a pixel where it is neither clipped nor beside a clipped pixel, shows what
//! the others show ([`super::ghosts`]), and is not so dark that its noise is cut off at black. The weights are
//! inverse variances `(g^2 a + g b L t + v) / t^2`, `v` that of rounding and compression, at the radiance `L`
//! of the average; at the frame's own noisy value, dark noise would weigh more than bright noise.

use super::frame::Exposed;
use super::ghosts::Ghosts;
use super::noise::NoiseModel;
use super::scale::Scale;
use unrender_scene::{Depth, Image, Merged, Picture, Rgb};

/// A shorter frame counts if the scene is this many standard deviations of the frame's dark noise above black.
/// At half of it dark pixels become too bright where noise is cut off at black; at double little is lost.
const DARK: f64 = 2.0;
/// If there is a shorter frame, a frame counts only up to this many standard deviations below clipping: above,
/// the brighter half of its noise is cut off. At half of it bright pixels become too dark.
const FULL: f64 = 2.0;
/// Averages, each with weights from the one before; the second changes the third digit of the
/// variance.
const ROUNDS: usize = 2;

/// The merged picture, and how much of it is clipped.
pub(super) struct Combined {
    pub(super) picture: Picture,
    pub(super) clipped: f64,
}

/// The merged value of a channel of a pixel.
enum Value {
    Known { radiance: f64, variance: f64 },
    Clipped,
    Unknown,
}

/// Averages `frames`, whose `order` is by exposure.
pub(super) fn combine(
    frames: &[Exposed<'_>],
    order: &[usize],
    ghosts: &Ghosts,
    scale: &Scale<'_>,
    noise: &NoiseModel,
) -> Combined {
    let (width, height) = (frames[0].picture.values.width(), frames[0].picture.values.height());
    let merge = Merge { frames, order, ghosts, scale, noise };
    let white_level = merge.white_level();
    let (mut values, mut variances) = (Vec::new(), Vec::new());
    let (mut invalid, mut clipped) = (Vec::new(), 0);
    for pixel in 0..width * height {
        let (mut value, mut variance) = (Rgb::ZERO, Rgb::ZERO);
        let (mut is_valid, mut is_clipped) = (true, false);
        for channel in 0..3 {
            match merge.value(pixel, channel, width) {
                Value::Known { radiance, variance: square } => {
                    // Values that are not clipped stay below the white level.
                    let below = white_level[channel].next_down();
                    value[channel] = (radiance as f32).min(below).clamp(-f32::MAX, f32::MAX);
                    variance[channel] = (square as f32).clamp(0.0, f32::MAX);
                }
                Value::Clipped => {
                    value[channel] = white_level[channel].min(f32::MAX);
                    is_clipped = true;
                }
                Value::Unknown => is_valid = false,
            }
        }
        if !is_valid {
            invalid.push(pixel);
            value = Rgb::ZERO;
        }
        clipped += usize::from(is_valid && is_clipped);
        values.push(value);
        variances.push(variance);
    }
    let count = values.len().max(1) as f64;
    let variance = Image::new(width, height, variances);
    let values = Picture::new(Image::new(width, height, values), Depth::Float);
    let merged = Some(Merged { variance, white_level });
    let picture = Picture { invalid, is_linear: true, merged, ..values };
    Combined { picture, clipped: clipped as f64 / count }
}

struct Merge<'a> {
    frames: &'a [Exposed<'a>],
    order: &'a [usize],
    ghosts: &'a Ghosts,
    scale: &'a Scale<'a>,
    noise: &'a NoiseModel,
}

/// A frame's reading of a channel.
struct Reading<'a> {
    frame: &'a Exposed<'a>,
    radiance: f64,
    /// The variance of the linear value by rounding and compression.
    of_file: f64,
}

impl Merge<'_> {
    /// The radiance at which the shortest frame is clipped, by channel.
    fn white_level(&self) -> Rgb {
        let shortest = &self.frames[self.order[0]];
        let level = |c: usize| {
            let from = shortest.clipped_from[c];
            if from.is_finite() {
                (self.scale.computed(c, from) / shortest.exposure) as f32
            } else {
                f32::INFINITY
            }
        };
        Rgb::new(level(0), level(1), level(2))
    }

    /// The merged value of a channel from all frames.
    fn value(&self, pixel: usize, channel: usize, width: usize) -> Value {
        let (x, y) = (pixel % width, pixel / width);
        let local = usize::from(self.ghosts.local[pixel]);
        let there = || self.order.iter().filter_map(|&f| Some((f, self.frames[f].index(x, y)?)));
        let usable = |&(f, index): &(usize, usize)| self.frames[f].is_usable(index, channel);
        let honest = |&(f, _): &(usize, usize)| f == local || !self.ghosts.is_ghost(f, pixel);
        let readings = |found: Vec<(usize, usize)>| -> Vec<Reading<'_>> {
            found.into_iter().map(|(f, index)| self.reading(f, index, channel)).collect()
        };
        let good = readings(there().filter(usable).filter(honest).collect());
        if !good.is_empty() {
            return self.average(good, channel);
        }
        // Beside pixels that are clipped in every frame, the shortest frame is the least affected. The same
        // holds where the frames contradict each other; the variance is then unknown.
        let has_value = |&(f, index): &(usize, usize)| self.frames[f].has_value(index, channel);
        if let Some((f, index)) = there().find(has_value) {
            let reading = self.reading(f, index, channel);
            let is_doubtful = !honest(&(f, index));
            let variance = self.variance(&reading, reading.radiance, channel);
            let doubt = if is_doubtful { reading.radiance.powi(2) } else { 0.0 };
            return Value::Known { radiance: reading.radiance, variance: variance + doubt };
        }
        let is_full = |&(f, index): &(usize, usize)| self.frames[f].is_full(index, channel);
        // The white level is a bound only if the shortest frame is clipped.
        let is_clipped =
            there().next().is_some_and(|first| first.0 == self.order[0] && is_full(&first));
        if is_clipped { Value::Clipped } else { Value::Unknown }
    }

    fn reading(&self, frame: usize, index: usize, channel: usize) -> Reading<'_> {
        let frame = &self.frames[frame];
        let code = frame.code(index, channel);
        Reading {
            frame,
            radiance: self.scale.linear(channel, code) / frame.exposure,
            of_file: self.noise.of_file(frame, (index, channel), self.scale),
        }
    }

    /// The variance of a reading where the radiance is this.
    fn variance(&self, reading: &Reading<'_>, radiance: f64, channel: usize) -> f64 {
        let frame = reading.frame;
        let x = radiance * frame.exposure;
        let variance = self.noise.variance(channel, frame.gain, x) + reading.of_file;
        variance / (frame.exposure * frame.exposure)
    }

    /// The average of readings, at least one, in the order from the shortest exposure to the longest.
    fn average(&self, mut readings: Vec<Reading<'_>>, channel: usize) -> Value {
        // The longest exposures come close to white first.
        while readings.len() > 1 && self.is_nearly_full(&readings[readings.len() - 1], channel) {
            readings.pop();
        }
        let mut radiance = readings[readings.len() - 1].radiance;
        let last = readings.len() - 1;
        let is_dark = |reading: &Reading<'_>| {
            let dark = self.variance(reading, 0.0, channel).sqrt();
            radiance < DARK * dark
        };
        let first = readings[..last].iter().position(|r| !is_dark(r)).unwrap_or(last);
        let readings = &readings[first..];
        let mut variance = 0.0;
        for _ in 0..ROUNDS {
            let (mut sum, mut weights) = (0.0, 0.0);
            for reading in readings {
                let weight = 1.0 / self.variance(reading, radiance, channel).max(f64::MIN_POSITIVE);
                sum += weight * reading.radiance;
                weights += weight;
            }
            (radiance, variance) = (sum / weights, 1.0 / weights);
        }
        Value::Known { radiance, variance }
    }

    /// Whether a part of the noise of a reading is cut off at white.
    fn is_nearly_full(&self, reading: &Reading<'_>, channel: usize) -> bool {
        let frame = reading.frame;
        let from = frame.clipped_from[channel];
        if !from.is_finite() {
            return false;
        }
        let full = self.scale.computed(channel, from);
        let deviation = self.noise.variance(channel, frame.gain, full).sqrt();
        reading.radiance * frame.exposure > full - FULL * deviation
    }
}
