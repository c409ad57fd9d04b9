//! The comparison of two models of one group: which of them explains the blocks better, by how much, and whether that is
//! significant.
//!
//! Each model was rendered twice with independent noise, `A` and `B`. The squared residual of a model is
//! the product `(P - A) C^-1 (P - B)` of both, whose mean does not hold the noise of the renderings: a model that is
//! hard to render gains or loses nothing by that. `C` is the covariance of the observation model
//! ([`crate::compare::likelihood`]) under the more likely model, with the larger one of the two rendering noises: that one of
//! them happens to be sampled well is no evidence for it.

pub mod likelihood;
pub mod residual;

use crate::compare::likelihood::{Likelihood, ResidualCovariance};
use crate::compare::residual::BlockResiduals;
use crate::evidence::Evidence;
use crate::observe::blocks::Blocks;
use crate::observe::model_error::{LightField, ModelError};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Neg;
use unrender_scene::Rgb;

/// What fewer numbers explain as well is preferred: more numbers have to gain this many standard deviations of the gain. At
/// none, a plain ceiling of a real room becomes a lobe under one seed of six; at half of it chance rejects faint lobes
/// where they are checked, at double it accepts wrong ones.
pub(crate) const CERTAIN: f64 = 2.0;
/// A texture is refused, or a step taken back, if it leaves more by this many standard deviations of the difference. At half
/// of it noise takes back what is right; double of it was not tried.
pub const WORSE: f64 = 3.0;
/// Two models explain a group equally well up to this difference of their squared residuals, in units of their covariance:
/// beyond it the evidence for the better one is strong [Kass and Raftery 1995]. Half of it is called positive, double of
/// it decisive.
pub(crate) const STRONG: f64 = 6.0;

/// At least this share of the blocks is taken as independent: the correlation is an estimate.
const LEAST_INDEPENDENT: f64 = 0.05;

/// One model of a group.
pub struct Side<'a> {
    /// Its residuals, block by block.
    pub residuals: &'a BlockResiduals,
    /// How the light that was gathered may be wrong.
    pub field: &'a LightField,
    /// The model error that is always allowed for.
    pub floor: ModelError,
}

/// What the blocks of one group say of two models.
pub struct Contrast {
    /// The squared residuals of the one model less those of the other, in units of their covariance.
    pub difference: f64,
    /// The squared distance of the two models, in units of the residuals' covariance: the expected gain of the true
    /// one. It is the product of the two halves' differences, free of the renderings' noise.
    pub separation: f64,
    /// The variance of the difference due to the renderings' noise.
    pub noise: f64,
    /// The share of the blocks that are independent of each other.
    pub independent: f64,
}

impl Contrast {
    /// The variance of the difference under either model.
    pub fn variance(&self) -> f64 {
        4.0 * self.separation.max(0.0) + self.noise
    }

    /// Compares the one model with the other.
    pub fn of(blocks: &Blocks, [mine, other]: [&Side<'_>; 2]) -> Self {
        let (a, b) = (Reference::of(mine, other), Reference::of(other, mine));
        let is_mine = a.likelihood.deviance < b.likelihood.deviance;
        Self::under(if is_mine { &a } else { &b }, blocks, [mine, other])
    }

    /// Compares the one model with the other, in units of the covariance of `reference`.
    fn under(reference: &Reference<'_>, blocks: &Blocks, [mine, other]: [&Side<'_>; 2]) -> Self {
        let Reference { residuals, field, likelihood } = reference;
        let covariance = ResidualCovariance::of(residuals, field, likelihood);
        let [of_mine, of_other] = [mine, other].map(|side| side.residuals.halves());
        let square = |[a, b]: &[Vec<Rgb>; 2]| covariance.product([a, b]);
        let difference = square(&of_mine) - square(&of_other);
        let apart = [0, 1].map(|half: usize| {
            let at = |k: usize| of_mine[half][k] - of_other[half][k];
            (0..blocks.len()).map(at).collect::<Vec<Rgb>>()
        });
        let independent = independent_share(blocks, &covariance.standardised());
        let noise = noise(&covariance, [mine, other].map(|side| side.residuals));
        Self { difference, separation: square(&apart), noise, independent }
    }
}

/// The variance, due to the renderings' noise, of the difference of two models' squared residuals.
///
/// With the mean `m` of both halves' residuals and half of their difference `h`, a model's square is
/// `m C^-1 m - h C^-1 h`. `m` has as much noise as `h`, independent of it: each block's share of the variance is on
/// average the square of the one model's `2 h C^-1 m` less the other's. This accounts for the correlation of a block's
/// channels, which see the same paths, and for the random numbers that both models have in common.
fn noise(covariance: &ResidualCovariance<'_>, [mine, other]: [&BlockResiduals; 2]) -> f64 {
    let of = |side: &BlockResiduals| {
        let means = covariance.inverse(&side.residual);
        let both = side.half.iter().zip(means);
        both.map(|(half, mean)| 2.0 * half.as_dvec3().dot(mean)).collect::<Vec<f64>>()
    };
    of(mine).iter().zip(of(other)).map(|(a, b)| (a - b).powi(2)).sum()
}

