//! A check of the response: a polynomial [Mitsunaga and Nayar 1999, eq. 6].
//!
//! The linear value of the code `M` is `f(M) = sum_n c_n M^n` with `f(0) = 0` and `f(1) = 1`. For two
//! frames with the exposures `t_q` and `t_q+1`, `R = t_q / t_q+1`, the sum of `(f(M_q) - R f(M_q+1))^2`
//! over all places is minimised. Exposures are known here; the paper finds them too. The order is the
//! lowest whose sum is not much above the best. The paper uses no weights; here a pair is divided by
//! `sqrt(1 + R^2)`, so that it does not matter which frame is called the first. Places where something
//! moved are left out beforehand.

use super::patches::Sample;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The greatest order. The paper has up to 10; with the noise of 8 bits and steps of four in exposure, higher
/// orders fit the noise by some percent of white, and orders below 6 cannot fit a shoulder.
const MOST: usize = 8;
/// An order is enough if its sum is at most this many times the least one. At 1 the order is always the
/// greatest.
const ENOUGH: f64 = 1.05;

/// The coefficients `c_1` to `c_n`.
pub(super) fn fit(samples: &[&Sample]) -> Vec<f64> {
    let all: Vec<(f64, Vec<f64>)> = (1..=MOST).filter_map(|n| of_order(samples, n)).collect();
    let least = all.iter().map(|(sum, _)| *sum).fold(f64::INFINITY, f64::min);
    let enough = all.into_iter().find(|(sum, _)| *sum <= ENOUGH * least);
    enough.map_or_else(|| vec![1.0], |(_, coefficients)| coefficients)
}

/// The polynomial.
fn value(coefficients: &[f64], code: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * code)
}

/// The largest difference between the polynomial and the curve of `codes` and `values`, between the codes `low`
/// and `high`, as a share of white; the first is scaled to the unit of the second.
pub(super) fn disagreement(
    coefficients: &[f64],
    codes: &[f64],
    values: &[f64],
    [low, high]: [f64; 2],
) -> f64 {
    let rows = || codes.iter().zip(values).filter(|(code, _)| (low..=high).contains(*code));
    let (mut both, mut own) = (0.0, 0.0);
    for (code, curve) in rows() {
        let polynomial = value(coefficients, *code);
        both += polynomial * curve;
        own += polynomial * polynomial;
    }
    let factor = if own > 0.0 { both / own } else { 1.0 };
    let difference =
        |(code, curve): (&f64, &f64)| (factor * value(coefficients, *code) - curve).abs();
    rows().map(difference).fold(0.0, f64::max)
}

/// The least sum with a polynomial of `order`, and its coefficients.
fn of_order(samples: &[&Sample], order: usize) -> Option<(f64, Vec<f64>)> {
    // The last coefficient is 1 less the others.
    let free = order - 1;
    let mut matrix = DMatrix::<f64>::zeros(free, free);
    let mut right = DVector::<f64>::zeros(free);
    let rows: Vec<(Vec<f64>, f64)> = samples.iter().flat_map(|s| pairs(s, order)).collect();
    for (row, wanted) in &rows {
        for a in 0..free {
            right[a] += row[a] * wanted;
            for b in 0..free {
                matrix[(a, b)] += row[a] * row[b];
            }
        }
    }
    let found = match free {
        0 => DVector::zeros(0),
        _ => Cholesky::new(matrix)?.solve(&right),
    };
    let residual = |(row, wanted): &(Vec<f64>, f64)| {
        let sum: f64 = row.iter().zip(found.iter()).map(|(r, c)| r * c).sum();
        (sum - wanted).powi(2)
    };
    let sum = rows.iter().map(residual).sum::<f64>();
    let mut coefficients: Vec<f64> = found.iter().copied().collect();
    coefficients.push(1.0 - coefficients.iter().sum::<f64>());
    Some((sum, coefficients))
}

/// The equations of a place, one for each two neighbours in exposure: the factors of the free coefficients,
/// and the right-hand side.
fn pairs(sample: &Sample, order: usize) -> Vec<(Vec<f64>, f64)> {
    let equation = |pair: &[[f64; 2]]| {
        let ratio = (pair[0][1] - pair[1][1]).exp();
        let weight = 1.0 / (1.0 + ratio * ratio).sqrt();
        let power =
            |n: usize| weight * (pair[0][0].powi(n as i32) - ratio * pair[1][0].powi(n as i32));
        let last = power(order);
        ((1..order).map(|n| power(n) - last).collect(), -last)
    };
    sample.readings.windows(2).map(equation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_found() {
        let truth = [0.2, 0.1, 0.7];
        let code = |x: f64| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *if value(&truth, middle) < x { &mut low } else { &mut high } = middle;
            }
            low
        };
        let place = |k: usize| {
            let radiance = 0.9 * k as f64 / 200.0;
            let readings = [0.3f64, 1.0].map(|t| [code(t * radiance), t.ln()]);
            Sample { readings: readings.to_vec() }
        };
        let samples: Vec<Sample> = (1..200).map(place).collect();
        let found = fit(&samples.iter().collect::<Vec<_>>());
        let codes: Vec<f64> = (0..=255).map(|k| f64::from(k) / 255.0).collect();
        let values: Vec<f64> = codes.iter().map(|code| value(&truth, *code)).collect();
        let differs = disagreement(&found, &codes, &values, [0.0, 1.0]);
        assert!(differs < 1e-5, "{differs} of {found:?}");
    }
}
