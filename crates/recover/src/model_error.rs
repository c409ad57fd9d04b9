//! The observation model: what a residual may be, besides a wrong hypothesis.
//!
//! `pixel = model + photograph's noise + rendering noise + model error`.
//!
//! - The **photograph's noise** is measured ([`crate::observation`]) and taken at the model's
//!   brightness, never at the photograph's own, which would let dark pixels rule.
//! - The **rendering noise** is that of the two halves' difference.
//! - The **model error** is what no model of a real scene gets right: geometry, lights, a reflectance
//!   that is not exactly the lobe. It has two parts. One changes slowly over a surface: the light
//!   that arrives there is wrong by an amount that varies with place and orientation
//!   ([`LightField`]). The other is independent from block to block, with the standard deviation
//!   `share * level`, `level^2 = (g^2 + m^2) / 2` for the group's mean light `g` and the local light
//!   `m`: the first keeps dark pixels from ruling, the second lets bright ones be wrong in proportion.
//!   The sizes of both are those that make the group's residuals most likely ([`Likelihood::of`]).
//!
//! Fits weight by the inverse of these variances, model selection compares likelihoods under them
//! ([`crate::selection`]), and the report judges by them what is not explained.
//!
//! A robust loss is not used: a highlight is a minority of bright pixels that a diffuse hypothesis
//! does not explain, and every robust loss throws it away as an outlier. What may be an outlier is
//! decided by physics, after the hypotheses have competed ([`crate::outliers`]).

use crate::blocks::Blocks;
use crate::evidence::{Evidence, Observed};
use crate::observation::Reading;
use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use unrender_render::{GeometryBuffers, Probes};
use unrender_scene::Rgb;

/// How much model error is allowed for before anything else is called wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// That of the incident light, slow over a surface.
    pub light: LightError,
    /// The least that is independent from block to block.
    pub floor: ModelError,
}

/// The model error of a group that is independent from block to block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// Its standard deviation as a share of the local level.
    pub share: f64,
}

/// A channel that a group hardly reflects counts as if its mean light were this share of the
/// brightest channel's: a model error of a black channel is a share of nothing. At half or double,
/// what is said of nearly black channels is twice or half as sure.
const DARK: f32 = 0.1;

/// The squared level that a model error is a share of: the mean of the squares of the group's mean
/// light and of the local light.
pub fn level2(mean: Rgb, local: Rgb) -> Rgb {
    let mean = mean.max(Rgb::splat(DARK * mean.max_element()));
    (0.5 * (mean * mean + local * local)).max(Rgb::splat(f32::MIN_POSITIVE))
}

impl ModelError {
    /// Before any residual is seen. It weights the first fit alone: at half or double of it the
    /// following fits are the same.
    pub const START: Self = Self { share: 0.05 };

    /// The weight of one pixel, of which there are `block` in its block: the inverse of its
    /// variance. The noise of a block's pixels averages out, their model error does not.
    pub fn weight(self, noise: Rgb, level2: Rgb, block: u32) -> Rgb {
        let model = (self.share * self.share) as f32 * block as f32 * level2;
        (noise + model).max(Rgb::splat(f32::MIN_POSITIVE)).recip()
    }
}

/// The residuals of a model over the blocks of a group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlockResiduals {
    /// Photograph minus model, the mean over each block.
    pub residual: Vec<Rgb>,
    /// The variance of that by the photograph's and the renderings' noise.
    pub noise: Vec<Rgb>,
    /// The squared level of each block.
    pub level2: Vec<Rgb>,
    /// The light of the reference model, which an error of the incident light is a share of.
    pub light: Vec<Rgb>,
}

