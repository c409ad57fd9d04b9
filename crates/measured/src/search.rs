//! The search for the numbers of a form: least squares of the compressed differences by Levenberg-Marquardt
//! [Levenberg 1944; Marquardt 1963].

use super::form::{Form, Number};
use super::samples::Sample;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use rayon::prelude::*;
use unrender_render::bsdf::Bsdf;
use unrender_scene::{Material, Rgb};

/// The most numbers of a form: with a lobe of free reflectance. Half of them would be too few for it.
const MOST: usize = 7;
/// The difference of refractive indices for its derivative. At half of it, rounding of single precision doubles its error; at
/// double of it the curvature quadruples its own.
const IOR_STEP: f32 = 2e-3;

/// How far a search goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Care {
    /// Relative changes of cost and numbers below which it ends.
    tolerance: f64,
    /// Most evaluations, for each number.
    patience: usize,
}

/// To see which start is the best one: half of the evaluations may not leave a wrong lobe, double of them take twice the
/// time (neither tried).
pub(super) const ROUGH: Care = Care { tolerance: 1e-4, patience: 4 };
/// Until single precision ends it: no table tells more. Most searches end before; half of the evaluations would cut off some, double
/// of them would cost time where nothing is determined (neither tried).
pub(super) const FINAL: Care = Care { tolerance: 1e-8, patience: 20 };

struct Problem<'a> {
    form: Form,
    numbers: Vec<Number>,
    samples: &'a [Sample],
    angles: DVector<f64>,
}

/// The residuals of a sample, and the derivatives by each angle, by channel.
type Rows = ([f64; 3], [[f64; 3]; MOST]);

impl Problem<'_> {
    /// The values of the numbers, and their derivatives by the angles.
    fn values(&self) -> Vec<(f64, f64)> {
        let at = |(number, angle): (&Number, &f64)| number.bounded().at(*angle);
        self.numbers.iter().zip(self.angles.iter()).map(at).collect()
    }

    fn material(&self) -> Material {
        let values: Vec<f64> = self.values().into_iter().map(|(value, _)| value).collect();
        self.form.material(&values)
    }

    fn rows(&self) -> Vec<Rows> {
        let material = self.material();
        let slopes: Vec<f64> = self.values().into_iter().map(|(_, slope)| slope).collect();
        let bsdf = self.bsdf(&material);
        let others = self.of_other_indices();
        let row = |sample: &Sample| {
            let terms = bsdf.terms(bsdf.rho_d, sample.wo, sample.wi);
            let by_alpha = terms.by_alpha_x + terms.by_alpha_y;
            let by_ior = others.as_ref().map_or(Rgb::ZERO, |[(low, below), (high, above)]| {
                let [below, above] = [below, above].map(|bsdf| bsdf.value(sample.wo, sample.wi));
                (above - below) / (high - low)
            });
            let (mut residuals, mut derivatives) = ([0.0; 3], [[0.0; 3]; MOST]);
            for channel in 0..3 {
                let (root, by_f) = sample.compressed(f64::from(terms.value[channel]));
                residuals[channel] = root - sample.compressed(sample.value[channel]).0;
                for (at, number) in self.numbers.iter().enumerate() {
                    let slope = match *number {
                        Number::Base(of) if of == channel => terms.by_rho_d,
                        Number::Lobe(of) if of == channel => terms.by_rho_s[channel],
                        Number::Base(_) | Number::Lobe(_) => 0.0,
                        Number::Ior => by_ior[channel],
                        Number::Alpha => by_alpha[channel],
                    };
                    derivatives[at][channel] = by_f * f64::from(slope) * slopes[at];
                }
            }
            (residuals, derivatives)
        };
        self.samples.par_iter().map(row).collect()
    }

    fn bsdf(&self, material: &Material) -> Bsdf<'static> {
        Bsdf::new(material, material.rho_d, self.form.model)
    }

    /// With the refractive indices on both sides, if there is one.
    fn of_other_indices(&self) -> Option<[(f32, Bsdf<'static>); 2]> {
        let at = self.numbers.iter().position(|number| *number == Number::Ior)?;
        let values: Vec<f64> = self.values().into_iter().map(|(value, _)| value).collect();
        Some([-1.0, 1.0].map(|side| {
            let mut values = values.clone();
            values[at] = (values[at] + side * f64::from(IOR_STEP)).max(1.0);
            (values[at] as f32, self.bsdf(&self.form.material(&values)))
        }))
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, angles: &DVector<f64>) {
        self.angles.copy_from(angles);
    }

    fn params(&self) -> DVector<f64> {
        self.angles.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let bsdf = self.bsdf(&self.material());
        let apart = |sample: &Sample| {
            let fitted = bsdf.value(sample.wo, sample.wi);
            [0, 1, 2].map(|channel| {
                sample.compressed(f64::from(fitted[channel])).0
                    - sample.compressed(sample.value[channel]).0
            })
        };
        let all: Vec<[f64; 3]> = self.samples.par_iter().map(apart).collect();
        let all = DVector::from_iterator(3 * all.len(), all.into_iter().flatten());
        all.iter().all(|r| r.is_finite()).then_some(all)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let rows = self.rows();
        let at = |row: usize, column: usize| rows[row / 3].1[column][row % 3];
        let all = DMatrix::from_fn(3 * rows.len(), self.numbers.len(), at);
        all.iter().all(|d| d.is_finite()).then_some(all)
    }
}

/// The values of the numbers of `form`, from `start`, that fit `samples` best, and the sum of the squared residuals.
pub(super) fn search(form: Form, samples: &[Sample], start: &[f64], care: Care) -> (Vec<f64>, f64) {
    let numbers = form.numbers();
    let angle = |(number, value): (&Number, &f64)| number.bounded().angle(*value);
    let angles = DVector::from_iterator(numbers.len(), numbers.iter().zip(start).map(angle));
    let search = LevenbergMarquardt::new().with_tol(care.tolerance).with_patience(care.patience);
    let problem = Problem { form, numbers, samples, angles };
    let (found, _) = search.minimize(problem);
    let values = found.values().into_iter().map(|(value, _)| value).collect();
    let cost = found.residuals().map_or(f64::INFINITY, |residuals| residuals.norm_squared());
    (values, cost)
}

#[cfg(test)]
mod tests {
    use super::super::samples::samples;
    use super::*;
    use unrender_scene::MeasuredBrdf;

    #[test]
    fn derivatives_are_those_of_the_residuals() {
        let table = MeasuredBrdf::from_fn([9, 5, 4], |wo, wi| {
            Rgb::new(0.1, 0.2, 0.05) + Rgb::splat((wo + wi).normalize().z.powi(30))
        });
        let samples = samples(&table.unwrap(), [1, 1, 1]);
        assert!(samples.len() > 20);
        for form in Form::of(None) {
            let numbers = form.numbers();
            let start = DVector::from_fn(numbers.len(), |at, _| 0.5 + 0.06 * at as f64);
            let mut problem = Problem { form, numbers, samples: &samples, angles: start.clone() };
            let jacobian = problem.jacobian().unwrap();
            for column in 0..start.len() {
                let step = 2e-3;
                let [below, above] = [-step, step].map(|step| {
                    let mut moved = start.clone();
                    moved[column] += step;
                    problem.set_params(&moved);
                    problem.residuals().unwrap()
                });
                let numeric = (above - below) / (2.0 * step);
                let off = (jacobian.column(column) - &numeric).norm() / numeric.norm();
                assert!(off < 0.02, "{form:?} {column}: {off}");
            }
        }
    }
}
