//! Candidates: other hypotheses for every group, the worst explained ones first.
//!
//! All uniform rungs are fitted to gathered incident light, and model selection takes one by light that was gathered
//! again ([`crate::selection`]). What none explains may be outliers ([`crate::outliers`]). A texture is no such candidate: it
//! is looked for by itself ([`crate::texture`]).
//! Only the worst groups are asked at a time, because a wrong group spoils the light of its
//! neighbours: once it is right, their errors may be gone. A proposal changes nothing by itself: the driver makes it.

use super::compared::{self, Compared, Fitted, decide, is_explained};
use super::evidence_pair::{EvidencePair, Fits, Gathering};
use super::proposal::Proposal;
use super::textures::{self, Textured};
use crate::compare::Difference;
use crate::compare::Measured;
use crate::compare::residual::ResidualStats;
use crate::guess::{GroupGuess, Guess};
use crate::hypothesis::{Fit, Hypothesis};
use crate::outliers;
use crate::problem::Options;
use crate::progress::Progress;
use crate::record::{CandidateRecord, Rule, Status};
use crate::sample_budget::{self, Level};
use crate::verify::{Score, Verified};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_scene::Material;

/// Of the groups in error, those with at least this share of the worst model error are asked: at
/// half of it more groups change at once under light that is wrong, at double only the worst does.
const WORST: f64 = 0.5;
/// A diffuse group is open if its model error is this many times what is always allowed for.
const CLEARLY: f64 = 1.5;
/// A group may have outliers if its relative residual under a uniform hypothesis is above this: at half of it shadows of
/// things that the model lacks were left out, at double small outliers were fitted, in scenes whose other groups are
/// explained to 1 %.
const UNEXPLAINED: f64 = 0.06;
/// A lobe over a texture is another one if its roughness is so many times as large or small. At half of the difference
/// the noise of the light changes it back and forth, double of it is visible.
const OTHER_LOBE: f32 = 1.3;
/// How often outliers are searched for, each time without those before.
const OUTLIER_ROUNDS: usize = 3;

/// Asks groups for other hypotheses (compares their candidates), and remembers which were asked.
#[derive(Clone)]
pub(crate) struct Candidates<'o> {
    options: &'o Options,
    /// At which level each group was asked last, and what was verified then.
    asked_at: Vec<Option<(Level, Arc<Score>)>>,
}

impl<'o> Candidates<'o> {
    pub(crate) fn new(guess: &Guess<'_>, options: &'o Options) -> Self {
        let groups = guess.materials.len();
        Self { options, asked_at: vec![None; groups] }
    }

    /// What was verified when `group` was asked last.
    pub(crate) fn asked_in(&self, group: usize) -> Option<&Score> {
        self.asked_at[group].as_ref().map(|(_, score)| &**score)
    }

    /// Lets `groups` be asked again at the present level.
    pub(crate) fn ask_again(&mut self, groups: &[usize]) {
        groups.iter().for_each(|group| self.asked_at[*group] = None);
    }

    /// Groups whose hypothesis does not explain the photograph yet.
    pub(crate) fn open(&self, guess: &Guess<'_>, level: Level) -> Vec<usize> {
        let allowed = sample_budget::allowance(level, self.options);
        let is_open = |g: &usize| {
            let of_group = &guess.groups[*g];
            of_group.hypothesis != Hypothesis::Textured
                && of_group.likelihood.is_none_or(|l| {
                    l.error.share > CLEARLY * allowed.floor.share
                        || l.light.share > CLEARLY * allowed.light.share
                })
        };
        guess.visible_unknowns().into_iter().filter(is_open).collect()
    }

