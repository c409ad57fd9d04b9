//! The default way up: trace once, solve many.
//!
//! In every turn each group's current hypothesis is fitted to the light that arrives at it. Where
//! that light comes from diffuse surfaces that the camera sees, the photograph itself says how much
//! it is (`unrender_render::radiance_cache`); only the rest hangs on what is believed of the other groups, and
//! the reflectances move most of the way to their fits (`DAMPING`). When nothing moves any more, the
//! groups that their hypothesis explains worst get a trial: all uniform rungs are fitted to one
//! cache of incident light and the simplest good one is taken ([`super::choice`]). Only the worst
//! ones, because a wrong group spoils the light of its neighbours: once it is right, their errors
//! may be gone. At the end every group that is not plainly diffuse is tried once again under the final
//! light. Sample counts grow from level to level ([`super::effort`]).

use super::effort::{self, FINEST, SETTLED};
use super::{State, choice, distance};
use crate::error::Misfit;
use crate::evidence::Evidence;
use crate::hypothesis::{self, Fit, Hypothesis, Search, brushed, textured};
use crate::problem::{Options, RecoverError};
use crate::record::{Deviations, Observer, Status, Termination, Trial};
use crate::refine;
use crate::stray;
use unrender_scene::Material;

/// The share of the way to the fitted reflectances that a turn goes. Groups that the camera does not
/// see light each other: when all become brighter at once, each looks darker in the next turn. A
/// little less than the full step keeps that from swinging.
const DAMPING: f32 = 0.9;
/// Of the groups in error, those with at least this share of the worst error are tried.
const WORST: f64 = 0.5;
/// While the light is rough, only errors this many times the threshold call for a trial.
const CLEARLY: f64 = 3.0;
/// A group is tried at most this often.
const TRIALS_MAX: usize = 6;
/// Turns without a change of rung after which a level ends even if something still moves.
const CALM_TURNS: [usize; 3] = [8, 6, 3];
/// A texture needs this many pixels.
const TEXTURE_PIXELS: usize = 200;
/// Strays are looked for so often, each time without those before.
const STRAY_ROUNDS: usize = 3;

/// Climbs until nothing moves.
pub(crate) fn climb(
    state: &mut State<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Termination, RecoverError> {
    let mut climber = Climber::new(state, options);
    for turn in 1..=options.max_turns {
        refine::settle_nuisances(state, options)?;
        let change = climber.turn(state);
        let done = turn as f64 / (turn as f64 + 10.0 - 4.0 * climber.level as f64);
        let threshold = options.thresholds.explained;
        observer.turn(state.end_turn(change, threshold, done));
        climber.calm += 1;
        if change > SETTLED[climber.level] && climber.calm < CALM_TURNS[climber.level] {
            continue;
        }
        if !climber.try_worst(state, turn) {
            if climber.level == FINEST {
                return Ok(Termination::Settled);
            }
            climber.level += 1;
        }
        climber.aims = state.materials.clone();
        climber.calm = 0;
    }
    Ok(Termination::TurnLimit)
}

struct Climber<'o> {
    options: &'o Options,
    level: usize,
    /// How often each group was tried.
    trials: Vec<usize>,
    /// At which level each group was tried last.
    tried_at: Vec<Option<usize>>,
    /// The lobes that each group's light is gathered for: as they were when the group came to its
    /// rung or the level began, so that the turns of a level see the same light samples.
    aims: Vec<Material>,
    /// Turns since a group changed its rung or the level began.
    calm: usize,
}

impl<'o> Climber<'o> {
    fn new(state: &State<'_>, options: &'o Options) -> Self {
        let groups = state.materials.len();
        Self {
            options,
            level: 0,
            trials: vec![0; groups],
            tried_at: vec![None; groups],
            aims: state.materials.clone(),
            calm: 0,
        }
    }

