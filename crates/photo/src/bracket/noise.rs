//! The noise of the frames, measured where two of them show the same.
//!
//! The variance of a linear value `x` in units of white is `g^2 a + g b x` plus that of the rounding, where `g`
//! is the gain of the frame: `a` is read noise, `b` photon noise. Compression by JPEG adds a standard deviation
//! of `c` times the contrast around the pixel, both in codes: it affects edges and texture most.
//!
//! The difference of two frames, each divided by its exposure, has the sum of their variances. `a` and `b` are
//! measured in classes of brightness, robustly: about the median of the class, which is an error of the
//! response and not noise, without motion and without edges. `c` follows from the remaining differences at
//! edges and in texture.

use super::frame::Exposed;
use super::scale::Scale;

/// The noise of a linear value, by channel: see the module's head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseModel {
    /// The variance without light, `a`, in squares of white.
    pub base: [f64; 3],
    /// The variance per unit of light, `b`, in units of white.
    pub slope: [f64; 3],
    /// The standard deviation by compression, as a share of the contrast around a pixel: `c`.
    pub contrast: f64,
}

/// The noise that is assumed if the frames do not determine it: photon noise of a sensor that holds 10 000
/// electrons; the variance of read noise is a thousandth of that at white. Weights hardly depend on it; the
/// variances are proportional to it.
pub(super) const USUAL: NoiseModel =
    NoiseModel { base: [1e-7; 3], slope: [1e-4; 3], contrast: 0.0 };

impl NoiseModel {
    /// The variance of a linear value `x` of a channel in a frame of this gain, without its rounding.
    pub(super) fn variance(&self, channel: usize, gain: f64, x: f64) -> f64 {
        gain * gain * self.base[channel] + gain * self.slope[channel] * x.max(0.0)
    }

    /// The variance of a linear value of a pixel from its file: rounding, and compression by JPEG.
    pub(super) fn of_file(
        &self,
        frame: &Exposed<'_>,
        (index, channel): (usize, usize),
        scale: &Scale<'_>,
    ) -> f64 {
        let code = frame.code(index, channel);
        let compression = self.contrast * f64::from(frame.contrast(index));
        scale.rounding(channel, code) + (compression * scale.per_code(channel, code)).powi(2)
    }
}

/// About this many pixels are compared per pair of frames. At a quarter the variances are still
/// known to 2 %.
const PIXELS: usize = 200_000;
/// Classes of brightness, and the fewest pixels in one that counts: they give the variance to 15 %.
const CLASSES: usize = 24;
const FEWEST: usize = 100;
/// Pixels further from the median than this many standard deviations are outliers. At 2.5 the variance is 4 %
/// too small, at 4 edges count.
const INLIERS: f64 = 3.0;
/// The contrast (of 1) above which a pixel is busy. Below half of it JPEG changes pixels by less than a
/// step.
const BUSY: f64 = 0.1;
/// Compression is measured by this quantile of the differences, which in normal noise lies `WITHIN` standard
/// deviations from zero. Its errors have long tails, so the median says little of edges: with it 1 % of a still
/// JPEG counts as moved, with this quantile less than 0.1 %. Motion covers a few percent of a picture; a higher
/// quantile would take it for compression.
const QUANTILE: f64 = 0.95;
const WITHIN: f64 = 1.96;
/// A variance below this, in squares of white, is negligible beside rounding in any file.
const LEAST: f64 = 1e-12;

/// One pixel of two frames that show it well.
pub(super) struct Pair {
    /// The mean radiance.
    radiance: f64,
    /// The radiance by the shorter frame less that by the longer one.
    difference: f64,
    /// The factors of base and slope in its variance.
    factors: [f64; 2],
    /// The variance by rounding.
    rounding: f64,
    /// The variance by compression where `c` is 1.
    compression: f64,
    /// Whether there is much contrast around it.
    is_busy: bool,
}

