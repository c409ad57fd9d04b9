//! Looks whether a group has a texture, and what lobe lies over it.

use super::lit::Lit;
use super::pattern::{ALPHAS, Judge, Pattern};
use crate::evidence::{Light, SampleBudget};
use crate::expected::ParameterBounds;
use crate::hypothesis::plastic;
use crate::observe::sample::Stage;
use crate::streams::Stream;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, ProbeSettings};
use unrender_scene::{Material, Rgb};

/// Pixels that are looked at, about, and the side of the squares that they come from where a group has more. At half of the
/// pixels faint textures are missed, double of them takes twice as long. The side is that of three of the largest squares
/// that are predicted; half of it has hardly a whole one, double of it few places of a group.
const PIXELS: usize = 6000;
const WINDOW: usize = 48;
/// The relative noise of the light, and by how much more of it is gathered at most where that is larger. At half of the
/// noise it takes four times as long; at double faint textures are missed.
const NOISE: f32 = 0.04;
const MORE_MAX: f32 = 16.0;

/// A texture that a group has.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// The lobe over it, with a black base.
    pub(crate) lobe: Material,
    pub(crate) pattern: Pattern,
}

/// What a texture has to be.
pub(crate) struct Asked<'a> {
    /// The uniform reflectances that it has to predict better than; the last one is the present one.
    pub(crate) uniform: &'a [Material],
    /// The bounds of the group.
    pub(crate) bounds: &'a ParameterBounds,
    /// The group if nothing but its colour is known, black.
    pub(crate) plain: Material,
    /// The least contrast.
    pub(crate) least: f64,
}

/// What texels predict of `pixels` of a group; none without texture coordinates. More light is gathered where a little of
/// it does not exclude a texture.
pub(crate) fn look(
    stage: &Stage<'_>,
    appearance: Appearance<'_>,
    (group, pixels): (usize, &[u32]),
    by: &Asked<'_>,
    budget: &SampleBudget,
) -> Option<Found> {
    let geometry = stage.renderer.geometry();
    let pixels = windows(pixels, geometry.width(), budget.pixels_seed);
    let mut probe = budget.probe.clone();
    probe.seed = Stream::Judging.change(probe.seed);
    let gather = |probe: &ProbeSettings| Light::gather(stage, appearance, group, &pixels, probe);
    let little = gather(&probe);
    let found = judged(stage, group, &little, by)?;
    let black = Material::diffuse(Rgb::ZERO);
    let noise = Lit::of(stage, group, (&little.0, &little.1), &black).smoothed(geometry).scatter();
    let more = (noise / NOISE).powi(2).min(MORE_MAX);
    if more <= 1.0 || found.pattern.at_most < by.least {
        return Some(found);
    }
    probe.cosine = (probe.cosine as f32 * more).ceil() as u32;
    probe.per_lobe = (probe.per_lobe as f32 * more.sqrt()).ceil() as u32;
    judged(stage, group, &gather(&probe), by)
}

/// What texels predict in the `light` behind some pixels of `group`.
fn judged(
    stage: &Stage<'_>,
    group: usize,
    (light, pixels): &(Light, Vec<u32>),
    by: &Asked<'_>,
) -> Option<Found> {
    let geometry = stage.renderer.geometry();
    let lit = |lobe: &Material| Lit::of(stage, group, (light, pixels), lobe).smoothed(geometry);
    let model = stage.renderer.model();
    let shown = |uniform: &Material| {
        let lit = lit(uniform);
        [0, 1].map(|half: usize| -> Vec<Rgb> {
            let both = lit.base[half].iter().zip(&lit.shine[half]);
            both.map(|(base, shine)| uniform.rho_d * *base + *shine).collect()
        })
    };
    let shown: Vec<[Vec<Rgb>; 2]> = by.uniform.iter().map(shown).collect();
    let judge = Judge::of(&lit(&Material::diffuse(Rgb::ZERO)), &shown, geometry)?;
    let may_be_plastic = model.is_principled() && plastic::is_within(by.bounds);
    let roughness = may_be_plastic.then(|| {
        let lobes: Vec<(f32, Lit)> = roughnesses(by.uniform)
            .into_iter()
            .map(|alpha| (alpha, lit(&plastic::of_alpha(model, alpha))))
            .collect();
        judge.roughness(&lit(&by.plain), &lobes)
    });
    let lobe = roughness.flatten().map(|alpha| plastic::of_alpha(model, alpha));
    let lobe = lobe.unwrap_or_else(|| by.plain.clone());
    let pattern = judge.predicted(&lit(&lobe));
    Some(Found { lobe, pattern })
}

/// The roughnesses that are tried: [`ALPHAS`], and those of `uniform` that are plastics, ascending.
fn roughnesses(uniform: &[Material]) -> Vec<f32> {
    let plastics = uniform.iter().filter(|of| of.is_glossy() && !of.reflectance.is_free());
    let own = plastics.map(|of| (of.alpha_x * of.alpha_y).sqrt());
    let mut all: Vec<f32> = ALPHAS.into_iter().chain(own).collect();
    all.sort_by(f32::total_cmp);
    all.dedup();
    all
}

/// About [`PIXELS`] of `pixels` of a picture of this `width`, in whole squares that `seed` chooses.
fn windows(pixels: &[u32], width: usize, seed: u64) -> Vec<u32> {
    if pixels.len() <= PIXELS {
        return pixels.to_vec();
    }
    let window = |pixel: &u32| {
        let (x, y) = (*pixel as usize % width, *pixel as usize / width);
        mix(seed ^ (y / WINDOW * width + x / WINDOW) as u64)
    };
    let mut order: Vec<u64> = pixels.iter().map(window).collect();
    order.sort_unstable();
    let last = order[PIXELS];
    pixels.iter().filter(|pixel| window(pixel) <= last).copied().collect()
}
