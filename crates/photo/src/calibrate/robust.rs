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

use super::model::{Free, Model, Sight, jacobian};
use super::refine::{Certainty, FINAL, ROUGH, certainty, refine};
use super::start::starts;
use nalgebra::{Matrix2, Vector2, Vector3};

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

/// The camera that most of `sights` agree with, and the inliers; none if no camera was found.
pub(super) fn agree(sights: &[Sight], focals: &[f64], free: Free, seed: u64) -> Option<Agreement> {
    let trimmed = trimmed_fit(sights, focals, free, seed)?;
    let kept = kept_count(sights.len(), free);
    let mean = trimmed_cost(&trimmed, sights, kept) / kept as f64;
    let scale = mean.sqrt();
    let stretch = if kept < sights.len() { TRIMMED } else { 1.0 };
    let equations = (2 * kept) as f64;
    let freedom = (equations - free.count() as f64).max(1.0);
    let sigma = (stretch * mean * kept as f64 / freedom).sqrt().max(LEAST_SIGMA);
    let distances: Vec<f64> = sights.iter().map(|s| distance(&trimmed, s)).collect();
    let first = distances.iter().map(|d| *d <= FIRST_SIGMAS * sigma).collect();
    let mut now = Agreement { model: trimmed, inlier: first, scale };
    let best = best_pairs(&trimmed, sights, free.fewest_pairs());
    best.iter().for_each(|index| now.inlier[*index] = true);
    for _ in 0..ITERATIONS {
        let chosen = select(sights, &now.inlier);
        now.model = refine(&now.model, &chosen, free, FINAL);
        let Ok(certainty) = certainty(&now.model, &chosen, free) else { break };
        let next = judge(&now, sights, free, &certainty);
        let enough = next.iter().filter(|b| **b).count() >= free.fewest_pairs();
        if next == now.inlier || !enough {
            break;
        }
        now.inlier = next;
    }
    Some(now)
}

/// The inliers.
pub(super) fn select(sights: &[Sight], inlier: &[bool]) -> Vec<Sight> {
    sights.iter().zip(inlier).filter(|(_, b)| **b).map(|(sight, _)| *sight).collect()
}

/// The reprojection error of a pair, pixels; infinite behind the camera.
pub(super) fn distance(model: &Model, sight: &Sight) -> f64 {
    if model.sees(sight) { model.residual(sight).norm() } else { f64::INFINITY }
}

fn kept_count(count: usize, free: Free) -> usize {
    let wrong = (WRONG * count as f64).floor() as usize;
    (count - wrong).max(free.fewest_pairs()).min(count)
}

/// The indices of the `count` pairs that fit best.
fn best_pairs(model: &Model, sights: &[Sight], count: usize) -> Vec<usize> {
    let mut order: Vec<(f64, usize)> =
        sights.iter().enumerate().map(|(n, sight)| (distance(model, sight), n)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().take(count).map(|(_, index)| index).collect()
}

fn trimmed_cost(model: &Model, sights: &[Sight], kept: usize) -> f64 {
    let best = best_pairs(model, sights, kept);
    best.into_iter().map(|index| distance(model, &sights[index]).powi(2)).sum()
}

/// One step of concentration: the camera of the pairs that fit best.
fn concentrate(model: &Model, sights: &[Sight], kept: usize, free: Free) -> Model {
    let best = best_pairs(model, sights, kept);
    let chosen: Vec<Sight> = best.into_iter().map(|index| sights[index]).collect();
    refine(model, &chosen, free, ROUGH)
}

fn trimmed_fit(sights: &[Sight], focals: &[f64], free: Free, seed: u64) -> Option<Model> {
    let pose = free.without_lens();
    let kept = kept_count(sights.len(), free);
    let size = pose.fewest_pairs().min(sights.len());
    let mut random = Random(seed);
    let mut found: Vec<(f64, Model)> = Vec::new();
    let mut subsets = vec![sights.to_vec()];
    if sights.len() > size {
        subsets.extend((0..SUBSETS).map(|_| random.subset(sights, size)));
    }
    for subset in &subsets {
        for start in starts(subset, focals, pose).into_iter().take(2) {
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
fn judge(now: &Agreement, sights: &[Sight], free: Free, certainty: &Certainty) -> Vec<bool> {
    let pairs = sights.iter().zip(&now.inlier);
    pairs.map(|(sight, inlier)| fits(&now.model, sight, *inlier, free, certainty)).collect()
}

fn fits(model: &Model, sight: &Sight, inlier: bool, free: Free, certainty: &Certainty) -> bool {
    if !model.sees(sight) {
        return false;
    }
    let residual: Vector2<f64> = model.residual(sight);
    let derivatives = jacobian(model, &[*sight], free, &Vector3::zeros());
    let spread = &derivatives * &certainty.inverse * derivatives.transpose();
    let spread: Matrix2<f64> = spread.fixed_view::<2, 2>(0, 0).into_owned();
    // An inlier influenced the camera; its residual without that influence is larger.
    let (matrix, freedom) = if inlier {
        (Matrix2::identity() - spread, certainty.freedom.saturating_sub(2))
    } else {
        (Matrix2::identity() + spread, certainty.freedom)
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
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// `size` different elements.
    fn subset(&mut self, sights: &[Sight], size: usize) -> Vec<Sight> {
        let mut left: Vec<Sight> = sights.to_vec();
        for drawn in 0..size {
            let other = drawn + (self.next() % (left.len() - drawn) as u64) as usize;
            left.swap(drawn, other);
        }
        left.truncate(size);
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
