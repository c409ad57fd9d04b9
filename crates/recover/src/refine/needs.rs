//! Where the renderings' noise matters, and how the paths of a pass are shared out among the cells.
//!
//! It may have a share of a number's variance, or what is below what anyone would ask for (`precise_enough`):
//! more paths than that bring a result no nearer to the truth. What a number lacks goes where its noise comes from
//! ([`super::origins`]), by `sqrt(a_c)` [Neyman 1934], which is not always its own group.

use super::blocks;
use super::means::Mean;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::sample_budget::TOGETHER;
use crate::state::State;
use nalgebra::{DMatrix, DVector};

/// Paths a pixel that a cell gets in a pass. The least is a full set of the sampler, which a cell that lacks nothing
/// gets when numbers have moved; double of it was not tried. The most is what a small highlight may take.
const SPP: [f64; 2] = [16.0, 1024.0];
/// The renderings may have this share of a number's variance. At half of it twice the paths are traced, for
/// standard deviations that are a tenth smaller; double of it makes them half as large again.
const RENDERING_SHARE: f64 = 0.35;
/// What the renderings' noise does not explain of a variance is taken as less by so many of its standard deviations: few
/// cells of heavy noise may look like it. At half of it the roughness of a thing in a room ends a third more uncertain; double
/// was not tried.
const DOUBTS: f64 = 2.0;
/// A pass makes the renderings' part of a variance so many times less at most: what is allowed is known better then.
const TIMES_MAX: f64 = 4.0;
/// So often an interval is halved in the search for how many paths are enough.
const HALVINGS: usize = 60;

/// How many paths a pixel each cell needs in the next pass, about `mean_spp` a pixel of the whole picture at most; none
/// where no number lacks any. What the lights and the camera lack, all cells do. Where a number has `moved` by more than
/// its standard deviation, all cells are looked at again from there: what they showed was carried along a straight line.
/// `variances` are those of all noise, of the renderings' alone, and how uncertain the difference is; `seen` is what each
/// cell showed so far, and `origins` the variance of every number by one path there.
pub(super) fn of(
    state: &State<'_>,
    (unknowns, effort): (&Unknowns, Effort),
    (covariance, rendering, doubt): (&DMatrix<f64>, &DVector<f64>, &DVector<f64>),
    moved: &[f64],
    (seen, origins): (&[Mean], &[DVector<f64>]),
    mean_spp: u32,
) -> Vec<u32> {
    let has_moved = moved.iter().any(|moved| *moved > 1.0);
    let mut wanted = vec![if has_moved { SPP[0] } else { 0.0 }; seen.len()];
    let mut numbers: Vec<Vec<f64>> = Vec::new();
    for (k, u) in unknowns.list.iter().enumerate() {
        let block = blocks::of(u.quantity);
        let precise = effort.deviation(block.precise_enough(state, u)).powi(2);
        let other = (covariance[(k, k)] - rendering[k] - DOUBTS * doubt[k]).max(0.0);
        let allowed = (RENDERING_SHARE / (1.0 - RENDERING_SHARE) * other).max(precise);
        let times = (rendering[k] / allowed).min(TIMES_MAX);
        if times > 1.0 && block.is_nuisance() {
            let more = seen.iter().map(|cell| (times - 1.0) * cell.paths);
            wanted.iter_mut().zip(more).for_each(|(wanted, more)| *wanted = wanted.max(more));
        } else if times > 1.0 {
            numbers.push(shares(seen, origins.iter().map(|of_cell| of_cell[k]), times));
        }
    }
    let most = f64::from(mean_spp) * seen.iter().map(|cell| cell.pixels).sum::<f64>();
    let cells: Vec<[f64; 2]> = seen.iter().map(|cell| [cell.pixels, cell.paths]).collect();
    let more = where_it_comes_from(&cells, &numbers, most);
    wanted.iter_mut().zip(more).for_each(|(wanted, more)| *wanted = wanted.max(more));
    allocate(&cells, &wanted, most, if has_moved { SPP[0] } else { 0.0 })
}

/// For each cell: the variance of a number by one path there (`by_path`), in units of what is allowed for all of its
/// variance, which is so many `times` as large now.
fn shares(seen: &[Mean], by_path: impl Iterator<Item = f64> + Clone, times: f64) -> Vec<f64> {
    let paths = |cell: &Mean| cell.pixels * cell.paths;
    let now: f64 = seen.iter().zip(by_path.clone()).map(|(cell, by)| by / paths(cell)).sum();
    by_path.map(|by| times * by / now.max(f64::MIN_POSITIVE)).collect()
}

/// How many paths a pixel more cells need, of which each has `[pixels, paths a pixel]`, for the variances of the
/// `numbers` to be what is allowed, or as near to it as so many paths bring their sum at `most`.
fn where_it_comes_from(cells: &[[f64; 2]], numbers: &[Vec<f64>], most: f64) -> Vec<f64> {
    let root = |cell: usize| numbers.iter().map(|shares| shares[cell]).sum::<f64>().sqrt();
    let roots: Vec<f64> = (0..cells.len()).map(root).collect();
    let more = |scale: f64| -> Vec<f64> {
        let of_cell = |([pixels, paths], root): (&[f64; 2], &f64)| {
            (scale * root / pixels - paths).clamp(0.0, SPP[1])
        };
        cells.iter().zip(&roots).map(of_cell).collect()
    };
    let is_enough = |more: &[f64]| {
        let with = cells.iter().zip(more).map(|([pixels, paths], more)| pixels * (paths + more));
        let with: Vec<f64> = with.collect();
        let left = |shares: &Vec<f64>| shares.iter().zip(&with).map(|(s, n)| s / n).sum::<f64>();
        let paths: f64 = cells.iter().zip(more).map(|([pixels, _], more)| pixels * more).sum();
        paths >= most || numbers.iter().all(|shares| left(shares) <= 1.0)
    };
    let least = roots.iter().copied().filter(|root| *root > 0.0).fold(f64::INFINITY, f64::min);
    let mut range = [0.0, (SPP[1] + cells.iter().map(|c| c[0] * c[1]).fold(0.0, f64::max)) / least];
    if !range[1].is_finite() {
        return vec![0.0; cells.len()];
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(is_enough(&more(middle)))] = middle;
    }
    more(range[1])
}

/// The `wanted` paths a pixel and `least` of them, all by the same factor fewer where they are more than `most` in all;
/// in full sets of the sampler.
fn allocate(cells: &[[f64; 2]], wanted: &[f64], most: f64, least: f64) -> Vec<u32> {
    let clamped = |wanted: &f64| wanted.min(SPP[1]);
    let total: f64 = cells.iter().zip(wanted).map(|([n, _], wanted)| n * clamped(wanted)).sum();
    let share = (most / total.max(f64::MIN_POSITIVE)).min(1.0);
    let together = f64::from(TOGETHER);
    let sets = |wanted: &f64| ((share * clamped(wanted)).max(least) / together).round() as u32;
    wanted.iter().map(|wanted| sets(wanted) * TOGETHER).collect()
}
