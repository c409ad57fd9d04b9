//! All parameters of all groups at once, against the whole photograph, with standard deviations.
//!
//! The ladder has chosen the hypotheses and stands near their best parameters. What is left is a
//! least-squares problem of tens of unknowns ([`unknowns`]) of several kinds ([`parameters`]), for which Gauss-Newton needs
//! a handful of passes ([`passes`]). Each renders radiance and derivatives twice ([`means`]), makes the normal
//! equations of them ([`normal`]), and solves these within the bounds ([`system`]).
//!
//! The covariance of the result comes from the spread of the picture's blocks. It holds the noise of the photograph and
//! of our renderings, and the model error, whose sizes need not be known. Then [`verdict`] says what the photograph
//! does not determine; where that makes a hypothesis simpler, the rest is refined again.

pub(crate) mod brightness;
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
mod system;
mod unknowns;
mod verdict;

use crate::effort::Effort;
use crate::guess::Guess;
use crate::problem::{Options, RecoverError};
use crate::progress::Progress;
use crate::record::{Status, Termination};
use crate::sample_budget;
use crate::streams::Stream;
use nalgebra::{DMatrix, DVector};
use normal::Normal;
use passes::{COARSE, Passes};
use system::System;
use unknowns::Unknowns;

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

/// Refines all unknowns of `guess` together and finds their standard deviations.
///
/// [`Depth::Coarse`] stops where steps are no longer significant, and judges nothing.
pub(crate) fn refine<'a>(
    mut guess: Guess<'a>,
    options: &Options,
    depth: Depth,
    progress: &mut Progress<'_>,
) -> (Guess<'a>, Termination) {
    guess.forget_deviations();
    free_the_unseen(&mut guess);
    let is_anything_free = |guess: &Guess<'_>| Unknowns::of(guess).len() > 0;
    if !is_anything_free(&guess) {
        return (guess, Termination::Settled);
    }
    let mut passes = Passes::new(options);
    let effort = match depth {
        Depth::Rough if guess.problem.unknown_lights.is_empty() => Effort::Draft,
        _ => options.effort,
    };
    if depth != Depth::Fine {
        return (passes.approach(guess, effort, progress), Termination::Refined);
    }
    for round in 1.. {
        let mut solution;
        (guess, solution) = passes.converge(guess, progress);
        if progress.is_cancelled() {
            return (guess, Termination::Interrupted);
        }
        if solution.failed {
            return (guess, Termination::RefinementFailed);
        }
        if round < ROUNDS_MAX && verdict::simplify(&mut guess, &solution, options, progress) {
            if is_anything_free(&guess) {
                continue;
            }
            // The last unknown group is out of sight, and assumed now.
            break;
        }
        verdict::record(&mut guess, &mut solution);
        if !solution.settled {
            return (guess, Termination::RefinementLimit);
        }
        break;
    }
    (guess, Termination::Refined)
}

/// Groups out of sight are refined too: the verdict may assume them again.
fn free_the_unseen(guess: &mut Guess<'_>) {
    for of_group in &mut guess.groups {
        if of_group.status == Status::Assumed {
            of_group.status = Status::Recovered;
        }
    }
}

/// `guess` with the lights and the exposure near enough for the ladder to begin: the exposure by the anchor's ratio, or
/// both by one Gauss-Newton step on the groups that are known; and with its radiance cache from the photograph.
pub(crate) fn settle_nuisances<'a>(
    mut guess: Guess<'a>,
    options: &Options,
) -> Result<Guess<'a>, RecoverError> {
    guess.look_at_photograph();
    if guess.problem.unknown_lights.is_empty() {
        guess.update_exposure(options)?;
    } else {
        guess = adjust_nuisances(guess, options);
    }
    guess.look_at_photograph();
    Ok(guess)
}

fn adjust_nuisances<'a>(mut guess: Guess<'a>, options: &Options) -> Guess<'a> {
    let unknowns = Unknowns::nuisances(&guess);
    let cells = sample::known(&guess, options.effort.pixels(COARSE.0), options.seed);
    if unknowns.len() == 0 || cells.is_empty() {
        return guess;
    }
    let samples = vec![0..options.effort.samples(COARSE.1); cells.len()];
    let settings = sample_budget::paths(0, Stream::Nuisances.seed(options.seed), options);
    let gather = || means::gather(&guess, &unknowns, &cells, &samples, &settings);
    let means = guess.steps.value("nuisances", gather);
    let normal = Normal::of(&means, &unknowns, guess.materials.len());
    let system = System::new(&unknowns, &normal, &DVector::zeros(unknowns.len()));
    if let Some(step) = system.step(0.0, &unknowns.bounds(&guess)) {
        unknowns.apply(&mut guess, &step);
    }
    guess
}