    /// One turn over all groups; returns the largest change that is still called for.
    fn turn(&mut self, state: &mut State<'_>) -> f64 {
        let mut next = state.materials.clone();
        let mut change = 0.0f64;
        for group in state.visible_unknowns() {
            if let Some(fitted) = self.refit(state, group) {
                change = change.max(distance(&state.materials[group], &fitted));
                next[group] = approach(&state.materials[group], fitted);
            }
        }
        self.groups_in_mirrors(state, &mut next);
        state.materials = next;
        change
    }

    /// The group's current hypothesis fitted to the present light.
    fn refit(&self, state: &mut State<'_>, group: usize) -> Option<Material> {
        let material = state.materials[group].clone();
        let hypothesis = state.standing[group].hypothesis;
        if hypothesis == Hypothesis::Textured {
            // What the last uniform rung left says nothing of the texture.
            state.standing[group].misfit = None;
            return extract(state, self.options, group, false);
        }
        let effort = if hypothesis == Hypothesis::Diffuse {
            effort::diffuse(self.level, self.options.seed)
        } else {
            effort::specular(self.level, self.options.seed, &self.aims[group])
        };
        let pixels = &state.observation.pixels_of_group[group];
        let evidence = self.gather(state, group, pixels, effort);
        if evidence.is_empty() {
            return None;
        }
        let fit = hypothesis::fit(hypothesis, &evidence, &material, Search::Local);
        state.standing[group].misfit = Some(fit.misfit);
        Some(fit.material)
    }

    fn gather(
        &self,
        state: &State<'_>,
        group: usize,
        pixels: &[u32],
        mut effort: crate::evidence::Effort,
    ) -> Evidence {
        effort.probe.max_bounces = self.options.max_bounces;
        Evidence::gather(&state.stage(), state.appearance(), group, pixels, &effort)
    }

    fn thresholds(&self) -> &crate::problem::Thresholds {
        &self.options.thresholds
    }

    /// Fits all uniform rungs to one cache of light and stands on the simplest good one. What none
    /// explains may be strays, which are then no longer believed.
    fn trial(&mut self, state: &mut State<'_>, group: usize, turn: usize) -> Material {
        self.trials[group] += 1;
        self.tried_at[group] = Some(self.level);
        let effort = effort::trial(self.options.seed ^ ((turn as u64) << 32));
        let pixels = &state.observation.pixels_of_group[group];
        let evidence = self.gather(state, group, pixels, effort);
        if evidence.is_empty() {
            return state.materials[group].clone();
        }
        let mut fits = fit_all(&evidence, state);
        let mut chosen = choice::choose(&fits, self.thresholds());
        let explained = fits[chosen].misfit.is_within(self.thresholds().textured);
        if self.options.strays
            && self.level > 0
            && !explained
            && let Some(better) = self.without_strays(state, group, evidence, &fits[chosen])
        {
            fits = better;
            chosen = choice::choose(&fits, self.thresholds());
        }
        let standing = &mut state.standing[group];
        standing.story.extend(fits.iter().enumerate().map(|(i, fit)| Trial {
            turn,
            hypothesis: fit.hypothesis,
            material: fit.material.clone(),
            misfit: fit.misfit,
            taken: i == chosen,
        }));
        standing.hypothesis = fits[chosen].hypothesis;
        standing.misfit = Some(fits[chosen].misfit);
        fits[chosen].material.clone()
    }

