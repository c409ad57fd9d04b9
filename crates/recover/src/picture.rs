//! The last picture: the photograph's view rendered with the results, and each group's error in it.

use crate::hypothesis::{Fit, Hypothesis};
use crate::problem::{Options, Role};
use crate::record::{Alternative, GroupResult, Observer, Recovery, Status, Termination};
use crate::rerender::Renderer;
use crate::residual::deviation_of_sum;
use crate::schedule;
use crate::state::State;
use glam::Vec3;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, NOTHING, Settings};
use unrender_scene::color::luminance;
use unrender_scene::{Image, Rgb, RgbImage};

/// Renders the last picture and gathers the results.
pub(crate) fn finish(
    state: State<'_>,
    options: &Options,
    termination: Termination,
    observer: &dyn Observer,
) -> Recovery {
    let halves = render_twice(state.problem.renderer, state.appearance(), options, observer);
    let squares: Vec<Squares> =
        (0..state.materials.len()).map(|g| Squares::of(&state, g, &halves)).collect();
    let whole = squares.iter().map(|s| s.error.max(0.0)).sum();
    let groups = squares.iter().enumerate().map(|(g, s)| group_result(&state, g, s, whole));
    let groups = groups.collect();
    let mean = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let noise = noise(&state, &halves);
    let geometry = state.problem.renderer.geometry();
    Recovery {
        groups,
        exposure: state.exposure,
        exposure_std: state.exposure_std,
        covariance: state.covariance,
        lights: state.light_results,
        photometric: state.photometric,
        noise,
        rerendered: RgbImage::new(geometry.width(), geometry.height(), mean),
        status: state.observation.status,
        iterations: state.iterations,
        termination,
    }
}

/// Two pictures with half of the paths each, so that their noise can be separated from the error.
fn render_twice(
    renderer: &dyn Renderer,
    appearance: Appearance<'_>,
    options: &Options,
    observer: &dyn Observer,
) -> [Vec<Rgb>; 2] {
    let spp = options.spp.div_ceil(2).max(1);
    [0, 1].map(|half| {
        let seed = mix(options.seed ^ 0x5EED).wrapping_add(half);
        let settings = Settings {
            first: 0,
            together: unrender_render::settings::TOGETHER,
            spp,
            seed,
            max_bounces: options.max_bounces,
            integrator: unrender_render::Integrator::PathReuse,
        };
        let progress = |share: f64| {
            let done = schedule::of_picture(options, (half as f64 + share) / 2.0);
            observer.working("rendering the last picture", done);
        };
        renderer.picture(appearance, &settings, &progress)
    })
}

