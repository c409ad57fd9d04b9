//! Where the renderings' noise matters, and how the paths of a pass are allocated to the cells.
//!
//! It may have a share of a number's variance, or be as small as is enough (`precise_enough`): more paths bring a
//! result no nearer to the truth. The paths that a number lacks go where its noise comes from ([`super::origins`]), by
//! `sqrt(a_c)` [Neyman 1934], which is not always its own group.

use super::means::Mean;
use super::parameters;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::guess::Guess;
use crate::sample_budget::TOGETHER;
use nalgebra::{DMatrix, DVector};

/// Paths a pixel that a cell gets in a pass, at most: what a small highlight may take. At a quarter of it the paths
/// that one lacks go to cells that need none; double was not tried.
const SPP_MAX: f64 = 1024.0;
/// The renderings may have this share of a number's variance. At half of it twice the paths are traced, for
/// standard deviations that are a tenth smaller; double of it makes them half as large again.
const RENDERING_SHARE: f64 = 0.35;
/// The part of a variance that the renderings' noise does not explain counts less so many of its standard deviations:
/// few cells of heavy noise may look like it. At half of it the roughness of an object in a room ends a third more
/// uncertain; double was not tried.
const DOUBTS: f64 = 2.0;
/// A pass reduces the renderings' part of a variance at most by this factor: what is allowed is known better then.
/// Without it, and with a quarter of [`SPP_MAX`], passes of the room with seed 881000 never ended before their limit;
/// half and double were not tried.
const TIMES_MAX: f64 = 4.0;
/// How often an interval is halved in the search for how many paths are enough: to the last digit. At half of it they
/// are known to a billionth; double of it changes nothing.
const HALVINGS: usize = 60;

/// How many paths a pixel each cell needs in the next pass, about `mean_spp` a pixel of the whole picture at most; none
/// where no number lacks any. Paths that the lights and the camera lack go to all cells. Where none are lacking and a
/// number has `moved` by more than its standard deviation, all cells are rendered again: their residuals were
/// extrapolated linearly. `covariance` is that of all noise, `rendering` the variances by the renderings' alone,
/// `doubt` the uncertainty of the difference; `seen` is what each cell showed so far, and `origins` the variance of
/// every number by one path there.
pub(super) fn of(
    guess: &Guess<'_>,
    (unknowns, effort): (&Unknowns, Effort),
    (covariance, rendering, doubt): (&DMatrix<f64>, &DVector<f64>, &DVector<f64>),
    moved: &[f64],
    (seen, origins): (&[Mean], &[DVector<f64>]),
    mean_spp: u32,
) -> Vec<u32> {
    let has_moved = moved.iter().any(|moved| *moved > 1.0);
    let mut wanted = vec![0.0f64; seen.len()];
    let mut numbers: Vec<Vec<f64>> = Vec::new();
    for (k, u) in unknowns.list.iter().enumerate() {
        let kind = parameters::of(u.quantity);
        let precise = effort.deviation(kind.precise_enough(guess, u)).powi(2);
        let other = (covariance[(k, k)] - rendering[k] - DOUBTS * doubt[k]).max(0.0);
        let allowed = (RENDERING_SHARE / (1.0 - RENDERING_SHARE) * other).max(precise);
        let times = (rendering[k] / allowed).min(TIMES_MAX);
        if times > 1.0 && kind.is_nuisance() {
            let more = seen.iter().map(|cell| (times - 1.0) * cell.paths);
            wanted.iter_mut().zip(more).for_each(|(wanted, more)| *wanted = wanted.max(more));
        } else if times > 1.0 {
            numbers.push(shares(seen, origins.iter().map(|of_cell| of_cell[k]), times));
        }
    }
    let most = f64::from(mean_spp) * seen.iter().map(|cell| cell.pixels).sum::<f64>();
    let cells: Vec<[f64; 2]> = seen.iter().map(|cell| [cell.pixels, cell.paths]).collect();
    let more = by_origin(&cells, &numbers, most);
    wanted.iter_mut().zip(more).for_each(|(wanted, more)| *wanted = wanted.max(more));
    let paths = allocate(&cells, &wanted, most);
    let lacks_none = paths.iter().all(|paths| *paths == 0);
    if has_moved && lacks_none { vec![TOGETHER; cells.len()] } else { paths }
}

/// For each cell: the variance of a number by one path there (`by_path`), in units of the allowed total variance; the
/// present total is so many `times` as large.
fn shares(seen: &[Mean], by_path: impl Iterator<Item = f64> + Clone, times: f64) -> Vec<f64> {
    let paths = |cell: &Mean| cell.pixels * cell.paths;
    let now: f64 = seen.iter().zip(by_path.clone()).map(|(cell, by)| by / paths(cell)).sum();
    by_path.map(|by| times * by / now.max(f64::MIN_POSITIVE)).collect()
}