/// The residuals whose covariance is the unit of a comparison.
struct Reference<'a> {
    residuals: BlockResiduals,
    field: &'a LightField,
    likelihood: Likelihood,
}

impl<'a> Reference<'a> {
    /// That of `side`, with no less noise than that of the `other`.
    fn of(side: &Side<'a>, other: &Side<'_>) -> Self {
        let residuals = side.residuals.with_noise(&other.residuals.noise);
        let likelihood = Likelihood::of(&residuals, side.field, side.floor);
        Self { residuals, field: side.field, likelihood }
    }
}

/// What a fit leaves unexplained.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Explained<'a> {
    pub(crate) residuals: &'a BlockResiduals,
    pub(crate) likelihood: &'a Likelihood,
}

/// By how much more one model leaves than another.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Difference {
    /// With the price.
    pub(crate) value: f64,
    /// Its standard deviation by the light's noise.
    pub(crate) deviation: f64,
    /// What the additional numbers cost.
    pub(crate) price: f64,
}

impl Neg for Difference {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, price: -self.price, ..self }
    }
}

impl Difference {
    /// The lower end of what is likely.
    pub(crate) fn least(self) -> f64 {
        self.value - CERTAIN * self.deviation
    }

    /// The upper end of what is likely.
    pub(crate) fn most(self) -> f64 {
        self.value + CERTAIN * self.deviation
    }

    /// The same for the record, of a change that `holds` or does not.
    pub(crate) fn measured(self, holds: bool) -> Measured {
        let Self { value, deviation, price } = self;
        Measured { holds, difference: value - price, deviation, price }
    }
}

/// The squared residuals of the first less those of the second, in units of their covariance, of which so many blocks are
/// `independent`.
pub(crate) fn difference(
    sides: [Explained<'_>; 2],
    evidence: &Evidence,
    independent: f64,
) -> Difference {
    let (field, floor) = (&evidence.sample.field, evidence.allowance.floor);
    let sides = sides.map(|side| Side { residuals: side.residuals, field, floor });
    let contrast = Contrast::of(&evidence.sample.blocks, sides.each_ref());
    let scale = independent / evidence.sample.blocks.len().max(1) as f64;
    let deviation = scale * contrast.noise.sqrt();
    Difference { value: scale * contrast.difference, deviation, price: 0.0 }
}

/// How many of the blocks are independent of each other under a fit.
pub(crate) fn independent_blocks(of: Explained<'_>, evidence: &Evidence) -> f64 {
    let residuals =
        ResidualCovariance::of(of.residuals, &evidence.sample.field, of.likelihood).standardised();
    evidence.sample.blocks.len() as f64 * independent_share(&evidence.sample.blocks, &residuals)
}

/// By which numbers a change holds, or does not.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Measured {
    pub(crate) holds: bool,
    /// The squared residuals with the change less those without, in units of their covariance.
    pub(crate) difference: f64,
    /// The standard deviation of that.
    pub(crate) deviation: f64,
    /// By how much it has to be below zero.
    pub(crate) price: f64,
}

/// The share of the blocks that are independent of each other, from their standardised `residuals`.
pub fn independent_share(blocks: &Blocks, residuals: &[DVec3]) -> f64 {
    share_by([&blocks.neighbours(), &blocks.same], residuals)
}

