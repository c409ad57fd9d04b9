//! The normal equations of one pass over the photograph, summed up tile by tile.
//!
//! With the residuals `r = B - L` and Jacobians `J` of two renderings with independent noise:
//! `H = sum w sym(J_A^T J_B)` and `g = sum w (J_A^T r_B + J_B^T r_A) / 2`: the noise of a rendering
//! meets itself nowhere, so it biases neither (design, section 5). Only the Jacobian of some
//! thousand pixels is ever in memory.
//!
//! `g` is also summed block by block: from the spread of the blocks comes its variance, whatever
//! the noise is and however it hangs together within a block, `G = sum_blocks g_b g_b^T`.

use super::sample::{Block, GroupNoise, NoiseSums};
use super::unknowns::Unknowns;
use crate::ladder::State;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use unrender_render::sampler::mix;
use unrender_render::{Jacobian, Settings};
use unrender_scene::Rgb;

/// What one pass found.
pub(crate) struct Normal {
    /// The curvature of half the weighted squared error.
    pub(crate) h: DMatrix<f64>,
    /// The negative of its gradient: where to go.
    pub(crate) g: DVector<f64>,
    /// The covariance of `g`.
    pub(crate) g_covariance: DMatrix<f64>,
    /// What each block contributes to the relative squared error that both renderings see.
    pub(crate) errors: Vec<f64>,
    /// The noise of every group, where there were pixels enough to measure it.
    pub(crate) noise: Vec<Option<GroupNoise>>,
}

/// Pixels whose Jacobians are in memory together, about.
const TILE: usize = 4096;
/// Residuals of more standard deviations than this pull as if they were of so many: a few pixels
/// that the model has no idea of do not rule the rest [Huber 1964].
const HUBER: f32 = 5.0;

/// One pass over `blocks` with `settings.spp` paths a pixel, twice.
pub(crate) fn gather(
    state: &State<'_>,
    unknowns: &Unknowns,
    blocks: &[Block],
    noise: &[GroupNoise],
    settings: &Settings,
) -> Normal {
    let n = unknowns.len();
    let mut sums = Sums::new(n, noise.len());
    let mut g_covariance = DMatrix::zeros(n, n);
    let mut errors = Vec::with_capacity(blocks.len());
    for tile in tiles(blocks) {
        let pass = Pass { state, unknowns, noise, spp: settings.spp };
        let pixels: Vec<u32> = tile.iter().flatten().map(|p| p.seen.pixel).collect();
        let jacobians = [0u64, 1].map(|half| {
            let seed = mix(settings.seed).wrapping_add(half);
            let settings = Settings { seed, ..*settings };
            let (appearance, seen) = (state.appearance(), state.seen.as_ref());
            let asked = &unknowns.parameters;
            state.problem.renderer.jacobian(appearance, &pixels, asked, &settings, seen)
        });
        let starts = tile.iter().scan(0, |next, block| {
            let start = *next;
            *next += block.len();
            Some(start)
        });
        let starts: Vec<usize> = starts.collect();
        let by_block: Vec<Sums> = tile
            .par_iter()
            .zip(starts)
            .map(|(block, start)| pass.block(block, start, &jacobians))
            .collect();
        for block in &by_block {
            g_covariance.syger(1.0, &block.g, &block.g, 1.0);
            errors.push(block.error);
            sums.merge(block);
        }
    }
    let mut h = sums.h;
    h.fill_upper_triangle_with_lower_triangle();
    g_covariance.fill_upper_triangle_with_lower_triangle();
    let noise = sums.noise.iter().map(NoiseSums::measured).collect();
    Normal { h, g: sums.g, g_covariance, errors, noise }
}

/// The blocks in tiles of about [`TILE`] pixels.
fn tiles(blocks: &[Block]) -> Vec<&[Block]> {
    let mut tiles = Vec::new();
    let (mut start, mut pixels) = (0, 0);
    for (i, block) in blocks.iter().enumerate() {
        pixels += block.len();
        if pixels >= TILE || i + 1 == blocks.len() {
            tiles.push(&blocks[start..=i]);
            (start, pixels) = (i + 1, 0);
        }
    }
    tiles
}

/// What all blocks of a pass share.
struct Pass<'a> {
    state: &'a State<'a>,
    unknowns: &'a Unknowns,
    noise: &'a [GroupNoise],
    spp: u32,
}

/// The sums over some pixels; `h` in its lower triangle.
struct Sums {
    h: DMatrix<f64>,
    g: DVector<f64>,
    error: f64,
    noise: Vec<NoiseSums>,
}

impl Sums {
    fn new(unknowns: usize, groups: usize) -> Self {
        Self {
            h: DMatrix::zeros(unknowns, unknowns),
            g: DVector::zeros(unknowns),
            error: 0.0,
            noise: vec![NoiseSums::default(); groups],
        }
    }

    fn merge(&mut self, other: &Self) {
        self.h += &other.h;
        self.g += &other.g;
        self.error += other.error;
        self.noise.iter_mut().zip(&other.noise).for_each(|(sum, other)| sum.merge(other));
    }
}

impl Pass<'_> {
    /// The sums over one block, whose first pixel is number `start` of the Jacobians.
    fn block(&self, block: &Block, start: usize, jacobians: &[Jacobian; 2]) -> Sums {
        let mut sums = Sums::new(self.unknowns.len(), self.noise.len());
        let mut row = Vec::new();
        for (i, pixel) in block.iter().enumerate() {
            let at = start + i;
            let [a, b] = jacobians.each_ref().map(|j| pixel.seen.radiance - j.radiance[at]);
            let noise = &self.noise[pixel.group];
            let variance = noise.variance(&pixel.seen, self.spp);
            let deviations = (0.5 * (a + b)).abs() / variance.map(f32::sqrt);
            let trust = (HUBER / deviations.max_element()).min(1.0);
            sums.noise[pixel.group].add(&pixel.seen, noise, self.spp, a, b);
            let level2 = (pixel.seen.level * pixel.seen.level).max(Rgb::splat(f32::MIN_POSITIVE));
            sums.error += f64::from((trust * a * b / level2).element_sum());
            for channel in 0..3 {
                let photograph = pixel.seen.radiance[channel];
                let place = (at, channel);
                self.unknowns.row(self.state, jacobians, place, photograph, &mut row);
                let weight = f64::from(trust / variance[channel]);
                let residuals = [f64::from(a[channel]), f64::from(b[channel])];
                add_row(&mut sums, &row, weight, residuals);
            }
        }
        sums
    }
}

/// Adds one pixel in one channel: its Jacobian's row under both renderings, and both residuals.
fn add_row(sums: &mut Sums, row: &[(usize, f64, f64)], weight: f64, [ra, rb]: [f64; 2]) {
    for (k, &(i, ai, bi)) in row.iter().enumerate() {
        sums.g[i] += 0.5 * weight * (ai * rb + bi * ra);
        for &(j, aj, bj) in &row[..=k] {
            let (low, high) = (i.max(j), i.min(j));
            sums.h[(low, high)] += 0.5 * weight * (ai * bj + bi * aj);
        }
    }
}
