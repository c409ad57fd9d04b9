//! Textures of groups: looked for, and extracted once more under the final light.

use crate::evidence::SampleBudget;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::problem::Options;
use crate::record::Deviations;
use crate::sample_budget;
use crate::texture::{self, Asked, Found};
use serde::{Deserialize, Serialize};
use unrender_scene::{Image, Material, Rgb};

/// A texture needs this many pixels: below that it has fewer texels than a lobe has parameters.
const PIXELS_MIN: usize = 100;

/// A texture with what is known of it.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Textured {
    pub(crate) material: Material,
    /// Which texels the photograph shows.
    pub(crate) seen: Image<bool>,
    /// The standard deviation of one of these.
    pub(crate) deviation: Rgb,
}

/// Whether `group` may have a texture: it has texture coordinates and enough pixels.
pub(crate) fn is_possible(guess: &Guess<'_>, group: usize) -> bool {
    let pixels = &guess.observation.pixels_of_group[group];
    let geometry = guess.stage().renderer.geometry().pixels();
    let uv = |pixel: &u32| geometry[*pixel as usize].uv;
    pixels.len() >= PIXELS_MIN && pixels.iter().any(|pixel| uv(pixel) != uv(&pixels[0]))
}

/// What texels predict of `group`, where a texture has at `least` this contrast; none without texture coordinates.
pub(crate) fn look(
    guess: &Guess<'_>,
    (group, least): (usize, f64),
    budget: &SampleBudget,
) -> Option<Found> {
    let pixels = &guess.observation.pixels_of_group[group];
    let uniform = uniforms(guess, group);
    let bounds = &guess.problem.groups[group].expected.bounds;
    let (stage, appearance) = (guess.stage(), guess.appearance());
    let plain = guess.plain(group, Rgb::ZERO);
    let by = Asked { uniform: &uniform, bounds, plain, least };
    texture::look(&stage, appearance, (group, pixels), &by, budget)
}

/// What a texture of `group` has to predict better than: its present reflectance, and that of the candidates which left
/// least when it was asked last. Light that is wrong may have spoken for a simpler one, and the texture would be what that
/// one lacks.
fn uniforms(guess: &Guess<'_>, group: usize) -> Vec<Material> {
    let log = &guess.groups[group].selection_log;
    let last = log.last().map(|last| last.iteration);
    let asked = log.iter().filter(|candidate| Some(candidate.iteration) == last);
    let best = asked.min_by(|a, b| a.residual.with_noise.total_cmp(&b.residual.with_noise));
    let present = Material { texture: None, ..guess.materials[group].clone() };
    best.map(|best| best.material.clone()).into_iter().chain([present]).collect()
}

/// The texture of `group` under this `lobe` in the present light; none without texture coordinates.
pub(crate) fn extract(
    guess: &Guess<'_>,
    options: &Options,
    group: usize,
    lobe: &Material,
    last: bool,
) -> Option<Textured> {
    let mut budget = sample_budget::texture(last, lobe, options);
    budget.probe.max_bounces = options.max_bounces;
    let (stage, detail) = (guess.stage(), guess.problem.detail.filter(|_| last));
    let mut extracted =
        texture::extract((&stage, detail), guess.appearance(), group, lobe, &budget)?;
    guess.problem.groups[group].expected.bounds.bound_texels(&mut extracted.texture);
    let rho_d = texture::mean(&extracted);
    let material = Material { texture: Some(extracted.texture), rho_d, ..lobe.clone() };
    Some(Textured { material, seen: extracted.seen, deviation: extracted.deviation })
}

/// `guess` with its textures once more, with more light samples, under the final light.
pub(crate) fn last<'a>(guess: &Guess<'a>, options: &Options) -> Guess<'a> {
    let mut with = guess.clone();
    for group in guess.visible_unknowns() {
        if guess.groups[group].hypothesis != Hypothesis::Textured {
            continue;
        }
        let lobe = Material { texture: None, ..guess.materials[group].clone() };
        let found = guess.steps.value("texture", || extract(&with, options, group, &lobe, true));
        let Some(Textured { material, seen, deviation }) = found else { continue };
        with.materials[group] = material;
        let of_group = &mut with.groups[group];
        of_group.seen_texels = Some(seen);
        of_group.std = Some(Deviations { rho_d: Some(deviation), ..Deviations::default() });
    }
    with
}