impl BlockResiduals {
    /// The residuals of the radiances `model`, rendered twice, of the pixels of `evidence`. The
    /// levels are those of the last [`Evidence::reweigh`].
    pub fn of(evidence: &Evidence, model: &[Vec<Rgb>; 2]) -> Self {
        let mut residuals = Self::over(&evidence.blocks, &evidence.pixels, model);
        if let Some(least) = &evidence.least_noise {
            // That a candidate happens to be sampled well is no evidence for it.
            residuals.noise.iter_mut().zip(least).for_each(|(noise, least)| {
                *noise = noise.max(*least);
            });
        }
        residuals
    }

    /// The same residuals with the larger one of both noises in every block.
    #[must_use]
    pub fn with_noise_of(&self, other: &Self) -> Self {
        let noise = self.noise.iter().zip(&other.noise).map(|(a, b)| a.max(*b)).collect();
        Self { noise, ..self.clone() }
    }

    /// As [`BlockResiduals::of`] for `pixels` in `blocks`.
    pub fn over(blocks: &Blocks, pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> Self {
        let n = pixels.len();
        let light: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] + model[1][i])).collect();
        let residual: Vec<Rgb> = (0..n).map(|i| pixels[i].radiance - light[i]).collect();
        let smooth = blocks.smooth(&light);
        // A lower bound that the model meets says nothing more.
        let counts = |i: usize| {
            let dark = || (smooth[blocks.of_pixel[i] as usize]).cmplt(pixels[i].radiance).any();
            pixels[i].reading == Reading::Value || dark()
        };
        let rendering = |i: usize| 0.25 * (model[0][i] - model[1][i]).powf(2.0);
        let rendering: Vec<Rgb> = (0..n).map(rendering).collect();
        let photograph: Vec<Rgb> = pixels.iter().map(|p| p.variance).collect();
        let level2: Vec<Rgb> = pixels.iter().map(|p| p.level * p.level).collect();
        let level2 = blocks.mean_where(&level2, |_| true);
        let rendering = pooled(&blocks.smooth(&rendering), &level2);
        let photograph = blocks.mean_where(&photograph, counts);
        let noise = (0..blocks.len())
            .map(|k| (photograph[k] + rendering[k]) / blocks.sizes[k] as f32)
            .collect();
        Self { residual: blocks.mean_where(&residual, counts), noise, level2, light: smooth }
    }
}

/// The variance of the rendering noise of a pixel in every block: half of it as measured around the
/// block, half as in the whole group relative to the level. The first alone is small where by chance
/// no bright path was found.
fn pooled(measured: &[Rgb], level2: &[Rgb]) -> Vec<Rgb> {
    let relative = |(v, level2): (&Rgb, &Rgb)| *v / *level2;
    let sum: Rgb = measured.iter().zip(level2).map(relative).sum();
    let mean = sum / measured.len().max(1) as f32;
    measured.iter().zip(level2).map(|(v, level2)| 0.5 * (*v + mean * *level2)).collect()
}

/// The standard deviation of the incident light's error that changes slowly over a surface, as a
/// share of the light. While the other groups' reflectances are rough, they light each other wrongly
/// by some percent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightError {
    /// The share.
    pub share: f64,
}

/// How the incident light of a group may be wrong: functions of place and orientation, one row a
/// block, each of unit mean square over the blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct LightField {
    /// Blocks by functions.
    functions: DMatrix<f64>,
    /// The least standard deviation of the whole field.
    least: LightError,
}