    /// Other hypotheses for the groups that are explained worst among those that were not asked at this level in their present
    /// light.
    pub(crate) fn propose_worst(
        &mut self,
        present: &mut Verified<'_>,
        level: Level,
        progress: &mut Progress<'_>,
    ) -> Vec<Proposal> {
        let Verified { guess, score } = present;
        loop {
            let is_asked = |g: usize| self.asked_at[g].as_ref().is_some_and(|(at, _)| *at == level);
            let is_wanted =
                |g: &usize| guess.groups[*g].hypothesis != Hypothesis::Textured && !is_asked(*g);
            let wanted: Vec<usize> =
                guess.visible_unknowns().into_iter().filter(is_wanted).collect();
            let error =
                |g: usize| guess.groups[g].likelihood.map_or(f64::INFINITY, |l| l.error.share);
            let worst = wanted.iter().map(|g| error(*g)).fold(0.0, f64::max);
            let worst: Vec<usize> =
                wanted.into_iter().filter(|g| error(*g) >= WORST * worst).collect();
            if worst.is_empty() {
                return Vec::new();
            }
            let mut proposals = Vec::new();
            let all = guess.visible_unknowns().len() as f64;
            for group in worst {
                let asked = self.asked_at.iter().flatten().filter(|(at, _)| *at == level).count();
                let done = asked as f64 / all;
                self.asked_at[group] = Some((level, score.clone()));
                proposals.extend(self.propose(guess, group, level, done, progress));
            }
            if !proposals.is_empty() {
                return proposals;
            }
        }
    }

    /// For groups whose hypothesis is not allowed: the best one that is, whatever the picture says.
    pub(crate) fn allowed(
        &mut self,
        guess: &mut Guess<'_>,
        level: Level,
        progress: &mut Progress<'_>,
    ) -> Vec<Proposal> {
        let is_refused = |g: &usize| !guess.problem.groups[*g].allows(guess.groups[*g].hypothesis);
        let refused: Vec<usize> = guess.visible_unknowns().into_iter().filter(is_refused).collect();
        refused
            .into_iter()
            .filter_map(|group| self.propose(guess, group, level, 0.0, progress))
            .collect()
    }

    /// Another hypothesis for `group`; none if the present one stands. What its candidates came to is noted in `guess`.
    fn propose(
        &mut self,
        guess: &mut Guess<'_>,
        group: usize,
        level: Level,
        done: f64,
        progress: &mut Progress<'_>,
    ) -> Option<Proposal> {
        let name = &guess.problem.groups[group].name;
        progress.working(&format!("comparing hypotheses for \"{name}\""), done);
        let answer = guess.steps.value("candidates", || self.ask(guess, group, level));
        let from = guess.groups[group].hypothesis;
        if let Some((to, measured)) = answer.decision {
            let is_made = answer.proposal.as_ref().is_some_and(|made| made.hypothesis == to);
            let measured = Measured { holds: measured.holds && is_made, ..measured };
            progress.decide(group, [from, to], measured, Rule::LightSamples);
        }
        answer.note(&mut guess.groups[group], progress.iterations.len());
        answer.proposal
    }

    /// The proposal that the candidates of `group` lead to.
    fn ask(&self, guess: &Guess<'_>, group: usize, level: Level) -> Answer {
        let pixels = guess.observation.informative_of_group[group].len();
        let budget =
            sample_budget::candidates(level, self.options, &guess.problem.unknown_lights, pixels);
        let by = Gathering { options: self.options, group, budget };
        let Some(compared) = compared::compare(guess, &by) else { return Answer::default() };
        let Compared { evidence, fitted, is_other_minimum } = compared;
        let mut answer = Answer {
            candidates: records(&fitted),
            decision: decision(guess.groups[group].hypothesis, &fitted),
            undecided: fitted.undecided(),
            ..Answer::default()
        };
        let chosen = fitted.chosen().clone();
        let uniform =
            Proposal { is_other_minimum, ..Proposal::uniform(group, &chosen, &fitted.outliers) };
        let proposal = if guess.problem.groups[group].allows(chosen.hypothesis) {
            let left = self.without_outliers(guess, group, evidence, chosen);
            let left = left.map(|left| Proposal::uniform(group, left.chosen(), &left.outliers));
            left.or(Some(uniform))
        } else {
            self.texture(guess, group, level, true).1
        };
        answer.proposal = proposal.filter(|proposal| proposal.moves(guess));
        answer
    }

