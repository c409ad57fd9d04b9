//! The response of a camera from the same places at several exposures [Debevec and Malik 1997, eq. 3].
//!
//! `Z_ij` is the code of place `i` in frame `j`, which has the exposure `t_j`. With the unknown radiances
//! `E_i` and `g(z)`, the logarithm of the linear value of code `z`, the paper's sum
//!
//! ```text
//! sum_ij (w(Z_ij) (g(Z_ij) - ln E_i - ln t_j))^2 + lambda sum_z (w(z) g''(z))^2
//! ```
//!
//! is minimised. `g` has a value for each of 256 codes, and is linear between them, where means of several
//! pixels and codes of 16 bits lie. The `ln E_i` are eliminated. Three things differ from the paper:
//!
//! - Exposures in equal steps leave `g` open up to a function that is periodic in `ln E`, so that much
//!   smoothness is needed; but `g''` of a gamma is large at dark codes. So `g` need not be smooth but
//!   `r(z) = g(z) - gamma ln z` with a free `gamma`, and its third difference is small: a power law costs
//!   nothing, a toe and a shoulder little.
//! - The weight `w` is the code itself: rounding and shot noise are about the same number of codes
//!   everywhere, and a code's share of `g` goes with its inverse. The paper's hat falls towards white, too; here
//!   a place with a clipped pixel does not count in that frame, and bright codes are the best.
//! - The sum is minimised again with Tukey's weights, by which places where something moved lose theirs
//!   [Beaton and Tukey 1974]; last the curve is made monotone by pooling adjacent violators
//!   [Ayer et al. 1955].

use super::patches::Sample;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Codes at which the curve has a value.
const KNOTS: usize = 256;
/// The smoothness `lambda` as a multiple of the mean weight of the samples per code. With the noise of 8-bit
/// cameras and steps of four in exposure a gamma is found to 0.13 % of white; at a tenth of it to 0.3 %, at a
/// hundredth to 0.8 %. A shoulder is found to 0.2 % at a tenth of it, too; much more would flatten it.
const SMOOTHNESS: f64 = 3000.0;
/// Solutions with Tukey's weights; more change the curve by less than 1e-4.
const ROUNDS: usize = 3;
/// Tukey's constant: 95 % efficiency for normal errors.
const TUKEY: f64 = 4.685;
/// A place is an outlier if a reading has less than this weight: beyond half of Tukey's reach. At double of it a
/// tenth of normal errors would be left out, at half of it some moved places stay.
const KEPT: f64 = 0.5;
/// The least growth of linear values from one row to the next, as a share, so that the curve can be
/// inverted.
const LEAST_GROWTH: f64 = 1e-6;

/// The linear values of the codes 0, 1/255, ... 1; that of 0 is 0, that of 1 is 1. And for each sample whether it
/// is an inlier: nothing moved there. None if the samples do not determine a curve.
pub(super) fn fit(samples: &[Sample]) -> Option<(Vec<f64>, Vec<bool>)> {
    let mut weights: Vec<Vec<f64>> = samples.iter().map(|s| vec![1.0; s.readings.len()]).collect();
    let mut logarithms = solve(samples, &weights)?;
    for _ in 0..ROUNDS {
        reweigh(samples, &logarithms, &mut weights);
        logarithms = solve(samples, &weights)?;
    }
    // No light is black.
    let above = monotone(&logarithms.as_slice()[1..KNOTS]);
    let last = above[KNOTS - 2];
    let mut grown = vec![0.0];
    grown.extend(above.iter().map(|g| (g - last).exp()));
    for k in 1..KNOTS {
        grown[k] = grown[k].max(grown[k - 1] * (1.0 + LEAST_GROWTH)).max(f64::MIN_POSITIVE);
    }
    let white = grown[KNOTS - 1];
    let kept = weights.iter().map(|weights| weights.iter().all(|w| *w > KEPT)).collect();
    Some((grown.iter().map(|value| value / white).collect(), kept))
}

/// The knot at or below `code`, and how far it is from there to the next.
fn knot(code: f64) -> (usize, f64) {
    let place = code * (KNOTS - 1) as f64;
    let knot = (place as usize).min(KNOTS - 2);
    (knot, place - knot as f64)
}

/// `g` at the knots, followed by `gamma`; `weights` of the readings multiply those of their codes.
fn solve(samples: &[Sample], weights: &[Vec<f64>]) -> Option<DVector<f64>> {
    let mut matrix = DMatrix::<f64>::zeros(KNOTS + 1, KNOTS + 1);
    let mut right = DVector::<f64>::zeros(KNOTS + 1);
    let mut total = 0.0;
    for (sample, weights) in samples.iter().zip(weights) {
        let squares = sample.readings.iter().zip(weights).map(|(r, w)| w * r[0].powi(2));
        let squares: Vec<f64> = squares.collect();
        let sum: f64 = squares.iter().sum();
        if sum <= 0.0 {
            continue;
        }
        total += sum;
        let mean: f64 =
            sample.readings.iter().zip(&squares).map(|(r, w)| r[1] * w / sum).sum::<f64>();
        for (a, reading) in sample.readings.iter().enumerate() {
            let (knot_a, t) = knot(reading[0]);
            for (place, share) in [(knot_a, 1.0 - t), (knot_a + 1, t)] {
                right[place] += squares[a] * share * (reading[1] - mean);
            }
            // The radiance of the place is eliminated: its mean is taken from every row.
            for (b, other) in sample.readings.iter().enumerate() {
                let own = if a == b { squares[a] } else { 0.0 };
                let weight = own - squares[a] * squares[b] / sum;
                let (knot_b, s) = knot(other[0]);
                matrix[(knot_a, knot_b)] += weight * (1.0 - t) * (1.0 - s);
                matrix[(knot_a, knot_b + 1)] += weight * (1.0 - t) * s;
                matrix[(knot_a + 1, knot_b)] += weight * t * (1.0 - s);
                matrix[(knot_a + 1, knot_b + 1)] += weight * t * s;
            }
        }
    }
    smooth(&mut matrix, SMOOTHNESS * total / KNOTS as f64);
    // The unit of g is arbitrary: its middle is set to zero, as in the paper.
    matrix[(KNOTS / 2, KNOTS / 2)] += total.max(1.0);
    let ridge = 1e-12 * total.max(1.0);
    (0..=KNOTS).for_each(|k| matrix[(k, k)] += ridge);
    Some(Cholesky::new(matrix)?.solve(&right))
}

