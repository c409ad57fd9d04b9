//! Whether any light of the scene reaches what the photograph shows: without it the photograph says nothing of a
//! reflectance, and every number of a fit would be a quotient of zeros.

use crate::guess::Guess;
use crate::hypothesis;
use crate::observe::blocks::spread;
use crate::problem::{Options, RecoverError, Role};
use crate::record::Status;
use crate::streams::Stream;
use std::sync::Arc;
use unrender_render::{ProbeSettings, Query};

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
    guess: &mut Guess<'_>,
    options: &Options,
) -> Result<(), RecoverError> {
    let is_seen = |group: &usize| {
        let role = guess.problem.groups[*group].role;
        role != Role::Emitter && !guess.observation.pixels_of_group[*group].is_empty()
    };
    let seen: Vec<usize> = (0..guess.problem.groups.len()).filter(is_seen).collect();
    let dark: Vec<usize> = seen.iter().copied().filter(|g| is_dark(guess, *g, options)).collect();
    if !seen.is_empty() && dark.len() == seen.len() {
        let names = dark.iter().map(|group| guess.problem.groups[*group].name.clone());
        return Err(RecoverError::NoLight(names.collect()));
    }
    for group in dark {
        let observation = Arc::make_mut(&mut guess.observation);
        observation.pixels_of_group[group].clear();
        observation.informative_of_group[group].clear();
        guess.groups[group].is_dark = true;
        if guess.problem.groups[group].role == Role::Unknown {
            guess.materials[group] = guess.problem.groups[group].unseen();
            guess.groups[group].hypothesis = hypothesis::of(&guess.materials[group]);
            guess.groups[group].status = Status::Assumed;
        }
    }
    Ok(())
}

/// Whether no path from the pixels of `group` finds light.
fn is_dark(guess: &Guess<'_>, group: usize, options: &Options) -> bool {
    let settings = ProbeSettings {
        cosine: DIRECTIONS,
        seed: Stream::Darkness.seed(options.seed),
        max_bounces: options.max_bounces,
        ..ProbeSettings::default()
    };
    let is_dark = |count: usize| {
        let sample = spread(&guess.observation.pixels_of_group[group], count, options.seed);
        let query = Query::new(guess.appearance(), &sample, &settings);
        let found = guess.problem.renderer.probe(&query);
        found.probes.iter().all(|probe| probe.diffuse.max_element() <= 0.0)
    };
    PIXELS.into_iter().all(is_dark)
}
