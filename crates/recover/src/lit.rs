//! Whether any light of the scene reaches what the photograph shows: without it the photograph says nothing of a
//! reflectance, and every number of a fit would be a quotient of zeros.

use crate::blocks::spread;
use crate::hypothesis;
use crate::problem::{Options, RecoverError, Role};
use crate::record::Status;
use crate::state::State;
use unrender_render::ProbeSettings;
use unrender_render::sampler::mix;

/// Pixels of each group in which the light is looked for: a few, and many where these are dark. Light that reaches a
/// hundredth of a group is missed by 256 in one case of thirteen, by half of them in one of four, by double in one of 170.
const PIXELS: [usize; 2] = [16, 256];
/// Directions in each pixel, and as many towards the lamps. A surface that so many paths find dark is dark to the recovery,
/// too, which looks no harder.
const DIRECTIONS: u32 = 16;

/// Leaves out the pixels of the groups that no light reaches, as if nothing was seen of them.
///
/// # Errors
/// If light reaches no surface that the photograph shows.
pub(crate) fn leave_out_the_dark(
    state: &mut State<'_>,
    options: &Options,
) -> Result<(), RecoverError> {
    let is_seen = |group: &usize| {
        let role = state.problem.groups[*group].role;
        role != Role::Emitter && !state.observation.pixels_of_group[*group].is_empty()
    };
    let seen: Vec<usize> = (0..state.problem.groups.len()).filter(is_seen).collect();
    let dark: Vec<usize> = seen.iter().copied().filter(|g| is_dark(state, *g, options)).collect();
    if !seen.is_empty() && dark.len() == seen.len() {
        let names = dark.iter().map(|group| state.problem.groups[*group].name.clone());
        return Err(RecoverError::NoLight(names.collect()));
    }
    for group in dark {
        state.observation.pixels_of_group[group].clear();
        state.observation.informative_of_group[group].clear();
        state.groups[group].is_dark = true;
        if state.problem.groups[group].role == Role::Unknown {
            state.materials[group] = state.problem.groups[group].unseen();
            state.groups[group].hypothesis = hypothesis::of(&state.materials[group]);
            state.groups[group].status = Status::Assumed;
        }
    }
    Ok(())
}

/// Whether no path from the pixels of `group` finds light.
fn is_dark(state: &State<'_>, group: usize, options: &Options) -> bool {
    let settings = ProbeSettings {
        cosine: DIRECTIONS,
        seed: mix(options.seed ^ 0x117),
        max_bounces: options.max_bounces,
        ..ProbeSettings::default()
    };
    let is_dark = |count: usize| {
        let sample = spread(&state.observation.pixels_of_group[group], count, options.seed);
        let found = state.problem.renderer.probe(state.appearance(), &sample, &settings, None);
        found.probes.iter().all(|probe| probe.diffuse.max_element() <= 0.0)
    };
    PIXELS.into_iter().all(is_dark)
}
