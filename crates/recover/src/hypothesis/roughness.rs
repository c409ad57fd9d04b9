//! Searches over the roughness of a lobe: from everywhere, and downhill from where one is known.

use super::Fit;
use crate::compare::STRONG;
use crate::compare::likelihood::Likelihood;
use crate::evidence::Evidence;
use crate::fit::simplex;
use rayon::prelude::*;

/// The steps of the global search: each about 1.6 times the one before.
const GLOBAL: [f32; 10] = [0.01, 0.016, 0.025, 0.04, 0.065, 0.1, 0.16, 0.25, 0.4, 0.65];

/// Steps of a global and of a local search.
pub(super) const STEPS: [u64; 2] = [30, 15];

/// The most likely roughness by its `deviance`: the best of [`GLOBAL`], and downhill from there; or from the value that
/// the user starts from, if that leads to one as likely.
pub(super) fn anywhere(evidence: &Evidence, deviance: &(dyn Fn(f32) -> f64 + Sync)) -> f32 {
    let by_log = |p: &[f64]| deviance(p[0].exp() as f32);
    let downhill = |from: f32| {
        let from = f64::from(from).ln();
        let (best, cost) = simplex::minimise(by_log, &[from], &[0.2], LIKELY, STEPS[0]);
        (cost, evidence.expected.bounds.nearest_round(best[0].exp() as f32))
    };
    let costs: Vec<_> = GLOBAL.into_par_iter().map(|alpha| (deviance(alpha), alpha)).collect();
    let best = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.1, |best| best.1);
    preferred(downhill(best), evidence.expected.start.alpha_x.map(downhill))
}

/// The minimum that the user's start leads to, unless the evidence for the `usual` one is [`STRONG`]; both with
/// their deviances.
pub(super) fn preferred<T>(usual: (f64, T), started: Option<(f64, T)>) -> T {
    match started {
        Some(started) if started.0 <= usual.0 + STRONG => started.1,
        _ => usual.1,
    }
}

/// Global searches stop when the deviances at the corners of the simplex differ by less than this: a
/// tenth of what counts as evidence.
pub(super) const LIKELY: f64 = 0.5;

/// The numbers downhill from `first`, whose fits are `fitted`, under the model error that the first one leaves.
pub(super) fn downhill_by(
    evidence: &Evidence,
    fitted: &dyn Fn(&[f64]) -> Fit,
    (first, size): (&[f64], &[f64]),
    steps: u64,
) -> Vec<f64> {
    let Likelihood { light, error, .. } = fitted(first).likelihood;
    let cost = |p: &[f64]| {
        Likelihood::given(&fitted(p).residuals, &evidence.sample.field, (light, error)).deviance
    };
    simplex::minimise(cost, first, size, SETTLED, steps).0
}

/// Local searches stop when the deviances at the corners of the simplex differ by less than this: a
/// hundredth of what one standard deviation of a number costs.
const SETTLED: f64 = 0.01;
