//! How likely residuals are under the observation model ([`crate::observe::model_error`]).
//!
//! For each channel the residuals are Gaussian with the covariance `C = diag(noise + share^2 level^2) +
//! U U^T`, the columns of `U` being the functions of the light's error times the light and their
//! standard deviation. With `W` the inverse of the diagonal, Woodbury's identity gives all that is needed from sums
//! over the blocks: `C^-1 = W - W U (1 + U^T W U)^-1 U^T W`, `ln det C = ln det(1 + U^T W U) - ln det W`. Noise that
//! was raised for the sake of a comparison counts as if the residuals had it: a model is not more likely for being
//! rendered with less noise than its rival.

use crate::compare::residual::BlockResiduals;
use crate::observe::model_error::{
    FUNCTIONS, FieldOfPhotograph, LightError, LightField, ModelError,
};
use glam::DVec3;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// How likely residuals are under the observation model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Likelihood {
    /// Minus twice the logarithm of the likelihood, all blocks and channels.
    pub deviance: f64,
    /// The share of model error that makes the residuals most likely.
    pub error: ModelError,
    /// The error of the incident light that does so.
    pub light: LightError,
    /// The number of blocks.
    pub blocks: usize,
}

/// Shares of model error are tried in steps of this factor; the likelihood changes by less than
/// half a unit a block between two of them.
const STEP: f64 = 1.25;
/// The largest share that is tried: the residual is as large as the photograph.
const LARGEST: f64 = 2.0;
/// Errors of the light are tried in steps of this factor, and so many of them: up to four times what is always allowed
/// for. With twice as many steps a table that is a mirror in a room of metal passes for an error of the light. In drafts of
/// a tiny room of brushed things, 18 of 25 groups are right; with half as many 16, with twice as many 23.
const LIGHT_STEP: f64 = 2.0;
const LIGHT_STEPS: i32 = 2;

impl Likelihood {
    /// The likelihood of `residuals`, with the most likely sizes of the model error's two parts: the
    /// share at least `floor`, the light's error one of those that `field` leads to; the latter's amplitudes are
    /// integrated out.
    pub fn of(residuals: &BlockResiduals, field: &LightField, floor: ModelError) -> Self {
        let lights = lights(field);
        let at = |share: f64| Self::best_of(residuals, field, &lights, ModelError { share });
        let mut best = at(floor.share);
        let mut share = floor.share * STEP * STEP;
        let mut rises = 0;
        while share <= LARGEST && rises < 2 {
            let found = at(share);
            rises = if found.deviance < best.deviance { 0 } else { rises + 1 };
            best = best.or(found);
            share *= STEP * STEP;
        }
        let around = [best.error.share / STEP, best.error.share * STEP];
        let around = around.into_iter().filter(|share| *share >= floor.share);
        around.fold(best, |best, share| best.or(at(share)))
    }

    /// The likelihood of `residuals` under given sizes of both parts of the model error.
    pub fn given(
        residuals: &BlockResiduals,
        field: &LightField,
        (light, error): (LightError, ModelError),
    ) -> Self {
        Self::best_of(residuals, field, &[light], error)
    }

    /// The same with the most likely one of `lights`.
    fn best_of(
        residuals: &BlockResiduals,
        field: &LightField,
        lights: &[LightError],
        error: ModelError,
    ) -> Self {
        let of_field = |field: &FieldOfPhotograph| {
            [0, 1, 2].map(|channel| Sums::of(residuals, field, error, channel))
        };
        let sums: Vec<Sums> = field.photographs.iter().flat_map(of_field).collect();
        let blocks = residuals.residual.len();
        let under = |light: &LightError| {
            let of_sums = |sums: &Sums| sums.deviance(*light).unwrap_or(f64::INFINITY);
            Self { deviance: sums.iter().map(of_sums).sum(), error, light: *light, blocks }
        };
        let first = under(&lights[0]);
        lights[1..].iter().fold(first, |best, light| best.or(under(light)))
    }

    /// This one, or the `other` if it is more likely.
    fn or(self, other: Self) -> Self {
        if other.deviance < self.deviance { other } else { self }
    }
}

/// The errors of the light that are tried: the least of `field` and up.
fn lights(field: &LightField) -> Vec<LightError> {
    (0..=LIGHT_STEPS)
        .map(|step| LightError { share: field.least.share * LIGHT_STEP.powi(step) })
        .collect()
}