    /// Textures for those of `groups` whose pixels predict each other by one, and the best uniform hypotheses for those with a
    /// texture whose pixels do not.
    pub(crate) fn textures(
        &mut self,
        guess: &mut Guess<'_>,
        groups: &[usize],
        level: Level,
        progress: &mut Progress<'_>,
    ) -> Vec<Proposal> {
        let mut proposals = Vec::new();
        // No contrast is as large as an infinite one.
        if self.options.thresholds.textured.is_infinite() {
            return proposals;
        }
        for (n, &group) in groups.iter().enumerate() {
            if progress.is_cancelled() {
                break;
            }
            let name = &guess.problem.groups[group].name;
            let done = n as f64 / groups.len() as f64;
            progress.working(&format!("looking for a texture of \"{name}\""), done);
            let (measured, proposal) =
                guess.steps.value("look", || self.texture(guess, group, level, false));
            let present = guess.groups[group].hypothesis;
            let is_textured = present == Hypothesis::Textured;
            if let Some(measured) = measured {
                let holds = measured.holds && !is_textured;
                let measured = Measured { holds, ..measured };
                progress.decide(group, [present, Hypothesis::Textured], measured, Rule::Prediction);
            }
            let other = if is_textured && measured.is_some_and(|measured| !measured.holds) {
                self.propose(guess, group, level, done, progress)
            } else {
                proposal
            };
            proposals.extend(other.filter(|other| other.moves(guess)));
        }
        proposals
    }

    /// A texture for `group` if its pixels predict each other by one, better than its uniform reflectance does, or where it
    /// must have one; and by what. It has no outliers: a texture explains every pixel.
    fn texture(
        &self,
        guess: &Guess<'_>,
        group: usize,
        level: Level,
        must: bool,
    ) -> (Option<Measured>, Option<Proposal>) {
        let is_allowed = guess.problem.groups[group].allows(Hypothesis::Textured);
        if !is_allowed || !textures::is_possible(guess, group) {
            return (None, None);
        }
        let mut whole = guess.clone();
        whole.forget_outliers(group);
        let pixels = whole.observation.pixels_of_group[group].len();
        let unknown_lights = &guess.problem.unknown_lights;
        let mut budget = sample_budget::candidates(level, self.options, unknown_lights, pixels);
        budget.probe.max_bounces = self.options.max_bounces;
        budget.probe.probes_per_pixel = 1;
        let (present, material) = (guess.groups[group].hypothesis, &guess.materials[group]);
        let least = self.options.thresholds.textured;
        let Some(found) = textures::look(&whole, (group, least), &budget) else {
            return (None, None);
        };
        let is_texture = must || found.pattern.is_texture(least);
        let measured = found.pattern.measured(is_texture, least);
        let extracted =
            is_texture.then(|| textures::extract(&whole, self.options, group, &found.lobe, false));
        let Some(Textured { material: next, seen, .. }) = extracted.flatten() else {
            return (Some(measured), None);
        };
        let is_other_minimum =
            present == Hypothesis::Textured && is_other_lobe(material, &found.lobe);
        let residual = ResidualStats::default();
        let proposal = Proposal {
            seen_texels: Some(seen),
            is_other_minimum,
            ..Proposal::to(group, (Hypothesis::Textured, next), residual)
        };
        (Some(measured), Some(proposal))
    }

