//! The minimum of a quadratic form within linear bounds, by Hildreth's dual coordinate ascent.
//!
//! The problem `min s.H s / 2 - g.s` with `A s <= b` has the dual `l >= 0`, `s = H^-1 (g - A^T l)`.
//! Each multiplier in turn is set to what makes its own bound hold, `l_i <- max(0, l_i + (a_i.s -
//! b_i) / (a_i.H^-1 a_i))` [Hildreth 1957]. For tens of unknowns with a prior in `H` this takes some
//! hundred sweeps of a few thousand operations.

use nalgebra::{DMatrix, DVector};

/// The bounds of a step: an interval for every number, and upper limits on sums of two.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounds {
    /// The least and the greatest value of each number; finite, the first below the second.
    pub intervals: Vec<[f64; 2]>,
    /// Pairs of indices whose numbers together are at most the limit.
    pub pairs: Vec<([usize; 2], f64)>,
}

impl Bounds {
    /// Whether `s` lies within.
    fn hold(&self, s: &DVector<f64>) -> bool {
        let within = |(s, [low, high]): (&f64, &[f64; 2])| (low..=high).contains(&s);
        s.iter().zip(&self.intervals).all(within)
            && self.pairs.iter().all(|([i, j], limit)| s[*i] + s[*j] <= *limit)
    }
}

/// Sweeps over the bounds at most; half of them leave bounds of strongly correlated numbers violated
/// by more than the tolerance now and then.
const SWEEPS_MAX: usize = 20_000;
/// The minimum is found when no bound is violated by more than this, in units of the numbers' own
/// curvature, and no multiplier moves by more.
const TOLERANCE: f64 = 1e-9;

/// The `s` that minimises `s.H s / 2 - g.s` within `bounds`. None if `h` is not positive definite, or
/// the bounds exclude each other.
pub fn minimise(h: &DMatrix<f64>, g: &DVector<f64>, bounds: &Bounds) -> Option<DVector<f64>> {
    let free = h.clone().cholesky().map(|factors| factors.solve(g));
    if let Some(free) = free.filter(|free| bounds.hold(free)) {
        return Some(free);
    }
    let n = g.len();
    // Numbers of one size: the unknowns are measured in their own curvature.
    let unit = DVector::from_fn(n, |i, _| h[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |i, j| h[(i, j)] * unit[i] * unit[j]);
    let inverse = scaled.cholesky()?.inverse();
    let rows = bounds.rows(&unit);
    let mut s = &inverse * g.component_mul(&unit);
    let directions: Vec<DVector<f64>> = rows
        .iter()
        .map(|row| row.terms.iter().map(|&(i, a)| inverse.column(i) * a).sum())
        .collect();
    let mut multipliers = vec![0.0f64; rows.len()];
    for _ in 0..SWEEPS_MAX {
        let mut largest = 0.0f64;
        for ((row, direction), multiplier) in rows.iter().zip(&directions).zip(&mut multipliers) {
            let curvature = row.along(direction);
            let next = (*multiplier + (row.along(&s) - row.limit) / curvature).max(0.0);
            let change = next - *multiplier;
            if change != 0.0 {
                s.axpy(-change, direction, 1.0);
                largest = largest.max(change.abs() * curvature);
                *multiplier = next;
            }
        }
        if largest <= TOLERANCE {
            let inside = |i: usize| {
                let [low, high] = bounds.intervals[i];
                (s[i] * unit[i]).clamp(low, high)
            };
            return Some(DVector::from_fn(n, |i, _| inside(i)));
        }
    }
    None
}

/// One bound: `sum a_i s_i <= limit`.
struct Row {
    terms: Vec<(usize, f64)>,
    limit: f64,
}

impl Row {
    fn along(&self, s: &DVector<f64>) -> f64 {
        self.terms.iter().map(|&(i, a)| a * s[i]).sum()
    }
}

impl Bounds {
    /// All bounds, for numbers measured in `unit`.
    fn rows(&self, unit: &DVector<f64>) -> Vec<Row> {
        let mut rows = Vec::new();
        for (i, [low, high]) in self.intervals.iter().enumerate() {
            rows.push(Row { terms: vec![(i, 1.0)], limit: high / unit[i] });
            rows.push(Row { terms: vec![(i, -1.0)], limit: -low / unit[i] });
        }
        for ([i, j], limit) in &self.pairs {
            let size = unit[*i].max(unit[*j]);
            let terms = vec![(*i, unit[*i] / size), (*j, unit[*j] / size)];
            rows.push(Row { terms, limit: limit / size });
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(n: usize) -> Bounds {
        Bounds { intervals: vec![[-100.0, 100.0]; n], pairs: Vec::new() }
    }

    #[test]
    fn without_active_bounds_it_is_the_linear_solution() {
        let h = DMatrix::from_row_slice(2, 2, &[4e6, 1e3, 1e3, 3.0]);
        let g = DVector::from_vec(vec![3e6, 800.0]);
        let s = minimise(&h, &g, &wide(2)).unwrap();
        let expected = h.clone().cholesky().unwrap().solve(&g);
        assert!((s - &expected).norm() < 1e-6 * expected.norm());
    }

    #[test]
    fn bounds_hold_and_the_rest_makes_the_best_of_them() {
        let h = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let g = DVector::from_vec(vec![4.0, 0.0]);
        // Free: (8/3, -4/3). With the first at most 1: the second is at -1/2.
        let bounds = Bounds { intervals: vec![[-9.0, 1.0], [-9.0, 9.0]], pairs: Vec::new() };
        let s = minimise(&h, &g, &bounds).unwrap();
        assert!((s[0] - 1.0).abs() < 1e-6 && (s[1] + 0.5).abs() < 1e-6, "{s}");
        // With their sum at most 1: along x + y = 1, the least of x^2 + xy + y^2 - 4x.
        let bounds = Bounds { pairs: vec![([0, 1], 1.0)], ..wide(2) };
        let s = minimise(&h, &g, &bounds).unwrap();
        assert!((s[0] - 2.5).abs() < 1e-6 && (s[1] + 1.5).abs() < 1e-6, "{s}");
    }

    #[test]
    fn bounds_that_exclude_each_other_have_no_minimum() {
        let h = DMatrix::identity(2, 2);
        let bounds = Bounds { intervals: vec![[0.5, 1.0]; 2], pairs: vec![([0, 1], 0.5)] };
        assert!(minimise(&h, &DVector::zeros(2), &bounds).is_none());
    }
}
