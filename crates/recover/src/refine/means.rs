//! One pass over the photograph: residuals and Jacobians, each rendered twice, as means over the
//! pixels of a group in a block.
//!
//! The Jacobian of one pixel is mostly noise: that of a wall by the roughness of the floor comes
//! from rare paths. A least-squares fit multiplies it with the residual, and noise times noise
//! dominates the sum. Over a block both change little, while their noise falls by the number of its
//! pixels; and the means of all blocks fit into memory where the Jacobians of all pixels would not:
//! only some thousand pixels' are there at a time.

use super::sample::Cell;
use super::unknowns::Unknowns;
use crate::guess::Guess;
use crate::observe::blocks::Place;
use crate::observe::model_error::{followed, level2};
use crate::observe::observation::Noise;
use crate::observe::photometric::PhotometricParameter;
use crate::observe::sample::Observed;
use glam::Vec3;
use nalgebra::DVector;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use unrender_render::sampler::mix;
use unrender_render::{Jacobian, Query, Settings};
use unrender_scene::Rgb;

/// What one cell shows on the mean.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Mean {
    pub(crate) group: usize,
    pub(crate) place: Place,
    /// As [`Cell::point`].
    pub(crate) point: Option<Vec3>,
    /// Whether the photograph is only known to be at least so bright there.
    pub(crate) bound: bool,
    /// Pixels in the mean.
    pub(crate) pixels: f64,
    /// Paths a pixel in each of the two renderings.
    pub(crate) paths: f64,
    /// Photograph minus rendering, for each of the two renderings.
    pub(crate) residuals: [Rgb; 2],
    /// The mean of both renderings.
    pub(crate) light: Rgb,
    /// The noise of one pixel of the photograph.
    noise: Noise,
    /// The variance of the photograph's noise, at the model's brightness.
    pub(crate) variance: Rgb,
    /// What model errors are relative to, squared, at the model's brightness.
    pub(crate) level2: Rgb,
    /// The same of the brighter one of model and photograph.
    pub(crate) brighter2: Rgb,
    /// For each channel: the unknowns on which the rendering depends, and its derivative by them in
    /// each of the two renderings.
    pub(crate) rows: [Vec<(usize, f64, f64)>; 3],
}

/// About how many pixels' Jacobians are in memory together.
const TILE: usize = 4096;

/// One pass over `cells`, with the paths numbered `samples` for each of their pixels, twice.
pub(crate) fn gather(
    guess: &Guess<'_>,
    unknowns: &Unknowns,
    cells: &[Cell],
    samples: &[Range<u32>],
    settings: &Settings,
) -> Vec<Mean> {
    of_tiles(guess, unknowns, cells, samples, |_, tile| {
        let all = || cells[tile.clone()].iter().zip(&samples[tile.clone()]);
        let of_cell = |(cell, samples): (&Cell, &Range<u32>)| -> Vec<(u32, Range<u32>)> {
            cell.pixels.iter().map(|seen| (seen.pixel, samples.clone())).collect()
        };
        let pixels: Vec<(u32, Range<u32>)> = all().flat_map(of_cell).collect();
        halves(settings).map(|settings| {
            guess.problem.renderer.jacobian(&Query {
                parameters: &unknowns.parameters,
                seen: guess.seen.as_deref(),
                ..Query::new(guess.appearance(), &pixels, &settings)
            })
        })
    })
}

/// The settings of the two renderings.
pub(super) fn halves(settings: &Settings) -> [Settings; 2] {
    [0u64, 1].map(|half| Settings { seed: mix(settings.seed).wrapping_add(half), ..*settings })
}

/// One pass over `cells`, with the paths numbered `samples` for each of their pixels, from the Jacobians that `of_tile`
/// finds for each of their [`tiles`].
pub(super) fn of_tiles(
    guess: &Guess<'_>,
    unknowns: &Unknowns,
    cells: &[Cell],
    samples: &[Range<u32>],
    of_tile: impl Fn(usize, &Range<usize>) -> [Jacobian; 2],
) -> Vec<Mean> {
    let mut means = Vec::with_capacity(cells.len());
    for (index, tile) in tiles(cells).iter().enumerate() {
        let jacobians = of_tile(index, tile);
        let cells = &cells[tile.clone()];
        let next = |next: &mut usize, cell: &Cell| {
            *next += cell.pixels.len();
            Some(*next - cell.pixels.len())
        };
        let starts: Vec<usize> = cells.iter().scan(0, next).collect();
        let paths = samples[tile.clone()].par_iter().map(|samples| samples.len() as f64);
        let of_cell = |((cell, paths), start): ((&Cell, f64), usize)| {
            mean(guess, unknowns, (cell, paths), start, &jacobians)
        };
        means.par_extend(cells.par_iter().zip(paths).zip(starts).map(of_cell));
    }
    take_levels(&mut means);
    means
}