impl LightField {
    /// The field of `blocks`, behind whose pixels `probes` lie: a constant, the place and its
    /// squares, the normal.
    pub fn of(
        blocks: &Blocks,
        probes: &Probes,
        geometry: &GeometryBuffers,
        least: LightError,
    ) -> Self {
        let probes = &probes.probes;
        let points: Vec<Vec3> = probes.iter().map(|p| p.point).collect();
        let normals: Vec<Vec3> =
            probes.iter().map(|p| geometry.pixels()[p.pixel as usize].normal).collect();
        let point = centred(&blocks.mean_where(&points, |_| true));
        let normal = centred(&blocks.mean_where(&normals, |_| true));
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; blocks.len()]];
        for axis in 0..3 {
            columns.push(point.iter().map(|p| f64::from(p[axis])).collect());
            columns.push(normal.iter().map(|n| f64::from(n[axis])).collect());
        }
        for (a, b) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            columns.push(point.iter().map(|p| f64::from(p[a] * p[b])).collect());
        }
        Self::from_columns(columns, least)
    }

    /// A field without any function but a constant, for blocks of which nothing else is known.
    pub fn constant(blocks: usize, least: LightError) -> Self {
        Self::from_columns(vec![vec![1.0; blocks]], least)
    }

    /// The field of the blocks that are left without the pixels that are flagged.
    #[must_use]
    pub fn without(&self, blocks: &Blocks, flags: &[bool]) -> Self {
        let mut left = vec![false; blocks.len()];
        let kept = blocks.of_pixel.iter().zip(flags).filter(|(_, flag)| !**flag);
        kept.for_each(|(block, _)| left[*block as usize] = true);
        let rows: Vec<usize> = (0..blocks.len()).filter(|block| left[*block]).collect();
        Self { functions: self.functions.select_rows(&rows), least: self.least }
    }

    fn from_columns(columns: Vec<Vec<f64>>, least: LightError) -> Self {
        let mut kept: Vec<DVector<f64>> = Vec::new();
        for column in columns {
            let column = DVector::from_vec(column);
            let size = (column.norm_squared() / column.len().max(1) as f64).sqrt();
            if size > 1e-6 {
                kept.push(column / size);
            }
        }
        let rows = kept.first().map_or(0, DVector::len);
        let functions = DMatrix::from_fn(rows, kept.len(), |i, j| kept[j][i]);
        Self { functions, least }
    }
}

fn centred(values: &[Vec3]) -> Vec<Vec3> {
    let mean = values.iter().copied().sum::<Vec3>() / values.len().max(1) as f32;
    let spread = values.iter().map(|v| v.distance(mean)).fold(1e-20, f32::max);
    values.iter().map(|v| (*v - mean) / spread).collect()
}

/// How likely residuals are under the observation model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Likelihood {
    /// Minus twice the logarithm of the likelihood, all blocks and channels.
    pub deviance: f64,
    /// The share of model error that makes the residuals most likely.
    pub error: ModelError,
    /// The error of the incident light that does.
    pub light: LightError,
    /// Blocks that it is taken over.
    pub blocks: usize,
}

/// Shares of model error are tried in steps of this factor; the likelihood changes by less than
/// half a unit a block between two of them.
const STEP: f64 = 1.25;
/// The largest share that is tried: the residual is as large as the photograph.
const LARGEST: f64 = 2.0;
/// Errors of the light are tried in steps of this factor, and so many of them: up to sixteen times
/// what is always allowed for. With half as many, the rough lamp of a real scene makes broad lobes of
/// its own; with more, nothing changes.
const LIGHT_STEP: f64 = 2.0;
const LIGHT_STEPS: i32 = 4;

impl Likelihood {
    /// The likelihood of `residuals`, with the most likely sizes of the model error's two parts: the
    /// share at least `floor`, the light's error at least that of `field`; the latter's amplitudes are
    /// integrated out.
    ///
    /// For each channel the residuals are Gaussian with the covariance `C = diag(noise + share^2
    /// level^2) + U U^T`, the columns of `U` being the functions of `field` times the light and the
    /// field's standard deviation; `C` is inverted by Woodbury's identity.
    pub fn of(residuals: &BlockResiduals, field: &LightField, floor: ModelError) -> Self {
        let mut best = Self::under(residuals, field, field.least, floor);
        for step in 1..=LIGHT_STEPS {
            let light = LightError { share: field.least.share * LIGHT_STEP.powi(step) };
            let wider = Self::under(residuals, field, light, floor);
            if wider.deviance >= best.deviance {
                break;
            }
            best = wider;
        }
        best
    }

