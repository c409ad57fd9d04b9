//! Robust estimation: inliers and outliers.
//!
//! Least trimmed squares [Rousseeuw and Van Driessen 2006]: many small random subsets each give an
//! initial camera; concentration steps refit it to the pairs with the smallest residuals. Then each
//! pair is tested against the camera of the *other* inliers. For an inlier
//!
//! ```text
//! T = e^T (I + J (J^T J)^-1 J^T)^-1 e / (2 sigma^2)      follows F(2, freedom)
//! ```
//!
//! where `e` is the residual of the pair against the prediction of the others. Pairs above the
//! quantile become outliers, those below it inliers again.

use super::model::{Free, Model, Observed, jacobian};
use super::refine::{Certainty, FINAL, ROUGH, certainty, refine};
use nalgebra::{DMatrix, Vector3};

/// Subsets to draw: with 40 % wrong pairs and 6 per subset, the chance that all contain a wrong one
/// is 10^-3.
const SUBSETS: usize = 150;
/// The largest fraction of outliers.
const WRONG: f64 = 0.4;
/// The number of cameras from subsets that are iterated to convergence.
const FOLLOWED: usize = 6;
const ITERATIONS: usize = 20;
/// The probability that an inlier is rejected.
const CHANCE: f64 = 1e-5;
/// Residuals below this never make an outlier, pixels.
pub(super) const LEAST_SIGMA: f64 = 0.2;
/// Squared residuals of the best 60 % of pairs times this are those of all, for normal errors.
const TRIMMED: f64 = 2.57;
/// The initial inliers: residuals up to this many standard deviations.
const FIRST_SIGMAS: f64 = 3.0;

/// A camera and the pairs that it was fitted to.
#[derive(Clone, Debug)]
pub(super) struct Agreement {
    pub(super) model: Model,
    /// For each pair whether it is an inlier.
    pub(super) inlier: Vec<bool>,
    /// The root mean square residual of the best pairs, pixels.
    pub(super) scale: f64,
}

/// The camera that most of `sights` agree with, and the inliers; none if no camera was found. `starts` gives cameras
/// that may have seen a subset, the best first.
pub(super) fn agree<T: Observed>(
    sights: &[T],
    free: Free,
    seed: u64,
    starts: &dyn Fn(&[T]) -> Vec<Model>,
) -> Option<Agreement> {
    let trimmed = trimmed_fit(sights, free, seed, starts)?;
    let kept = kept_count(sights, free);
    let mean = trimmed_cost(&trimmed, sights, kept) / kept as f64;
    let scale = mean.sqrt();
    let stretch = if kept < sights.len() { TRIMMED } else { 1.0 };
    let equations = (T::ROWS * kept) as f64;
    let freedom = (equations - free.count() as f64).max(1.0);
    let sigma = (stretch * mean * kept as f64 / freedom).sqrt().max(LEAST_SIGMA);
    let distances: Vec<f64> = sights.iter().map(|s| distance(&trimmed, s)).collect();
    let first = distances.iter().map(|d| *d <= FIRST_SIGMAS * sigma).collect();
    let mut now = Agreement { model: trimmed, inlier: first, scale };
    let best = best_pairs(&trimmed, sights, T::fewest(sights, free));
    best.iter().for_each(|index| now.inlier[*index] = true);
    for _ in 0..ITERATIONS {
        let chosen = select(sights, &now.inlier);
        now.model = refine(&now.model, &chosen, free, FINAL);
        let Ok(certainty) = certainty(&now.model, &chosen, free) else { break };
        let next = judge(&now, sights, free, &certainty);
        if next == now.inlier || !T::suffice(&select(sights, &next), free) {
            break;
        }
        now.inlier = next;
    }
    Some(now)
}

/// The inliers.
pub(super) fn select<T: Observed>(sights: &[T], inlier: &[bool]) -> Vec<T> {
    sights.iter().zip(inlier).filter(|(_, b)| **b).map(|(sight, _)| *sight).collect()
}

/// The reprojection error of a pair, pixels; infinite behind the camera.
pub(super) fn distance<T: Observed>(model: &Model, sight: &T) -> f64 {
    if sight.is_in_front(model) { sight.residual(model).norm() } else { f64::INFINITY }
}

fn kept_count<T: Observed>(sights: &[T], free: Free) -> usize {
    let count = sights.len();
    let wrong = (WRONG * count as f64).floor() as usize;
    (count - wrong).max(T::fewest(sights, free)).min(count)
}

