//! From a photograph, or several, and a scene to materials [Boivin and Gagalowicz 2002]. Sources are cited by the keys
//! of `docs/bibliography.md`; "the paper" is this one, and so is the source of a section or figure without one.
//!
//! The modules stand in the order of the paper's loop, plain data first:
//! photograph and scene ([`observation`], [`blocks`], [`problem`]) -> [`evidence`] ->
//! [`hypothesis`] -> [`rerender`] -> error ([`model_error`], [`residual`], [`outliers`]) -> next
//! hypothesis ([`selection`], `ladder`; as the paper does it: [`paper`]) -> all parameters at once (`refine`) -> materials
//! ([`record`]). The `driver` owns iteration, verification and cancellation. The model is registered to the photograph
//! before, by [`unrender_register`].
//!
//! [`recover`] does all of it. It touches no file, no clock and no terminal; the renderer is behind
//! the small trait [`Renderer`], and an [`Observer`] can follow the progress.

pub mod block_residuals;
pub mod blocks;
mod coated;
pub mod contrast;
mod criterion;
mod driver;
pub mod effort;
pub mod evidence;
pub mod expected;
pub mod fit;
mod group_error;
pub mod hypothesis;
pub mod journal;
pub mod ladder;
pub mod likelihood;
mod lit;
pub mod model_error;
pub mod noise;
pub mod observation;
mod others;
pub mod outliers;
pub mod paper;
mod photometric;
mod picture;
pub mod problem;
pub mod record;
mod refine;
pub mod rerender;
pub mod residual;
mod same_place;
pub mod sample_budget;
mod schedule;
pub mod selection;
mod sheet;
pub mod sketch;
mod state;
mod unknown;
mod verify;
pub mod views;
mod within;

pub use effort::Effort;
pub use expected::{Expected, Like, ParameterBounds, StartValues};
pub use hypothesis::Hypothesis;
pub use hypothesis::textured::Detail;
pub use journal::Journal;
pub use observation::{Observation, PhotographNoise, Picture, PixelStatus};
pub use photometric::{PhotometricEstimate, PhotometricParameter};
pub use problem::{
    ExposureRule, GroupSpec, LadderKind, Options, PaperDirection, Problem, RecoverError, Role,
    Thresholds,
};
pub use record::{
    Alternative, Covariance, Deviations, GroupIteration, GroupResult, IterationRecord, LightResult,
    ObjectsSeen, Observer, Recovery, Status, Termination,
};
pub use rerender::{Renderer, Stored, View};
pub use schedule::expected_seconds;
pub use sheet::Sheet;
pub use unknown::{Quantity, Unknown};
pub use views::Views;

use journal::Steps;
use state::State;
use unrender_scene::Material;

/// Refines `materials`, one for each group of `problem`, which are near what the photograph shows:
/// those of an earlier recovery, say. Each keeps its hypothesis unless the photograph does not bear
/// it out.
///
/// # Errors
/// If the camera sees nothing, no light reaches what it sees, or the anchor cannot fix the exposure.
pub fn refine_from(
    problem: &Problem<'_>,
    materials: &[Material],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Recovery, RecoverError> {
    let (state, termination) = refined(problem, materials, options, observer)?;
    Ok(picture::finish(state, &last_picture(options, termination), termination, observer))
}

/// The standard deviations of the numbers of each group of `problem` if `materials`, one for each group, are right:
/// those after a refinement that begins at them as [`refine_from`] does; no picture is rendered.
///
/// # Errors
/// As those of [`refine_from`].
pub fn deviations_at(
    problem: &Problem<'_>,
    materials: &[Material],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Vec<Option<Deviations>>, RecoverError> {
    let (state, _) = refined(problem, materials, options, observer)?;
    Ok(state.groups.into_iter().map(|of_group| of_group.std).collect())
}

fn refined<'a>(
    problem: &'a Problem<'a>,
    materials: &[Material],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<(State<'a>, Termination), RecoverError> {
    let mut state = State::new(problem)?;
    state.assign_materials(materials);
    lit::leave_out_the_dark(&mut state, options)?;
    refine::settle_nuisances(&mut state, options)?;
    let termination = refine::refine(&mut state, options, refine::Depth::Fine, observer);
    Ok((state, termination))
}

/// Recovers the material of every group of `problem`.
///
/// # Errors
/// If the camera sees nothing, no light reaches what it sees, or the anchor cannot fix the exposure.
pub fn recover(
    problem: &Problem<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Recovery, RecoverError> {
    run(State::new(problem)?, options, observer)
}

/// As [`recover`], with a journal: steps that an earlier run of the same problem and options has left there are not
/// done again, and new ones are kept there. The result has the same bits with and without it.
///
/// # Errors
/// As those of [`recover`].
pub fn recover_with(
    problem: &Problem<'_>,
    options: &Options,
    observer: &mut dyn Observer,
    journal: &dyn Journal,
) -> Result<Recovery, RecoverError> {
    let state = State { steps: Steps(Some(journal)), ..State::new(problem)? };
    run(state, options, observer)
}

fn run(
    mut state: State<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Recovery, RecoverError> {
    lit::leave_out_the_dark(&mut state, options)?;
    state.schedule = schedule::Schedule::new(state.problem, options);
    let termination = match options.ladder {
        LadderKind::Default => driver::drive(&mut state, options, observer)?,
        LadderKind::Paper => paper::run(&mut state, options, observer)?,
    };
    Ok(picture::finish(state, &last_picture(options, termination), termination, observer))
}

/// The settings of the last picture: a user who interrupts is not kept waiting for a clean one.
fn last_picture(options: &Options, termination: Termination) -> Options {
    /// Paths a pixel of that. Half and double of it were not tried.
    const HASTY: u32 = 8;
    match termination {
        Termination::Interrupted => Options { spp: options.spp.min(HASTY), ..options.clone() },
        _ => options.clone(),
    }
}
