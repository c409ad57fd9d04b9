//! Shifts between frames, in whole pixels, by median threshold bitmaps [Ward 2003].
//!
//! A pixel of such a bitmap says whether the picture is brighter there than its median, which no exposure
//! changes. Two bitmaps are compared by counting the pixels in which they differ, except those close to the
//! median, whose bit is noise. The search goes from coarse to fine: in each level of a pyramid the shift is
//! doubled and changed by at most one pixel in each direction. The paper follows the best shift alone; here
//! the best `KEPT` are, since fine patterns are noise in the coarse levels. Frames are compared with their
//! neighbours in exposure. Time: some thirty passes over the pixels of each pair.

use super::frame::Exposed;
use unrender_scene::Picture;

/// The coarsest level of the pyramid is not smaller than this in either direction, pixels. At half of it its
/// bitmaps say nothing; at double the search takes longer.
const COARSEST: usize = 16;
/// At that level all shifts up to this many pixels are tried: up to an eighth of the picture. Half of it
/// is too short for hand-held cameras.
const WIDEST: i32 = 2;
/// The number of shifts that are followed to the next level. One alone is wrong in fine patterns; double
/// of it finds the same.
const KEPT: usize = 4;
/// Codes (0 to 1) this close to the threshold are ignored: four steps of 8 bits, as in the paper.
const NOISE: f32 = 4.0 / 255.0;
/// The same for linear values, as a share of the threshold.
const NOISE_SHARE: f32 = 0.04;
/// The quantiles that are tried as thresholds, until one is neither clipped nor black in both frames. The
/// paper has the median and two others.
const QUANTILES: [f32; 7] = [0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9];
/// Thresholds are neither below nor above this share of the range.
const RANGE: [f32; 2] = [0.03, 0.97];
/// A shift is significant if the count of differing pixels falls by this many of its standard deviations. At half
/// of it noise shifts pictures without edges; at double small shifts of dim rooms are missed.
const SIGNIFICANT: f64 = 4.0;