/// The pixels of each pair of frames adjacent in exposure, by channel.
pub(super) fn overlaps(
    frames: &[Exposed<'_>],
    order: &[usize],
    scale: &Scale<'_>,
) -> Vec<[Vec<Pair>; 3]> {
    let of = |pair: &[usize]| overlap(&frames[pair[0]], &frames[pair[1]], scale);
    order.windows(2).map(of).collect()
}

fn overlap(short: &Exposed<'_>, long: &Exposed<'_>, scale: &Scale<'_>) -> [Vec<Pair>; 3] {
    let (width, height) = (short.picture.values.width(), short.picture.values.height());
    let stride = (width * height / PIXELS).max(1);
    let mut pairs: [Vec<Pair>; 3] = Default::default();
    for place in (0..width * height).step_by(stride) {
        let (x, y) = (place % width, place / width);
        let (Some(a), Some(b)) = (short.index(x, y), long.index(x, y)) else { continue };
        for (channel, pairs) in pairs.iter_mut().enumerate() {
            if !short.is_usable(a, channel) || !long.is_usable(b, channel) {
                continue;
            }
            let codes = [short.code(a, channel), long.code(b, channel)];
            let [x, y] = codes.map(|code| scale.linear(channel, code));
            let rounding = codes.map(|code| scale.rounding(channel, code));
            let (t, s) = (short.exposure, long.exposure);
            let contrasts = [short.contrast(a), long.contrast(b)].map(f64::from);
            let compression = |k: usize| (contrasts[k] * scale.per_code(channel, codes[k])).powi(2);
            // The longer frame has less noise, so that classes by it hardly depend on noise.
            let radiance = y / s;
            if x <= 0.0 || y <= 0.0 {
                continue;
            }
            let base = (short.gain / t).powi(2) + (long.gain / s).powi(2);
            let slope = radiance * (short.gain / t + long.gain / s);
            pairs.push(Pair {
                radiance,
                difference: x / t - y / s,
                factors: [base, slope],
                rounding: rounding[0] / (t * t) + rounding[1] / (s * s),
                compression: compression(0) / (t * t) + compression(1) / (s * s),
                is_busy: contrasts[0].max(contrasts[1]) > BUSY,
            });
        }
    }
    pairs
}

/// The noise from all pairs; none if too few pixels are well exposed twice.
pub(super) fn measure(overlaps: &[[Vec<Pair>; 3]]) -> Option<NoiseModel> {
    let mut noise = NoiseModel { base: [0.0; 3], slope: [0.0; 3], contrast: 0.0 };
    for channel in 0..3 {
        let classes = overlaps.iter().flat_map(|pairs| classes(&pairs[channel]));
        let [base, slope] = fit(&classes.collect::<Vec<Class>>())?;
        (noise.base[channel], noise.slope[channel]) = (base, slope);
    }
    noise.contrast = compression(overlaps, &noise);
    Some(noise)
}

/// The standard deviation by compression per contrast, from the excess of the differences of busy pixels over
/// the rest of the `noise`; zero if that explains them.
fn compression(overlaps: &[[Vec<Pair>; 3]], noise: &NoiseModel) -> f64 {
    let mut squares = Vec::new();
    for pairs in overlaps {
        for (channel, pairs) in pairs.iter().enumerate() {
            let [base, slope] = [noise.base[channel], noise.slope[channel]];
            let mut order: Vec<&Pair> = pairs.iter().collect();
            order.sort_by(|a, b| a.radiance.total_cmp(&b.radiance));
            let size = order.len().div_ceil(CLASSES).max(FEWEST);
            for class in order.chunks_exact(size) {
                let share = share(class);
                for pair in class.iter().filter(|p| p.is_busy && p.compression > 0.0) {
                    let known = pair.factors[0] * base + pair.factors[1] * slope + pair.rounding;
                    let off = pair.difference - share * pair.radiance;
                    let reach = WITHIN * WITHIN;
                    squares.push((off * off / reach - known) / pair.compression);
                }
            }
        }
    }
    if squares.len() < FEWEST {
        return 0.0;
    }
    let place = (QUANTILE * squares.len() as f64) as usize;
    let quantile = *squares.select_nth_unstable_by(place, f64::total_cmp).1;
    quantile.max(0.0).sqrt()
}

/// The median difference of a class, which is an error of the response, as a share of the radiance.
fn share(pairs: &[&Pair]) -> f64 {
    median(pairs.iter().map(|p| p.difference / p.radiance).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The variance of the differences of a class.
struct Class {
    /// Without that of the rounding.
    variance: f64,
    rounding: f64,
    factors: [f64; 2],
    count: f64,
}

fn classes(pairs: &[Pair]) -> Vec<Class> {
    let mut order: Vec<&Pair> = pairs.iter().collect();
    order.sort_by(|a, b| a.radiance.total_cmp(&b.radiance));
    let size = order.len().div_ceil(CLASSES).max(FEWEST);
    order.chunks_exact(size).map(class).collect()
}

fn class(pairs: &[&Pair]) -> Class {
    // Errors of the response grow with the radiance: the difference is taken as a share of it.
    let share = share(pairs);
    let off: Vec<f64> = pairs.iter().map(|p| p.difference - share * p.radiance).collect();
    let mean =
        |f: &dyn Fn(&Pair) -> f64| pairs.iter().map(|p| f(p)).sum::<f64>() / pairs.len() as f64;
    let rounding = mean(&|p| p.rounding);
    let deviation = 1.4826 * median(off.iter().map(|d| d.abs()).collect());
    let reach = INLIERS * deviation.max(rounding.sqrt());
    let inliers: Vec<f64> = off.into_iter().filter(|d| d.abs() <= reach).collect();
    let count = inliers.len().max(1) as f64;
    let variance = inliers.iter().map(|d| d * d).sum::<f64>() / count - rounding;
    let factors = [mean(&|p| p.factors[0]), mean(&|p| p.factors[1])];
    Class { variance, rounding, factors, count }
}

/// Base and slope, neither of them negative, by least squares weighted by the inverse variances of the
/// variances.
fn fit(classes: &[Class]) -> Option<[f64; 2]> {
    if classes.is_empty() {
        return None;
    }
    let mut found = [USUAL.base[0], USUAL.slope[0]];
    for _ in 0..5 {
        let mut sums = [0.0; 5];
        for class in classes {
            let [a, b] = class.factors;
            let predicted = a * found[0] + b * found[1] + class.rounding + LEAST * a;
            let weight = class.count / (predicted * predicted);
            let terms = [a * a, a * b, b * b, a * class.variance, b * class.variance];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
        }
        let [aa, ab, bb, av, bv] = sums;
        let determinant = aa * bb - ab * ab;
        let both = [(bb * av - ab * bv) / determinant, (aa * bv - ab * av) / determinant];
        found = if determinant > 1e-9 * aa * bb && both.iter().all(|v| *v >= 0.0) {
            both
        } else if bv / bb * bv > av / aa * av {
            [0.0, (bv / bb).max(0.0)]
        } else {
            [(av / aa).max(0.0), 0.0]
        };
    }
    found[0] = found[0].max(LEAST);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

/// The brightness of each frame relative to its exposure and the next longer frame; 1 for the longest, and
/// where nothing can be compared.
pub(super) fn brightness(overlaps: &[[Vec<Pair>; 3]], order: &[usize]) -> Vec<f64> {
    let mut brightness = vec![1.0; order.len()];
    for (pairs, &shorter) in overlaps.iter().zip(order) {
        let all = pairs.iter().flatten();
        let mut shares: Vec<f64> = all.map(|p| p.difference / p.radiance).collect();
        if shares.len() >= FEWEST {
            let middle = shares.len() / 2;
            brightness[shorter] = 1.0 + *shares.select_nth_unstable_by(middle, f64::total_cmp).1;
        }
    }
    brightness
}
