//! One pass over the photograph: residuals and Jacobians, each rendered twice, as means over the
//! pixels of a group in a block.
//!
//! The Jacobian of one pixel is mostly noise: that of a wall by the roughness of the floor lives on
//! rare paths. A least-squares fit multiplies it with the residual, and noise times noise drowns
//! the sum. Over a block both change little, while their noise falls by the number of its pixels;
//! and the means of all blocks fit into memory where the Jacobians of all pixels would not: only
//! those of some thousand pixels are ever there.

use super::sample::Cell;
use super::unknowns::Unknowns;
use crate::evidence::Observed;
use crate::ladder::State;
use rayon::prelude::*;
use unrender_render::sampler::mix;
use unrender_render::{Jacobian, Settings};
use unrender_scene::Rgb;

/// What one cell shows on the mean.
#[derive(Clone, Debug)]
pub(crate) struct Mean {
    pub(crate) group: usize,
    /// Pixels in the mean.
    pub(crate) pixels: f64,
    /// Photograph minus rendering, for each of the two renderings.
    pub(crate) residuals: [Rgb; 2],
    /// The variance of the photograph's noise.
    pub(crate) variance: Rgb,
    /// What relative errors are relative to, squared.
    pub(crate) level2: Rgb,
    /// For each channel: the unknowns on which the rendering hangs, and its derivative by them in
    /// each of the two renderings.
    pub(crate) rows: [Vec<(usize, f64, f64)>; 3],
}

/// Pixels whose Jacobians are in memory together, about.
const TILE: usize = 4096;

/// One pass over `cells` with `settings.spp` paths a pixel, twice.
pub(crate) fn gather(
    state: &State<'_>,
    unknowns: &Unknowns,
    cells: &[Cell],
    settings: &Settings,
) -> Vec<Mean> {
    let mut means = Vec::with_capacity(cells.len());
    for tile in tiles(cells) {
        let pixels: Vec<u32> = tile.iter().flat_map(|c| &c.pixels).map(|p| p.pixel).collect();
        let jacobians = [0u64, 1].map(|half| {
            let seed = mix(settings.seed).wrapping_add(half);
            let settings = Settings { seed, ..*settings };
            let (appearance, seen) = (state.appearance(), state.seen.as_ref());
            let asked = &unknowns.parameters;
            state.problem.renderer.jacobian(appearance, &pixels, asked, &settings, seen)
        });
        let starts: Vec<usize> = tile
            .iter()
            .scan(0, |next, cell| {
                *next += cell.pixels.len();
                Some(*next - cell.pixels.len())
            })
            .collect();
        let of_cell =
            |(cell, start): (&Cell, usize)| mean(state, unknowns, cell, start, &jacobians);
        means.par_extend(tile.par_iter().zip(starts).map(of_cell));
    }
    means
}

/// The cells in tiles of about [`TILE`] pixels.
fn tiles(cells: &[Cell]) -> Vec<&[Cell]> {
    let mut tiles = Vec::new();
    let (mut start, mut pixels) = (0, 0);
    for (i, cell) in cells.iter().enumerate() {
        pixels += cell.pixels.len();
        if pixels >= TILE || i + 1 == cells.len() {
            tiles.push(&cells[start..=i]);
            (start, pixels) = (i + 1, 0);
        }
    }
    tiles
}

/// The mean over a cell, whose first pixel is number `start` of the Jacobians.
fn mean(
    state: &State<'_>,
    unknowns: &Unknowns,
    cell: &Cell,
    start: usize,
    jacobians: &[Jacobian; 2],
) -> Mean {
    let n = cell.pixels.len() as f32;
    let range = start..start + cell.pixels.len();
    let over = |f: &dyn Fn(&Observed) -> Rgb| cell.pixels.iter().map(f).sum::<Rgb>() / n;
    let photograph = over(&|p| p.radiance);
    let radiance = jacobians.each_ref().map(|j| j.radiance[range.clone()].iter().sum::<Rgb>() / n);
    let slots = unknowns.parameters.len();
    let derivatives = jacobians.each_ref().map(|j| {
        let mut sums = vec![Rgb::ZERO; slots];
        for pixel in range.clone() {
            let row = &j.derivatives[pixel * slots..(pixel + 1) * slots];
            sums.iter_mut().zip(row).for_each(|(sum, d)| *sum += *d / n);
        }
        sums
    });
    let level = over(&|p| p.level);
    Mean {
        group: cell.group,
        pixels: f64::from(n),
        residuals: radiance.map(|radiance| photograph - radiance),
        variance: over(&|p| p.variance) / n,
        level2: (level * level).max(Rgb::splat(f32::MIN_POSITIVE)),
        rows: [0, 1, 2].map(|channel| {
            unknowns.row(state, &derivatives, channel, f64::from(photograph[channel]))
        }),
    }
}