/// One channel's residuals in one photograph under a share of model error: sums over the blocks, weighted by the
/// inverse of each block's variance without the light's error.
struct Sums {
    functions: usize,
    /// Of the squared residuals, less the logarithms of the weights.
    squares: f64,
    /// Of the residuals times the light's functions.
    projected: [f64; FUNCTIONS],
    /// Of the products of two of the light's functions.
    products: [[f64; FUNCTIONS]; FUNCTIONS],
}

/// The weight of block `k` in one channel.
fn weight(residuals: &BlockResiduals, error: ModelError, k: usize, channel: usize) -> f64 {
    let at = |values: &[Rgb]| f64::from(values[k][channel]);
    let model = error.share.powi(2) * at(&residuals.level2);
    (at(&residuals.noise) + model).max(f64::MIN_POSITIVE).recip()
}

impl Sums {
    fn of(
        residuals: &BlockResiduals,
        field: &FieldOfPhotograph,
        error: ModelError,
        channel: usize,
    ) -> Self {
        let mut sums = Self {
            functions: field.count,
            squares: 0.0,
            projected: [0.0; FUNCTIONS],
            products: [[0.0; FUNCTIONS]; FUNCTIONS],
        };
        for (k, row) in field.blocks() {
            let weight = weight(residuals, error, k, channel);
            let residual = f64::from(residuals.residual[k][channel]);
            let light = f64::from(residuals.light[k][channel]);
            let missing = f64::from(residuals.missing[k][channel]);
            sums.squares += (residual * residual + missing) * weight - weight.ln();
            let (once, twice) = (weight * light * residual, weight * light * light);
            for (i, f) in row.iter().enumerate() {
                sums.projected[i] += once * f;
                let scaled = twice * f;
                for (sum, g) in sums.products[i].iter_mut().zip(row) {
                    *sum += scaled * g;
                }
            }
        }
        sums
    }

    /// The standard deviation of each of the light's functions.
    fn scale(&self, light: LightError) -> f64 {
        light.share / (self.functions.max(1) as f64).sqrt()
    }

    /// `1 + U^T W U`; none if the sums are not finite.
    fn factors(&self, light: LightError) -> Option<Cholesky<f64, Dyn>> {
        let (n, scale) = (self.functions, self.scale(light));
        let information = DMatrix::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + scale * scale * self.products[i][j]
        });
        information.cholesky()
    }

    /// Minus twice the logarithm of the likelihood under a given error of the light; none if the sums are not finite.
    fn deviance(&self, light: LightError) -> Option<f64> {
        let (n, scale) = (self.functions, self.scale(light));
        let projected = DVector::from_fn(n, |i, _| scale * self.projected[i]);
        let factors = self.factors(light)?;
        let amplitudes = factors.solve(&projected);
        let logarithm: f64 = (0..n).map(|i| 2.0 * factors.l_dirty()[(i, i)].ln()).sum();
        Some(self.squares - projected.dot(&amplitudes) + logarithm)
    }
}

/// The covariance of residuals under given errors, ready to be inverted.
pub struct ResidualCovariance<'a> {
    residuals: &'a BlockResiduals,
    field: &'a LightField,
    error: ModelError,
    /// For each photograph and channel.
    factors: Vec<[Factors; 3]>,
}

/// The standard deviation of the light's functions, and `1 + U^T W U` if that is finite.
type Factors = (f64, Option<Cholesky<f64, Dyn>>);

impl<'a> ResidualCovariance<'a> {
    /// That of `residuals` under the errors of `likelihood`.
    pub fn of(
        residuals: &'a BlockResiduals,
        field: &'a LightField,
        likelihood: &Likelihood,
    ) -> Self {
        let Likelihood { error, light, .. } = *likelihood;
        let of_field = |field: &FieldOfPhotograph| {
            [0, 1, 2].map(|channel| {
                let sums = Sums::of(residuals, field, error, channel);
                (sums.scale(light), sums.factors(light))
            })
        };
        let factors = field.photographs.iter().map(of_field).collect();
        Self { residuals, field, error, factors }
    }

    /// `C^-1 values`, block by block.
    pub fn inverse(&self, values: &[Rgb]) -> Vec<DVec3> {
        let mut all = vec![DVec3::ZERO; values.len()];
        for (field, factors) in self.field.photographs.iter().zip(&self.factors) {
            for (channel, (scale, factors)) in factors.iter().enumerate() {
                let Some(factors) = factors else { continue };
                self.inverse_of(values, (field, channel), (*scale, factors), &mut all);
            }
        }
        all
    }

