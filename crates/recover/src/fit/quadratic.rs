//! The minimum of a quadratic form within linear bounds, by the dual active-set method.
//!
//! The problem `min s.H s / 2 - g.s` with `A s <= b`: from the minimum without bounds, the most violated
//! bound joins the active ones, and those whose multipliers would become negative leave, until none is
//! violated [Goldfarb and Idnani 1983]. It ends after finitely many exchanges, also where bounds depend on
//! each other (a group that reflects everything has three of them in one corner).

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

/// The most exchanges of bounds; there are hardly ever more than twice as many as numbers.
const EXCHANGES_MAX: usize = 10_000;
/// A bound is violated by more than this, in units of the numbers' own curvature.
const VIOLATED: f64 = 1e-7;
/// A bound depends on the active ones if less than this share of its normal is left beside them.
const DEPENDS: f64 = 1e-10;

/// The `s` that minimises `s.H s / 2 - g.s` within `bounds`.
///
/// ```
/// use nalgebra::{DMatrix, DVector};
/// use unrender_recover::fit::quadratic::{Bounds, minimise};
///
/// // Towards (0.9, 0.4), where the two together are at most one: the nearest point is (0.75, 0.25).
/// let bounds = Bounds { intervals: vec![[0.0, 1.0]; 2], pairs: vec![([0, 1], 1.0)] };
/// let wanted = DVector::from_vec(vec![0.9, 0.4]);
/// let found = minimise(&DMatrix::identity(2, 2), &wanted, &bounds).unwrap();
/// assert!((found - DVector::from_vec(vec![0.75, 0.25])).norm() < 1e-12);
/// ```
///
/// None if `h` is not positive definite, `g` is not finite, or the bounds exclude each other.
pub fn minimise(h: &DMatrix<f64>, g: &DVector<f64>, bounds: &Bounds) -> Option<DVector<f64>> {
    if !g.iter().all(|g| g.is_finite()) {
        return None;
    }
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
    let s = &inverse * g.component_mul(&unit);
    let mut search = ActiveSet { inverse, rows, s, active: Vec::new() };
    for _ in 0..EXCHANGES_MAX {
        let Some(violated) = search.most_violated() else {
            let inside = |i: usize| {
                let [low, high] = bounds.intervals[i];
                (search.s[i] * unit[i]).clamp(low, high)
            };
            return Some(DVector::from_fn(n, |i, _| inside(i)));
        };
        search.activate(violated)?;
    }
    None
}

/// The state of the search for the minimum.
struct ActiveSet {
    /// The inverse of the curvature.
    inverse: DMatrix<f64>,
    rows: Vec<Row>,
    s: DVector<f64>,
    /// The bounds that hold as equations, with their multipliers.
    active: Vec<(usize, f64)>,
}

impl ActiveSet {
    fn most_violated(&self) -> Option<usize> {
        let excess = |row: &Row| row.along(&self.s) - row.limit;
        let excesses = self.rows.iter().map(excess).enumerate();
        let violated = excesses.filter(|(_, excess)| *excess > VIOLATED);
        violated.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
    }

    /// Makes bound `new` hold as an equation; others may become inactive. None if it excludes the
    /// active ones.
    fn activate(&mut self, new: usize) -> Option<()> {
        let mut multiplier = 0.0;
        // Each round but the last removes one of the active bounds.
        for _ in 0..=self.active.len() {
            let (direction, exchange) = self.directions(new)?;
            let row = &self.rows[new];
            let curvature = row.along(&direction);
            let blocking = (0..self.active.len())
                .filter(|k| exchange[*k] > 0.0)
                .map(|k| (k, self.active[k].1 / exchange[k]))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let depends = curvature <= DEPENDS * row.along(&row.through(&self.inverse));
            let full = (row.along(&self.s) - row.limit) / curvature;
            let (length, leaves) = match blocking {
                Some((k, length)) if depends || length < full => (length, Some(k)),
                _ if depends => return None,
                _ => (full, None),
            };
            multiplier += length;
            for ((_, multiplier), exchange) in self.active.iter_mut().zip(exchange.iter()) {
                *multiplier -= length * exchange;
            }
            if !depends {
                self.s.axpy(-length, &direction, 1.0);
            }
            match leaves {
                Some(k) => drop(self.active.remove(k)),
                None => {
                    self.active.push((new, multiplier));
                    return Some(());
                }
            }
        }
        None
    }

    /// Minus the derivative of `s` by the multiplier of bound `new` while the active ones hold, and how fast the
    /// multipliers of these fall.
    fn directions(&self, new: usize) -> Option<(DVector<f64>, DVector<f64>)> {
        let through = self.rows[new].through(&self.inverse);
        let of_active: Vec<DVector<f64>> =
            self.active.iter().map(|(row, _)| self.rows[*row].through(&self.inverse)).collect();
        let row = |k: usize| &self.rows[self.active[k].0];
        let n = of_active.len();
        let products = DMatrix::from_fn(n, n, |i, j| row(i).along(&of_active[j]));
        let exchange =
            products.cholesky()?.solve(&DVector::from_fn(n, |i, _| row(i).along(&through)));
        let mut direction = through;
        for (column, by) in of_active.iter().zip(exchange.iter()) {
            direction.axpy(-by, column, 1.0);
        }
        Some((direction, exchange))
    }
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

    /// Its normal times `inverse`.
    fn through(&self, inverse: &DMatrix<f64>) -> DVector<f64> {
        self.terms.iter().map(|&(i, a)| a * inverse.column(i)).sum()
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
    fn bounds_that_depend_on_each_other_hold_in_their_corner() {
        // A group that reflects everything: neither number may grow, nor their sum.
        let n = 30;
        let mix = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
        let h = &mix * mix.transpose() + DMatrix::identity(n, n) * 1e-3;
        let g = DVector::from_fn(n, |i, _| if i % 2 == 0 { 50.0 } else { -20.0 });
        let bounds = Bounds {
            intervals: (0..n)
                .map(|i| if i % 2 == 0 { [-0.3, 0.0] } else { [-5e-9, 0.3] })
                .collect(),
            pairs: (0..n / 2).map(|k| ([2 * k, 2 * k + 1], 0.0)).collect(),
        };
        let s = minimise(&h, &g, &bounds).unwrap();
        assert!(bounds.intervals.iter().zip(s.iter()).all(|([a, b], s)| a <= s && s <= b));
        assert!(bounds.pairs.iter().all(|([i, j], _)| s[*i] + s[*j] <= 1e-9));
        // No feasible direction leads down.
        let slope = &h * &s - &g;
        for k in 0..n / 2 {
            let (i, j) = (2 * k, 2 * k + 1);
            for (di, dj) in [(-1.0, 0.0), (-1.0, 1.0)] {
                let free = s[i] > -0.3 + 1e-9 && (dj == 0.0 || s[j] < 0.3 - 1e-9);
                assert!(!free || slope[i] * di + slope[j] * dj > -1e-6, "{k}: {s}");
            }
        }
    }

    #[test]
    fn bounds_that_exclude_each_other_have_no_minimum() {
        let h = DMatrix::identity(2, 2);
        let bounds = Bounds { intervals: vec![[0.5, 1.0]; 2], pairs: vec![([0, 1], 0.5)] };
        assert!(minimise(&h, &DVector::zeros(2), &bounds).is_none());
    }
}