/// For each frame, the place that shows what frame `reference` shows at (0, 0); `order` is by
/// exposure.
pub(super) fn shifts(frames: &[Exposed<'_>], order: &[usize], reference: usize) -> Vec<[i32; 2]> {
    let pyramids: Vec<Pyramid> = frames.iter().map(Pyramid::of).collect();
    let mut shifts = vec![[0; 2]; frames.len()];
    for pair in order.windows(2) {
        let [step_x, step_y] = shift(&pyramids[pair[0]], &pyramids[pair[1]]);
        let [x, y] = shifts[pair[0]];
        shifts[pair[1]] = [x + step_x, y + step_y];
    }
    let [x, y] = shifts[reference];
    shifts.iter().map(|shift| [shift[0] - x, shift[1] - y]).collect()
}

/// One level of a pyramid: grey values.
struct Grey {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Grey {
    fn of(picture: &Picture) -> Self {
        let (width, height) = (picture.values.width(), picture.values.height());
        // The paper's weights of red, green and blue.
        let grey = |c: &unrender_scene::Rgb| (54.0 * c.x + 183.0 * c.y + 19.0 * c.z) / 256.0;
        Self { width, height, values: picture.values.pixels().iter().map(grey).collect() }
    }

    /// Half of it in both directions.
    fn half(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let at = |x: usize, y: usize| self.values[y * self.width + x];
        let mean = |index: usize| {
            let (x, y) = (2 * (index % width), 2 * (index / width));
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        Self { width, height, values: (0..width * height).map(mean).collect() }
    }

    /// The value below which the share `quantile` of the pixels lies.
    fn quantile(&self, quantile: f32) -> f32 {
        let mut values = self.values.clone();
        let place = (quantile * (values.len() - 1) as f32) as usize;
        *values.select_nth_unstable_by(place, f32::total_cmp).1
    }

    /// For each pixel whether it is brighter than `threshold`; none where it is close to it.
    fn bitmap(&self, threshold: f32, noise: f32) -> Vec<Option<bool>> {
        let bit = |value: &f32| ((value - threshold).abs() > noise).then_some(*value > threshold);
        self.values.iter().map(bit).collect()
    }
}

/// The grey values of a frame from fine to coarse.
struct Pyramid {
    levels: Vec<Grey>,
    /// The greatest code, 1, or the value at which a floating-point frame is clipped; infinite without one.
    top: f32,
    is_integer: bool,
}

impl Pyramid {
    fn of(frame: &Exposed<'_>) -> Self {
        let mut levels = vec![Grey::of(frame.picture)];
        while let Some(last) = levels.last()
            && last.width.min(last.height) >= 2 * COARSEST
        {
            levels.push(last.half());
        }
        let top = frame.clipped_from.min_element();
        Self { levels, top, is_integer: frame.picture.depth.max_code().is_some() }
    }

    /// The bitmap of a level for the quantile.
    fn bitmap(&self, level: usize, quantile: f32) -> Vec<Option<bool>> {
        let grey = &self.levels[level];
        let threshold = grey.quantile(quantile);
        let noise = if self.is_integer { NOISE } else { NOISE_SHARE * threshold.abs() };
        grey.bitmap(threshold, noise)
    }

    /// Whether the quantile is neither black nor clipped.
    fn is_exposed(&self, quantile: f32) -> bool {
        let value = self.levels[0].quantile(quantile);
        let low = if self.is_integer { RANGE[0] } else { 0.0 };
        value > low && value < RANGE[1] * self.top
    }
}

/// The place in `b` that shows what `a` shows at (0, 0).
fn shift(a: &Pyramid, b: &Pyramid) -> [i32; 2] {
    let good = |quantile: &&f32| a.is_exposed(**quantile) && b.is_exposed(**quantile);
    let quantile = *QUANTILES.iter().find(good).unwrap_or(&QUANTILES[0]);
    let side = 2 * WIDEST + 1;
    let mut tried: Vec<[i32; 2]> =
        (0..side * side).map(|k| [k % side - WIDEST, k / side - WIDEST]).collect();
    for level in (0..a.levels.len()).rev() {
        let size = (a.levels[level].width, a.levels[level].height);
        let bitmaps = [a.bitmap(level, quantile), b.bitmap(level, quantile)];
        let best = best_of(&bitmaps, size, tried);
        if level == 0 {
            let found = best[0];
            return if is_significant(&bitmaps, size, found) { found } else { [0, 0] };
        }
        let around = |s: &[i32; 2]| {
            let [x, y] = s.map(|s| 2 * s);
            (0..9).map(move |k| [x + k % 3 - 1, y + k / 3 - 1])
        };
        tried = best.iter().flat_map(around).collect();
    }
    [0, 0]
}

/// The [`KEPT`] shifts with the fewest differing pixels, the best first; the shorter of equal ones.
fn best_of(
    bitmaps: &[Vec<Option<bool>>; 2],
    size: (usize, usize),
    mut shifts: Vec<[i32; 2]>,
) -> Vec<[i32; 2]> {
    shifts.sort_by_key(|[x, y]| (x.abs() + y.abs(), *x, *y));
    shifts.dedup();
    let share = |shift: [i32; 2]| {
        let (different, compared) = difference(bitmaps, size, shift);
        different as f64 / compared.max(1) as f64
    };
    let mut all: Vec<(f64, [i32; 2])> = shifts.into_iter().map(|s| (share(s), s)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().take(KEPT).map(|(_, shift)| shift).collect()
}

/// Whether the bitmaps differ in clearly fewer pixels with the shift than without it.
fn is_significant(bitmaps: &[Vec<Option<bool>>; 2], size: (usize, usize), shift: [i32; 2]) -> bool {
    let (without, all) = difference(bitmaps, size, [0, 0]);
    let (with, compared) = difference(bitmaps, size, shift);
    let with = with as f64 * all as f64 / compared.max(1) as f64;
    let without = without as f64;
    without - with > SIGNIFICANT * (without + with).sqrt()
}

/// In how many pixels the bitmaps differ if the second is moved back by `shift`, and how many are compared.
fn difference(
    [a, b]: &[Vec<Option<bool>>; 2],
    (width, height): (usize, usize),
    [shift_x, shift_y]: [i32; 2],
) -> (usize, usize) {
    let range = |size: usize, shift: i32| {
        let reach = shift.unsigned_abs() as usize;
        if shift < 0 { reach.min(size)..size } else { 0..size.saturating_sub(reach) }
    };
    let (mut different, mut compared) = (0, 0);
    let columns = range(width, shift_x);
    for y in range(height, shift_y) {
        let first = y * width + columns.start;
        let second = (y as i64 + i64::from(shift_y)) as usize * width;
        let second = (second as i64 + columns.start as i64 + i64::from(shift_x)) as usize;
        for k in 0..columns.len() {
            if let (Some(a), Some(b)) = (a[first + k], b[second + k]) {
                compared += 1;
                different += usize::from(a != b);
            }
        }
    }
    (different, compared)
}