    /// The rungs fitted to what is left of the group without its strays, if one of them explains
    /// that; the strays are then no longer believed.
    fn without_strays(
        &self,
        state: &mut State<'_>,
        group: usize,
        mut evidence: Evidence,
        fit: &Fit,
    ) -> Option<Vec<Fit>> {
        let geometry = state.problem.renderer.geometry();
        let whole = evidence.pixels.len() as f32;
        let mut fit = fit.clone();
        let mut strays = Vec::new();
        for _ in 0..STRAY_ROUNDS {
            let flags = stray::find(&evidence, &fit, geometry, self.thresholds().dispersion)?;
            let sampled: Vec<u32> = evidence.pixels.iter().map(|p| p.pixel).collect();
            let believed = &state.observation.pixels_of_group[group];
            strays.extend(stray::spread_out(&sampled, &flags, believed, geometry));
            evidence = evidence.without(&flags);
            if (evidence.pixels.len() as f32) < (1.0 - stray::SHARE_MAX) * whole {
                return None;
            }
            let fits = fit_all(&evidence, state);
            let chosen = choice::choose(&fits, self.thresholds());
            if fits[chosen].misfit.is_within(self.thresholds().textured) {
                let share = 100.0 * strays.len() as f64 / believed.len().max(1) as f64;
                state.standing[group].note = None;
                state.standing[group].add_note(format!(
                    "{share:.0} % of its pixels show something that is not in the model and do not \
                     count"
                ));
                state.observation.distrust(group, &strays);
                return Some(fits);
            }
            fit = fits[chosen].clone();
        }
        None
    }

    /// Tries all rungs on the groups that are explained worst. True if one of them moved.
    fn try_worst(&mut self, state: &mut State<'_>, turn: usize) -> bool {
        let errors: Vec<(usize, f64)> = state
            .visible_unknowns()
            .into_iter()
            .filter(|&g| self.is_open(state, g))
            .map(|g| (g, state.standing[g].misfit.map_or(0.0, |m| m.relative())))
            .collect();
        let worst = errors.iter().map(|e| e.1).fold(0.0, f64::max);
        let mut moved = false;
        for (group, _) in errors.into_iter().filter(|e| e.1 >= WORST * worst) {
            let believed = |state: &State<'_>| state.observation.pixels_of_group[group].len();
            let before = (state.standing[group].hypothesis, believed(state));
            let mut material = self.trial(state, group, turn);
            let explained = |m: Misfit| m.is_within(self.thresholds().textured);
            if !state.standing[group].misfit.is_some_and(explained)
                && self.level > 0
                && let Some(textured) = extract(state, self.options, group, false)
            {
                state.standing[group].hypothesis = Hypothesis::Textured;
                material = textured;
            }
            if (state.standing[group].hypothesis, believed(state)) != before {
                state.materials[group] = material;
                moved = true;
            }
        }
        moved
    }

    /// Whether a group may stand on the wrong rung: its error is above the threshold and it was not
    /// tried too often, nor since the light was this good.
    fn is_open(&self, state: &State<'_>, group: usize) -> bool {
        let standing = &state.standing[group];
        let factor = if self.level == 0 { CLEARLY } else { 1.0 };
        let explained =
            standing.misfit.is_none_or(|m| m.is_within(factor * self.thresholds().explained));
        let climbed = standing.hypothesis != Hypothesis::Diffuse;
        let done = self.trials[group] >= TRIALS_MAX || self.tried_at[group] == Some(self.level);
        let wanted = !explained || (climbed && self.level > 0);
        wanted && !done && standing.hypothesis != Hypothesis::Textured
    }

    /// Groups that no pixel shows directly may be seen in a mirror: there they get a diffuse
    /// reflectance.
    fn groups_in_mirrors(&self, state: &mut State<'_>, next: &mut [Material]) {
        let observation = &state.observation;
        let mirrors = (0..state.materials.len()).filter(|&g| state.materials[g].is_pure_mirror());
        let in_mirrors: Vec<u32> =
            mirrors.flat_map(|g| observation.pixels_of_group[g].iter().copied()).collect();
        if in_mirrors.is_empty() {
            return;
        }
        for group in 0..next.len() {
            let asked = state.problem.groups[group].role == crate::problem::Role::Unknown;
            if !asked || !observation.pixels_of_group[group].is_empty() {
                continue;
            }
            let mut effort = effort::diffuse(self.level, self.options.seed);
            effort.probe.through_mirrors = true;
            let evidence = self.gather(state, group, &in_mirrors, effort);
            if evidence.pixels.len() < 20 {
                continue;
            }
            let fit = hypothesis::fit(Hypothesis::Diffuse, &evidence, &next[group], Search::Local);
            next[group] = fit.material;
            let standing = &mut state.standing[group];
            standing.misfit = Some(fit.misfit);
            standing.status = Status::Recovered;
            standing.note = Some("seen in a mirror only; taken as diffuse".to_owned());
        }
    }
}

