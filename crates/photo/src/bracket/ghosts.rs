//! Motion: pixels at which a frame shows something else than the reference.
//!
//! Each pixel has a local reference: the reference frame where it is neither clipped nor invalid, else the
//! nearest frame in exposure that is not, the shorter ones first. A frame contradicts it where their radiances
//! differ by more than noise in some channel. Single such pixels are noise; those with two neighbours of their
//! kind, and the neighbours of all these, are left out.

use super::frame::Exposed;
use super::noise::NoiseModel;
use super::scale::Scale;

/// Radiances differ significantly from this many standard deviations on. With normal noise, one pixel in
/// 16 000 does; at 3 moving things with smaller differences are found, and one pixel in 400 is noise.
const DEVIATIONS: f64 = 4.0;
/// Beside noise, radiances may differ by this share: errors of the response, rounded exposure times, shifts by
/// parts of a pixel. At half of it edges are left out; at double, grey things before grey walls stay.
const TOLERANCE: f64 = 0.03;
/// A pixel that differs needs this many such neighbours, ...
const COMPANY: usize = 2;
/// ... unless it differs by this many times the limit.
const ALONE: f64 = 2.5;

/// Which frames are left out where.
pub(super) struct Ghosts {
    /// For each frame and each pixel of the reference.
    masks: Vec<Vec<bool>>,
    /// For each pixel its local reference.
    pub(super) local: Vec<u8>,
}

impl Ghosts {
    /// Whether `frame` shows something else at the pixel.
    pub(super) fn is_ghost(&self, frame: usize, pixel: usize) -> bool {
        self.masks[frame][pixel]
    }

    /// For each frame the share of the pixels at which it is left out.
    pub(super) fn shares(&self) -> Vec<f64> {
        let share = |mask: &Vec<bool>| {
            mask.iter().filter(|ghost| **ghost).count() as f64 / mask.len().max(1) as f64
        };
        self.masks.iter().map(share).collect()
    }

    /// The share of the pixels at which some frame is left out.
    pub(super) fn share_of_any(&self) -> f64 {
        let any = |&pixel: &usize| self.masks.iter().any(|mask| mask[pixel]);
        (0..self.local.len()).filter(any).count() as f64 / self.local.len().max(1) as f64
    }
}

/// Finds motion between `frames`, whose `order` is by exposure.
pub(super) fn find(
    frames: &[Exposed<'_>],
    order: &[usize],
    reference: usize,
    scale: &Scale<'_>,
    noise: &NoiseModel,
) -> Ghosts {
    let (width, height) = (frames[0].picture.values.width(), frames[0].picture.values.height());
    let compare = Compare { frames, scale, noise };
    let preferred = preferred(order, reference);
    let place = |pixel: usize| (pixel % width, pixel / width);
    let local: Vec<u8> =
        (0..width * height).map(|pixel| compare.local(&preferred, place(pixel)) as u8).collect();
    let mask = |frame: usize| {
        let raw: Vec<f64> = (0..width * height)
            .map(|pixel| compare.excess(frame, local[pixel].into(), place(pixel)))
            .collect();
        cleaned(&raw, width, height)
    };
    Ghosts { masks: (0..frames.len()).map(mask).collect(), local }
}

/// The reference, then the shorter frames, the nearest first, then the longer ones.
fn preferred(order: &[usize], reference: usize) -> Vec<usize> {
    let place = order.iter().position(|&index| index == reference).unwrap_or(0);
    order[..=place].iter().rev().chain(&order[place + 1..]).copied().collect()
}

struct Compare<'a> {
    frames: &'a [Exposed<'a>],
    scale: &'a Scale<'a>,
    noise: &'a NoiseModel,
}

impl Compare<'_> {
    /// The first of the `preferred` frames with most usable channels there.
    fn local(&self, preferred: &[usize], (x, y): (usize, usize)) -> usize {
        let usable = |frame: usize| {
            let frame = &self.frames[frame];
            frame.index(x, y).map_or(0, |i| (0..3).filter(|&c| frame.is_usable(i, c)).count())
        };
        let mut best = (0, preferred[0]);
        for &frame in preferred {
            let count = usable(frame);
            if count > best.0 {
                best = (count, frame);
            }
        }
        best.1
    }

    /// The difference of `frame` from its local reference as a multiple of the allowed one, in the worst
    /// channel.
    fn excess(&self, frame: usize, local: usize, (x, y): (usize, usize)) -> f64 {
        if frame == local {
            return 0.0;
        }
        let (own, other) = (&self.frames[frame], &self.frames[local]);
        let (Some(a), Some(b)) = (own.index(x, y), other.index(x, y)) else { return 0.0 };
        let of_channel = |c: usize| {
            let comparable = |frame: &Exposed<'_>, index: usize| {
                frame.is_usable(index, c) || frame.is_full(index, c)
            };
            if !comparable(own, a) || !comparable(other, b) {
                return 0.0;
            }
            let (l, var_l) = self.radiance(own, a, c);
            let (m, var_m) = self.radiance(other, b, c);
            // A clipped value is a lower bound.
            let off = match (own.is_full(a, c), other.is_full(b, c)) {
                (true, true) => 0.0,
                (true, false) => (l - m).max(0.0),
                (false, true) => (m - l).max(0.0),
                (false, false) => (l - m).abs(),
            };
            let allowed = DEVIATIONS * (var_l + var_m).sqrt() + TOLERANCE * l.max(m).max(0.0);
            if off > 0.0 { off / allowed.max(f64::MIN_POSITIVE) } else { 0.0 }
        };
        (0..3).map(of_channel).fold(0.0, f64::max)
    }

    /// Radiance and variance by one frame; for a clipped value, those at the clipping level.
    fn radiance(&self, frame: &Exposed<'_>, index: usize, channel: usize) -> (f64, f64) {
        let code = frame.code(index, channel);
        let x = if frame.is_full(index, channel) {
            self.scale.computed(channel, frame.clipped_from[channel].min(code))
        } else {
            self.scale.linear(channel, code)
        };
        let of_file = self.noise.of_file(frame, (index, channel), self.scale);
        let variance = self.noise.variance(channel, frame.gain, x) + of_file;
        (x / frame.exposure, variance / (frame.exposure * frame.exposure))
    }
}

/// The mask of pixels that differ in company or by much, and their neighbours.
fn cleaned(raw: &[f64], width: usize, height: usize) -> Vec<bool> {
    let around = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |row| {
            (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column)
        })
    };
    let mut mask = vec![false; raw.len()];
    for pixel in 0..raw.len() {
        let company = || around(pixel).filter(|&n| raw[n] > 1.0).count() > COMPANY;
        if raw[pixel] > ALONE || (raw[pixel] > 1.0 && company()) {
            around(pixel).for_each(|n| mask[n] = true);
        }
    }
    mask
}
