//! The last picture: the photograph's view rendered with the results, and each group's error in it.

use crate::group_error::GroupError;
use crate::guess::Guess;
use crate::hypothesis::{Fit, Hypothesis};
use crate::problem::{Options, Role};
use crate::progress::Progress;
use crate::record::{Alternative, GroupResult, Recovery, Status, Termination};
use crate::schedule::Phase;
use crate::streams::Stream;
use glam::Vec3;
use std::ops::Range;
use unrender_render::{Integrator, NOTHING, Settings};
use unrender_scene::color::luminance;
use unrender_scene::{Image, Rgb, RgbImage};

/// Renders the last picture and gathers the results.
pub(crate) fn finish(
    guess: Guess<'_>,
    options: &Options,
    termination: Termination,
    mut progress: Progress<'_>,
) -> Recovery {
    let halves = render_twice(&guess, options, &progress);
    progress.begin(Phase::Errors);
    let by_more = (termination != Termination::Interrupted).then_some(options);
    let count = guess.materials.len();
    let error = |group: usize| {
        let what = format!("measuring the error of \"{}\"", guess.problem.groups[group].name);
        progress.working(&what, group as f64 / count as f64);
        GroupError::of(&guess, group, &halves, by_more)
    };
    let errors: Vec<GroupError> = (0..count).map(error).collect();
    let whole = errors.iter().map(|error| error.squares.square.max(0.0)).sum();
    let groups = errors.iter().enumerate().map(|(group, error)| {
        let decisions = progress.decisions.iter().filter(|(of, _)| *of == group);
        let decisions = decisions.map(|(_, decision)| decision.clone()).collect();
        GroupResult { decisions, ..group_result(&guess, group, error, whole) }
    });
    let groups = groups.collect();
    let mean = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let noise = noise(&guess, &halves);
    let geometry = guess.problem.renderer.geometry();
    let samples = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * luminance(*a - *b)).collect();
    Recovery {
        groups,
        exposure: guess.exposure,
        exposure_std: guess.exposure_std,
        covariance: guess.covariance,
        lights: guess.light_results,
        photometric: guess.photometric,
        noise,
        noise_sample: Image::new(geometry.width(), geometry.height(), samples),
        rerendered: RgbImage::new(geometry.width(), geometry.height(), mean),
        status: guess.observation.status.clone(),
        iterations: progress.iterations,
        termination,
    }
}

/// Two pictures with half of the paths each, so that their noise can be separated from the error.
fn render_twice(guess: &Guess<'_>, options: &Options, progress: &Progress<'_>) -> [Vec<Rgb>; 2] {
    let Range { start, end } = progress.of_phase(Phase::Picture);
    let observer = progress.observer();
    let spp = options.spp.div_ceil(2).max(1);
    [0, 1].map(|half| {
        let seed = Stream::LastPicture.seed(options.seed).wrapping_add(half);
        let settings = Settings {
            spp,
            seed,
            max_bounces: options.max_bounces,
            integrator: Integrator::PathReuse,
            ..Settings::default()
        };
        let progress = |share: f64| {
            let done = start + (end - start) * (half as f64 + share) / 2.0;
            observer.working("rendering the last picture", done);
        };
        guess.problem.renderer.picture(guess.appearance(), &settings, &progress)
    })
}

/// The result of a group, of which `whole` is the squared error of all groups.
fn group_result(guess: &Guess<'_>, group: usize, error: &GroupError, whole: f64) -> GroupResult {
    let spec = &guess.problem.groups[group];
    let of_group = &guess.groups[group];
    let observation = &guess.observation;
    let valid = &observation.pixels_of_group[group];
    // What no pixel shows is recovered only if its standard deviations were found small enough.
    let is_guess =
        of_group.status == Status::Recovered && valid.is_empty() && of_group.std.is_none();
    let status = if is_guess { Status::Assumed } else { of_group.status };
    let doubts = [error.doubt(), undecided(of_group.hypothesis, &of_group.undecided)];
    let doubt = doubts.into_iter().flatten().reduce(joined).filter(|_| status == Status::Recovered);
    let assumed = || {
        let is_unseen = guess.materials[group] == spec.unseen();
        let from_light = "a guess from the light that it sends to the others";
        let taken = format!("taken as {}", spec.unseen_in_words());
        format!("{}: {}", guess.why_unseen(group), if is_unseen { &taken } else { from_light })
    };
    let note = of_group.note.clone().or_else(|| (status == Status::Assumed).then(assumed));
    let notes = [doubt.clone(), note, on_bounds(guess, group)];
    let note = notes.into_iter().flatten().reduce(joined);
    GroupResult {
        name: spec.name.clone(),
        status: if doubt.is_some() { Status::Doubtful } else { status },
        hypothesis: of_group.hypothesis,
        material: guess.materials[group].clone(),
        std: of_group.std,
        alternatives: of_group.alternatives.iter().map(alternative).collect(),
        direction: direction(guess, group),
        seen_texels: of_group.seen_texels.clone(),
        pixels: observation.all_pixels_of_group[group].len(),
        valid_pixels: valid.len(),
        error: error.squares.relative().filter(|error| error.is_finite()),
        error_share: error.squares.share_of(whole),
        selection_log: of_group.selection_log.clone(),
        decisions: Vec::new(),
        note,
    }
}