/// The indices of the `count` pairs that fit best, the same share of each kind.
fn best_pairs<T: Observed>(model: &Model, sights: &[T], count: usize) -> Vec<usize> {
    let mut order: Vec<(usize, f64, usize)> = sights
        .iter()
        .enumerate()
        .map(|(n, sight)| (sight.kind(), distance(model, sight), n))
        .collect();
    order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    // Which of its kind each is, as a share of them; the best two of each come first.
    let mut ranked: Vec<(f64, usize)> = Vec::with_capacity(order.len());
    for of_one_kind in order.chunk_by(|a, b| a.0 == b.0) {
        let all = of_one_kind.len() as f64;
        let share = |rank: usize| if rank < 2 { 0.0 } else { (rank as f64 + 0.5) / all };
        let rank = |(rank, pair): (usize, &(usize, f64, usize))| (share(rank), pair.2);
        ranked.extend(of_one_kind.iter().enumerate().map(rank));
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    ranked.into_iter().take(count).map(|(_, index)| index).collect()
}

fn trimmed_cost<T: Observed>(model: &Model, sights: &[T], kept: usize) -> f64 {
    let best = best_pairs(model, sights, kept);
    best.into_iter().map(|index| distance(model, &sights[index]).powi(2)).sum()
}

/// One step of concentration: the camera of the pairs that fit best.
fn concentrate<T: Observed>(model: &Model, sights: &[T], kept: usize, free: Free) -> Model {
    let best = best_pairs(model, sights, kept);
    let chosen: Vec<T> = best.into_iter().map(|index| sights[index]).collect();
    refine(model, &chosen, free, ROUGH)
}

fn trimmed_fit<T: Observed>(
    sights: &[T],
    free: Free,
    seed: u64,
    starts: &dyn Fn(&[T]) -> Vec<Model>,
) -> Option<Model> {
    let pose = free.without_lens();
    let kept = kept_count(sights, free);
    let size = T::fewest(sights, pose).min(sights.len());
    let mut random = Random(seed);
    let mut found: Vec<(f64, Model)> = Vec::new();
    let mut subsets = vec![sights.to_vec()];
    if sights.len() > size {
        subsets.extend((0..SUBSETS).map(|_| random.subset(sights, size)));
    }
    for subset in &subsets {
        for start in starts(subset).into_iter().take(2) {
            let next = concentrate(&start, sights, kept, pose);
            found.push((trimmed_cost(&next, sights, kept), next));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(FOLLOWED);
    for (cost, model) in &mut found {
        for _ in 0..ITERATIONS {
            let next = concentrate(model, sights, kept, free);
            let next_cost = trimmed_cost(&next, sights, kept);
            let better = next_cost < 0.999 * *cost;
            if next_cost < *cost {
                (*cost, *model) = (next_cost, next);
            }
            if !better {
                break;
            }
        }
    }
    let best = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    best.0.is_finite().then_some(best.1)
}

/// The pairs whose residual against the prediction of the other inliers is not significant.
fn judge<T: Observed>(
    now: &Agreement,
    sights: &[T],
    free: Free,
    certainty: &Certainty,
) -> Vec<bool> {
    let pairs = sights.iter().zip(&now.inlier);
    pairs.map(|(sight, inlier)| fits(&now.model, sight, *inlier, free, certainty)).collect()
}

fn fits<T: Observed>(
    model: &Model,
    sight: &T,
    inlier: bool,
    free: Free,
    certainty: &Certainty,
) -> bool {
    if !sight.is_in_front(model) {
        return false;
    }
    let residual = sight.residual(model);
    let residual = residual.rows(0, T::ROWS);
    let derivatives = jacobian(model, &[*sight], free, &Vector3::zeros());
    let spread = &derivatives * &certainty.inverse * derivatives.transpose();
    let one = DMatrix::identity(T::ROWS, T::ROWS);
    // An inlier influenced the camera; its residual without that influence is larger.
    let (matrix, freedom) = if inlier {
        (one - spread, certainty.freedom.saturating_sub(T::ROWS))
    } else {
        (one + spread, certainty.freedom)
    };
    // A pair without which the camera is not determined cannot be tested.
    let Some(inverse) = matrix.try_inverse().filter(|_| freedom > 0) else { return inlier };
    let squared = residual.dot(&(inverse * residual));
    let all = certainty.sigma.powi(2) * certainty.freedom as f64;
    let others = if inlier { (all - squared).max(0.0) } else { all };
    let variance = (others / freedom as f64).max(LEAST_SIGMA.powi(2));
    squared / (2.0 * variance) <= greatest_chance(freedom)
}

/// The value that F(2, freedom) exceeds with the probability [`CHANCE`]:
/// `P(F > x) = (1 + 2 x / freedom)^(-freedom / 2)`.
pub(super) fn greatest_chance(freedom: usize) -> f64 {
    let half = 0.5 * freedom as f64;
    half * (CHANCE.powf(-1.0 / half) - 1.0)
}

/// splitmix64 [Steele et al. 2014]: the same subsets for the same seed, on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// One of `0..count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// `size` different elements.
    fn subset<T: Observed>(&mut self, sights: &[T], size: usize) -> Vec<T> {
        let mut left: Vec<T> = sights.to_vec();
        for drawn in 0..size {
            let other = drawn + self.below(left.len() - drawn);
            left.swap(drawn, other);
        }
        left.truncate(size);
        left
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Sight;
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn the_limit_of_chance_nears_that_of_many_pairs() {
        // For many degrees of freedom 2 F is chi-squared with two: P(F > x) = exp(-x).
        assert!((greatest_chance(1_000_000) - (1.0 / CHANCE).ln()).abs() < 1e-3);
        assert!(greatest_chance(2) > 1000.0);
    }

    #[test]
    fn subsets_have_different_elements() {
        let sight =
            |n: usize| Sight { image: Vector2::new(n as f64, 0.0), point: Default::default() };
        let all: Vec<Sight> = (0..7).map(sight).collect();
        let mut random = Random(1);
        let drawn = random.subset(&all, 5);
        for (n, a) in drawn.iter().enumerate() {
            assert!(drawn[..n].iter().all(|b| a.image.x != b.image.x));
        }
        assert_ne!(random.next(), Random(2).next());
    }
}
