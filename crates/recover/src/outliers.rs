//! Outliers: pixels that show something that is not in the model, like the book on the paper's desk
//! [Boivin and Gagalowicz 2002, section 3.2].
//!
//! The paper fits a plane to the values of a flat object. Light is seldom planar, but its shape is
//! known here: what must be flat over a surface is the relative residual under the best uniform
//! hypothesis. Its median is taken over small cells of the picture. Cells that differ from their
//! group, in a few coherent patches, are outliers: the group is fitted again without them, which
//! may show more. A pattern is no outlier: it covers more, or comes in many pieces.
//!
//! What may be an outlier is decided by physics. A reflectance cannot make an isolated dark patch on
//! an evenly lit surface; it can make a bright one where, for some roughness, the surface mirrors
//! something bright. A cell that is brighter than the model is an outlier only where no specular
//! term is large: a highlight that a hypothesis explains only roughly must not be thrown away.
//!
//! In groups of several objects, an object whose residual is further than lambda from the median of
//! all does not count either: the function f of the paper's equation 3.

use crate::evidence::Evidence;
use crate::hypothesis::Fit;
use std::collections::{BTreeMap, BTreeSet};
use unrender_render::GeometryBuffers;
use unrender_scene::color::luminance;

/// Cells in the height of a picture: people and things in a room cover several of them. At half of it small things are
/// missed, at double a cell of a small picture is a pixel.
const CELLS: usize = 85;
/// About how many pixels of a cell are sampled: the median of fewer is noise.
const SAMPLES: usize = 3;
/// A cell may show a highlight where a specular term exceeds its median by this share of its
/// greatest excess in the group.
const HIGHLIGHT: f32 = 0.1;
/// The roughnesses whose highlights are looked for: wider ones are hardly patches.
const ALPHAS: [f32; 3] = [0.02, 0.06, 0.16];
/// A specular term has a highlight if its greatest value is so many times its median.
const PEAK: f32 = 3.0;
/// A cell stands out by this many deviations of its group's cells ...
const DEVIATIONS: f32 = 5.0;
/// ... and by this much at least, relatively.
const LEAST: f32 = 0.05;
/// A cell beside one that stands out joins it at this share of the threshold.
const BESIDE: f32 = 0.4;
/// Outliers cover at most this share of a group.
pub const SHARE_MAX: f32 = 0.2;
/// A patch of outliers has at least this many cells on average; less is a pattern or noise.
const PATCH: f32 = 3.0;

/// A cell of the picture: column and row.
type Cell = (usize, usize);

/// The sampled pixels of a group that show something else, as flags beside `evidence.sample.pixels`; none
/// if `fit` has no such pixels.
pub fn find(
    evidence: &Evidence,
    fit: &Fit,
    geometry: &GeometryBuffers,
    dispersion: f64,
    side: usize,
) -> Option<Vec<bool>> {
    let cell_of = |pixel: u32| cell(pixel, geometry.width(), side);
    let ratios = ratios(evidence, fit);
    let dispersed = dispersed_objects(evidence, &ratios, geometry, dispersion);
    let object = |pixel: u32| geometry.pixels()[pixel as usize].object;
    let mut cells: BTreeMap<Cell, Vec<f32>> = BTreeMap::new();
    for (pixel, ratio) in evidence.sample.pixels.iter().zip(&ratios) {
        if !dispersed.contains(&object(pixel.pixel)) {
            cells.entry(cell_of(pixel.pixel)).or_default().push(*ratio);
        }
    }
    let mut outliers = outlying_cells(&cells);
    let middle = median(cells.values().map(|values| median(values.clone())).collect());
    let highlights = highlights(evidence, &cell_of);
    outliers.retain(|cell| median(cells[cell].clone()) < middle || !highlights.contains(cell));
    let flags: Vec<bool> = evidence
        .sample
        .pixels
        .iter()
        .map(|p| dispersed.contains(&object(p.pixel)) || outliers.contains(&cell_of(p.pixel)))
        .collect();
    flags.iter().any(|flag| *flag).then_some(flags)
}

/// The side of a cell, pixels: a share of the `height` of a photograph, and enough for some sampled pixels, of
/// which there are `sampled` among the `pixels` of the group.
pub fn cell_side(height: usize, pixels: usize, sampled: usize) -> usize {
    let least = (SAMPLES * pixels / sampled.max(1)).isqrt();
    (height / CELLS).max(least).max(2)
}

/// The cell of a pixel.
fn cell(pixel: u32, width: usize, side: usize) -> Cell {
    (pixel as usize % width / side, pixel as usize / width / side)
}

/// The cells in which some roughness would show a highlight.
fn highlights(evidence: &Evidence, cell_of: &dyn Fn(u32) -> Cell) -> BTreeSet<Cell> {
    let mut found = BTreeSet::new();
    for alpha in ALPHAS {
        let [a, b] = evidence.light.lobe(alpha, alpha, 0.0);
        let mut cells: BTreeMap<Cell, (f32, f32)> = BTreeMap::new();
        for (i, pixel) in evidence.sample.pixels.iter().enumerate() {
            let (sum, count) = cells.entry(cell_of(pixel.pixel)).or_default();
            *sum += luminance(a[i] + b[i]);
            *count += 1.0;
        }
        let means: BTreeMap<Cell, f32> =
            cells.into_iter().map(|(cell, (sum, count))| (cell, sum / count)).collect();
        let middle = median(means.values().copied().collect());
        let most = means.values().copied().fold(0.0, f32::max);
        if most > PEAK * middle {
            let high = |mean: f32| mean - middle >= HIGHLIGHT * (most - middle);
            found.extend(means.into_iter().filter(|(_, mean)| high(*mean)).map(|(cell, _)| cell));
        }
    }
    found
}

