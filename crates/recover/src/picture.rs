//! The end: the photograph's view rendered with what was found, and each group's error in it.

use crate::hypothesis::Fit;
use crate::ladder::State;
use crate::problem::{Options, Role};
use crate::record::{Alternative, GroupResult, Observer, Recovery, Status, Termination};
use crate::rerender::Renderer;
use glam::Vec3;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, Settings};
use unrender_scene::{Rgb, RgbImage};

/// Pixels rendered between two words to the observer.
const CHUNK: usize = 4096;

/// Renders the last picture and gathers the results.
pub(crate) fn finish(
    state: State<'_>,
    options: &Options,
    termination: Termination,
    observer: &dyn Observer,
) -> Recovery {
    let halves = render_twice(state.problem.renderer, state.appearance(), options, observer);
    let groups = (0..state.materials.len()).map(|g| group_result(&state, g, &halves)).collect();
    let mean = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let geometry = state.problem.renderer.geometry();
    Recovery {
        groups,
        exposure: state.exposure,
        exposure_std: state.exposure_std,
        lights: state.light_results,
        corrected: state.corrected,
        rerendered: RgbImage::new(geometry.width(), geometry.height(), mean),
        trust: state.observation.trust,
        turns: state.turns,
        termination,
    }
}

/// Two pictures with half of the paths each, so that their noise can be told from the error.
fn render_twice(
    renderer: &dyn Renderer,
    appearance: Appearance<'_>,
    options: &Options,
    observer: &dyn Observer,
) -> [Vec<Rgb>; 2] {
    let pixels: Vec<u32> = (0..renderer.geometry().pixels().len() as u32).collect();
    let spp = options.spp.div_ceil(2).max(1);
    [0usize, 1].map(|half| {
        let seed = mix(options.seed ^ 0x5EED).wrapping_add(half as u64);
        let settings = Settings { spp, seed, max_bounces: options.max_bounces };
        let mut picture = Vec::with_capacity(pixels.len());
        for chunk in pixels.chunks(CHUNK) {
            picture.extend(renderer.rerender(appearance, chunk, &settings));
            observer.picture((half as f64 + picture.len() as f64 / pixels.len() as f64) / 2.0);
        }
        picture
    })
}

fn group_result(state: &State<'_>, group: usize, halves: &[Vec<Rgb>; 2]) -> GroupResult {
    let spec = &state.problem.groups[group];
    let standing = &state.standing[group];
    let observation = &state.observation;
    let believed = &observation.pixels_of_group[group];
    let emitter = spec.role == Role::Emitter;
    let note = standing.note.clone().or_else(|| match standing.status {
        Status::Assumed => Some("no pixel shows this group: taken as white diffuse".to_owned()),
        _ => None,
    });
    GroupResult {
        name: spec.name.clone(),
        status: standing.status,
        hypothesis: standing.hypothesis,
        material: state.materials[group].clone(),
        std: standing.std,
        alternatives: standing.alternatives.iter().map(alternative).collect(),
        direction: direction(state, group),
        seen_texels: standing.seen_texels.clone(),
        pixels: observation.all_pixels_of_group[group].len(),
        trusted_pixels: believed.len(),
        error: if emitter { None } else { relative_error(state, believed, halves) },
        story: standing.story.clone(),
        note,
    }
}

fn alternative(fit: &Fit) -> Alternative {
    let error = fit.misfit.relative();
    Alternative { hypothesis: fit.hypothesis, material: fit.material.clone(), error }
}

/// Relative root mean square of photograph minus re-rendering: the products of the two halves'
/// residuals hold the error without the rendering's noise.
fn relative_error(state: &State<'_>, pixels: &[u32], halves: &[Vec<Rgb>; 2]) -> Option<f64> {
    let (mut sum, mut scale) = (0.0, 0.0);
    for &pixel in pixels {
        let at = pixel as usize;
        let photo = state.exposure * state.value(at);
        let product = (photo - halves[0][at]) * (photo - halves[1][at]);
        sum += f64::from(product.element_sum());
        scale += f64::from((photo * photo).element_sum());
    }
    (scale > 0.0).then(|| (sum / scale).max(0.0).sqrt())
}

/// The brushed direction at the middle one of the group's believed pixels, world space.
fn direction(state: &State<'_>, group: usize) -> Option<Vec3> {
    let believed = &state.observation.pixels_of_group[group];
    let middle = *believed.get(believed.len() / 2)?;
    let at = state.problem.renderer.geometry().pixels()[middle as usize];
    let front_normal = if at.front { at.normal } else { -at.normal };
    let (sin, cos) = state.materials[group].theta_rad.sin_cos();
    Some(at.tangent * cos + front_normal.cross(at.tangent) * sin)
}
