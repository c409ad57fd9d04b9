//! Textures: the last rung, taken where no uniform hypothesis explains a group.

use crate::guess::Guess;
use crate::hypothesis::{Hypothesis, textured};
use crate::problem::Options;
use crate::record::Deviations;
use crate::sample_budget;
use serde::{Deserialize, Serialize};
use unrender_scene::{Image, Material, Rgb};

/// A texture needs this many pixels: below that it has fewer texels than a lobe has parameters.
const PIXELS_MIN: usize = 200;

/// A texture with what is known of it.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Textured {
    pub(crate) material: Material,
    /// Which texels the photograph shows.
    pub(crate) seen: Image<bool>,
    /// The standard deviation of one of these.
    pub(crate) deviation: Rgb,
}

/// The texture of `group` under the present light; where it has no texture coordinates or too few pixels, why it has none.
pub(crate) fn extract(
    guess: &Guess<'_>,
    options: &Options,
    group: usize,
    last: bool,
) -> Result<Textured, String> {
    let why = |reason: &str| {
        format!("no uniform reflectance explains this group, and it has {reason} for a texture")
    };
    if guess.observation.pixels_of_group[group].len() < PIXELS_MIN {
        return Err(why("too few pixels"));
    }
    let mut budget = sample_budget::texture(last, options);
    budget.probe.max_bounces = options.max_bounces;
    let plain = Material::diffuse(guess.materials[group].rho_d);
    let (stage, detail) = (guess.stage(), guess.problem.detail.filter(|_| last));
    let mut extracted =
        textured::extract((&stage, detail), guess.appearance(), group, &plain, &budget)
            .ok_or_else(|| why("no texture coordinates"))?;
    guess.problem.groups[group].expected.bounds.bound_texels(&mut extracted.texture);
    let mean = textured::mean(&extracted);
    let material = Material { texture: Some(extracted.texture), rho_d: mean, ..plain };
    Ok(Textured { material, seen: extracted.seen, deviation: extracted.deviation })
}

/// `guess` with its textures once more, with more light samples, under the final light. The mean that a joint refinement
/// found from the light that a texture sends to others is given to it by the texels that no pixel shows.
pub(crate) fn last<'a>(guess: &Guess<'a>, options: &Options) -> Guess<'a> {
    let mut with = guess.clone();
    for group in guess.visible_unknowns() {
        if guess.groups[group].hypothesis != Hypothesis::Textured {
            continue;
        }
        let found = guess.steps.value("texture", || extract(&with, options, group, true).ok());
        let Some(Textured { mut material, seen, deviation }) = found else { continue };
        if guess.covariance.is_some() && textured::is_partly_unseen(&seen) {
            let (shown, sent) = (material.rho_d, guess.materials[group].rho_d);
            (0..3).for_each(|c| textured::set_mean(&mut material, &seen, c, sent[c]));
            material.rho_d = shown;
        }
        // The unseen texels may have left the bounds.
        with.materials[group] = guess.problem.groups[group].expected.bounds.nearest(&material);
        let of_group = &mut with.groups[group];
        of_group.seen_texels = Some(seen);
        of_group.std = Some(Deviations { rho_d: Some(deviation), ..Deviations::default() });
    }
    with
}
