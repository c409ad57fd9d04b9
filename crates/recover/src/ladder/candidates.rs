//! Candidates: other hypotheses for the groups that the present ones explain worst.
//!
//! All uniform rungs are fitted to gathered incident light, and model selection takes one by light that was gathered
//! again ([`crate::selection`]). What none explains may be outliers ([`crate::outliers`]), or a texture.
//! Only the worst groups are asked at a time, because a wrong group spoils the light of its
//! neighbours: once it is right, their errors may be gone. A proposal changes nothing by itself; the
//! driver accepts it if the re-rendering of the whole picture is not worse for it.

use super::compared::{Asking, Compared, Fitted, decide, is_explained};
use super::evidence_pair::{EvidencePair, Fits, Gathering};
use super::proposal::{Proposal, added};
use super::textures::{self, Textured};
use crate::compare::Difference;
use crate::compare::Measured;
use crate::guess::{GroupGuess, Guess};
use crate::hypothesis::{Fit, Hypothesis};
use crate::observe::model_error::{Allowance, ModelError};
use crate::others::{MIDDLE, error_of_others, left_by_others, light_of_others};
use crate::outliers;
use crate::problem::Options;
use crate::progress::Progress;
use crate::record::{CandidateRecord, Rule, Status};
use crate::sample_budget::{self, Level};
use serde::{Deserialize, Serialize};

/// Of the groups in error, those with at least this share of the worst model error are asked: at
/// half of it more groups change at once under light that is wrong, at double only the worst does.
const WORST: f64 = 0.5;
/// A group is asked at most so often.
const ASKED_MAX: usize = 6;
/// A diffuse group is open if its model error is this many times what is always allowed for.
const CLEARLY: f64 = 1.5;
/// A group may have outliers if its residual under a uniform hypothesis is this many times that of the scene's better
/// groups: at half of it shadows of things that the model lacks are left out, at double small outliers are fitted.
const UNEXPLAINED: f64 = 6.0;
/// A texture is tried if the residual is this many times that of the better groups, and has to gain more than from
/// residuals of that size ([`crate::verify`]). At half of it time goes to textures that are rejected, and shadows
/// become textures; at double faint textures are taken for noise.
const TEXTURED: f64 = 2.0;
/// The scene's better groups: those below this quantile of the residual. A group that no hypothesis
/// explains yet must not hide the others' textures.
const BETTER: f64 = 0.25;
/// The residual of the better groups is taken as at least this: no real scene is modelled better.
const TYPICAL_MIN: f64 = 0.01;
/// How often outliers are searched for, each time without those before.
const OUTLIER_ROUNDS: usize = 3;

/// Asks groups for other hypotheses (compares their candidates), and remembers which were asked.
#[derive(Clone)]
pub(crate) struct Candidates<'o> {
    options: &'o Options,
    /// How often each group was asked.
    asked: Vec<usize>,
    /// At which level each group was asked last.
    asked_at: Vec<Option<Level>>,
    /// Hypotheses that the whole picture spoke against.
    rejected: Vec<Vec<Hypothesis>>,
    /// A group whose hypothesis is held while the others are asked.
    held: Option<usize>,
}

impl<'o> Candidates<'o> {
    pub(crate) fn new(guess: &Guess<'_>, options: &'o Options) -> Self {
        let groups = guess.materials.len();
        Self {
            options,
            asked: vec![0; groups],
            asked_at: vec![None; groups],
            rejected: vec![Vec::new(); groups],
            held: None,
        }
    }

    /// Remembers that the re-rendering spoke against `proposal`.
    pub(crate) fn reject(&mut self, proposal: &Proposal) {
        self.rejected[proposal.group].push(proposal.hypothesis);
    }

    /// Gives rejected hypotheses another chance, under better light.
    pub(crate) fn forget_rejections(&mut self) {
        self.rejected.iter_mut().for_each(Vec::clear);
    }

    /// The groups whose texture was rejected, which may now be proposed again: it was judged by the other groups'
    /// residuals.
    pub(crate) fn take_refused_textures(&mut self) -> Vec<usize> {
        let mut groups = Vec::new();
        for (group, rejected) in self.rejected.iter_mut().enumerate() {
            if rejected.contains(&Hypothesis::Textured) {
                rejected.retain(|hypothesis| *hypothesis != Hypothesis::Textured);
                groups.push(group);
            }
        }
        groups
    }

    /// Lets `groups` be asked again at the present level, for rejected hypotheses too: their light has changed.
    pub(crate) fn ask_again(&mut self, groups: &[usize]) {
        for &group in groups {
            self.asked_at[group] = None;
            self.rejected[group].clear();
        }
    }