    /// The same in one channel of one photograph, into `all`.
    fn inverse_of(
        &self,
        values: &[Rgb],
        (field, c): (&FieldOfPhotograph, usize),
        (scale, factors): (f64, &Cholesky<f64, Dyn>),
        all: &mut [DVec3],
    ) {
        let weight = |k: usize| weight(self.residuals, self.error, k, c);
        let light = |k: usize| f64::from(self.residuals.light[k][c]);
        let mut projected = DVector::zeros(factors.l_dirty().nrows());
        for (k, row) in field.blocks() {
            let once = scale * weight(k) * light(k) * f64::from(values[k][c]);
            projected.iter_mut().zip(row).for_each(|(sum, f)| *sum += once * f);
        }
        let amplitudes = scale * factors.solve(&projected);
        for (k, row) in field.blocks() {
            let wrong: f64 = row.iter().zip(amplitudes.iter()).map(|(f, a)| f * a).sum();
            all[k][c] = weight(k) * (f64::from(values[k][c]) - light(k) * wrong);
        }
    }

    /// `a C^-1 b`, all channels: the weighted product of two differences of all blocks' light.
    pub fn product(&self, [a, b]: [&[Rgb]; 2]) -> f64 {
        a.iter().zip(self.inverse(b)).map(|(a, b)| a.as_dvec3().dot(b)).sum()
    }

    /// The residuals in units of their standard deviations, less the most likely error of the light.
    pub fn standardised(&self) -> Vec<DVec3> {
        let mut all = self.inverse(&self.residuals.residual);
        for (k, value) in all.iter_mut().enumerate() {
            for c in 0..3 {
                value[c] /= weight(self.residuals, self.error, k, c).sqrt();
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: ModelError = ModelError { share: 0.002 };

    /// A hash of `i` from -1 to 1 with variance one third.
    fn scatter(i: usize) -> f32 {
        let mut x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        2.0 * ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32 - 1.0
    }

    fn residuals(noise: f32, f: impl Fn(usize) -> f32) -> BlockResiduals {
        let n = 300;
        BlockResiduals {
            residual: (0..n).map(|k| Rgb::splat(f(k))).collect(),
            noise: vec![Rgb::splat(noise * noise); n],
            rendering: vec![Rgb::splat(noise * noise); n],
            half: vec![Rgb::ZERO; n],
            missing: vec![Rgb::ZERO; n],
            level2: vec![Rgb::ONE; n],
            light: vec![Rgb::ONE; n],
        }
    }

    #[test]
    fn the_share_of_model_error_is_what_noise_leaves() {
        let field = LightField::constant(300, LightError { share: 0.02 });
        let spread = |size: f32| move |k: usize| size * 3f32.sqrt() * scatter(k);
        let found = |noise: f32, size: f32| {
            Likelihood::of(&residuals(noise, spread(size)), &field, FLOOR).error.share
        };
        assert!((found(0.0, 0.1) / 0.1 - 1.0).abs() < 0.2);
        assert!((found(0.1, 0.1 * 2f32.sqrt()) / 0.1 - 1.0).abs() < 0.25);
        assert!(found(0.1, 0.1) < 0.04, "noise alone is no model error");
    }

    #[test]
    fn light_that_is_wrong_by_a_few_percent_costs_little_and_a_pattern_costs_much() {
        let field = LightField::constant(300, LightError { share: 0.02 });
        let deviance =
            |f: &dyn Fn(usize) -> f32| Likelihood::of(&residuals(0.005, f), &field, FLOOR).deviance;
        let none = deviance(&|k| 0.005 * scatter(k));
        let slow = deviance(&|k| 0.03 + 0.005 * scatter(k));
        let pattern = deviance(&|k| 0.03 * scatter(k));
        assert!(slow - none < 30.0, "{}", slow - none);
        assert!(pattern - none > 300.0, "{}", pattern - none);
    }

    #[test]
    fn a_model_whose_rendering_is_noise_is_unlikely() {
        let field = LightField::constant(300, LightError { share: 0.02 });
        let quiet = Likelihood::of(&residuals(0.01, |k| 0.02 * scatter(k)), &field, FLOOR);
        let noisy = Likelihood::of(&residuals(5.0, |_| 0.0), &field, FLOOR);
        assert!(noisy.deviance > quiet.deviance + 1000.0);
    }
}