/// The result of a group, of which `whole` is the squared error of all groups.
fn group_result(state: &State<'_>, group: usize, squares: &Squares, whole: f64) -> GroupResult {
    let spec = &state.problem.groups[group];
    let of_group = &state.groups[group];
    let is_recovered = of_group.status == Status::Recovered;
    let doubts = [
        squares.doubt(),
        of_group.untextured.clone(),
        undecided(of_group.hypothesis, &of_group.undecided),
    ];
    let doubt = doubts.into_iter().flatten().reduce(joined).filter(|_| is_recovered);
    let observation = &state.observation;
    let valid = &observation.pixels_of_group[group];
    let note = of_group.note.clone().or_else(|| match of_group.status {
        Status::Assumed => {
            Some(format!("no pixel shows this group: taken as {}", spec.unseen_in_words()))
        }
        _ => None,
    });
    let notes = [doubt.clone(), note, on_bounds(state, group)];
    let note = notes.into_iter().flatten().reduce(joined);
    GroupResult {
        name: spec.name.clone(),
        status: if doubt.is_some() { Status::Doubtful } else { of_group.status },
        hypothesis: of_group.hypothesis,
        material: state.materials[group].clone(),
        std: of_group.std,
        alternatives: of_group.alternatives.iter().map(alternative).collect(),
        direction: direction(state, group),
        seen_texels: of_group.seen_texels.clone(),
        pixels: observation.all_pixels_of_group[group].len(),
        valid_pixels: valid.len(),
        error: squares.relative(),
        error_share: squares.share_of(whole),
        selection_log: of_group.selection_log.clone(),
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
fn on_bounds(state: &State<'_>, group: usize) -> Option<String> {
    let spec = &state.problem.groups[group];
    let of_group = &state.groups[group];
    if spec.role != Role::Unknown || of_group.status != Status::Recovered {
        return None;
    }
    let touched = spec.expected.touched(of_group.hypothesis, &state.materials[group]);
    let said = touched.join(", ");
    let of_std = if of_group.std.is_some() { ", which std leaves out" } else { "" };
    (!said.is_empty()).then(|| format!("{said}{of_std}"))
}

fn alternative(fit: &Fit) -> Alternative {
    let error = fit.residual.relative();
    Alternative { hypothesis: fit.hypothesis, material: fit.material.clone(), error }
}

/// Sums over the valid pixels of a group that is no lamp; zero for lamps.
struct Squares {
    /// Of photograph minus re-rendering: the products of the two halves' residuals hold the error
    /// without the rendering's noise.
    error: f64,
    /// The standard deviation of that.
    deviation: f64,
    /// The variance of the photograph's and the re-rendering's noise.
    noise: f64,
    /// Of the photograph.
    photo: f64,
}

/// A group is doubtful above this relative error, whatever the noise: materials that leave a third
/// of the photograph unexplained predict nothing.
const DOUBTFUL: f64 = 0.3;
/// And above this many times its noise; at double of it, errors that anyone sees pass.
const TIMES_NOISE: f64 = 5.0;
/// The error counts for doubt less so many of its standard deviations: a noisy last picture is no reason to doubt.
/// Without it, with 2 paths a pixel, 24 of 145 right groups of twelve rooms were doubtful by the noise of that picture
/// alone; half and double of it were not tried.
const CERTAIN: f64 = 2.0;
/// Noise and model error together are at least this, relatively. At half of it, photographs without
/// noise make every group doubtful.
const NOISE_MIN: f64 = 0.006;

impl Squares {
    fn of(state: &State<'_>, group: usize, halves: &[Vec<Rgb>; 2]) -> Self {
        let mut squares = Self { error: 0.0, deviation: 0.0, noise: 0.0, photo: 0.0 };
        if state.problem.groups[group].role == Role::Emitter {
            return squares;
        }
        let mut products = Vec::new();
        for &pixel in &state.observation.pixels_of_group[group] {
            let at = pixel as usize;
            let photo = state.exposure * state.value(at);
            let [a, b] = [halves[0][at], halves[1][at]];
            let noise = state.observation.noise(group, pixel, state.exposure);
            let noise = noise.variance(0.5 * (a + b));
            products.push(f64::from(((photo - a) * (photo - b) - noise).element_sum()));
            let rendering = 0.25 * (a - b) * (a - b);
            squares.noise += f64::from((noise + rendering).element_sum());
            squares.photo += f64::from((photo * photo).element_sum());
        }
        squares.error = products.iter().sum();
        squares.deviation = deviation_of_sum(&products);
        squares
    }

    /// The relative root mean square; where it is not significant, its standard deviation.
    /// None where no pixel shows the group.
    fn relative(&self) -> Option<f64> {
        let square = self.error.max(self.deviation).max(0.0);
        (self.photo > 0.0).then(|| (square / self.photo).sqrt())
    }

    /// The share of the squared error `whole`.
    fn share_of(&self, whole: f64) -> Option<f64> {
        (self.photo > 0.0 && whole > 0.0).then(|| self.error.max(0.0) / whole)
    }

    /// Why noise and model error do not explain what is left, if they certainly do not.
    fn doubt(&self) -> Option<String> {
        let error = self.relative()?;
        let noise = (self.noise / self.photo).sqrt();
        let certain = (self.error - CERTAIN * self.deviation).max(0.0);
        let certain = (certain / self.photo).sqrt();
        let doubtful = certain > DOUBTFUL || certain > TIMES_NOISE * noise.max(NOISE_MIN);
        doubtful.then(|| {
            format!(
                "its error of {:.1} % is not explained by noise ({:.1} %) and model error",
                100.0 * error,
                100.0 * noise
            )
        })
    }
}

/// The standard deviation that noise gives the luminance of photograph minus re-rendering: the
/// photograph's own variance, and that of the mean of both halves, `(A - B)^2 / 4` on the mean over
/// the neighbours of a pixel.
fn noise(state: &State<'_>, halves: &[Vec<Rgb>; 2]) -> Image<f32> {
    let geometry = state.problem.renderer.geometry();
    let weights = Rgb::new(luminance(Rgb::X), luminance(Rgb::Y), luminance(Rgb::Z));
    let of_rendering = |at: usize| luminance(halves[0][at] - halves[1][at]).powi(2) / 4.0;
    let one = |at: usize| {
        let group = geometry.pixels()[at].group;
        if group == NOTHING {
            return 0.0;
        }
        let noise = state.observation.noise(group as usize, at as u32, state.exposure);
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
fn direction(state: &State<'_>, group: usize) -> Option<Vec3> {
    let valid = &state.observation.pixels_of_group[group];
    let middle = *valid.get(valid.len() / 2)?;
    let at = state.problem.renderer.geometry().pixels()[middle as usize];
    let front_normal = if at.front { at.normal } else { -at.normal };
    let (sin, cos) = state.materials[group].theta_rad.sin_cos();
    Some(at.tangent * cos + front_normal.cross(at.tangent) * sin)
}

#[cfg(test)]
mod tests {
    use super::{Squares, undecided};
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

    #[test]
    fn what_noise_leaves_open_is_no_reason_to_doubt() {
        let squares = |error, deviation| Squares { error, deviation, noise: 0.01, photo: 1.0 };
        // Half of the photograph is unexplained, and that is certain.
        assert!(squares(0.25, 0.01).doubt().is_some());
        // As much, in a picture so noisy that it is not significant; it is shown all the same.
        assert!(squares(0.25, 0.2).doubt().is_none());
        assert_eq!(squares(0.0, 0.25).relative(), Some(0.5));
        assert!(squares(0.0, 0.25).doubt().is_none());
        // An error that is explained.
        assert!(squares(0.04, 0.001).doubt().is_none());
    }
}