    /// Leaves `group` as it is until another one, or none, is held.
    pub(crate) fn hold(&mut self, group: Option<usize>) {
        self.held = group;
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

    /// Other hypotheses for the groups in error, the worst ones among those that were not asked at
    /// this level in their present light.
    pub(crate) fn propose_worst(
        &mut self,
        guess: &mut Guess<'_>,
        level: Level,
        progress: &mut Progress<'_>,
    ) -> Vec<Proposal> {
        loop {
            let open = self.open(guess, level);
            let climbed = |g: &usize| {
                let hypothesis = guess.groups[*g].hypothesis;
                !matches!(hypothesis, Hypothesis::Diffuse | Hypothesis::Textured)
            };
            let asked = |g: &usize| {
                let is_new = self.asked[*g] < ASKED_MAX && self.asked_at[*g] != Some(level);
                is_new && self.held != Some(*g)
            };
            let wanted = guess.visible_unknowns().into_iter();
            let wanted: Vec<usize> =
                wanted.filter(|g| open.contains(g) || climbed(g)).filter(asked).collect();
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
                let asked = self.asked_at.iter().filter(|at| **at == Some(level)).count();
                proposals.extend(self.propose(guess, group, level, asked as f64 / all, progress));
            }
            if !proposals.is_empty() {
                return proposals;
            }
        }
    }

    /// Forgets why groups have no texture if their refined numbers explain them after all.
    pub(crate) fn forget_explained(&self, guess: &mut Guess<'_>) {
        for group in guess.visible_unknowns() {
            let limit = self.textured_above(typical(guess, group));
            let of_group = &mut guess.groups[group];
            if of_group.likelihood.is_some_and(|left| left.error.share <= limit) {
                of_group.untextured = None;
            }
        }
    }

    /// The residual above which a texture is tried, if the better ones of the other groups leave `typical`.
    fn textured_above(&self, typical: f64) -> f64 {
        self.options.thresholds.textured.unwrap_or(TEXTURED * typical)
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
    pub(crate) fn propose(
        &mut self,
        guess: &mut Guess<'_>,
        group: usize,
        level: Level,
        done: f64,
        progress: &mut Progress<'_>,
    ) -> Option<Proposal> {
        let name = &guess.problem.groups[group].name;
        progress.working(&format!("comparing hypotheses for \"{name}\""), done);
        self.asked[group] += 1;
        self.asked_at[group] = Some(level);
        let answer = guess.steps.value("candidates", || self.ask(guess, group, level));
        if let Some((to, measured)) = answer.decision {
            let from = guess.groups[group].hypothesis;
            progress.decide(group, [from, to], measured, Rule::LightSamples);
        }
        answer.note(&mut guess.groups[group], progress.iterations.len());
        answer.proposal
    }

    /// The proposal that the candidates of `group` lead to.
    fn ask(&self, guess: &Guess<'_>, group: usize, level: Level) -> Answer {
        let pixels = guess.observation.informative_of_group[group].len();
        let mut budget =
            sample_budget::candidates(level, self.options, &guess.problem.unknown_lights, pixels);
        // The model may be as wrong here as it is for the other groups.
        let floor = &mut budget.allowance.floor;
        floor.share = floor.share.max(error_of_others(guess, group, MIDDLE));
        let typical = typical(guess, group);
        let most = light_of_others(guess, group);
        let by = Gathering { options: self.options, group, most, budget };
        let asking = Asking {
            by,
            level,
            rejected: &self.rejected[group],
            explained: self.textured_above(typical),
            stands: sample_budget::is_light_to_spare(
                level,
                self.options,
                &guess.problem.unknown_lights,
            ),
        };
        let Some(compared) = asking.compare(guess) else { return Answer::default() };
        let Compared { evidence, fitted, is_other_minimum, is_borne_out } = compared;
        let mut answer = Answer {
            candidates: records(&fitted),
            decision: decision(guess.groups[group].hypothesis, &fitted),
            undecided: fitted.undecided(),
            ..Answer::default()
        };
        let chosen = fitted.chosen().clone();
        let Some(chain) = chain(guess, group, &fitted) else { return answer };
        let uniform = Proposal { is_other_minimum, is_borne_out, ..chain };
        let after = if guess.problem.groups[group].allows(chosen.hypothesis) {
            self.beyond_uniform(guess, group, evidence, (chosen, typical), &mut answer.untextured)
        } else {
            let texture = self.texture(guess, group, &chosen, &mut answer.untextured);
            answer.proposal = texture.filter(|texture| texture.moves(guess));
            return answer;
        };
        let is_textured = guess.groups[group].hypothesis == Hypothesis::Textured;
        answer.proposal = if uniform.moves(guess) && !(is_textured && after.is_some()) {
            Some(Proposal { then: after.map(Box::new), ..uniform })
        } else {
            after.filter(|after| after.moves(guess))
        };
        answer
    }

    /// Proposals for a group that no uniform hypothesis explains: one of these without outliers, and a texture,
    /// compared with it, since an outlier costs as much as some texels. The better ones of the other groups leave
    /// `typical`.
    fn beyond_uniform(
        &self,
        guess: &Guess<'_>,
        group: usize,
        evidence: EvidencePair,
        (chosen, typical): (Fit, f64),
        untextured: &mut Option<String>,
    ) -> Option<Proposal> {
        let asked = self.options.thresholds.textured;
        let (limit, textured_above) = (UNEXPLAINED * typical, self.textured_above(typical));
        let floor = evidence.judging.allowance.floor;
        let texture = if is_explained(&chosen, textured_above, floor) {
            None
        } else {
            // An error of the light as large as that of other groups is no texture.
            let most = evidence.judging.sample.field.most;
            let light =
                if most.share.is_finite() { most } else { evidence.judging.allowance.light };
            let least = Allowance { light, floor: ModelError { share: TEXTURED * typical } };
            let least = asked.is_none().then_some(least);
            let texture = self.texture(guess, group, &chosen, untextured);
            texture.map(|texture| Proposal { least, ..texture })
        };
        if !self.options.outliers || is_explained(&chosen, limit, floor) {
            return texture;
        }
        let left = self.without_outliers(guess, group, evidence, chosen, limit);
        match left.filter(|left| is_explained(left.chosen(), asked.unwrap_or(limit), floor)) {
            Some(left) => {
                let then = texture.map(Box::new);
                chain(guess, group, &left).map(|best| Proposal { then, ..best })
            }
            None => texture,
        }
    }

    /// A texture for a group that `uniform` explains best of the uniform hypotheses, or why there is none. It has no
    /// outliers: a texture explains every pixel.
    fn texture(
        &self,
        guess: &Guess<'_>,
        group: usize,
        uniform: &Fit,
        untextured: &mut Option<String>,
    ) -> Option<Proposal> {
        if !self.may_be_textured(guess, group) {
            return None;
        }
        let mut whole = guess.clone();
        whole.forget_outliers(group);
        let extracted = textures::extract(&whole, self.options, group, false);
        let Textured { material, seen, .. } =
            extracted.map_err(|why| *untextured = Some(why)).ok()?;
        let present = guess.groups[group].hypothesis;
        Some(Proposal {
            hypothesis: Hypothesis::Textured,
            is_more_complex: present < Hypothesis::Textured,
            adds: added(guess, group, (Hypothesis::Textured, &material)),
            material,
            seen_texels: Some(seen),
            ..Proposal::uniform(guess, group, uniform, &[], None)
        })
    }

    fn may_be_textured(&self, guess: &Guess<'_>, group: usize) -> bool {
        guess.problem.groups[group].allows(Hypothesis::Textured)
            && !self.rejected[group].contains(&Hypothesis::Textured)
    }

    /// The fits to the group without its outliers, if one of them explains it.
    fn without_outliers(
        &self,
        guess: &Guess<'_>,
        group: usize,
        mut evidence: EvidencePair,
        mut fit: Fit,
        limit: f64,
    ) -> Option<Fitted> {
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
            let rejected = &self.rejected[group];
            let choices = decide(self.options, rejected, &fits, &evidence.judging);
            let chosen = &fits[choices[0].chosen];
            if is_explained(chosen, limit, evidence.judging.allowance.floor) {
                return Some(Fitted { fits, choices, outliers: found });
            }
            fit = chosen.clone();
        }
        None
    }
}