/// The group's texture under the present light; none without texture coordinates or with too
/// few pixels, which the group's note then says.
fn extract(state: &mut State<'_>, options: &Options, group: usize, last: bool) -> Option<Material> {
    let few = state.observation.pixels_of_group[group].len() < TEXTURE_PIXELS;
    let mut effort = effort::texture(last, options.seed);
    effort.probe.max_bounces = options.max_bounces;
    let plain = Material::diffuse(state.materials[group].rho_d);
    let stage = state.stage();
    let extracted = if few {
        None
    } else {
        textured::extract(&stage, state.appearance(), group, &plain, &effort)
    };
    let standing = &mut state.standing[group];
    let Some(extracted) = extracted else {
        let reason = if few { "too few pixels" } else { "no texture coordinates" };
        standing.note = Some(format!(
            "no uniform reflectance explains this group, and it has {reason} for a texture"
        ));
        return None;
    };
    let mean = textured::mean(&extracted);
    standing.seen_texels = Some(extracted.seen);
    let rho_d = Some(extracted.deviation);
    standing.std = last.then_some(Deviations { rho_d, ..Deviations::default() });
    Some(Material { texture: Some(extracted.texture), rho_d: mean, ..plain })
}

/// Tries the uniform rungs once more on groups that came out textured: under the refined light one
/// of them may do. True if one does.
pub(crate) fn reconsider_textures(state: &mut State<'_>, options: &Options) -> bool {
    let mut climber = Climber::new(state, options);
    let (turn, mut moved) = (state.turns.len(), false);
    for group in state.visible_unknowns() {
        if state.standing[group].hypothesis != Hypothesis::Textured {
            continue;
        }
        let material = climber.trial(state, group, turn);
        let standing = &mut state.standing[group];
        if standing.misfit.is_some_and(|m| m.is_within(options.thresholds.textured)) {
            state.materials[group] = material;
            standing.seen_texels = None;
            moved = true;
        } else {
            standing.hypothesis = Hypothesis::Textured;
        }
    }
    moved
}

/// The textures once more, with more light samples, under the final light.
pub(crate) fn finish_textures(state: &mut State<'_>, options: &Options) {
    for group in state.visible_unknowns() {
        if state.standing[group].hypothesis == Hypothesis::Textured
            && let Some(material) = extract(state, options, group, true)
        {
            state.materials[group] = material;
        }
    }
}

/// The material on the way from `now` to `fitted`.
fn approach(now: &Material, fitted: Material) -> Material {
    Material {
        rho_d: now.rho_d.lerp(fitted.rho_d, DAMPING),
        rho_s: now.rho_s.lerp(fitted.rho_s, DAMPING),
        ..fitted
    }
}

/// All uniform rungs, fitted to one cache.
fn fit_all(evidence: &Evidence, state: &State<'_>) -> Vec<Fit> {
    let mut fits: Vec<Fit> = Vec::new();
    for hypothesis in hypothesis::UNIFORM {
        let mut start =
            fits.last().map_or(Material::diffuse(glam::Vec3::ZERO), |f| f.material.clone());
        if hypothesis == Hypothesis::Anisotropic {
            let geometry = state.problem.renderer.geometry();
            start.theta_rad = brushed::direction(evidence, geometry).unwrap_or(0.0);
        }
        fits.push(hypothesis::fit(hypothesis, evidence, &start, Search::Global));
    }
    fits
}