/// The brightness of the renderings of the groups `of` relative to the photograph; one in a channel in which either is
/// black.
pub(super) fn brightness(means: &[Mean], of: impl Fn(usize) -> bool) -> Rgb {
    let mut shown = LocalSums::default();
    means.iter().filter(|mean| !mean.bound && of(mean.group)).for_each(|mean| shown.add(mean));
    let [light, photograph] = shown.means();
    let both = light.cmpgt(Rgb::ZERO) & photograph.cmpgt(Rgb::ZERO);
    Rgb::select(both, light / photograph, Rgb::ONE)
}

/// Takes the noise and the levels of all cells at the model's brightness: the mean of the renderings
/// over a cell and those around it, so that a rendering which happens to be dark gains no weight. They
/// follow a model that is brighter than the photograph no further than [`followed`] says.
fn take_levels(means: &mut [Mean]) {
    let mut groups: BTreeMap<usize, LocalSums> = BTreeMap::new();
    let mut cells: BTreeMap<(usize, Place), LocalSums> = BTreeMap::new();
    for mean in means.iter() {
        groups.entry(mean.group).or_default().add(mean);
        cells.entry((mean.group, mean.place)).or_default().add(mean);
    }
    for mean in means {
        let near = mean.place.around().filter_map(|place| cells.get(&(mean.group, place)));
        let [local, shown] = near.fold(LocalSums::default(), |sum, cell| sum.and(cell)).means();
        let [group, group_shown] = groups[&mean.group].means();
        let bright = level2(group.max(group_shown), local.max(shown));
        mean.brighter2 = mean.place.fine_blocks() * bright;
        let (group, local) = followed((group, local), (group_shown, shown));
        mean.level2 = mean.place.fine_blocks() * level2(group, local);
        mean.variance = mean.noise.variance(local) / mean.pixels as f32;
    }
}

/// What some cells show: sums over their pixels.
#[derive(Clone, Copy, Default)]
struct LocalSums {
    light: Rgb,
    photograph: Rgb,
    pixels: f32,
}

impl LocalSums {
    fn add(&mut self, mean: &Mean) {
        let pixels = mean.pixels as f32;
        let residual = 0.5 * (mean.residuals[0] + mean.residuals[1]);
        self.light += pixels * mean.light;
        self.photograph += pixels * (mean.light + residual);
        self.pixels += pixels;
    }

    fn and(self, other: &Self) -> Self {
        Self {
            light: self.light + other.light,
            photograph: self.photograph + other.photograph,
            pixels: self.pixels + other.pixels,
        }
    }

    /// The means of the model's light and of the photograph.
    fn means(&self) -> [Rgb; 2] {
        [self.light, self.photograph].map(|sum| sum / self.pixels.max(1.0))
    }
}

/// Adds what a pass found to the average of those before, cell by cell; each counts by its paths.
pub(crate) fn average(average: &mut Vec<Mean>, found: Vec<Mean>) {
    if average.is_empty() {
        *average = found;
        return;
    }
    average.iter_mut().zip(found).for_each(|(mean, found)| mean.add(&found));
}

/// What both renderings leave of the photograph, root mean square over pixels and channels, as shares of the brighter one of
/// photograph and rendering: of a black rendering one, however dark the photograph is.
pub(crate) struct RelativeErrors {
    /// That of all pixels.
    pub(crate) all: f64,
    /// Those of the groups; none without cells.
    pub(crate) of_groups: Vec<Option<f64>>,
}

impl RelativeErrors {
    /// Those of `groups` groups.
    pub(crate) fn of(means: &[Mean], groups: usize) -> Self {
        let mut sums = vec![(0.0f64, 0.0f64); groups];
        for mean in means {
            let [a, b] = mean.residuals;
            let (left, pixels) = &mut sums[mean.group];
            *left += f64::from((a * b / mean.brighter2).element_sum()) / 3.0 * mean.pixels;
            *pixels += mean.pixels;
        }
        let relative = |(left, pixels): (f64, f64)| (left / pixels).max(0.0).sqrt();
        let all = sums.iter().fold((0.0, 0.0), |all, of| (all.0 + of.0, all.1 + of.1));
        let of_groups = sums.into_iter().map(|of| (of.1 > 0.0).then(|| relative(of))).collect();
        Self { all: relative((all.0, all.1.max(1.0))), of_groups }
    }
}