    /// The fits to the group without its outliers, if one of them explains it, where `fit` to all of it does not.
    fn without_outliers(
        &self,
        guess: &Guess<'_>,
        group: usize,
        mut evidence: EvidencePair,
        mut fit: Fit,
    ) -> Option<Fitted> {
        let floor = evidence.judging.allowance.floor;
        if !self.options.outliers || is_explained(&fit, UNEXPLAINED, floor) {
            return None;
        }
        let geometry = guess.problem.renderer.geometry();
        let mut found = Vec::new();
        let valid = &guess.observation.pixels_of_group[group];
        let height = guess.observation.sheet.highest();
        let side = outliers::cell_side(height, valid.len(), evidence.judging.sample.pixels.len());
        for _ in 0..OUTLIER_ROUNDS {
            let dispersion = self.options.thresholds.dispersion;
            let flags = outliers::find(&evidence.judging, &fit, geometry, dispersion, side)?;
            let sampled: Vec<u32> =
                evidence.judging.sample.pixels.iter().map(|p| p.pixel).collect();
            found.extend(outliers::spread_out(&sampled, &flags, valid, geometry, side));
            if found.len() as f32 > outliers::SHARE_MAX * valid.len() as f32 {
                return None;
            }
            let (left, Fits { all: fits, .. }) = evidence.without(&flags).fit_all(guess, group);
            if fits.is_empty() {
                return None;
            }
            evidence = left;
            let present = guess.groups[group].hypothesis;
            let choice = decide(self.options, &fits, &evidence.judging, present);
            let chosen = &fits[choice.chosen];
            if is_explained(chosen, UNEXPLAINED, floor) {
                return Some(Fitted { fits, choice, outliers: found });
            }
            fit = chosen.clone();
        }
        None
    }
}

/// Whether the lobe of `present` is another one than `lobe`.
fn is_other_lobe(present: &Material, lobe: &Material) -> bool {
    let (a, b) = (present.alpha_x, lobe.alpha_x);
    match (present.is_glossy(), lobe.is_glossy()) {
        (true, true) => a.max(b) > OTHER_LOBE * a.min(b),
        (before, now) => before != now,
    }
}

/// What the candidates of one group came to.
#[derive(Default, Serialize, Deserialize)]
struct Answer {
    candidates: Vec<CandidateRecord>,
    /// The one that was compared with the present hypothesis, and by what.
    decision: Option<(Hypothesis, Measured)>,
    /// The hypotheses that stay open.
    undecided: Vec<Hypothesis>,
    proposal: Option<Proposal>,
}

impl Answer {
    /// Notes it in the guess at the group, after so many iterations.
    fn note(&self, of_group: &mut GroupGuess, iteration: usize) {
        if self.candidates.is_empty() {
            return;
        }
        let records = self.candidates.iter().cloned();
        of_group.selection_log.extend(records.map(|of| CandidateRecord { iteration, ..of }));
        of_group.undecided.clone_from(&self.undecided);
        if of_group.status == Status::Assumed {
            of_group.status = Status::Recovered;
        }
    }
}

/// The candidate that was chosen instead of the `present` one, or else the one that came nearest to it, and by what it
/// was chosen or not; none without a present one.
fn decision(present: Hypothesis, fitted: &Fitted) -> Option<(Hypothesis, Measured)> {
    let (fits, choice) = (&fitted.fits, &fitted.choice);
    let place = fits.iter().position(|fit| fit.hypothesis == present)?;
    let holds = choice.chosen != place;
    let others = (0..fits.len()).filter(|other| *other != place);
    let nearest =
        || others.min_by(|a, b| choice.excess[*a].value.total_cmp(&choice.excess[*b].value));
    let to = if holds { choice.chosen } else { nearest()? };
    let excess = if holds { -choice.excess[place] } else { choice.excess[to] };
    Some((fits[to].hypothesis, excess.measured(holds)))
}

/// The candidates for the group's selection log.
fn records(fitted: &Fitted) -> Vec<CandidateRecord> {
    let (fits, choice) = (&fitted.fits, &fitted.choice);
    let entry = |(i, (fit, excess)): (usize, (&Fit, &Difference))| CandidateRecord {
        iteration: 0,
        hypothesis: fit.hypothesis,
        material: fit.material.clone(),
        residual: fit.residual,
        model_error: fit.likelihood.error.share,
        criterion: excess.value,
        accepted: i == choice.chosen,
    };
    fits.iter().zip(&choice.excess).enumerate().map(entry).collect()
}
