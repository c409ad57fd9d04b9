//! One photograph and a scene to materials [Boivin & Gagalowicz 2002].
//!
//! The modules stand in the order of one turn of the paper's loop:
//! photograph and scene ([`register`], [`observation`], [`problem`]) -> [`evidence`] ->
//! [`hypothesis`] -> [`rerender`] -> [`error`], [`stray`] -> next hypothesis (`ladder`) -> all
//! numbers at once (`refine`) -> materials ([`record`]).
//!
//! [`recover`] is the whole of it. It touches no file, no clock and no terminal; the renderer is
//! behind the small trait [`Renderer`], and whoever wants to follow gives an [`Observer`].

pub mod convert;
pub mod correction;
pub mod error;
pub mod evidence;
pub mod fit;
pub mod hypothesis;
pub mod ladder;
pub mod observation;
mod picture;
pub mod problem;
pub mod prospect;
pub mod record;
mod refine;
pub mod register;
pub mod rerender;
pub mod stray;

pub use correction::{Corrected, Correction};
pub use hypothesis::Hypothesis;
pub use observation::{Observation, Picture, Trust};
pub use problem::{
    ExposureRule, GroupSpec, LadderKind, Options, Problem, RecoverError, Role, Thresholds,
};
pub use record::{
    Alternative, Deviations, GroupResult, GroupTurn, LightResult, Observer, Recovery, Status,
    Termination, TurnRecord,
};
pub use rerender::{Renderer, View};

use ladder::{State, climb, paper};
use unrender_scene::Material;

/// Refines `materials`, one for each group of `problem`, which are near what the photograph shows:
/// those of an earlier recovery, say. Each keeps its hypothesis unless the photograph does not bear
/// it out.
///
/// # Errors
/// If the camera sees nothing, or the anchor cannot fix the exposure.
pub fn refine_from(
    problem: &Problem<'_>,
    materials: &[Material],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Recovery, RecoverError> {
    let mut state = State::new(problem)?;
    state.wear(materials);
    refine::settle_nuisances(&mut state, options)?;
    let termination = refine::refine(&mut state, options, observer);
    Ok(picture::finish(state, options, termination, observer))
}

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
            let mut termination = climb::climb(&mut state, options, observer)?;
            if options.refine {
                termination = refine::refine(&mut state, options, observer);
                if climb::reconsider_textures(&mut state, options) {
                    termination = refine::refine(&mut state, options, observer);
                }
                refine::basins::find(&mut state, options);
            }
            climb::finish_textures(&mut state, options);
            termination
        }
        LadderKind::Paper => paper::climb(&mut state, options, observer)?,
    };
    Ok(picture::finish(state, options, termination, observer))
}
