//! Local first-order regression of the signal on the features [Bitterli et al. 2016].
//!
//! About a pixel p, with weights `w_q` and regressors `z_q` (position and features relative to those of p), the
//! model is the intercept `a` and the slopes `b` that minimise
//!
//! ```text
//! sum over q of  w_q |u_q - a - b . z_q|^2  +  PRIOR s^2 |b|^2
//! ```
//!
//! where `s^2` is the mean square of each regressor about its mean. The second term (ridge regression) draws the
//! model to the weighted mean where only few pixels are alike.

use super::similarity::{OFFSETS, RADIUS, SIDE};
use glam::{DVec3, Vec3};

/// Regressors: position across and down, normal (3), nearness, reflectance.
const SLOPES: usize = 7;
/// Columns of the sums: one, the regressors, the signal's three channels, and one to make them even.
const COLUMNS: usize = 12;
/// The prior of the slopes in pixels: with as many of them, slopes are half of what they would be without it.
/// With half of it models of few pixels are noisier, with double of it shading is flattened.
const PRIOR: f64 = 2.0;
/// Regressors whose variance about their mean is below this are constants.
const CONSTANT: f64 = 1e-8;

/// One pixel of the window as a row of the regression: 1, regressors, signal.
pub(super) type Row = [f64; COLUMNS];

/// The window about a pixel: rows of all offsets inside of the picture, and their weights.
#[derive(Default)]
pub(super) struct Window {
    rows: Vec<Row>,
    /// The offsets of `rows`.
    pub(super) offsets: Vec<usize>,
    weights: Vec<f32>,
}

impl Window {
    /// Removes all pixels.
    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.offsets.clear();
        self.weights.clear();
    }

    /// Adds the pixel at `offset`; `guide` are its features relative to those of the centre.
    pub(super) fn push(&mut self, offset: usize, weight: f32, guide: [f32; 5], signal: Vec3) {
        debug_assert!(offset < OFFSETS);
        let place = |n: usize| (n as f64 - RADIUS as f64) / RADIUS as f64;
        let [a, b, c, d, e] = guide.map(f64::from);
        let [red, green, blue] = signal.as_dvec3().to_array();
        let (x, y) = (place(offset % SIDE), place(offset / SIDE));
        self.rows.push([1.0, x, y, a, b, c, d, e, red, green, blue, 0.0]);
        self.offsets.push(offset);
        self.weights.push(weight);
    }

    /// The model of the pixels whose weight, to the power `power`, is at least `least`; `each` is called with
    /// the offset, weight and predicted signal of each of them.
    pub(super) fn regress(&self, power: i32, least: f32, mut each: impl FnMut(usize, f32, Vec3)) {
        let mut sums = [[0.0; COLUMNS]; SLOPES + 1];
        let powered = |weight: f32| Some(weight.powi(power)).filter(|w| *w >= least);
        for (row, weight) in self.rows.iter().zip(&self.weights) {
            if let Some(weight) = powered(*weight) {
                add(&mut sums, row, f64::from(weight));
            }
        }
        let Some(model) = Model::fit(&sums) else { return };
        for ((row, weight), offset) in self.rows.iter().zip(&self.weights).zip(&self.offsets) {
            if let Some(weight) = powered(*weight) {
                each(*offset, weight, model.at(row));
            }
        }
    }
}

/// Adds the products of a row's numbers, those of the upper triangle at least.
#[inline]
fn add(sums: &mut [[f64; COLUMNS]; SLOPES + 1], row: &Row, weight: f64) {
    for i in 0..=SLOPES {
        let factor = weight * row[i];
        // From an even column on, for the sake of vector instructions.
        for j in (i & !1)..COLUMNS {
            sums[i][j] += factor * row[j];
        }
    }
}

/// A fitted model: the signal at the centre, and its slopes.
struct Model {
    intercept: DVec3,
    slopes: [DVec3; SLOPES],
}

impl Model {
    /// The model of least squares; none without weights.
    fn fit(sums: &[[f64; COLUMNS]; SLOPES + 1]) -> Option<Self> {
        let weight = sums[0][0];
        if weight <= 0.0 || !weight.is_finite() {
            return None;
        }
        let mean = |i: usize| sums[0][i] / weight;
        let signal = DVec3::new(mean(SLOPES + 1), mean(SLOPES + 2), mean(SLOPES + 3));
        let covariance = |i: usize, j: usize| sums[i][j] / weight - mean(i) * mean(j);
        let mut matrix = [[0.0; SLOPES]; SLOPES];
        let mut right = [DVec3::ZERO; SLOPES];
        let deviation: [f64; SLOPES] = std::array::from_fn(|i| {
            let variance = covariance(i + 1, i + 1);
            if variance > CONSTANT { variance.sqrt() } else { 0.0 }
        });
        for i in 0..SLOPES {
            if deviation[i] == 0.0 {
                matrix[i][i] = 1.0;
                continue;
            }
            for j in i..SLOPES {
                if deviation[j] > 0.0 {
                    let correlation = covariance(i + 1, j + 1) / (deviation[i] * deviation[j]);
                    (matrix[i][j], matrix[j][i]) = (correlation, correlation);
                }
            }
            matrix[i][i] = 1.0 + PRIOR / weight;
            let with = |channel: usize| covariance(i + 1, SLOPES + 1 + channel) / deviation[i];
            right[i] = DVec3::new(with(0), with(1), with(2));
        }
        let mut slopes = solve(matrix, right)?;
        let mut intercept = signal;
        for i in 0..SLOPES {
            slopes[i] = if deviation[i] > 0.0 { slopes[i] / deviation[i] } else { DVec3::ZERO };
            intercept -= slopes[i] * mean(i + 1);
        }
        let finite = intercept.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        finite.then_some(Self { intercept, slopes })
    }

    /// The signal at a row's regressors.
    #[inline]
    fn at(&self, row: &Row) -> Vec3 {
        let terms = self.slopes.iter().zip(&row[1..]).map(|(slope, z)| *slope * *z);
        (self.intercept + terms.sum::<DVec3>()).as_vec3()
    }
}

/// Solves a symmetric positive definite system by Cholesky's decomposition; none if it is not definite.
fn solve(
    mut matrix: [[f64; SLOPES]; SLOPES],
    mut right: [DVec3; SLOPES],
) -> Option<[DVec3; SLOPES]> {
    for j in 0..SLOPES {
        for k in 0..j {
            for i in j..SLOPES {
                matrix[i][j] -= matrix[i][k] * matrix[j][k];
            }
        }
        if matrix[j][j] <= 0.0 {
            return None;
        }
        let root = matrix[j][j].sqrt();
        for i in j..SLOPES {
            matrix[i][j] /= root;
        }
        right[j] /= root;
        for i in j + 1..SLOPES {
            right[i] -= right[j] * matrix[i][j];
        }
    }
    for j in (0..SLOPES).rev() {
        for i in j + 1..SLOPES {
            right[j] -= right[i] * matrix[i][j];
        }
        right[j] /= matrix[j][j];
    }
    Some(right)
}