fn joined(before: String, after: String) -> String {
    format!("{before}; {after}")
}

/// The hypotheses in `open` other than the `present` one of a group, in words, if any; none for a texture.
fn undecided(present: Hypothesis, open: &[Hypothesis]) -> Option<String> {
    let is_other = |other: &&Hypothesis| **other != present && present != Hypothesis::Textured;
    let others: Vec<&str> = open.iter().filter(is_other).map(|open| open.name()).collect();
    let others = others.join(" or ");
    (!others.is_empty()).then(|| format!("it may be {others}: rendering noise leaves that open"))
}

/// Which of an unknown group's numbers lie on bounds of the project, if any do.
fn on_bounds(guess: &Guess<'_>, group: usize) -> Option<String> {
    let spec = &guess.problem.groups[group];
    let of_group = &guess.groups[group];
    if spec.role != Role::Unknown || of_group.status != Status::Recovered {
        return None;
    }
    let touched = spec.expected.touched(of_group.hypothesis, &guess.materials[group]);
    let said = touched.join(", ");
    let of_std = if of_group.std.is_some() { ", which std leaves out" } else { "" };
    (!said.is_empty()).then(|| format!("{said}{of_std}"))
}

fn alternative(fit: &Fit) -> Alternative {
    let error = fit.residual.relative();
    Alternative { hypothesis: fit.hypothesis, material: fit.material.clone(), error }
}

/// The standard deviation that noise gives the luminance of photograph minus re-rendering: the
/// photograph's own variance, and that of the mean of both halves, `(A - B)^2 / 4` on the mean over
/// the neighbours of a pixel.
fn noise(guess: &Guess<'_>, halves: &[Vec<Rgb>; 2]) -> Image<f32> {
    let geometry = guess.problem.renderer.geometry();
    let weights = Rgb::new(luminance(Rgb::X), luminance(Rgb::Y), luminance(Rgb::Z));
    let of_rendering = |at: usize| luminance(halves[0][at] - halves[1][at]).powi(2) / 4.0;
    let one = |at: usize| {
        let group = geometry.pixels()[at].group;
        if group == NOTHING {
            return 0.0;
        }
        let noise = guess.observation.noise(group as usize, at as u32, guess.exposure);
        let of_photo = noise.variance(0.5 * (halves[0][at] + halves[1][at]));
        let of_photo = (of_photo * weights * weights).element_sum();
        let neighbours: Vec<f32> = geometry.neighbourhood(at).map(of_rendering).collect();
        let of_rendering = neighbours.iter().sum::<f32>() / neighbours.len() as f32;
        (of_photo + of_rendering).sqrt()
    };
    let pixels = (0..geometry.pixels().len()).map(one).collect();
    Image::new(geometry.width(), geometry.height(), pixels)
}

/// The anisotropy direction at the middle one of the group's valid pixels, world space.
fn direction(guess: &Guess<'_>, group: usize) -> Option<Vec3> {
    let valid = &guess.observation.pixels_of_group[group];
    let middle = *valid.get(valid.len() / 2)?;
    let at = guess.problem.renderer.geometry().pixels()[middle as usize];
    let front_normal = if at.front { at.normal } else { -at.normal };
    let (sin, cos) = guess.materials[group].theta_rad.sin_cos();
    Some(at.tangent * cos + front_normal.cross(at.tangent) * sin)
}

#[cfg(test)]
mod tests {
    use super::undecided;
    use crate::hypothesis::Hypothesis::{Anisotropic, Diffuse, Isotropic, Textured};

    #[test]
    fn what_stayed_open_is_said_unless_it_was_taken() {
        let said = undecided(Diffuse, &[Isotropic, Anisotropic]);
        assert_eq!(
            said.as_deref(),
            Some("it may be isotropic or anisotropic: rendering noise leaves that open")
        );
        assert_eq!(undecided(Isotropic, &[Isotropic]), None);
        assert_eq!(undecided(Textured, &[Anisotropic]), None);
        assert_eq!(undecided(Diffuse, &[]), None);
    }
}
