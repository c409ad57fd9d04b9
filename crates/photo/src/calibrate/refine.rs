//! Refinement: least squares by Levenberg-Marquardt, and the covariance of the estimate.
//!
//! For independent errors of one standard deviation sigma in all image coordinates this is the
//! maximum-likelihood estimate; its covariance is, to first order, the Cramer-Rao bound
//!
//! ```text
//! C = sigma^2 (J^T J)^-1,      sigma^2 = sum of the squared residuals / (residuals - numbers)
//! ```

use super::model::{Free, Model, Observed, jacobian, residuals};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, Vector3};

/// Termination criteria.
#[derive(Clone, Copy, Debug)]
pub(super) struct Care {
    /// Relative changes of cost and parameters below which the search ends.
    tolerance: f64,
    /// Most evaluations of the residuals, per parameter.
    patience: usize,
}

/// Sufficient to compare cameras.
pub(super) const ROUGH: Care = Care { tolerance: 1e-4, patience: 2 };
/// To machine precision.
pub(super) const FINAL: Care = Care { tolerance: 1e-13, patience: 60 };
/// Singular values below this share of the largest (of the Jacobian with normalised columns) mean
/// that the parameters are not determined.
const SINGULAR: f64 = 1e-7;

struct Problem<'a, T> {
    start: &'a Model,
    observed: &'a [T],
    free: Free,
    step: DVector<f64>,
}

impl<T> Problem<'_, T> {
    fn model(&self) -> Model {
        self.start.moved(self.step.as_slice(), self.free)
    }
}

impl<T: Observed> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, T> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, step: &DVector<f64>) {
        self.step.copy_from(step);
    }

    fn params(&self) -> DVector<f64> {
        self.step.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let all = residuals(&self.model(), self.observed);
        all.iter().all(|r| r.is_finite()).then_some(all)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let turn = Vector3::new(self.step[0], self.step[1], self.step[2]);
        let all = jacobian(&self.model(), self.observed, self.free, &turn);
        all.iter().all(|d| d.is_finite()).then_some(all)
    }
}

/// The camera near `start` whose residuals have the least squares; `start` if none is better.
pub(super) fn refine<T: Observed>(start: &Model, observed: &[T], free: Free, care: Care) -> Model {
    let step = DVector::zeros(free.count());
    let search = LevenbergMarquardt::new().with_tol(care.tolerance).with_patience(care.patience);
    let (problem, _) = search.minimize(Problem { start, observed, free, step });
    let found = problem.model();
    if found.cost(observed) <= start.cost(observed) { found } else { *start }
}

/// The uncertainty of the estimate.
#[derive(Clone, Debug)]
pub(super) struct Certainty {
    /// The standard deviation of one image coordinate, pixels.
    pub(super) sigma: f64,
    /// Degrees of freedom.
    pub(super) freedom: usize,
    /// The inverse of J^T J; times sigma^2 the covariance of the steps of [`Model::moved`].
    pub(super) inverse: DMatrix<f64>,
}

impl Certainty {
    /// The standard deviation of the parameter in this column.
    pub(super) fn std(&self, column: usize) -> f64 {
        self.sigma * self.inverse[(column, column)].sqrt()
    }
}

/// The uncertainty of `model`, fitted to `observed`.
///
/// # Errors
/// If `observed` does not determine the parameters: the index of the least certain one.
pub(super) fn certainty<T: Observed>(
    model: &Model,
    observed: &[T],
    free: Free,
) -> Result<Certainty, usize> {
    let jacobian = jacobian(model, observed, free, &Vector3::zeros());
    let rows = jacobian.nrows();
    let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    if let Some(index) = norms.iter().position(|norm| !(*norm > 0.0 && norm.is_finite())) {
        return Err(index);
    }
    let mut scaled = jacobian;
    scaled.column_iter_mut().zip(&norms).for_each(|(mut column, norm)| column /= *norm);
    let decomposed = scaled.svd(false, true);
    let values = &decomposed.singular_values;
    let (last, least) = values.argmin();
    let Some(directions) = decomposed.v_t else { return Err(0) };
    if rows < free.count() || least < SINGULAR * values.max() {
        return Err(directions.row(last).transpose().icamax());
    }
    let mut half = directions.transpose();
    for (column, value) in values.iter().enumerate() {
        half.column_mut(column).scale_mut(1.0 / value);
    }
    half.row_iter_mut().zip(&norms).for_each(|(mut row, norm)| row /= *norm);
    let freedom = rows - free.count();
    let sigma = (model.cost(observed) / freedom.max(1) as f64).sqrt();
    Ok(Certainty { sigma, freedom, inverse: &half * half.transpose() })
}
