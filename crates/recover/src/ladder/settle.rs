//! Fitting the present hypotheses until nothing moves.
//!
//! In every iteration each group's hypothesis is fitted to the light that arrives at it. Where that
//! light comes from diffuse surfaces that the camera sees, the photograph itself says how much it is
//! (`unrender_render::radiance_cache`); only the rest depends on the other groups' reflectances, which move
//! most of the way to their fits ([`crate::approach`]). Sample counts grow from level to level
//! ([`crate::sample_budget`]).

use super::textures;
use crate::approach::Way;
use crate::evidence::{Evidence, SampleBudget};
use crate::hypothesis::{self, Hypothesis, Search};
use crate::model_error::ModelError;
use crate::others::light_of_others;
use crate::problem::{Options, RecoverError, Role};
use crate::record::{Observer, Status};
use crate::refine;
use crate::sample_budget::{self, SETTLED};
use crate::state::{State, distance};
use unrender_scene::Material;

/// Iterations after which a level ends even if something still moves.
const ITERATIONS: [usize; 3] = [8, 4, 3];
/// A group that is seen only in mirrors is fitted from this many pixels on.
const MIRRORED_PIXELS: usize = 20;

/// Fits all groups at one level, time after time.
pub(crate) struct Settler<'o> {
    options: &'o Options,
    level: usize,
    /// The level whose sample counts are used.
    samples: usize,
    /// The lobes that each group's light is gathered for: as they were when this began, so that all
    /// its iterations see the same light samples.
    aims: Vec<Material>,
}

impl<'o> Settler<'o> {
    /// With as many light samples as the level asks for.
    pub(crate) fn new(state: &State<'_>, options: &'o Options, level: usize) -> Self {
        Self { options, level, samples: level, aims: state.materials.clone() }
    }

    /// With few light samples: enough for the other groups to follow when some have changed their
    /// hypotheses.
    pub(crate) fn quick(state: &State<'_>, options: &'o Options, level: usize) -> Self {
        Self { samples: 0, ..Self::new(state, options, level) }
    }

    /// The level that it settles.
    pub(crate) fn level(&self) -> usize {
        self.level
    }

    /// Iterates until nothing moves, or `left` iterations are used up, or the observer cancels.
    /// `open` are the groups that are not explained, for the records.
    pub(crate) fn run(
        &self,
        state: &mut State<'_>,
        open: &dyn Fn(&State<'_>) -> Vec<usize>,
        left: &mut usize,
        observer: &mut dyn Observer,
    ) -> Result<(), RecoverError> {
        // How fits answered in another light says nothing in this one.
        state.groups.iter_mut().for_each(|of_group| of_group.last_way = None);
        for n in 1..=ITERATIONS[self.level] {
            if *left == 0 || observer.is_cancelled() {
                return Ok(());
            }
            *left -= 1;
            refine::settle_nuisances(state, self.options)?;
            let change = state.step("iteration", |state| self.iterate(state));
            let done = n as f64 / ITERATIONS[self.level] as f64;
            let open = open(state);
            observer.iteration(state.end_iteration(change, &open, done));
            if change <= SETTLED[self.samples] {
                return Ok(());
            }
        }
        Ok(())
    }

    /// One iteration over all groups; returns the largest change that is still called for.
    fn iterate(&self, state: &mut State<'_>) -> f64 {
        let mut next = state.materials.clone();
        let mut change = 0.0f64;
        for group in state.visible_unknowns() {
            if let Some(fitted) = self.refit(state, group) {
                change = change.max(distance(&state.materials[group], &fitted));
                let of_group = &mut state.groups[group];
                let way = Way::new(of_group.hypothesis, &state.materials[group], &fitted);
                next[group] = way.go(of_group.last_way.as_ref(), fitted);
                of_group.last_way = Some(way);
            }
        }
        self.groups_in_mirrors(state, &mut next);
        state.materials = next;
        change
    }

    /// The group's current hypothesis fitted to the present light.
    fn refit(&self, state: &mut State<'_>, group: usize) -> Option<Material> {
        let material = state.materials[group].clone();
        let hypothesis = state.groups[group].hypothesis;
        if hypothesis == Hypothesis::Textured {
            // What the last uniform rung left says nothing of the texture.
            (state.groups[group].residual, state.groups[group].likelihood) = (None, None);
            return textures::extract(state, self.options, group, false);
        }
        let lights = &state.problem.unknown_lights;
        let mut budget = if hypothesis == Hypothesis::Diffuse {
            sample_budget::diffuse(self.samples, self.options, lights)
        } else {
            sample_budget::specular(self.samples, self.options, lights, &self.aims[group])
        };
        budget.allowance = sample_budget::allowance(self.level, self.options);
        let mut evidence = gather(state, self.options, group, budget);
        if evidence.is_empty() {
            return None;
        }
        evidence.field.most = light_of_others(state, group);
        let error = state.groups[group].likelihood.map_or(ModelError::START, |l| l.error);
        evidence.reweigh(&material, error);
        let mut fit = hypothesis::fit(hypothesis, &evidence, &material, Search::Local);
        if fit.material.is_glossy() {
            // Weights follow the model: a highlight that is not exactly the lobe is fitted sharper under
            // the weights of a broad lobe, and broader under those of a sharp one.
            evidence.reweigh(&fit.material, fit.likelihood.error);
            let next = hypothesis::fit(hypothesis, &evidence, &fit.material, Search::Local);
            let between = between(&fit.material, next.material);
            fit = hypothesis::fit(hypothesis, &evidence, &between, Search::Kept);
        }
        state.groups[group].residual = Some(fit.residual);
        state.groups[group].likelihood = Some(fit.likelihood);
        Some(fit.material)
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
            let asked = state.problem.groups[group].role == Role::Unknown;
            if !asked || !state.observation.pixels_of_group[group].is_empty() {
                continue;
            }
            let mut budget =
                sample_budget::diffuse(self.level, self.options, &state.problem.unknown_lights);
            budget.probe.through_mirrors = true;
            budget.probe.max_bounces = self.options.max_bounces;
            let (stage, appearance) = (state.stage(), state.appearance());
            let evidence = Evidence::gather(&stage, appearance, group, &in_mirrors, &budget);
            let evidence = evidence.expecting(state.problem.groups[group].expected);
            if evidence.pixels.len() < MIRRORED_PIXELS {
                continue;
            }
            let fit = hypothesis::fit(Hypothesis::Diffuse, &evidence, &next[group], Search::Local);
            next[group] = fit.material;
            let of_group = &mut state.groups[group];
            of_group.residual = Some(fit.residual);
            of_group.status = Status::Recovered;
            of_group.note = Some("seen in a mirror only; taken as diffuse".to_owned());
        }
    }
}

/// The evidence on a group under the present light.
pub(crate) fn gather(
    state: &State<'_>,
    options: &Options,
    group: usize,
    mut budget: SampleBudget,
) -> Evidence {
    budget.probe.max_bounces = options.max_bounces;
    let pixels = &state.observation.informative_of_group[group];
    let evidence = Evidence::gather(&state.stage(), state.appearance(), group, pixels, &budget);
    evidence.expecting(state.problem.groups[group].expected)
}

/// The lobe half way between two, but for its direction, which is that of the second.
fn between(a: &Material, b: Material) -> Material {
    let mean = |a: f32, b: f32| (a * b).sqrt();
    Material { alpha_x: mean(a.alpha_x, b.alpha_x), alpha_y: mean(a.alpha_y, b.alpha_y), ..b }
}
