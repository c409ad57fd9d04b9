//! Textures: the last rung, taken where no uniform hypothesis explains a group.

use crate::hypothesis::{Hypothesis, textured};
use crate::problem::Options;
use crate::record::Deviations;
use crate::sample_budget;
use crate::state::State;
use unrender_scene::Material;

/// A texture needs this many pixels: below that it has fewer texels than a lobe has parameters.
const PIXELS_MIN: usize = 200;

/// The group's texture under the present light; none without texture coordinates or with too few
/// pixels; its state then says which.
pub(crate) fn extract(
    state: &mut State<'_>,
    options: &Options,
    group: usize,
    last: bool,
) -> Option<Material> {
    let few = state.observation.pixels_of_group[group].len() < PIXELS_MIN;
    let mut budget = sample_budget::texture(last, options);
    budget.probe.max_bounces = options.max_bounces;
    let plain = Material::diffuse(state.materials[group].rho_d);
    let stage = state.stage();
    let extracted = if few {
        None
    } else {
        let detail = state.problem.detail.filter(|_| last);
        textured::extract((&stage, detail), state.appearance(), group, &plain, &budget)
    };
    let of_group = &mut state.groups[group];
    let Some(mut extracted) = extracted else {
        let reason = if few { "too few pixels" } else { "no texture coordinates" };
        of_group.untextured = Some(format!(
            "no uniform reflectance explains this group, and it has {reason} for a texture"
        ));
        return None;
    };
    state.problem.groups[group].expected.bounds.bound_texels(&mut extracted.texture);
    let mean = textured::mean(&extracted);
    of_group.seen_texels = Some(extracted.seen);
    let rho_d = Some(extracted.deviation);
    of_group.std = last.then_some(Deviations { rho_d, ..Deviations::default() });
    Some(Material { texture: Some(extracted.texture), rho_d: mean, ..plain })
}

/// The textures once more, with more light samples, under the final light. The mean that a joint refinement found from
/// the light that a texture sends to others is given to it by the texels that no pixel shows.
pub(crate) fn finish(state: &mut State<'_>, options: &Options) {
    for group in state.visible_unknowns() {
        if state.groups[group].hypothesis != Hypothesis::Textured {
            continue;
        }
        let sent = state.covariance.is_some().then(|| state.materials[group].rho_d);
        let Some(mut material) = extract(state, options, group, true) else { continue };
        if let (Some(sent), Some(seen)) = (sent, &state.groups[group].seen_texels)
            && textured::is_partly_unseen(seen)
        {
            let shown = material.rho_d;
            (0..3).for_each(|c| textured::set_mean(&mut material, seen, c, sent[c]));
            material.rho_d = shown;
        }
        // The unseen texels may have left the bounds.
        state.materials[group] = state.problem.groups[group].expected.bounds.nearest(&material);
    }
}
