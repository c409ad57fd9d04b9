//! Two models of one group side by side: which of them explains the blocks better, and by how much.
//!
//! Each model was rendered twice with independent noise, `A` and `B`. The squared residual of a model is
//! the product `(P - A) C^-1 (P - B)` of both, whose mean does not hold the noise of the renderings: a
//! model that is hard to render is neither further from the photograph nor nearer to it for that. `C` is
//! the covariance of the observation model ([`crate::likelihood`]) under the model that is explained
//! better, with the larger one of the two rendering noises: that one of them happens to be sampled well is
//! no evidence for it.

use crate::block_residuals::BlockResiduals;
use crate::blocks::Blocks;
use crate::likelihood::{Likelihood, product, standardised};
use crate::model_error::{LightField, ModelError};
use glam::DVec3;
use unrender_scene::Rgb;

/// The variance of the difference of two products of residuals, each of two halves with independent
/// noise, in units of the square of the mean's variance: each half has twice the mean's, which gives
/// four for a product; the common random numbers leave about half of the sum of two.
const PRODUCT: f64 = 4.0;
/// No fewer blocks than this share are taken as independent: the correlation is an estimate.
const LEAST_INDEPENDENT: f64 = 0.05;

/// One model of a group.
pub struct Side<'a> {
    /// Its residuals, block by block.
    pub residuals: &'a BlockResiduals,
    /// How the light that was gathered may be wrong.
    pub field: &'a LightField,
    /// The share of model error below which nothing counts.
    pub floor: ModelError,
}

/// What the blocks of one group say of two models.
pub struct Contrast {
    /// The squared residuals of the one model less those of the other, in units of their covariance.
    pub difference: f64,
    /// How far the two models are apart, squared, in units of the residuals' covariance: what the true
    /// one of them gains on the mean. It is the product of the two halves' differences, free of the
    /// renderings' noise.
    pub separation: f64,
    /// The variance of the difference by the renderings' noise.
    pub noise: f64,
    /// The share of the blocks that are independent of each other.
    pub independent: f64,
}

/// A model is wrong if what it gains is less by so many standard deviations than what a right one does. At
/// half of it chance takes faint lobes back, at double it lets wrong ones pass.
const WRONG: f64 = 2.0;

impl Contrast {
    /// The variance of the difference under either model.
    pub fn variance(&self) -> f64 {
        4.0 * self.separation.max(0.0) + self.noise
    }

    /// Whether the difference is what it would be if the one model were right, as far as it tells.
    pub fn may_be_right(&self) -> bool {
        self.difference + self.separation.max(0.0) < WRONG * self.variance().sqrt()
    }

    /// The one model beside the other.
    pub fn of(blocks: &Blocks, [mine, other]: [&Side<'_>; 2]) -> Self {
        let fitted = |side: &Side<'_>, other: &Side<'_>| {
            let residuals = side.residuals.with_noise(&other.residuals.noise);
            let likelihood = Likelihood::of(&residuals, side.field, side.floor);
            (residuals, likelihood)
        };
        let (a, b) = (fitted(mine, other), fitted(other, mine));
        let is_mine = a.1.deviance < b.1.deviance;
        let ((residuals, likelihood), field) =
            if is_mine { (a, mine.field) } else { (b, other.field) };
        let product = |a: &[Rgb], b: &[Rgb]| product(&residuals, field, &likelihood, [a, b]);
        let (of_mine, of_other) = (mine.residuals.halves(), other.residuals.halves());
        let difference = product(&of_mine[0], &of_mine[1]) - product(&of_other[0], &of_other[1]);
        let apart = [0, 1].map(|half: usize| {
            let at = |k: usize| of_mine[half][k] - of_other[half][k];
            (0..blocks.len()).map(at).collect::<Vec<Rgb>>()
        });
        let separation = product(&apart[0], &apart[1]);
        let share = (likelihood.error.share * likelihood.error.share) as f32;
        let of_rendering = |k: usize| {
            let rendering = mine.residuals.rendering[k].max(other.residuals.rendering[k]);
            let variance = residuals.noise[k] + share * residuals.level2[k];
            let part = rendering / variance.max(Rgb::splat(f32::MIN_POSITIVE));
            f64::from((part * part).element_sum())
        };
        let noise = PRODUCT * (0..blocks.len()).map(of_rendering).sum::<f64>();
        let standardised = standardised(&residuals, field, &likelihood);
        let independent = independent_share(blocks, &standardised);
        Self { difference, separation, noise, independent }
    }
}

/// The share of the blocks that are independent of each other, from their standardised `residuals`.
pub fn independent_share(blocks: &Blocks, residuals: &[DVec3]) -> f64 {
    share_by(&blocks.neighbours(), residuals)
}

/// The share of standardised `residuals` that are independent of each other, from the correlation `r` of
/// neighbours, which are the `pairs`: `((1 - r) / (1 + r))^2`, once for each direction of the picture.
pub(crate) fn share_by(pairs: &[(usize, usize)], residuals: &[DVec3]) -> f64 {
    let correlation = correlation(pairs, residuals);
    ((1.0 - correlation) / (1.0 + correlation)).powi(2).max(LEAST_INDEPENDENT)
}

/// The correlation of the values of the `pairs`, 0 to 1.
fn correlation(pairs: &[(usize, usize)], values: &[DVec3]) -> f64 {
    if pairs.is_empty() {
        return 0.0;
    }
    let product = pairs.iter().map(|&(i, j)| values[i].dot(values[j])).sum::<f64>();
    let square = values.iter().map(|v| v.length_squared()).sum::<f64>();
    let mean = square / values.len() as f64;
    if mean > 0.0 { (product / pairs.len() as f64 / mean).clamp(0.0, 1.0) } else { 0.0 }
}
