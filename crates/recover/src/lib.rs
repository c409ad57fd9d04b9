//! From a photograph, or several, and a scene to materials [Boivin and Gagalowicz 2002]. Sources are cited by the keys
//! of `docs/bibliography.md`; "the paper" is this one, and so is the source of a section or figure without one.
//!
//! The modules stand in the order of the paper's loop, plain data first:
//! photograph and scene ([`observe`], [`problem`]) -> [`evidence`] ->
//! [`hypothesis`] -> [`Renderer`] -> error ([`compare`], [`outliers`]) -> next
//! hypothesis ([`selection`], `ladder`) -> all parameters at once (`refine`) -> materials ([`record`]). The `driver` owns
//! iteration, verification and cancellation. The model is registered to the photograph before, by [`unrender_register`].
//!
//! [`recover`] does all of it. It touches no file, no clock and no terminal; the renderer is behind
//! the small trait [`Renderer`], and an [`Observer`] can follow the progress. [`recover_by`] takes a method of one's own:
//! the paper's is in the crate `unrender-paper`.

mod coated;
pub mod compare;
mod driver;
pub mod effort;
pub mod evidence;
pub mod expected;
pub mod fit;
mod group_error;
mod guess;
pub mod hypothesis;
pub mod journal;
pub mod ladder;
mod lit;
pub mod observe;
pub mod outliers;
mod picture;
pub mod problem;
mod progress;
pub mod record;
mod refine;
pub mod sample_budget;
mod schedule;
pub mod selection;
mod session;
mod streams;
pub mod texture;
mod unknown;
mod verify;

pub use effort::Effort;
pub use expected::{Expected, Like, ParameterBounds, StartValues};
pub use hypothesis::Hypothesis;
pub use journal::Journal;
pub use observe::observation::{Observation, PhotographNoise, Picture, PixelStatus};
pub use observe::photometric::{PhotometricEstimate, PhotometricParameter};
pub use problem::{ExposureRule, GroupSpec, Options, Problem, RecoverError, Role, Thresholds};
pub use record::{
    Alternative, Covariance, Decision, Deviations, GroupIteration, GroupResult, IterationRecord,
    LightResult, Observer, Recovery, Rule, Status, Termination,
};
pub use schedule::expected_seconds;
pub use session::Session;
pub use texture::Detail;
pub use unknown::{Quantity, Unknown};
pub use unrender_render::{Query, Renderer, Stored, View, Views};
pub use unrender_scene::Sheet;

use guess::Guess;
use journal::Steps;
use progress::Progress;
use streams::Stream;
use unrender_scene::{Material, Rgb};

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
    let mut progress = Progress::new(problem, options, observer);
    let (guess, termination) = refined(problem, materials, options, &mut progress)?;
    Ok(picture::finish(guess, &last_picture(options, termination), termination, progress))
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
    let mut progress = Progress::new(problem, options, observer);
    let (guess, _) = refined(problem, materials, options, &mut progress)?;
    Ok(guess.groups.into_iter().map(|of_group| of_group.std).collect())
}

/// What `pixels` show by so many paths each if every group of `problem` is diffuse and quickly fitted, in the photograph's
/// values.
///
/// # Errors
/// If the camera sees nothing, or the anchor cannot fix the exposure.
pub fn sketched(
    problem: &Problem<'_>,
    options: &Options,
    (pixels, spp): (&[u32], u32),
) -> Result<Vec<Rgb>, RecoverError> {
    let mut nobody = ();
    let mut progress = Progress::new(problem, options, &mut nobody);
    let guess = refine::settle_nuisances(Guess::new(problem)?, options)?;
    let (guess, _) = refine::refine(guess, options, refine::Depth::Rough, &mut progress);
    let settings = sample_budget::paths(spp, Stream::Sketch.seed(options.seed), options);
    let rendered = problem.renderer.rerender(guess.appearance(), pixels, &settings);
    Ok(rendered.into_iter().map(|radiance| radiance / guess.exposure).collect())
}

fn refined<'a>(
    problem: &'a Problem<'a>,
    materials: &[Material],
    options: &Options,
    progress: &mut Progress<'_>,
) -> Result<(Guess<'a>, Termination), RecoverError> {
    let mut guess = Guess::new(problem)?;
    guess.assign_materials(materials);
    lit::leave_out_the_dark(&mut guess, options)?;
    let guess = refine::settle_nuisances(guess, options)?;
    Ok(refine::refine(guess, options, refine::Depth::Fine, progress))
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
    run(problem, options, observer, None, driver::drive)
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
    run(problem, options, observer, Some(journal), driver::drive)
}

/// Recovers by another `method`, which finds the hypotheses and materials; what comes before and after it is that of
/// [`recover_with`].
///
/// # Errors
/// As those of [`recover`], and those of `method`.
pub fn recover_by(
    problem: &Problem<'_>,
    options: &Options,
    observer: &mut dyn Observer,
    journal: Option<&dyn Journal>,
    method: impl FnOnce(&mut Session<'_, '_, '_>) -> Result<Termination, RecoverError>,
) -> Result<Recovery, RecoverError> {
    run(problem, options, observer, journal, |mut guess, _, progress| {
        let termination = method(&mut Session::of(&mut guess, progress))?;
        Ok((guess, termination))
    })
}

fn run<'a>(
    problem: &'a Problem<'a>,
    options: &Options,
    observer: &mut dyn Observer,
    journal: Option<&'a dyn Journal>,
    method: impl FnOnce(
        Guess<'a>,
        &Options,
        &mut Progress<'_>,
    ) -> Result<(Guess<'a>, Termination), RecoverError>,
) -> Result<Recovery, RecoverError> {
    let mut guess = Guess { steps: Steps(journal), ..Guess::new(problem)? };
    lit::leave_out_the_dark(&mut guess, options)?;
    let mut progress = Progress::new(problem, options, observer);
    let (guess, termination) = method(guess, options, &mut progress)?;
    Ok(picture::finish(guess, &last_picture(options, termination), termination, progress))
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