/// The residual of the better ones of the groups other than `group`.
fn typical(guess: &Guess<'_>, group: usize) -> f64 {
    left_by_others(guess, group, BETTER).max(TYPICAL_MIN)
}

/// The changes that were chosen from `fitted`, each to be tried if the picture speaks against the one before.
fn chain(guess: &Guess<'_>, group: usize, fitted: &Fitted) -> Option<Proposal> {
    let Fitted { fits, choices, outliers } = fitted;
    let chosen = choices.iter().rev().map(|choice| &fits[choice.chosen]);
    chosen.fold(None, |next, fit| {
        Some(Proposal::uniform(guess, group, fit, outliers, next.map(Box::new)))
    })
}

/// What the candidates of one group came to.
#[derive(Default, Serialize, Deserialize)]
struct Answer {
    candidates: Vec<CandidateRecord>,
    /// The one that was compared with the present hypothesis, and by what.
    decision: Option<(Hypothesis, Measured)>,
    /// The hypotheses that stay open.
    undecided: Vec<Hypothesis>,
    /// Why the group has no texture, though nothing uniform explains it.
    untextured: Option<String>,
    proposal: Option<Proposal>,
}

impl Answer {
    /// Notes it in the guess at the group, after so many iterations.
    fn note(&self, of_group: &mut GroupGuess, iteration: usize) {
        of_group.untextured.clone_from(&self.untextured);
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
    let (fits, choice) = (&fitted.fits, &fitted.choices[0]);
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
    let (fits, choice) = (&fitted.fits, &fitted.choices[0]);
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
