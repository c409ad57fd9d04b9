//! A recovery under way, for a method other than the default one: [`crate::recover_by`] prepares the guess, the method
//! changes it through this handle, and the last picture and the record are made as usual.

use crate::compare::Measured;
use crate::compare::residual::ResidualStats;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::sample::Stage;
use crate::problem::{Options, Problem, RecoverError};
use crate::progress::Progress;
use crate::record::{CandidateRecord, Rule};
use serde::Serialize;
use serde::de::DeserializeOwned;
use unrender_render::Appearance;
use unrender_scene::Material;

/// What a method may see and change of a recovery.
pub struct Session<'s, 'a, 'o> {
    guess: &'s mut Guess<'a>,
    progress: &'s mut Progress<'o>,
}

impl<'s, 'a, 'o> Session<'s, 'a, 'o> {
    pub(crate) fn of(guess: &'s mut Guess<'a>, progress: &'s mut Progress<'o>) -> Self {
        Self { guess, progress }
    }

    /// The problem.
    pub fn problem(&self) -> &'a Problem<'a> {
        self.guess.problem
    }

    /// The photograph at the present exposure, and the renderer.
    pub fn stage(&self) -> Stage<'_> {
        self.guess.stage()
    }

    /// What the scene looks like under the present materials.
    pub fn appearance(&self) -> Appearance<'_> {
        self.guess.appearance()
    }

    /// The groups to be recovered that the photograph shows.
    pub fn asked(&self) -> Vec<usize> {
        self.guess.visible_unknowns()
    }

    /// The valid pixels of `group`.
    pub fn pixels(&self, group: usize) -> &[u32] {
        &self.guess.observation.pixels_of_group[group]
    }

    /// The present materials, one for each group.
    pub fn materials(&self) -> &[Material] {
        &self.guess.materials
    }

    /// Replaces all materials. Hypotheses are set on their own.
    pub fn set_materials(&mut self, materials: Vec<Material>) {
        self.guess.materials = materials;
    }

    /// The present hypothesis of `group`.
    pub fn hypothesis(&self, group: usize) -> Hypothesis {
        self.guess.groups[group].hypothesis
    }

    /// Replaces the hypothesis of `group`, and notes it in the record.
    pub fn set_hypothesis(&mut self, group: usize, hypothesis: Hypothesis) {
        let before = std::mem::replace(&mut self.guess.groups[group].hypothesis, hypothesis);
        if before != hypothesis {
            let measured = Measured { holds: true, ..Measured::default() };
            self.progress.decide(group, [before, hypothesis], measured, Rule::Method);
        }
    }

    /// States the error of `group` under its present material.
    pub fn set_residual(&mut self, group: usize, residual: ResidualStats) {
        self.guess.groups[group].residual = Some(residual);
    }

    /// Writes the present hypothesis and material of `group`, with their error, into its selection log, and whether
    /// they were accepted.
    pub fn log(&mut self, group: usize, iteration: usize, residual: ResidualStats, accepted: bool) {
        let candidate = CandidateRecord {
            iteration,
            hypothesis: self.guess.groups[group].hypothesis,
            material: self.guess.materials[group].clone(),
            residual,
            model_error: residual.relative(),
            criterion: 0.0,
            accepted,
        };
        self.guess.groups[group].selection_log.push(candidate);
    }

    /// Whether the last entry of the selection log of `group` is of another hypothesis.
    pub fn is_new_to(&self, group: usize, hypothesis: Hypothesis) -> bool {
        self.guess.groups[group].is_new_to(hypothesis)
    }

    /// With an anchor: the exposure that makes the photograph of the anchor group agree with its reflectance.
    ///
    /// # Errors
    /// If the anchor group is not seen lit.
    pub fn update_exposure(&mut self, options: &Options) -> Result<(), RecoverError> {
        self.guess.update_exposure(options)
    }

    /// The result of `work`, which changes nothing; from the journal if that has it.
    pub fn value<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        work: impl FnOnce() -> T,
    ) -> T {
        self.guess.steps.value(name, work)
    }

    /// Whether to stop with the present results.
    pub fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }

    /// Records the end of an iteration in which the largest change of a material was `change`; the groups `open` are
    /// not explained yet, and `done` is the share of the work that is done, 0 to 1.
    pub fn end_iteration(&mut self, change: f64, open: &[usize], done: f64) {
        self.progress.end_iteration(self.guess, change, open, done);
    }
}
