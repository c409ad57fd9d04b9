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
use super::textures;
use crate::hypothesis::{Fit, Hypothesis};
use crate::model_error::{Allowance, ModelError};
use crate::others::{MIDDLE, error_of_others, left_by_others, light_of_others};
use crate::outliers;
use crate::problem::Options;
use crate::record::{CandidateRecord, Observer, Status};
use crate::sample_budget::{self, Level};
use crate::state::State;

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
    pub(crate) fn new(state: &State<'_>, options: &'o Options) -> Self {
        let groups = state.materials.len();
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
    pub(crate) fn open(&self, state: &State<'_>, level: Level) -> Vec<usize> {
        let allowed = sample_budget::allowance(level, self.options);
        let is_open = |g: &usize| {
            let of_group = &state.groups[*g];
            of_group.hypothesis != Hypothesis::Textured
                && of_group.likelihood.is_none_or(|l| {
                    l.error.share > CLEARLY * allowed.floor.share
                        || l.light.share > CLEARLY * allowed.light.share
                })
        };
        state.visible_unknowns().into_iter().filter(is_open).collect()
    }

    /// Other hypotheses for the groups in error, the worst ones among those that were not asked at
    /// this level in their present light.
    pub(crate) fn propose_worst(
        &mut self,
        state: &mut State<'_>,
        level: Level,
        observer: &dyn Observer,
    ) -> Vec<Proposal> {
        loop {
            let open = self.open(state, level);
            let climbed = |g: &usize| {
                let hypothesis = state.groups[*g].hypothesis;
                !matches!(hypothesis, Hypothesis::Diffuse | Hypothesis::Textured)
            };
            let asked = |g: &usize| {
                let is_new = self.asked[*g] < ASKED_MAX && self.asked_at[*g] != Some(level);
                is_new && self.held != Some(*g)
            };
            let wanted = state.visible_unknowns().into_iter();
            let wanted: Vec<usize> =
                wanted.filter(|g| open.contains(g) || climbed(g)).filter(asked).collect();
            let error =
                |g: usize| state.groups[g].likelihood.map_or(f64::INFINITY, |l| l.error.share);
            let worst = wanted.iter().map(|g| error(*g)).fold(0.0, f64::max);
            let worst: Vec<usize> =
                wanted.into_iter().filter(|g| error(*g) >= WORST * worst).collect();
            if worst.is_empty() {
                return Vec::new();
            }
            let mut proposals = Vec::new();
            let all = state.visible_unknowns().len() as f64;
            for group in worst {
                let asked = self.asked_at.iter().filter(|at| **at == Some(level)).count();
                tell(state, observer, group, asked as f64 / all);
                proposals.extend(self.propose(state, group, level));
            }
            if !proposals.is_empty() {
                return proposals;
            }
        }
    }

    /// Forgets why groups have no texture if their refined numbers explain them after all.
    pub(crate) fn forget_explained(&self, state: &mut State<'_>) {
        for group in state.visible_unknowns() {
            let limit = self.textured_above(typical(state, group));
            let of_group = &mut state.groups[group];
            if of_group.likelihood.is_some_and(|left| left.error.share <= limit) {
                of_group.untextured = None;
            }
        }
    }

    /// The residual above which a texture is tried, if the better ones of the other groups leave `typical`.
    fn textured_above(&self, typical: f64) -> f64 {
        self.options.thresholds.textured.unwrap_or(TEXTURED * typical)
    }

    /// Gives groups whose hypothesis is not allowed the best one that is, whatever the picture says.
    pub(crate) fn enforce(&mut self, state: &mut State<'_>, level: Level) {
        for group in state.visible_unknowns() {
            if state.problem.groups[group].allows(state.groups[group].hypothesis) {
                continue;
            }
            if let Some(proposal) = self.propose(state, group, level) {
                proposal.apply(state);
            }
        }
    }

    /// Another hypothesis for `group`; none if the present one stands.
    pub(crate) fn propose(
        &mut self,
        state: &mut State<'_>,
        group: usize,
        level: Level,
    ) -> Option<Proposal> {
        self.asked[group] += 1;
        self.asked_at[group] = Some(level);
        state.step("candidates", |state| self.ask(state, group, level))
    }

    /// The proposal that the candidates of `group` lead to.
    fn ask(&self, state: &mut State<'_>, group: usize, level: Level) -> Option<Proposal> {
        state.groups[group].untextured = None;
        let pixels = state.observation.informative_of_group[group].len();
        let mut budget =
            sample_budget::candidates(level, self.options, &state.problem.unknown_lights, pixels);
        // The model may be as wrong here as it is for the other groups.
        let floor = &mut budget.allowance.floor;
        floor.share = floor.share.max(error_of_others(state, group, MIDDLE));
        let typical = typical(state, group);
        let most = light_of_others(state, group);
        let by = Gathering { options: self.options, group, most, budget };
        let asking = Asking {
            by,
            level,
            rejected: &self.rejected[group],
            explained: self.textured_above(typical),
            stands: sample_budget::is_light_to_spare(
                level,
                self.options,
                &state.problem.unknown_lights,
            ),
        };
        let Compared { evidence, fitted, is_other_minimum, is_borne_out } =
            asking.compare(state)?;
        log(state, group, &fitted);
        state.groups[group].undecided = fitted.undecided();
        let chosen = fitted.chosen().clone();
        let chain = chain(state, group, &fitted)?;
        let uniform = Proposal { is_other_minimum, is_borne_out, ..chain };
        if !state.problem.groups[group].allows(chosen.hypothesis) {
            return self.texture(state, group, &chosen).filter(|texture| texture.moves(state));
        }
        let after = self.beyond_uniform(state, group, evidence, (chosen, typical));
        let is_textured = state.groups[group].hypothesis == Hypothesis::Textured;
        if uniform.moves(state) && !(is_textured && after.is_some()) {
            return Some(Proposal { then: after.map(Box::new), ..uniform });
        }
        after.filter(|after| after.moves(state))
    }

    /// Proposals for a group that no uniform hypothesis explains: one of these without outliers, and a texture,
    /// compared with it, since an outlier costs as much as some texels. The better ones of the other groups leave
    /// `typical`.
    fn beyond_uniform(
        &self,
        state: &mut State<'_>,
        group: usize,
        evidence: EvidencePair,
        (chosen, typical): (Fit, f64),
    ) -> Option<Proposal> {
        let asked = self.options.thresholds.textured;
        let (limit, textured_above) = (UNEXPLAINED * typical, self.textured_above(typical));
        let floor = evidence.judging.allowance.floor;
        let texture = if is_explained(&chosen, textured_above, floor) {
            None
        } else {
            // An error of the light as large as that of other groups is no texture.
            let most = evidence.judging.field.most;
            let light =
                if most.share.is_finite() { most } else { evidence.judging.allowance.light };
            let least = Allowance { light, floor: ModelError { share: TEXTURED * typical } };
            let least = asked.is_none().then_some(least);
            self.texture(state, group, &chosen).map(|texture| Proposal { least, ..texture })
        };
        if !self.options.outliers || is_explained(&chosen, limit, floor) {
            return texture;
        }
        let left = self.without_outliers(state, group, evidence, chosen, limit);
        match left.filter(|left| is_explained(left.chosen(), asked.unwrap_or(limit), floor)) {
            Some(left) => {
                let then = texture.map(Box::new);
                chain(state, group, &left).map(|best| Proposal { then, ..best })
            }
            None => texture,
        }
    }

    /// A texture for a group that `uniform` explains best of the uniform hypotheses. It has no outliers: a
    /// texture explains every pixel.
    fn texture(&self, state: &mut State<'_>, group: usize, uniform: &Fit) -> Option<Proposal> {
        if !self.may_be_textured(state, group) {
            return None;
        }
        let valid = state.observation.valid_pixels();
        state.observation.forget_outliers(group);
        let material = textures::extract(state, self.options, group, false);
        state.observation.restore_valid_pixels(&valid);
        let material = material?;
        let present = state.groups[group].hypothesis;
        Some(Proposal {
            hypothesis: Hypothesis::Textured,
            is_more_complex: present < Hypothesis::Textured,
            adds: added(state, group, (Hypothesis::Textured, &material)),
            material,
            ..Proposal::uniform(state, group, uniform, &[], None)
        })
    }

    fn may_be_textured(&self, state: &State<'_>, group: usize) -> bool {
        state.problem.groups[group].allows(Hypothesis::Textured)
            && !self.rejected[group].contains(&Hypothesis::Textured)
    }

    /// A uniform hypothesis for a group that is textured, if one explains it after all.
    pub(crate) fn propose_uniform(
        &mut self,
        state: &mut State<'_>,
        group: usize,
        level: Level,
    ) -> Option<Proposal> {
        let proposal = self.propose(state, group, level)?;
        (proposal.hypothesis != Hypothesis::Textured).then_some(proposal)
    }

    /// The fits to the group without its outliers, if one of them explains it.
    fn without_outliers(
        &self,
        state: &State<'_>,
        group: usize,
        mut evidence: EvidencePair,
        mut fit: Fit,
        limit: f64,
    ) -> Option<Fitted> {
        let geometry = state.problem.renderer.geometry();
        let mut found = Vec::new();
        let valid = &state.observation.pixels_of_group[group];
        let height = state.observation.sheet.highest();
        let side = outliers::cell_side(height, valid.len(), evidence.judging.pixels.len());
        for _ in 0..OUTLIER_ROUNDS {
            let dispersion = self.options.thresholds.dispersion;
            let flags = outliers::find(&evidence.judging, &fit, geometry, dispersion, side)?;
            let sampled: Vec<u32> = evidence.judging.pixels.iter().map(|p| p.pixel).collect();
            found.extend(outliers::spread_out(&sampled, &flags, valid, geometry, side));
            if found.len() as f32 > outliers::SHARE_MAX * valid.len() as f32 {
                return None;
            }
            let (left, Fits { all: fits, .. }) = evidence.without(&flags).fit_all(state, group);
            if fits.is_empty() {
                return None;
            }
            evidence = left;
            let rejected = &self.rejected[group];
            let decisions = decide(self.options, rejected, &fits, &evidence.judging);
            let chosen = &fits[decisions[0].chosen];
            if is_explained(chosen, limit, evidence.judging.allowance.floor) {
                return Some(Fitted { fits, decisions, outliers: found });
            }
            fit = chosen.clone();
        }
        None
    }
}

