//! The minimum of a quadratic form within linear bounds, by an interior-point solver.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
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

/// The `s` that makes `s.H s / 2 - g.s` least within `bounds`, for a symmetric matrix `h` without
/// negative eigenvalues. None if the bounds leave no room or the solver gives up.
pub fn minimise(h: &DMatrix<f64>, g: &DVector<f64>, bounds: &Bounds) -> Option<DVector<f64>> {
    let n = g.len();
    let free = h.clone().cholesky().map(|factors| factors.solve(g));
    if let Some(free) = free.filter(|free| bounds.hold(free)) {
        return Some(free);
    }
    // Numbers of one size: the unknowns are measured in their own curvature.
    let scale = DVector::from_fn(n, |i, _| h[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
    let upper =
        DMatrix::from_fn(n, n, |i, j| if i <= j { h[(i, j)] * scale[i] * scale[j] } else { 0.0 });
    let p = sparse(&upper);
    let q: Vec<f64> = (0..n).map(|i| -g[i] * scale[i]).collect();
    let rows = 2 * n + bounds.pairs.len();
    let mut a = DMatrix::zeros(rows, n);
    let mut b = vec![0.0; rows];
    for (i, [low, high]) in bounds.intervals.iter().enumerate() {
        (a[(i, i)], b[i]) = (1.0, high / scale[i]);
        (a[(n + i, i)], b[n + i]) = (-1.0, -low / scale[i]);
    }
    for (row, ([i, j], limit)) in bounds.pairs.iter().enumerate() {
        let unit = scale[*i].max(scale[*j]);
        a[(2 * n + row, *i)] = scale[*i] / unit;
        a[(2 * n + row, *j)] = scale[*j] / unit;
        b[2 * n + row] = limit / unit;
    }
    let settings = DefaultSettingsBuilder::default().verbose(false).build().ok()?;
    let cones = [NonnegativeConeT(rows)];
    let mut solver = DefaultSolver::new(&p, &q, &sparse(&a), &b, &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    ) && solver.solution.x.iter().all(|x| x.is_finite());
    let inside = |i: usize| {
        let [low, high] = bounds.intervals[i];
        (solver.solution.x[i] * scale[i]).clamp(low, high)
    };
    solved.then(|| DVector::from_fn(n, |i, _| inside(i)))
}

/// The matrix by columns, zeros left out.
fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in matrix.column_iter() {
        for (row, value) in column.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            rows.push(row);
            values.push(*value);
        }
        starts.push(rows.len());
    }
    CscMatrix::new(matrix.nrows(), matrix.ncols(), starts, rows, values)
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