impl Mean {
    fn add(&mut self, other: &Self) {
        let paths = self.paths + other.paths;
        let (mine, theirs) = (self.paths / paths, other.paths / paths);
        for (residual, other) in self.residuals.iter_mut().zip(other.residuals) {
            *residual = *residual * mine as f32 + other * theirs as f32;
        }
        for (row, other) in self.rows.iter_mut().zip(&other.rows) {
            let mut all: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
            for (share, row) in [(mine, &*row), (theirs, other)] {
                for &(k, a, b) in row {
                    let sum = all.entry(k).or_default();
                    *sum = (sum.0 + share * a, sum.1 + share * b);
                }
            }
            *row = all.into_iter().map(|(k, (a, b))| (k, a, b)).collect();
        }
        self.paths = paths;
    }

    /// Extrapolates the residuals to where the unknowns move by `step`.
    pub(crate) fn move_by(&mut self, step: &DVector<f64>) {
        for (channel, row) in self.rows.iter().enumerate() {
            for &(k, a, b) in row {
                self.residuals[0][channel] -= (a * step[k]) as f32;
                self.residuals[1][channel] -= (b * step[k]) as f32;
            }
        }
    }
}

/// The cells in tiles of about [`TILE`] pixels.
pub(super) fn tiles(cells: &[Cell]) -> Vec<Range<usize>> {
    let mut tiles = Vec::new();
    let (mut start, mut pixels) = (0, 0);
    for (place, cell) in cells.iter().enumerate() {
        pixels += cell.pixels.len();
        if pixels >= TILE || place + 1 == cells.len() {
            tiles.push(start..place + 1);
            (start, pixels) = (place + 1, 0);
        }
    }
    tiles
}

/// The mean over a cell, whose first pixel is number `start` of the Jacobians.
fn mean(
    guess: &Guess<'_>,
    unknowns: &Unknowns,
    (cell, paths): (&Cell, f64),
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
    let change = |c: &PhotometricParameter| {
        let change = over(&|p| guess.exposure * c.change(&guess.observation, p.pixel));
        Rgb::select(photograph.cmpgt(Rgb::ZERO), change / photograph, Rgb::ZERO)
    };
    let changes: Vec<Rgb> = guess.problem.photometric_parameters.iter().map(change).collect();
    let mut residuals = radiance.map(|radiance| photograph - radiance);
    let light = 0.5 * (radiance[0] + radiance[1]);
    // A clipped pixel has no residual where the model is brighter.
    let asks = |channel: usize| !cell.bound || light[channel] < photograph[channel];
    let met = Rgb::from_array([0, 1, 2].map(|c| f32::from(u8::from(asks(c)))));
    residuals.iter_mut().for_each(|residual| *residual *= met);
    Mean {
        group: cell.group,
        place: cell.place,
        point: cell.point,
        bound: cell.bound,
        pixels: f64::from(n),
        paths,
        residuals,
        light,
        noise: Noise { base: over(&|p| p.noise.base), slope: over(&|p| p.noise.slope) },
        variance: Rgb::ZERO,
        level2: Rgb::ONE,
        brighter2: Rgb::ONE,
        rows: [0, 1, 2].map(|channel| {
            if !asks(channel) {
                return Vec::new();
            }
            let radiance = radiance.map(|radiance| f64::from(radiance[channel]));
            unknowns.row(guess, (&derivatives, &changes, cell.place.photograph), channel, radiance)
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell of `group` that shows `photograph` where renderings show `light`.
    fn cell(group: usize, pixels: f64, photograph: f32, light: f32) -> Mean {
        Mean {
            group,
            place: Place::default(),
            point: None,
            bound: false,
            pixels,
            paths: 1.0,
            residuals: [Rgb::splat(photograph - light); 2],
            light: Rgb::splat(light),
            noise: Noise { base: Rgb::ZERO, slope: Rgb::ZERO },
            variance: Rgb::ZERO,
            level2: Rgb::ONE,
            brighter2: Rgb::ONE,
            rows: Default::default(),
        }
    }

    #[test]
    fn where_photograph_or_rendering_is_black_all_is_left_whatever_the_brightness() {
        for dark in [1.0, 1e-3, 1e-6] {
            for [photograph, light] in [[dark, 0.0], [0.0, dark]] {
                let mut cells = [cell(0, 99.0, 1.0, 0.9), cell(1, 1.0, photograph, light)];
                take_levels(&mut cells);
                let errors = RelativeErrors::of(&cells, 2);
                assert!((errors.of_groups[1].unwrap() - 1.0).abs() < 1e-5);
                assert!((errors.all - (0.99 * 0.01 + 0.01f64).sqrt()).abs() < 1e-5);
            }
        }
    }
}