/// Adds the second term of the sum: `lambda` times the squares of the third differences of `r`.
fn smooth(matrix: &mut DMatrix<f64>, lambda: f64) {
    let factors = [-1.0, 3.0, -3.0, 1.0];
    // Black has no logarithm.
    for first in 1..KNOTS - 3 {
        let knots = || (first..first + 4).zip(factors);
        let power = knots().map(|(z, factor)| factor * (z as f64).ln()).sum::<f64>();
        let row: Vec<(usize, f64)> = knots().chain([(KNOTS, -power)]).collect();
        for &(a, of_a) in &row {
            for &(b, of_b) in &row {
                matrix[(a, b)] += lambda * of_a * of_b;
            }
        }
    }
}

/// Gives each reading Tukey's weight by how far it is from the radiance of its place.
fn reweigh(samples: &[Sample], logarithms: &DVector<f64>, weights: &mut [Vec<f64>]) {
    let residuals: Vec<Vec<f64>> =
        samples.iter().zip(&*weights).map(|(s, w)| residuals(s, w, logarithms)).collect();
    let mut sizes: Vec<f64> = residuals.iter().flatten().map(|r| r.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    // 1.4826 medians are a standard deviation; frames without noise differ by rounding alone.
    let reach = TUKEY * (1.4826 * median).max(1e-9);
    for (weights, residuals) in weights.iter_mut().zip(&residuals) {
        for (weight, residual) in weights.iter_mut().zip(residuals) {
            *weight = (1.0 - (residual / reach).powi(2)).max(0.0).powi(2);
        }
    }
}

/// The weights of the codes times the differences of the readings of one place to the mean of their radiances.
fn residuals(sample: &Sample, weights: &[f64], logarithms: &DVector<f64>) -> Vec<f64> {
    let radiance = |reading: &[f64; 2]| {
        let (knot, t) = knot(reading[0]);
        (1.0 - t) * logarithms[knot] + t * logarithms[knot + 1] - reading[1]
    };
    let all: Vec<f64> = sample.readings.iter().map(radiance).collect();
    let squares = sample.readings.iter().zip(weights).map(|(r, w)| w * r[0].powi(2));
    let squares: Vec<f64> = squares.collect();
    let sum = squares.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mean = all.iter().zip(&squares).map(|(value, w)| value * w / sum).sum::<f64>();
    all.iter().zip(&sample.readings).map(|(value, r)| r[0] * (value - mean)).collect()
}

/// The nearest non-decreasing sequence.
fn monotone(values: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for value in values {
        pools.push((*value, 1));
        while let [.., before, last] = pools[..]
            && before.0 > last.0
        {
            let count = before.1 + last.1;
            let mean = (before.0 * before.1 as f64 + last.0 * last.1 as f64) / count as f64;
            pools.truncate(pools.len() - 2);
            pools.push((mean, count));
        }
    }
    pools.into_iter().flat_map(|(value, count)| std::iter::repeat_n(value, count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of many radiances at three exposures, without noise.
    fn samples(code: impl Fn(f64) -> f64) -> Vec<Sample> {
        let exposures = [0.25, 1.0, 4.0f64];
        let place = |k: usize| {
            let radiance = 6e-4 * 10f64.powf(4.0 * k as f64 / 400.0);
            let readings = exposures.map(|t| [code((t * radiance).min(1.2)), t.ln()]);
            let good = |r: &[f64; 2]| r[0] > 0.0 && r[0] < 0.995;
            Sample { readings: readings.into_iter().filter(good).collect() }
        };
        (0..400).map(place).filter(|s| s.readings.len() > 1).collect()
    }

    #[test]
    fn a_gamma_and_a_toe_with_a_shoulder_are_found() {
        let gamma = |x: f64| x.powf(1.0 / 2.2);
        let (curve, kept) = fit(&samples(gamma)).unwrap();
        assert!(2 * kept.iter().filter(|kept| **kept).count() > kept.len());
        let worst = (0..KNOTS).map(|k| (curve[k] - (k as f64 / 255.0).powf(2.2)).abs());
        assert!(worst.clone().fold(0.0, f64::max) < 1e-3, "{:?}", worst.fold(0.0, f64::max));
        // A toe below and a shoulder above.
        let inverse = |code: f64| 0.35 * code.powf(1.4) + 0.65 * code.powi(4);
        let code = |x: f64| {
            let (mut low, mut high) = (0.0, 1.5);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *if inverse(middle) < x { &mut low } else { &mut high } = middle;
            }
            low
        };
        let (curve, _) = fit(&samples(code)).unwrap();
        let worst = (0..KNOTS).map(|k| (curve[k] - inverse(k as f64 / 255.0)).abs());
        assert!(worst.clone().fold(0.0, f64::max) < 1e-3, "{:?}", worst.fold(0.0, f64::max));
    }

    #[test]
    fn what_falls_is_pooled() {
        assert_eq!(monotone(&[0.0, 2.0, 1.0, 3.0, 2.0, 1.0]), [0.0, 1.5, 1.5, 2.0, 2.0, 2.0]);
    }
}
