//! Model selection: the simplest hypothesis whose residual is statistically indistinguishable from
//! the best.
//!
//! A pure step: fits of one group on the same evidence go in, a decision with its numbers comes out.
//! Hypotheses are compared by the Bayesian information criterion [Schwarz 1978]
//! `IC = (N_eff / N) deviance + p ln N_eff`, with `p` free parameters. The deviance is that of the
//! observation model ([`crate::model_error`]); `N` is the number of blocks and `N_eff` the number of
//! independent ones among them, from the correlation `r` of neighbouring blocks' residuals under the
//! best hypothesis: `N_eff = N ((1 - r) / (1 + r))^2`. A candidate whose rendering is mostly noise
//! has a large variance, which the deviance counts against it.

use crate::blocks::Blocks;
use crate::evidence::Evidence;
use crate::hypothesis::{Fit, Hypothesis};
use crate::model_error::standardised;

/// A simpler hypothesis stands unless a more complex one has an information criterion lower by this:
/// strong evidence [Kass & Raftery 1995]. Half of it is called positive, double of it decisive.
pub(crate) const STRONG: f64 = 6.0;
/// No fewer blocks than this share are taken as independent: the correlation is an estimate.
const LEAST_INDEPENDENT: f64 = 0.05;

/// What was decided for one group, and by which numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The index of the fit to take.
    pub chosen: usize,
    /// For each fit: its information criterion less the lowest.
    pub excess: Vec<f64>,
    /// Blocks that are independent of each other, about.
    pub independent: f64,
}

/// Free parameters of a hypothesis without a texture.
fn parameters(hypothesis: Hypothesis) -> f64 {
    match hypothesis {
        Hypothesis::Mirror => 0.0,
        Hypothesis::Diffuse | Hypothesis::PartialMirror | Hypothesis::Textured => 3.0,
        Hypothesis::DiffuseSpecular => 6.0,
        Hypothesis::Isotropic => 7.0,
        Hypothesis::Anisotropic => 9.0,
    }
}

/// Chooses among the `fits` that are `allowed` (the first always is); they go from simple to complex,
/// all on the same `evidence`, and there is at least one. With `simpler`, one is preferred whose
/// error is at most so many times the best one's.
pub fn select(
    fits: &[Fit],
    evidence: &Evidence,
    allowed: &dyn Fn(&Fit) -> bool,
    simpler: Option<f64>,
) -> Decision {
    let deviance = |fit: &&Fit| fit.likelihood.deviance;
    let competes = |i: usize| i == 0 || allowed(&fits[i]);
    let best = (0..fits.len()).filter(|i| competes(*i)).map(|i| &fits[i]);
    let best = best.min_by(|a, b| deviance(a).total_cmp(&deviance(b)));
    let independent = best.map_or(1.0, |best| independent_blocks(best, evidence));
    let scale = independent / evidence.blocks.len().max(1) as f64;
    let criteria: Vec<f64> = fits
        .iter()
        .map(|fit| {
            scale * fit.likelihood.deviance + parameters(fit.hypothesis) * independent.max(1.0).ln()
        })
        .collect();
    let competing = (0..fits.len()).filter(|i| competes(*i));
    let lowest = competing.map(|i| criteria[i]).fold(f64::INFINITY, f64::min);
    let excess: Vec<f64> = criteria.iter().map(|c| c - lowest).collect();
    let least = best.map_or(0.0, |best| best.residual.relative());
    let good = |i: &usize| {
        let near = simpler.is_some_and(|times| fits[*i].residual.relative() <= times * least);
        competes(*i) && (excess[*i] <= STRONG || near)
    };
    let chosen = (0..fits.len()).find(good).unwrap_or(0);
    Decision { chosen, excess, independent }
}

/// Whether `fit` explains the evidence no worse than `best` does, as far as it tells.
pub fn explains_alike(fit: &Fit, best: &Fit, evidence: &Evidence) -> bool {
    let scale = independent_blocks(best, evidence) / evidence.blocks.len().max(1) as f64;
    scale * (fit.likelihood.deviance - best.likelihood.deviance) <= STRONG
}

/// How many of the blocks are independent of each other under `fit`.
fn independent_blocks(fit: &Fit, evidence: &Evidence) -> f64 {
    let residuals = standardised(&fit.residuals, &evidence.field, &fit.likelihood);
    let correlation = neighbour_correlation(&evidence.blocks, &residuals);
    let share = ((1.0 - correlation) / (1.0 + correlation)).powi(2);
    evidence.blocks.len() as f64 * share.max(LEAST_INDEPENDENT)
}

/// The correlation of the values of neighbouring blocks, 0 to 1.
fn neighbour_correlation(blocks: &Blocks, values: &[glam::DVec3]) -> f64 {
    let pairs = blocks.neighbours();
    if pairs.is_empty() {
        return 0.0;
    }
    let product = pairs.iter().map(|&(i, j)| values[i].dot(values[j])).sum::<f64>();
    let square = values.iter().map(|v| v.length_squared()).sum::<f64>();
    let mean = square / values.len() as f64;
    if mean > 0.0 { (product / pairs.len() as f64 / mean).clamp(0.0, 1.0) } else { 0.0 }
}
