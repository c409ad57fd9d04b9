//! The data for the response: small uniform patches of the scene, with their mean code in every frame that
//! shows them well.

use super::frame::Exposed;
use unrender_scene::Rgb;

/// One place of the scene in one channel.
pub(super) struct Sample {
    /// Mean code above black, 0 to 1, and logarithm of the exposure, in at least two frames.
    pub(super) readings: Vec<[f64; 2]>,
}

/// The fewest places per channel for a response. At half of it noise shows in the curve.
pub(super) const FEWEST: usize = 30;
/// Half the side of a patch, pixels: the mean of 5 x 5 pixels has a fifth of their noise, and patches of this
/// size are uniform in most pictures. At 1 the noise is 1.7 times as large; at 4 few places are uniform.
const REACH: usize = 2;
/// About this many patches are used. At half of it the curve is 1.4 times as noisy; at double it takes
/// longer.
const PATCHES: usize = 3000;
/// A patch is uniform if the standard deviation of its codes (0 to 1) is below this: ten steps of 8 bits. As
/// the response is curved, the mean of codes is not the code of the mean, which matters at double of it.
const EVEN: f64 = 0.04;

/// The samples of each channel.
pub(super) fn samples(frames: &[Exposed<'_>], black_level: Rgb) -> [Vec<Sample>; 3] {
    let (width, height) = (frames[0].picture.values.width(), frames[0].picture.values.height());
    let cell = ((width * height) as f64 / PATCHES as f64).sqrt().ceil() as usize;
    let cell = cell.max(2 * REACH + 1);
    let mut samples: [Vec<Sample>; 3] = Default::default();
    for top in (0..height).step_by(cell) {
        for left in (0..width).step_by(cell) {
            for (channel, samples) in samples.iter_mut().enumerate() {
                samples.extend(best_of_cell(frames, [left, top, cell], channel, black_level));
            }
        }
    }
    samples
}

/// The codes, 0 to 1, between which all channels have samples.
pub(super) fn covered(samples: &[Vec<Sample>; 3]) -> [f64; 2] {
    let of_channel = |samples: &Vec<Sample>| {
        let codes = samples.iter().flat_map(|s| s.readings.iter().map(|r| r[0]));
        codes.fold([1.0f64, 0.0], |[low, high], code| [low.min(code), high.max(code)])
    };
    let all = samples.each_ref().map(of_channel);
    let low = all.iter().map(|range| range[0]).fold(0.0, f64::max);
    [low, all.iter().map(|range| range[1]).fold(1.0, f64::min)]
}

/// The most uniform of nine patches in the cell at (left, top) that two frames show well.
fn best_of_cell(
    frames: &[Exposed<'_>],
    [left, top, cell]: [usize; 3],
    channel: usize,
    black_level: Rgb,
) -> Option<Sample> {
    let room = cell - 2 * REACH - 1;
    let places = if room == 0 { 1 } else { 3 };
    let mut best: Option<(f64, Sample)> = None;
    for place in 0..places * places {
        let along = |k: usize| REACH + if places == 1 { 0 } else { room * k / 2 };
        let centre = [left + along(place % places), top + along(place / places)];
        let mut readings = Vec::new();
        let mut spread = 0.0;
        for frame in frames {
            if let Some((mean, deviation)) = patch(frame, centre, channel, black_level[channel]) {
                readings.push([mean, frame.exposure.ln()]);
                spread += deviation;
            }
        }
        let spread = spread / readings.len().max(1) as f64;
        if readings.len() > 1 && best.as_ref().is_none_or(|(least, _)| spread < *least) {
            best = Some((spread, Sample { readings }));
        }
    }
    best.map(|(_, sample)| sample)
}

/// Mean and standard deviation of the codes around `centre`, above black; none if one of them is clipped or
/// black, or the place is not uniform.
fn patch(
    frame: &Exposed<'_>,
    [x, y]: [usize; 2],
    channel: usize,
    black: f32,
) -> Option<(f64, f64)> {
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for row in y - REACH..=y + REACH {
        for column in x - REACH..=x + REACH {
            let index = inside(frame, column, row)?;
            let code = frame.code(index, channel);
            if !frame.is_usable(index, channel) || code <= black {
                return None;
            }
            let code = f64::from((code - black) / (1.0 - black));
            sum += code;
            squares += code * code;
            count += 1.0;
        }
    }
    let mean = sum / count;
    let deviation = (squares / count - mean * mean).max(0.0).sqrt();
    (deviation < EVEN).then_some((mean, deviation))
}

/// The pixel of `frame` at (`x`, `y`) of the reference, if both have it.
fn inside(frame: &Exposed<'_>, x: usize, y: usize) -> Option<usize> {
    let values = &frame.picture.values;
    (x < values.width() && y < values.height()).then(|| frame.index(x, y))?
}