/// All of `pixels` in the cells of the sampled outliers, and in cells of which no pixel was sampled but
/// of whose sampled neighbours at least half are outliers.
pub fn spread_out(
    sampled: &[u32],
    flags: &[bool],
    pixels: &[u32],
    geometry: &GeometryBuffers,
    side: usize,
) -> Vec<u32> {
    let key = |pixel: u32| cell(pixel, geometry.width(), side);
    let outlier = sampled.iter().zip(flags).filter(|(_, outlier)| **outlier);
    let outliers: BTreeSet<Cell> = outlier.map(|(p, _)| key(*p)).collect();
    let seen: BTreeSet<Cell> = sampled.iter().map(|p| key(*p)).collect();
    let is_outlier = |cell: Cell| {
        let around =
            |cells: &BTreeSet<Cell>| neighbours(cell).filter(|c| cells.contains(c)).count();
        let surrounded = || 2 * around(&outliers) >= around(&seen).max(1);
        outliers.contains(&cell) || (!seen.contains(&cell) && surrounded())
    };
    pixels.iter().copied().filter(|&p| is_outlier(key(p))).collect()
}

/// One plus the relative residual at each sampled pixel, in the channel where it is largest.
fn ratios(evidence: &Evidence, fit: &Fit) -> Vec<f32> {
    let model = evidence.light.radiance(&fit.material);
    let one = |i: usize| {
        let pixel = &evidence.sample.pixels[i];
        let mean = 0.5 * (model[0][i] + model[1][i]);
        let relative = (pixel.radiance - mean) / pixel.level;
        let [r, g, b] = relative.to_array();
        1.0 + [g, b].into_iter().fold(r, |most, c| if c.abs() > most.abs() { c } else { most })
    };
    (0..evidence.sample.pixels.len()).map(one).collect()
}

/// Objects of which the median ratio is further than `dispersion` from the median of all the
/// group's objects, relatively; none if that would be half of the group or more.
fn dispersed_objects(
    evidence: &Evidence,
    ratios: &[f32],
    geometry: &GeometryBuffers,
    dispersion: f64,
) -> BTreeSet<u32> {
    let mut objects: BTreeMap<u32, Vec<f32>> = BTreeMap::new();
    for (pixel, ratio) in evidence.sample.pixels.iter().zip(ratios) {
        objects.entry(geometry.pixels()[pixel.pixel as usize].object).or_default().push(*ratio);
    }
    let medians: BTreeMap<u32, f32> =
        objects.into_iter().map(|(object, values)| (object, median(values))).collect();
    let middle = median(medians.values().copied().collect());
    let far = |m: f32| f64::from((m / middle - 1.0).abs()) > dispersion;
    let far: BTreeSet<u32> = medians.iter().filter(|m| far(*m.1)).map(|m| *m.0).collect();
    if 2 * far.len() < medians.len() { far } else { BTreeSet::new() }
}

/// The cells that stand out in coherent patches: by their medians, or by their means at a patch's edge, where it may
/// cover less than half of a cell.
fn outlying_cells(cells: &BTreeMap<Cell, Vec<f32>>) -> BTreeSet<Cell> {
    let of_cells = |value: fn(&[f32]) -> f32| -> BTreeMap<Cell, f32> {
        cells.iter().map(|(cell, values)| (*cell, value(values))).collect()
    };
    let medians = of_cells(|values| median(values.to_vec()));
    let means = of_cells(|values| values.iter().sum::<f32>() / values.len() as f32);
    let middle = median(medians.values().copied().collect());
    let deviation = 1.4826 * median(medians.values().map(|m| (m - middle).abs()).collect());
    let threshold = (DEVIATIONS * deviation).max(LEAST);
    let beyond = |value: f32, share: f32| (value - middle).abs() > share * threshold;
    let seeds = medians.iter().filter(|(_, median)| beyond(**median, 1.0));
    let seeds: BTreeSet<Cell> = seeds.map(|(cell, _)| *cell).collect();
    let mut outliers = BTreeSet::new();
    for patch in patches(&seeds) {
        if patch.len() as f32 >= PATCH {
            outliers.extend(patch);
        }
    }
    let beside = |cell: &Cell| neighbours(*cell).any(|n| outliers.contains(&n));
    let grown = means.iter().filter(|(cell, mean)| beside(cell) && beyond(**mean, BESIDE));
    let grown: Vec<Cell> = grown.map(|(cell, _)| *cell).collect();
    outliers.extend(grown);
    outliers
}

/// The connected patches of a set of cells.
fn patches(cells: &BTreeSet<Cell>) -> Vec<Vec<Cell>> {
    let mut left = cells.clone();
    let mut patches = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut patch, mut next) = (vec![first], 0);
        while next < patch.len() {
            for neighbour in neighbours(patch[next]) {
                if left.remove(&neighbour) {
                    patch.push(neighbour);
                }
            }
            next += 1;
        }
        patches.push(patch);
    }
    patches
}

fn neighbours((x, y): Cell) -> impl Iterator<Item = Cell> {
    let rows = y.saturating_sub(1)..=y + 1;
    rows.flat_map(move |row| (x.saturating_sub(1)..=x + 1).map(move |col| (col, row)))
}

fn median(mut values: Vec<f32>) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