    /// The same under a given error of the light.
    fn under(
        residuals: &BlockResiduals,
        field: &LightField,
        light: LightError,
        floor: ModelError,
    ) -> Self {
        let mut best = Self {
            deviance: f64::INFINITY,
            error: ModelError { share: LARGEST },
            light,
            blocks: residuals.residual.len(),
        };
        let mut share = floor.share;
        let mut rises = 0;
        while share <= LARGEST && rises < 3 {
            let error = ModelError { share };
            let deviance =
                (0..3).map(|c| deviance(residuals, field, (light, error), c)).sum::<f64>();
            if deviance < best.deviance {
                best = Self { deviance, error, ..best };
                rises = 0;
            } else {
                rises += 1;
            }
            share *= STEP;
        }
        best
    }
}

/// One channel's residuals under a share of model error: their weights, and what of the light's
/// error they call for.
struct Channel {
    inverse: Vec<f64>,
    /// The columns of `U`, a row a block.
    rows: DMatrix<f64>,
    /// The most likely amplitudes of the light's error.
    amplitudes: DVector<f64>,
    deviance: f64,
}

impl Channel {
    fn of(
        residuals: &BlockResiduals,
        field: &LightField,
        (light, error): (LightError, ModelError),
        channel: usize,
    ) -> Option<Self> {
        let at = |values: &[Rgb], k: usize| f64::from(values[k][channel]);
        let (n, functions) = (residuals.residual.len(), field.functions.ncols());
        let inverse: Vec<f64> = (0..n)
            .map(|k| {
                let model = error.share.powi(2) * at(&residuals.level2, k);
                (at(&residuals.noise, k) + model).max(f64::MIN_POSITIVE).recip()
            })
            .collect();
        let scale = light.share / (functions.max(1) as f64).sqrt();
        let mut rows = field.functions.clone();
        let mut information = DMatrix::<f64>::identity(functions, functions);
        let mut projected = DVector::<f64>::zeros(functions);
        let mut sum = 0.0;
        for k in 0..n {
            let residual = at(&residuals.residual, k);
            sum += residual * residual * inverse[k] - inverse[k].ln();
            let light = scale * at(&residuals.light, k);
            for i in 0..functions {
                rows[(k, i)] *= light;
                projected[i] += rows[(k, i)] * residual * inverse[k];
                for j in 0..=i {
                    information[(i, j)] += rows[(k, i)] * rows[(k, j)] * inverse[k];
                }
            }
        }
        information.fill_upper_triangle_with_lower_triangle();
        let factors = information.cholesky()?;
        let amplitudes = factors.solve(&projected);
        let logarithm: f64 = (0..functions).map(|i| 2.0 * factors.l()[(i, i)].ln()).sum();
        let deviance = sum - projected.dot(&amplitudes) + logarithm;
        Some(Self { inverse, rows, amplitudes, deviance })
    }
}

/// Minus twice the logarithm of the likelihood of one channel, but for a constant.
fn deviance(
    residuals: &BlockResiduals,
    field: &LightField,
    errors: (LightError, ModelError),
    channel: usize,
) -> f64 {
    Channel::of(residuals, field, errors, channel).map_or(f64::INFINITY, |channel| channel.deviance)
}

/// The residuals in units of their standard deviations under the errors of `likelihood`, less the
/// most likely error of the light.
pub fn standardised(
    residuals: &BlockResiduals,
    field: &LightField,
    likelihood: &Likelihood,
) -> Vec<DVec3> {
    let mut all = vec![DVec3::ZERO; residuals.residual.len()];
    for c in 0..3 {
        let errors = (likelihood.light, likelihood.error);
        let Some(channel) = Channel::of(residuals, field, errors, c) else { continue };
        let light = &channel.rows * &channel.amplitudes;
        for (k, value) in all.iter_mut().enumerate() {
            let left = f64::from(residuals.residual[k][c]) - light[k];
            value[c] = left * channel.inverse[k].sqrt();
        }
    }
    all
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