/// The share of standardised `residuals` that are independent of each other.
///
/// The correlation `r` of `neighbours` gives `((1 - r) / (1 + r))^2`, one factor for each direction of the picture.
/// Those of `n` photographs that show the `same` place, with the correlation `s`, count as `n / (1 + (n - 1) s)`.
pub(crate) fn share_by([neighbours, same]: [&[(usize, usize)]; 2], residuals: &[DVec3]) -> f64 {
    let beside = correlation(neighbours, residuals);
    let share = ((1.0 - beside) / (1.0 + beside)).powi(2).max(LEAST_INDEPENDENT);
    let others = 2.0 * same.len() as f64 / residuals.len().max(1) as f64;
    share / (1.0 + others * correlation(same, residuals))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::blocks::Grid;
    use crate::observe::model_error::{FUNCTIONS, FieldOfPhotograph, LightError};
    use unrender_render::sampler::mix;
    use unrender_scene::Sheet;

    const SIDE: usize = 20;

    /// Residuals of `f` at the column and row of each of `SIDE` by `SIDE` blocks, from -1 to 1.
    fn residuals(f: impl Fn(f32, f32) -> f32) -> BlockResiduals {
        let at = |k: usize| 2.0 * k as f32 / (SIDE - 1) as f32 - 1.0;
        let n = SIDE * SIDE;
        BlockResiduals {
            residual: (0..n).map(|k| Rgb::splat(f(at(k % SIDE), at(k / SIDE)))).collect(),
            noise: vec![Rgb::splat(1e-4); n],
            rendering: vec![Rgb::ZERO; n],
            half: vec![Rgb::ZERO; n],
            missing: vec![Rgb::ZERO; n],
            level2: vec![Rgb::ONE; n],
            light: vec![Rgb::ONE; n],
        }
    }

    /// A constant and a slope along the rows.
    fn field() -> LightField {
        let row = |k: usize| {
            let mut row = [0.0; FUNCTIONS];
            row[0] = 1.0;
            row[1] = 3f64.sqrt() * (2.0 * (k % SIDE) as f64 / (SIDE - 1) as f64 - 1.0);
            row
        };
        let blocks: Vec<usize> = (0..SIDE * SIDE).collect();
        let rows = blocks.iter().map(|k| row(*k)).collect();
        let field = FieldOfPhotograph { blocks, rows, count: 2 };
        LightField::uniting(vec![field], LightError { share: 0.03 })
    }

    #[test]
    fn the_variance_by_the_noise_of_renderings_is_that_of_many() {
        let n = SIDE * SIDE;
        let blocks = Blocks::of(
            &(0..n as u32).collect::<Vec<_>>(),
            &Grid::even(&Sheet::of(&[(SIDE, SIDE)]), 1),
        );
        let (field, floor) = (field(), ModelError { share: 0.02 });
        let mut drawn = 0u64;
        let mut uniform = || {
            drawn += 1;
            (mix(drawn) >> 40) as f32 / (1u64 << 24) as f32
        };
        // `noise` is in units of the least model error; half of its variance is common to both models.
        let mut contrast = |wrong: f32, noise: f32| {
            let mut draw = || 0.02 * noise * ((0..12).map(|_| uniform()).sum::<f32>() - 6.0);
            let mut both = [residuals(|x, _| wrong * (20.0 * x).sin()), residuals(|_, _| 0.0)];
            for k in 0..n {
                let common = [draw(), draw()];
                for side in &mut both {
                    let [a, b] = common.map(|common| common + draw());
                    side.residual[k] -= Rgb::splat(0.5 * (a + b));
                    side.half[k] += Rgb::splat(0.5 * (a - b));
                }
            }
            let likelihood = Likelihood::of(&residuals(|_, _| 0.0), &field, floor);
            let reference =
                Reference { residuals: residuals(|_, _| 0.0), field: &field, likelihood };
            let sides = both.each_ref().map(|residuals| Side { residuals, field: &field, floor });
            Contrast::under(&reference, &blocks, sides.each_ref())
        };
        // Noise beside a wrong model, and noise alone.
        for (wrong, noise) in [(0.06, 0.1), (0.0, 1.0)] {
            let all: Vec<Contrast> = (0..400).map(|_| contrast(wrong, noise)).collect();
            let mean = |of: &dyn Fn(&Contrast) -> f64| all.iter().map(of).sum::<f64>() / 400.0;
            let level = mean(&|c| c.difference);
            let variance = mean(&|c| (c.difference - level).powi(2));
            let stated = mean(&|c| c.noise);
            // The variance of 400 is known to 7 %.
            assert!((stated / variance - 1.0).abs() < 0.2, "{stated} of {variance}");
        }
    }

    #[test]
    fn what_is_the_same_in_two_photographs_counts_once() {
        let scatter =
            |k: usize| DVec3::splat((mix(k as u64) >> 40) as f64 / (1u64 << 23) as f64 - 1.0);
        let n = 500;
        let same: Vec<(usize, usize)> = (0..n).map(|k| (k, n + k)).collect();
        let share = |of: &dyn Fn(usize) -> DVec3| {
            share_by([&[], &same], &(0..2 * n).map(of).collect::<Vec<DVec3>>())
        };
        assert!((share(&|k| scatter(k % n)) - 0.5).abs() < 1e-9);
        // The correlation of 500 that are independent is known to a twentieth.
        assert!(share(&scatter) > 0.9);
        assert!((share_by([&[], &[]], &[DVec3::ONE; 4]) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_change_of_the_light_is_free_of_the_noise_of_renderings() {
        let before = residuals(|_, _| 0.0);
        let brighter = residuals(|_, _| -0.1);
        assert!((brighter.change_from(&before) - 0.01).abs() < 1e-6);
        // One rendering a tenth above, the other as far below, in each block.
        let noisy = BlockResiduals { half: vec![Rgb::splat(0.1); SIDE * SIDE], ..before.clone() };
        assert!(noisy.change_from(&before) < 0.0);
    }
}
