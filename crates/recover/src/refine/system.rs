//! The normal equations with the prior, in its units.
//!
//! `(H + P) s = g + P (p_0 - p)`: `P` is the precision of the prior, so wide that it only matters
//! where the photograph does not determine a number, and of known differences
//! ([`super::relations`]). The covariance of the solution is the sandwich
//! `(H + P)^-1 (G + P) (H + P)^-1`.

use super::normal::Normal;
use super::unknowns::Unknowns;
use crate::fit::quadratic;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// The equations of one place.
pub(super) struct System {
    unit: DVector<f64>,
    h: DMatrix<f64>,
    g: DVector<f64>,
    g_covariance: DMatrix<f64>,
    g_dependent: DMatrix<f64>,
    g_rendering: DMatrix<f64>,
}

impl System {
    /// `to_belief` is the mean of the prior less the values of the unknowns.
    pub(super) fn new(unknowns: &Unknowns, normal: &Normal, to_belief: &DVector<f64>) -> Self {
        let n = unknowns.len();
        let unit = DVector::from_column_slice(&unknowns.deviations);
        let scaled =
            |m: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| unit[i] * m[(i, j)] * unit[j]);
        // Noise can make an eigenvalue of the curvature negative; nothing is known along it.
        let mut eigen = SymmetricEigen::new(scaled(&normal.h));
        eigen.eigenvalues.apply(|v| *v = v.max(0.0));
        let one = DMatrix::identity(n, n);
        let h = eigen.recompose() + &one;
        let g = normal.g.component_mul(&unit) + to_belief.component_div(&unit);
        let g_covariance = scaled(&normal.g_covariance) + &one;
        let g_dependent = scaled(&normal.g_dependent) + one;
        Self { h, g, g_covariance, g_dependent, g_rendering: scaled(&normal.g_rendering), unit }
    }

    /// The same with what is known of the differences of the `unknowns`, which stand at `values`.
    pub(super) fn related(mut self, unknowns: &Unknowns, values: &DVector<f64>) -> Self {
        for relation in &unknowns.relations {
            let precision = relation.deviation.powi(-2);
            let pull = precision * relation.difference(|index| values[index]);
            for (i, sign) in relation.signs() {
                self.g[i] -= sign * pull * self.unit[i];
                for (j, other) in relation.signs() {
                    let of_both = sign * other * precision * self.unit[i] * self.unit[j];
                    for of in [&mut self.h, &mut self.g_covariance, &mut self.g_dependent] {
                        of[(i, j)] += of_both;
                    }
                }
            }
        }
        self
    }

    /// The step to the minimum within `bounds`; `damping` shortens it.
    pub(super) fn step(&self, damping: f64, bounds: &quadratic::Bounds) -> Option<DVector<f64>> {
        let mut h = self.h.clone();
        for i in 0..h.nrows() {
            h[(i, i)] *= 1.0 + damping;
        }
        let h =
            DMatrix::from_fn(h.nrows(), h.ncols(), |i, j| h[(i, j)] / self.unit[i] / self.unit[j]);
        quadratic::minimise(&h, &self.g.component_div(&self.unit), bounds)
    }

    /// The covariance of the minimum if all cells were independent: it judges steps, and how many paths are worth their
    /// time.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        self.sandwich(&self.g_covariance)
    }

    /// The covariance of the minimum, as it is stated.
    pub(super) fn stated_covariance(&self) -> DMatrix<f64> {
        self.sandwich(&self.g_dependent)
    }

    /// The part of its diagonal that comes from the noise of the renderings.
    pub(super) fn rendering_variance(&self) -> DVector<f64> {
        self.sandwich(&self.g_rendering).diagonal()
    }

    /// The inverse of the curvature.
    pub(super) fn inverse(&self) -> DMatrix<f64> {
        let (n, inverse) = (self.unit.len(), self.scaled_inverse());
        DMatrix::from_fn(n, n, |i, j| self.unit[i] * inverse[(i, j)] * self.unit[j])
    }

    fn scaled_inverse(&self) -> DMatrix<f64> {
        let n = self.unit.len();
        self.h.clone().cholesky().map_or(DMatrix::identity(n, n), |c| c.inverse())
    }

    fn sandwich(&self, of_gradient: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, inverse) = (self.unit.len(), self.scaled_inverse());
        let covariance = &inverse * of_gradient * &inverse;
        DMatrix::from_fn(n, n, |i, j| self.unit[i] * covariance[(i, j)] * self.unit[j])
    }
}
