//! One frame of a bracket: its shift to the reference, and which of its codes are usable.

use super::{Frame, Settings};
use crate::clipping::clipped_from;
use unrender_scene::{Depth, Picture, Rgb};

/// A frame with its exposure as a multiple of the reference frame's.
pub(super) struct Exposed<'a> {
    pub(super) picture: &'a Picture,
    pub(super) exposure: f64,
    /// The gain as a multiple of the reference frame's.
    pub(super) gain: f64,
    /// The place that shows what the reference shows at (0, 0).
    pub(super) shift: [i32; 2],
    /// The code from which on each channel is clipped.
    pub(super) clipped_from: Rgb,
    marks: Vec<u8>,
    /// The contrast of each cell, row by row; empty except for files of 8 bits.
    contrasts: Vec<f32>,
}

/// The side of a cell, pixels: that of JPEG's blocks. With double of it, the size of its colour
/// blocks in most files, less motion is found beside edges, and more textures are taken for motion.
const CELL: usize = 8;

/// From this value (of 1) on, codes of 8-bit files count as clipped. Most are JPEG, which writes clipped pixels
/// with codes from about 250 on, more so where one channel is clipped. Another exposure covers the values that are
/// lost. At 253 a response fitted to JPEG bends at white by 20 %; at 245 white is extrapolated from further away.
const CLIPPED_OF_EIGHT: f32 = 249.5 / 255.0;
/// The bit of the first channel that is clipped; the others follow.
const FULL: u8 = 1;
/// The bit of the first channel beside such a pixel: charge spreads, and demosaicing and JPEG mix neighbours.
const BESIDE: u8 = 8;
/// The pixel has no number in the file.
const INVALID: u8 = 64;

impl<'a> Exposed<'a> {
    /// `frame`, not yet aligned to `reference`.
    pub(super) fn new(frame: &'a Frame, settings: &Settings, reference: &Frame) -> Self {
        let picture = &frame.picture;
        let mut clipped_from = clipped_from(picture, settings.white_level);
        if picture.depth == Depth::Eight {
            clipped_from = clipped_from.min(Rgb::splat(CLIPPED_OF_EIGHT));
        }
        if let Some(response) = &settings.response {
            let last = |c: usize| response.last_code(c).next_up();
            clipped_from = clipped_from.min(Rgb::new(last(0), last(1), last(2)));
        }
        Self {
            picture,
            exposure: frame.exposure / reference.exposure,
            gain: frame.gain / reference.gain,
            shift: [0; 2],
            clipped_from,
            marks: marks(picture, clipped_from),
            contrasts: if picture.depth == Depth::Eight { contrasts(picture) } else { Vec::new() },
        }
    }

    /// The index of the pixel that shows what the reference shows at (`x`, `y`), if there is one.
    pub(super) fn index(&self, x: usize, y: usize) -> Option<usize> {
        let values = &self.picture.values;
        let column =
            x.checked_add_signed(self.shift[0] as isize).filter(|c| *c < values.width())?;
        let row = y.checked_add_signed(self.shift[1] as isize).filter(|r| *r < values.height())?;
        Some(row * values.width() + column)
    }

    /// The range of the codes around the pixel, in the channel where it is largest: edges and texture, where JPEG
    /// errs most. Zero except in files of 8 bits.
    pub(super) fn contrast(&self, index: usize) -> f32 {
        let width = self.picture.values.width();
        let (column, row) = (index % width / CELL, index / width / CELL);
        self.contrasts.get(row * width.div_ceil(CELL) + column).copied().unwrap_or(0.0)
    }

    /// The code of a channel.
    pub(super) fn code(&self, index: usize, channel: usize) -> f32 {
        self.picture.values.pixels()[index][channel]
    }

    /// Whether the channel is clipped there: the scene is at least as bright as the code says.
    pub(super) fn is_full(&self, index: usize, channel: usize) -> bool {
        self.marks[index] & (FULL << channel) != 0
    }

    /// Whether the file has a number there that is not clipped.
    pub(super) fn has_value(&self, index: usize, channel: usize) -> bool {
        self.marks[index] & (INVALID | FULL << channel) == 0
    }

    /// Whether the code measures the radiance: a number, not clipped, and no neighbour clipped.
    pub(super) fn is_usable(&self, index: usize, channel: usize) -> bool {
        self.marks[index] & (INVALID | (FULL | BESIDE) << channel) == 0
    }
}

/// The range of the codes of each cell, in the channel where it is largest.
fn contrasts(picture: &Picture) -> Vec<f32> {
    let (width, height) = (picture.values.width(), picture.values.height());
    let columns = width.div_ceil(CELL);
    let mut ranges = vec![(Rgb::INFINITY, Rgb::NEG_INFINITY); columns * height.div_ceil(CELL)];
    for (index, code) in picture.values.pixels().iter().enumerate() {
        let (low, high) = &mut ranges[index / width / CELL * columns + index % width / CELL];
        (*low, *high) = (low.min(*code), high.max(*code));
    }
    ranges.into_iter().map(|(low, high)| (high - low).max_element()).collect()
}

fn marks(picture: &Picture, clipped_from: Rgb) -> Vec<u8> {
    let full = |code: &Rgb| {
        let bits = (0..3).filter(|&c| code[c] >= clipped_from[c]).map(|c| FULL << c);
        bits.sum::<u8>()
    };
    let mut marks: Vec<u8> = picture.values.pixels().iter().map(full).collect();
    let all = FULL | FULL << 1 | FULL << 2;
    for index in 0..marks.len() {
        let bits = marks[index] & all;
        if bits != 0 {
            for neighbour in picture.values.neighbourhood(index) {
                marks[neighbour] |= bits * BESIDE;
            }
        }
    }
    picture.invalid.iter().for_each(|&index| marks[index] |= INVALID);
    marks
}
