//! All parameters of all groups at once, against the whole photograph, with standard deviations.
//!
//! The ladder has chosen the hypotheses and stands near their best parameters. What is left is a
//! least-squares problem of tens of unknowns ([`unknowns`]) of several kinds ([`parameters`]), for which Gauss-Newton needs
//! a handful of passes ([`passes`]). Each renders radiance and derivatives twice ([`means`]), makes the normal
//! equations of them ([`normal`]), and solves these within the bounds ([`system`]).
//!
//! The covariance of the result comes from the spread of the picture's blocks. It holds the noise of the photograph and
//! of our renderings, and the model error, whose sizes need not be known. Then [`verdict`] says what the photograph
//! does not determine; where that makes a hypothesis simpler, the rest is refined again. Hypotheses of one group are
//! compared on the same kind of paths ([`side_by_side`]).

pub(crate) mod brightness;
pub(crate) mod contenders;
mod descent;
mod kept;
pub(crate) mod local_minima;
mod means;
mod needs;
mod normal;
mod origins;
mod parameters;
mod passes;
mod relations;
mod sample;
pub(crate) mod score_test;
pub(crate) mod side_by_side;
mod system;
mod unknowns;
mod verdict;

use crate::effort::Effort;
use crate::problem::{Options, RecoverError};
use crate::record::{Observer, Status, Termination};
use crate::state::State;
use nalgebra::{DMatrix, DVector};
use normal::Normal;
use passes::{COARSE, Passes};
use system::System;
use unknowns::Unknowns;
use unrender_render::Settings;
use unrender_render::sampler::mix;

/// The most refinements; each but the last may end with simpler hypotheses: of groups in sight, of these once more, and
/// of those out of sight.
const ROUNDS_MAX: usize = 4;

/// How far to refine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// Until no step is significant, on as few paths as a draft has.
    Rough,
    /// Until no step is significant.
    Coarse,
    /// Until the renderings' noise does not matter, with standard deviations.
    Fine,
}

/// The result of a joint refinement.
struct Solution {
    unknowns: Unknowns,
    covariance: DMatrix<f64>,
    settled: bool,
    /// Whether a step could not be solved.
    failed: bool,
}

/// Refines all unknowns of `state` together and finds their standard deviations.
///
/// [`Depth::Coarse`] stops where steps are no longer significant, and judges nothing.
pub(crate) fn refine(
    state: &mut State<'_>,
    options: &Options,
    depth: Depth,
    observer: &mut dyn Observer,
) -> Termination {
    state.forget_deviations();
    free_the_unseen(state);
    let is_anything_free = |state: &State<'_>| Unknowns::of(state).len() > 0;
    if !is_anything_free(state) {
        return Termination::Settled;
    }
    let mut passes = Passes::new(options);
    let effort = match depth {
        Depth::Rough if state.problem.unknown_lights.is_empty() => Effort::Draft,
        _ => options.effort,
    };
    if depth != Depth::Fine {
        passes.approach(state, effort, observer);
        return Termination::Refined;
    }
    for round in 1.. {
        let solution = passes.converge(state, observer);
        if observer.is_cancelled() {
            return Termination::Interrupted;
        }
        if solution.failed {
            return Termination::RefinementFailed;
        }
        if round < ROUNDS_MAX && verdict::simplify(state, &solution, options) {
            if is_anything_free(state) {
                continue;
            }
            // The last unknown group is out of sight, and assumed now.
            break;
        }
        verdict::record(state, &solution);
        if !solution.settled {
            return Termination::RefinementLimit;
        }
        break;
    }
    Termination::Refined
}

/// Groups out of sight are refined too: the verdict may assume them again.
fn free_the_unseen(state: &mut State<'_>) {
    for of_group in &mut state.groups {
        if of_group.status == Status::Assumed {
            of_group.status = Status::Recovered;
        }
    }
}

/// Brings the lights and the exposure near enough for the ladder to begin: the exposure by the
/// anchor's ratio, or both by one Gauss-Newton step on the groups that are known. Then updates the
/// radiance cache from the photograph.
pub(crate) fn settle_nuisances(
    state: &mut State<'_>,
    options: &Options,
) -> Result<(), RecoverError> {
    state.look_at_photograph();
    if state.problem.unknown_lights.is_empty() {
        state.update_exposure(options)?;
    } else {
        adjust_nuisances(state, options);
    }
    state.look_at_photograph();
    Ok(())
}

fn adjust_nuisances(state: &mut State<'_>, options: &Options) {
    let unknowns = Unknowns::nuisances(state);
    let cells = sample::known(state, options.effort.pixels(COARSE.0), options.seed);
    if unknowns.len() == 0 || cells.is_empty() {
        return;
    }
    let samples = vec![0..options.effort.samples(COARSE.1); cells.len()];
    let seed = mix(options.seed ^ 0x11687);
    let settings = Settings {
        first: 0,
        together: crate::sample_budget::TOGETHER,
        spp: 0,
        seed,
        max_bounces: options.max_bounces,
        integrator: unrender_render::Integrator::Path,
    };
    let gather = || means::gather(state, &unknowns, &cells, &samples, &settings);
    let means = state.steps.value("nuisances", gather);
    let normal = Normal::of(&means, &unknowns, state.materials.len());
    let system = System::new(&unknowns, &normal, &DVector::zeros(unknowns.len()));
    if let Some(step) = system.step(0.0, &unknowns.bounds(state)) {
        unknowns.apply(state, &step);
    }
}
