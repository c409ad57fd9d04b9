//! Evidence gathered anew, under the refined light: what the ladder compared its candidates by may have been
//! another light.

use crate::evidence::Evidence;
use crate::hypothesis::{self, Fit, Hypothesis, Search};
use crate::model_error::ModelError;
use crate::others::light_of_others;
use crate::problem::Options;
use crate::sample_budget;
use crate::selection::Comparison;
use crate::state::State;

/// Pixels that are looked at. At half of it faint lobes go, double costs as much as the ladder's candidates.
const PIXELS: usize = 2000;

/// The evidence on `group` by light samples that no search has seen, weighted for its present material; none
/// where nothing was seen of it.
pub(super) fn evidence(state: &State<'_>, options: &Options, group: usize) -> Option<Evidence> {
    let other_noise = Options { seed: options.seed ^ 0xBA51, ..options.clone() };
    let pixels = &state.observation.pixels_of_group[group];
    let mut budget = sample_budget::candidates(
        sample_budget::Level::Refined,
        &other_noise,
        &state.problem.unknown_lights,
        pixels.len(),
    );
    budget.pixels = options.effort.pixels(PIXELS);
    budget.probe.max_bounces = options.max_bounces;
    let gathered = Evidence::gather(&state.stage(), state.appearance(), group, pixels, &budget);
    let mut evidence = gathered.expecting(state.problem.groups[group].expected);
    if evidence.is_empty() {
        return None;
    }
    let error = state.groups[group].likelihood.map_or(ModelError::START, |l| l.error);
    evidence.reweigh(&state.materials[group], error);
    Some(evidence)
}

/// Whether `group` needs more than the `simpler` hypothesis: by the information criterion, which asks whether a
/// lobe is there, or whether it has a width, where the standard deviations say how strong or how wide it is (a
/// single highlight leaves a lobe's strength uncertain and its presence certain).
pub(super) fn needs_more_than(
    simpler: Hypothesis,
    state: &State<'_>,
    options: &Options,
    group: usize,
) -> bool {
    let Some(mut evidence) = evidence(state, options, group) else {
        return false;
    };
    evidence.field.most = light_of_others(state, group);
    let present = &state.materials[group];
    let of = |hypothesis| hypothesis::fit(hypothesis, &evidence, present, Search::Kept);
    let fits = [simpler, state.groups[group].hypothesis].map(of);
    if !fits.iter().all(Fit::is_finite) {
        return false;
    }
    Comparison::new(&fits, &evidence).choose(&|_| true, None).chosen != 0
}