/// The residual of the better ones of the groups other than `group`.
fn typical(state: &State<'_>, group: usize) -> f64 {
    left_by_others(state, group, BETTER).max(TYPICAL_MIN)
}

/// The changes that were chosen from `fitted`, each to be tried if the picture speaks against the one before.
fn chain(state: &State<'_>, group: usize, fitted: &Fitted) -> Option<Proposal> {
    let Fitted { fits, decisions, outliers } = fitted;
    let chosen = decisions.iter().rev().map(|decision| &fits[decision.chosen]);
    chosen.fold(None, |next, fit| {
        Some(Proposal::uniform(state, group, fit, outliers, next.map(Box::new)))
    })
}

/// Tells the observer that `group` is asked, with the share `done` of the present part.
pub(crate) fn tell(state: &mut State<'_>, observer: &dyn Observer, group: usize, done: f64) {
    let name = &state.problem.groups[group].name;
    observer.working(&format!("comparing hypotheses for \"{name}\""), state.schedule.share(done));
}

/// Writes the candidates into the group's selection log.
fn log(state: &mut State<'_>, group: usize, fitted: &Fitted) {
    let (fits, decision) = (&fitted.fits, &fitted.decisions[0]);
    let iteration = state.iterations.len();
    let entries =
        fits.iter().zip(&decision.excess).enumerate().map(|(i, (fit, excess))| CandidateRecord {
            iteration,
            hypothesis: fit.hypothesis,
            material: fit.material.clone(),
            residual: fit.residual,
            model_error: fit.likelihood.error.share,
            criterion: *excess,
            accepted: i == decision.chosen,
        });
    state.groups[group].selection_log.extend(entries.collect::<Vec<_>>());
    if state.groups[group].status == Status::Assumed {
        state.groups[group].status = Status::Recovered;
    }
}
