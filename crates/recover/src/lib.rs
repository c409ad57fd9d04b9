//! One photograph and a scene to materials [Boivin & Gagalowicz 2002].
//!
//! The modules stand in the order of one turn of the paper's loop:
//! photograph and scene ([`observation`], [`problem`]) -> [`evidence`] -> [`hypothesis`] ->
//! [`rerender`] -> [`error`] -> next hypothesis (`ladder`) -> materials ([`record`]).
//!
//! [`recover`] is the whole of it. It touches no file, no clock and no terminal; the renderer is
//! behind the small trait [`Renderer`], and whoever wants to follow gives an [`Observer`].

pub mod error;
pub mod evidence;
pub mod fit;
pub mod hypothesis;
pub mod ladder;
pub mod observation;
mod picture;
pub mod problem;
pub mod record;
mod refine;
pub mod rerender;

pub use hypothesis::Hypothesis;
pub use observation::{Observation, Picture};
pub use problem::{
    ExposureRule, GroupSpec, LadderKind, Options, Problem, RecoverError, Role, Thresholds,
};
pub use record::{
    Deviations, GroupResult, LightResult, Observer, Recovery, Status, Termination, TurnRecord,
};
pub use rerender::{Renderer, View};

use ladder::{State, climb, paper};

/// Recovers the material of every group of `problem`.
///
/// # Errors
/// If the camera sees nothing, or the anchor cannot fix the exposure.
pub fn recover(
    problem: &Problem<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Recovery, RecoverError> {
    let mut state = State::new(problem)?;
    let termination = match options.ladder {
        LadderKind::Default => {
            let climbed = climb::climb(&mut state, options, observer)?;
            let refined = options.refine.then(|| refine::refine(&mut state, options, observer));
            climb::finish_textures(&mut state, options);
            refined.unwrap_or(climbed)
        }
        LadderKind::Paper => paper::climb(&mut state, options, observer)?,
    };
    Ok(picture::finish(state, options, termination, observer))
}
