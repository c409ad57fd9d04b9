//! The similarity of pixels: the weights of non-local means [Buades et al. 2005; Rousselle et al. 2012].
//!
//! Pixels p and q are alike if the patches about them are, given the noise. With a picture `u` of variance `V`,
//! the distance of two pixels is
//!
//! ```text
//! d(p, q) = ((u_p - u_q)^2 - (V_p + min(V_p, V_q))) / (epsilon + V_p + V_q),
//! ```
//!
//! averaged over channels and over the pixels of both patches, and the weight is `exp(-max(0, d) / k^2)`. The
//! distance is computed for all pixels of a tile at once, one offset `q - p` after the other, so that the sum over
//! patches is a box filter: its cost does not depend on the patch.

use super::signal::Planes;
use std::ops::Range;

/// The search window: pixels p and q are at most this far apart in either direction. Not derived from the
/// resolution: it sets over how many pixels, 19 x 19, noise is averaged. Half of it leaves twice the noise in flat
/// regions, double of it takes four times as long and finds few pixels that are alike.
pub(super) const RADIUS: usize = 9;
/// Offsets in a row of the window.
pub(super) const SIDE: usize = 2 * RADIUS + 1;
/// Offsets in the window.
pub(super) const OFFSETS: usize = SIDE * SIDE;
/// The patch has this many pixels on either side of its centre. With half of it the noise makes pixels unlike, with
/// double of it an edge reaches twice as far.
const PATCH: usize = 3;
/// Distances of single pixels are at most this, so that no infinity comes up.
const DISTANCE_MAX: f32 = 1e6;
/// Weights below this, of distances above its logarithm, count as zero: this saves the time of the regression. With
/// half of it or double of it the result is the same to a percent.
const WEIGHT_MIN: f32 = 0.01;

/// A rectangle of pixels.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Tile {
    /// The centres in the tile: every `step`-th pixel of every `step`-th row.
    pub(super) fn centres(&self, step: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = self.rows.clone().step_by(step);
        rows.flat_map(move |y| self.columns.clone().step_by(step).map(move |x| (x, y)))
    }

    /// The same with `margin` more pixels on each side, within a picture of `size`.
    pub(super) fn grown(&self, margin: usize, (width, height): (usize, usize)) -> Self {
        let grow = |range: &Range<usize>, end: usize| {
            range.start.saturating_sub(margin)..(range.end + margin).min(end)
        };
        Self { columns: grow(&self.columns, width), rows: grow(&self.rows, height) }
    }
}

/// The weights of all offsets at the centres of `tile`, [`OFFSETS`] for each centre, for k = 1.
pub(super) fn weights(
    picture: &Planes,
    variance: &Planes,
    epsilon: f32,
    tile: &Tile,
    step: usize,
) -> Vec<f32> {
    let centres = tile.centres(step).count();
    let mut weights = vec![0.0; centres * OFFSETS];
    let mut distances = Distances::new(picture, variance, epsilon, tile);
    for offset in 0..OFFSETS {
        distances.fill(offset);
        distances.put(offset, step, &mut weights);
    }
    weights
}

/// The distances between the pixels of a tile and those at one offset.
struct Distances<'a> {
    picture: &'a Planes,
    variance: &'a Planes,
    epsilon: f32,
    tile: &'a Tile,
    /// The tile with the patches of its pixels.
    grown: Tile,
    /// Of the pixels of `grown`, row by row; zero where the other pixel is outside of the picture.
    values: Vec<f32>,
    /// The pixels of `grown` whose other pixel is inside.
    inside: Tile,
    /// Sums of `values` over the rows of a patch.
    sums: Vec<f32>,
}

impl<'a> Distances<'a> {
    fn new(picture: &'a Planes, variance: &'a Planes, epsilon: f32, tile: &'a Tile) -> Self {
        let grown = tile.grown(PATCH, picture.size());
        let values = vec![0.0; grown.columns.len() * grown.rows.len()];
        let sums = vec![0.0; grown.columns.len()];
        let inside = grown.clone();
        Self { picture, variance, epsilon, tile, grown, values, inside, sums }
    }

    /// Computes the distances at the offset number `offset`.
    fn fill(&mut self, offset: usize) {
        let (width, height) = self.picture.size();
        let shifted = |range: &Range<usize>, shift: usize, end: usize| {
            // Of x with 0 <= x + shift - RADIUS < end.
            let start = range.start.max(RADIUS.saturating_sub(shift));
            start..range.end.min((end + RADIUS).saturating_sub(shift)).max(start)
        };
        let (dx, dy) = (offset % SIDE, offset / SIDE);
        self.inside = Tile {
            columns: shifted(&self.grown.columns, dx, width),
            rows: shifted(&self.grown.rows, dy, height),
        };
        self.values.fill(0.0);
        let columns = self.inside.columns.clone();
        if columns.is_empty() {
            return;
        }
        for y in self.inside.rows.clone() {
            let (p, q) = (y * width, (y + dy - RADIUS) * width);
            let at_p = p + columns.start..p + columns.end;
            let first = q + columns.start + dx - RADIUS;
            let at_q = first..first + columns.len();
            let place = (y - self.grown.rows.start) * self.grown.columns.len()
                + (columns.start - self.grown.columns.start);
            let row = &mut self.values[place..place + columns.len()];
            for channel in 0..3 {
                let (u, v) = (&self.picture.channels[channel], &self.variance.channels[channel]);
                let (u_p, u_q) = (&u[at_p.clone()], &u[at_q.clone()]);
                let (v_p, v_q) = (&v[at_p.clone()], &v[at_q.clone()]);
                for x in 0..row.len() {
                    let difference = u_p[x] - u_q[x];
                    let both = v_p[x] + v_q[x];
                    let excess = difference * difference - (v_p[x] + v_p[x].min(v_q[x]));
                    row[x] += (excess / (self.epsilon + both)).min(DISTANCE_MAX);
                }
            }
        }
    }

    /// Puts the weights of the offset number `offset` at all centres into `weights`.
    fn put(&mut self, offset: usize, step: usize, weights: &mut [f32]) {
        let stride = self.grown.columns.len();
        let patch = |range: &Range<usize>, centre: usize| {
            let start = range.start.max(centre.saturating_sub(PATCH));
            start..range.end.min(centre + PATCH + 1).max(start)
        };
        let farthest = -WEIGHT_MIN.ln();
        let mut centre = 0;
        for y in self.tile.rows.clone().step_by(step) {
            let rows = patch(&self.inside.rows, y);
            self.sums.fill(0.0);
            for row in rows.clone() {
                let place = (row - self.grown.rows.start) * stride;
                let row = &self.values[place..place + stride];
                self.sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
            }
            for x in self.tile.columns.clone().step_by(step) {
                let is_inside = self.inside.columns.contains(&x) && self.inside.rows.contains(&y);
                if is_inside {
                    let columns = patch(&self.inside.columns, x);
                    let first = columns.start - self.grown.columns.start;
                    let sum: f32 = self.sums[first..first + columns.len()].iter().sum();
                    let distance = sum / (3 * rows.len() * columns.len()) as f32;
                    if distance < farthest {
                        weights[centre * OFFSETS + offset] = (-distance.max(0.0)).exp();
                    }
                }
                centre += 1;
            }
        }
    }
}