/// How many more paths a pixel the `cells`, each with `[pixels, paths a pixel]`, need for the variances of the
/// `numbers` to be what is allowed, or for their sum to be as small as `most` paths make it.
fn by_origin(cells: &[[f64; 2]], numbers: &[Vec<f64>], most: f64) -> Vec<f64> {
    let root = |cell: usize| numbers.iter().map(|shares| shares[cell]).sum::<f64>().sqrt();
    let roots: Vec<f64> = (0..cells.len()).map(root).collect();
    let more = |scale: f64| -> Vec<f64> {
        let of_cell = |([pixels, paths], root): (&[f64; 2], &f64)| {
            (scale * root / pixels - paths).clamp(0.0, SPP_MAX)
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
    let with_most = |[pixels, paths]: &[f64; 2]| pixels * (paths + SPP_MAX);
    let mut range = [0.0, cells.iter().map(with_most).fold(0.0, f64::max) / least];
    if !range[1].is_finite() {
        return vec![0.0; cells.len()];
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (range[0] + range[1]);
        range[usize::from(is_enough(&more(middle)))] = middle;
    }
    more(range[1])
}

/// The `wanted` paths a pixel, all reduced by the same factor if they are more than `most` in all; in full sets of the
/// sampler.
fn allocate(cells: &[[f64; 2]], wanted: &[f64], most: f64) -> Vec<u32> {
    let clamped = |wanted: &f64| wanted.min(SPP_MAX);
    let total: f64 = cells.iter().zip(wanted).map(|([n, _], wanted)| n * clamped(wanted)).sum();
    let share = (most / total.max(f64::MIN_POSITIVE)).min(1.0);
    let together = f64::from(TOGETHER);
    let sets = |wanted: &f64| (share * clamped(wanted) / together).round() as u32;
    wanted.iter().map(|wanted| sets(wanted) * TOGETHER).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance of a number with these `shares` after `more` paths, in units of what is allowed.
    fn left(cells: &[[f64; 2]], shares: &[f64], more: &[f64]) -> f64 {
        let with = cells.iter().zip(more).map(|([pixels, paths], more)| pixels * (paths + more));
        shares.iter().zip(with).map(|(share, paths)| share / paths).sum()
    }

    #[test]
    fn paths_go_where_the_noise_comes_from() {
        // 64 paths in each of four cells of 10 pixels; the first has sixteen times the noise of the others.
        let cells = [[10.0, 64.0]; 4];
        let shares: Vec<f64> = [16.0, 1.0, 1.0, 1.0].map(|noise| noise * 640.0 / 19.0 * 2.0).into();
        assert!((left(&cells, &shares, &[0.0; 4]) - 2.0).abs() < 1e-9);
        let more = by_origin(&cells, std::slice::from_ref(&shares), f64::INFINITY);
        // What is allowed is reached and not more, and only where the noise comes from.
        assert!((left(&cells, &shares, &more) - 1.0).abs() < 1e-3, "{more:?}");
        assert!(more[0] > 64.0 && more[1..].iter().all(|more| *more == 0.0), "{more:?}");
        // Without enough paths, all there are; cells with the same noise get the same.
        let even = vec![6400.0; 4];
        let more = by_origin(&cells, &[even], 800.0);
        assert!(more.iter().all(|more| (more - 20.0).abs() < 0.1), "{more:?}");
        // A fourth of the variance takes four times the paths.
        let more = by_origin(&[[64.0, 16.0]; 4], &[vec![4.0 * 256.0; 4]], f64::INFINITY);
        assert!(more.iter().all(|more| (more - 48.0).abs() < 0.1), "{more:?}");
        // No number lacks any.
        assert_eq!(by_origin(&cells, &[], 800.0), [0.0; 4]);
    }

    #[test]
    fn no_other_sharing_out_leaves_less_noise() {
        let cells = [[64.0, 32.0], [20.0, 32.0], [64.0, 32.0], [3.0, 32.0]];
        let shares = vec![900.0, 4000.0, 100.0, 50.0];
        let more = by_origin(&cells, std::slice::from_ref(&shares), 4000.0);
        let least = left(&cells, &shares, &more);
        // Moving paths from one cell to another makes it no better.
        for (from, to) in (0..4).flat_map(|from| (0..4).map(move |to| (from, to))) {
            let mut moved = more.clone();
            let paths = (0.05 * more[from] * cells[from][0]).min(20.0);
            moved[from] -= paths / cells[from][0];
            moved[to] += paths / cells[to][0];
            assert!(left(&cells, &shares, &moved) >= least * (1.0 - 1e-6), "{from} to {to}");
        }
    }

    #[test]
    fn paths_come_in_full_sets() {
        let cells = [[1000.0, 0.0], [1000.0, 0.0], [10.0, 0.0], [500.0, 0.0]];
        let most = 32.0 * 2510.0;
        // What is wanted is given to the nearest set, and no more.
        assert_eq!(allocate(&cells, &[30.0, 0.0, 16.0, 3.0], most), [32, 0, 16, 0]);
        // A small one takes no more than makes sense; where it is too much, all get fewer.
        assert_eq!(allocate(&cells, &[0.0, 0.0, 5000.0, 0.0], most), [0, 0, 1024, 0]);
        assert_eq!(allocate(&cells, &[160.0, 80.0, 0.0, 0.0], most), [48, 32, 0, 0]);
    }
}
