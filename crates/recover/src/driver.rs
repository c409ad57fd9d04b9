//! The driver: owns iteration, verification and cancellation.
//!
//! All parameters of the present hypotheses are fitted together; other hypotheses are proposed for the groups that are
//! explained worst; a proposal is accepted if the re-rendering of the whole picture ([`crate::verify`]) does not speak
//! against it. Then all parameters are refined together, which is taken back if it ends worse, and the hypotheses are
//! compared again under the refined light. The result is the best state that was verified.

use crate::hypothesis::Hypothesis;
use crate::ladder::branches::{self, Kind};
use crate::ladder::candidates::{self, Candidates};
use crate::ladder::lacking;
use crate::ladder::proposal::Proposal;
use crate::ladder::textures;
use crate::problem::{Options, RecoverError};
use crate::record::{Observer, Termination};
use crate::refine::{self, Depth, brightness, score_test};
use crate::sample_budget::{self, Level};
use crate::schedule::Phase;
use crate::state::{Snapshot, State};
use crate::verify::{Score, Verified, Verifier};

/// How often the hypotheses are compared again after a refinement; each time costs a refinement if
/// one changes.
const REVISIONS: usize = 2;
/// The most other kinds of hypothesis that are tried for groups which stay unexplained: both of one group, and one of a
/// second. Each costs about as much as the first choice. Half and double of it were not tried.
const BRANCHES: usize = 3;
/// How many of the groups that would gain most by a specular part are tried at a time. Each costs a joint fit and a
/// comparison. In drafts of four scenes the right one was the first or the second; half and double of it were not
/// tried.
const LACKING: usize = 2;
/// A specular part is kept if it explains the other groups' pixels better by so many standard deviations. In a room,
/// right ones reached 5.0 to 6.0; wrong ones, there and in three photographs of plain walls, 0.5 at most: half and
/// double of it keep the same ones.
const BETTER: f64 = 1.0;

/// Recovers everything, the default way.
pub(crate) fn drive(
    state: &mut State<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Termination, RecoverError> {
    let mut driver = Driver {
        options,
        verifier: Verifier::new(state, options),
        candidates: Candidates::new(state, options),
        spoken_for: Vec::new(),
    };
    let mut termination = driver.select_models(state, observer)?;
    if options.refine && !observer.is_cancelled() {
        termination = driver.refine(state, observer)?;
    }
    state.step("textures", |state| textures::finish(state, options));
    if options.refine && !observer.is_cancelled() {
        state.schedule.begin(Phase::OtherMinima);
        observer.working(
            "looking for other materials that explain the photo as well",
            state.schedule.share(0.0),
        );
        state.step("other minima", |state| refine::local_minima::find(state, options));
    }
    Ok(if observer.is_cancelled() { Termination::Interrupted } else { termination })
}

struct Driver<'o> {
    options: &'o Options,
    verifier: Verifier,
    candidates: Candidates<'o>,
    /// Groups whose specular part is supported by the other groups' pixels, not by their own.
    spoken_for: Vec<usize>,
}

impl Driver<'_> {
    /// All numbers are fitted together, on few paths; other hypotheses are proposed, accepted or taken back.
    fn select_models(
        &mut self,
        state: &mut State<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Termination, RecoverError> {
        state.schedule.begin(Phase::Fits);
        refine::settle_nuisances(state, self.options)?;
        let mut best = self.verifier.verify(state);
        let first = state.snapshot();
        self.refine_once(state, &mut best, Depth::Rough, observer);
        let is_suspect =
            !self.options.force && brightness::find(state, self.options, &first).is_some();
        let level = Level::Choice;
        self.candidates.enforce(state, level);
        best = self.verifier.verify(state);
        state.schedule.begin(Phase::Choice);
        self.choose(state, &mut best, observer)?;
        // While all are diffuse, a specular part may look like other light. An interrupted choice keeps its results.
        if is_suspect
            && !observer.is_cancelled()
            && let Some(off) = brightness::find(state, self.options, &first)
        {
            return Err(off.into());
        }
        if self.options.effort.asks_again() {
            self.branch(state, &mut best, observer)?;
            self.add_lacking(state, &mut best, observer)?;
        }
        let open = self.candidates.open(state, level);
        state.note_open(&open);
        Ok(Termination::Settled)
    }

    /// Compares the hypotheses of the groups that are explained worst, until none changes in its present light.
    fn choose(
        &mut self,
        state: &mut State<'_>,
        best: &mut Verified,
        observer: &mut dyn Observer,
    ) -> Result<(), RecoverError> {
        let level = Level::Choice;
        while !observer.is_cancelled() {
            refine::settle_nuisances(state, self.options)?;
            let proposals = self.candidates.propose_worst(state, level, observer);
            if proposals.is_empty() {
                break;
            }
            let before = best.score.clone();
            let proposed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
            if self.try_all(state, proposals, best, Depth::Rough, observer) {
                self.refine_once(state, best, Depth::Rough, observer);
                let mut changed = self.changed(state, &best.score, &before, level);
                changed.retain(|group| !proposed.contains(group));
                self.candidates.ask_again(&changed);
            }
        }
        Ok(())
    }

    /// Groups that light each other may keep each other wrong: one that stays unexplained gets another kind of
    /// hypothesis, those of the groups that it lights are compared again, and the better of both results is kept.
    fn branch(
        &mut self,
        state: &mut State<'_>,
        best: &mut Verified,
        observer: &mut dyn Observer,
    ) -> Result<(), RecoverError> {
        let (level, mut tried) = (Level::Choice, Vec::new());
        let allowed = sample_budget::allowance(level, self.options).floor;
        while tried.len() < BRANCHES && !observer.is_cancelled() {
            let Some(other) = branches::next(state, allowed, &tried) else { break };
            tried.extend(Kind::of(other.hypothesis).map(|kind| (other.group, kind)));
            let before = self.candidates.clone();
            other.apply(state);
            refine::refine(state, self.options, Depth::Rough, observer);
            let mut found = self.verifier.verify(state);
            self.candidates.hold(Some(other.group));
            self.candidates.ask_again(&self.changed(state, &found.score, &best.score, level));
            self.choose(state, &mut found, observer)?;
            if self.verifier.compare(&best.score, &found.score).is_worse() {
                *best = found;
                self.candidates.hold(None);
                self.choose(state, best, observer)?;
            } else {
                self.candidates = before;
                state.restore(&best.snapshot);
            }
        }
        Ok(())
    }

    /// Where the picture stays unexplained, the diffuse group that would explain most of it by a specular part gets
    /// one, and keeps it if that explains the other groups better; then the hypotheses of the groups whose light
    /// changed are compared again.
    fn add_lacking(
        &mut self,
        state: &mut State<'_>,
        best: &mut Verified,
        observer: &mut dyn Observer,
    ) -> Result<(), RecoverError> {
        let (level, mut tried) = (Level::Choice, Vec::new());
        let allowed = sample_budget::allowance(level, self.options).floor;
        while !observer.is_cancelled() {
            let others = lacking::all(state, self.options, allowed, &tried);
            let mut first = others.into_iter().take(LACKING);
            let is_found = first.any(|other| {
                tried.push(other.group);
                other.apply(state);
                refine::refine(state, self.options, Depth::Rough, observer);
                let now = state.snapshot();
                let is_better = self.is_better(state, other.group, [&now, &best.snapshot]);
                if !is_better {
                    state.restore(&best.snapshot);
                }
                is_better
            });
            if !is_found {
                break;
            }
            self.spoken_for.extend(tried.last());
            let before = std::mem::replace(best, self.verifier.verify(state));
            self.candidates.ask_again(&self.changed(state, &best.score, &before.score, level));
            self.choose(state, best, observer)?;
        }
        Ok(())
    }

    /// Whether the other groups are explained better in the first state than in the second, where `group` is diffuse.
    fn is_better(&self, state: &mut State<'_>, group: usize, both: [&Snapshot; 2]) -> bool {
        score_test::certainty(state, self.options, group, both) > BETTER
    }

    /// Makes the changes of `proposals` together; if the picture speaks against them, tries each half of them alone.
    /// `best` is the present state, and afterwards the accepted one. Returns whether one was accepted.
    fn try_all(
        &mut self,
        state: &mut State<'_>,
        proposals: Vec<Proposal>,
        best: &mut Verified,
        depth: Depth,
        observer: &mut dyn Observer,
    ) -> bool {
        let mut accepted = false;
        let (alone, together): (Vec<Proposal>, Vec<Proposal>) =
            proposals.into_iter().partition(|one| self.spoken_for.contains(&one.group));
        let mut waiting: Vec<Vec<Proposal>> = alone.into_iter().map(|one| vec![one]).collect();
        waiting.extend((!together.is_empty()).then_some(together));
        while let Some(mut proposals) = waiting.pop() {
            if let Some(found) = self.try_one(state, &proposals, best, depth, observer) {
                proposals.iter().for_each(|proposal| proposal.record(state, true));
                (*best, accepted) = (found, true);
                let next = proposals.into_iter().filter_map(|proposal| proposal.afterwards(state));
                let next: Vec<Proposal> = next.collect();
                if !next.is_empty() {
                    // A texture would also fit a lobe's residual: the lobe is refined first.
                    self.refine_once(state, best, depth, observer);
                }
                waiting.extend(next.into_iter().map(|next| vec![next]));
                continue;
            }
            state.restore(&best.snapshot);
            if proposals.len() > 1 {
                let other = proposals.split_off(proposals.len() / 2);
                waiting.push(other);
                waiting.push(proposals);
            } else if let Some(proposal) = proposals.pop() {
                self.candidates.reject(&proposal);
                proposal.record(state, false);
                waiting.extend(proposal.otherwise(state).map(|next| vec![next]));
            }
        }
        accepted
    }

    /// The state with the changes of `proposals`, if the picture does not speak against it. Other groups were fitted in
    /// the light of the groups that change here, right or wrong: where these gain and others lose, all are fitted again
    /// before the decision. A more complex hypothesis, or another minimum of the same, has to be supported by its own
    /// group's pixels: nothing else speaks for it.
    fn try_one(
        &mut self,
        state: &mut State<'_>,
        proposals: &[Proposal],
        best: &Verified,
        depth: Depth,
        observer: &mut dyn Observer,
    ) -> Option<Verified> {
        proposals.iter().for_each(|proposal| proposal.apply(state));
        if let [one] = proposals
            && self.spoken_for.contains(&one.group)
            && one.hypothesis == Hypothesis::Diffuse
        {
            refine::refine(state, self.options, depth, observer);
            let now = state.snapshot();
            if self.is_better(state, one.group, [&best.snapshot, &now]) {
                return None;
            }
        }
        let is_borne_out = |proposal: &Proposal| {
            !proposal.is_to_be_borne_out() || self.verifier.bears_out(state, best, proposal)
        };
        if !proposals.iter().all(is_borne_out) {
            return None;
        }
        observer.working("comparing the change with the whole photo", state.schedule.share(0.0));
        let mut found = self.verifier.verify(state);
        let changed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
        let mut comparison = self.verifier.compare(&found.score, &best.score);
        if comparison.is_worse() && comparison.gains(&changed) {
            refine::refine(state, self.options, depth, observer);
            found = self.verifier.verify(state);
            comparison = self.verifier.compare(&found.score, &best.score);
        }
        (!comparison.is_worse()).then_some(found)
    }

    /// Refines all parameters together, roughly at first; under that light the hypotheses are compared again.
    fn refine(
        &mut self,
        state: &mut State<'_>,
        observer: &mut dyn Observer,
    ) -> Result<Termination, RecoverError> {
        self.verifier.begin_refined(self.options);
        self.candidates.forget_rejections();
        let mut best = self.verifier.verify(state);
        state.schedule.begin(Phase::Refinement);
        self.refine_once(state, &mut best, Depth::Coarse, observer);
        if self.options.effort.asks_again() {
            state.schedule.begin(Phase::Revision);
            self.revise(state, &mut best, observer)?;
        }
        state.schedule.begin(Phase::LastRefinement);
        let termination = self.refine_once(state, &mut best, Depth::Fine, observer);
        self.candidates.forget_explained(state);
        Ok(termination)
    }

    /// The groups whose light differs between two scores by more than the error that is always allowed for: a smaller
    /// change decides nothing.
    fn changed(&self, state: &State<'_>, now: &Score, before: &Score, level: Level) -> Vec<usize> {
        let tolerated = sample_budget::allowance(level, self.options).light.share;
        let changed = self.verifier.changed(now, before, tolerated);
        state.visible_unknowns().into_iter().filter(|group| changed.contains(group)).collect()
    }

    /// Compares the hypotheses of all groups again, and then of those whose light has changed, or whose texture was
    /// rejected by the former residuals of the other groups.
    fn revise(
        &mut self,
        state: &mut State<'_>,
        best: &mut Verified,
        observer: &mut dyn Observer,
    ) -> Result<(), RecoverError> {
        let mut groups = state.visible_unknowns();
        for _ in 0..REVISIONS {
            refine::settle_nuisances(state, self.options)?;
            let before = best.score.clone();
            let proposals = self.ask(state, &groups, observer);
            let proposed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
            if proposals.is_empty() || observer.is_cancelled() {
                break;
            }
            if !self.try_all(state, proposals, best, Depth::Coarse, observer) {
                break;
            }
            self.refine_once(state, best, Depth::Coarse, observer);
            groups = self.changed(state, &best.score, &before, Level::Refined);
            groups.retain(|group| !proposed.contains(group));
            groups.extend(self.candidates.take_refused_textures());
            groups.sort_unstable();
            groups.dedup();
        }
        Ok(())
    }

    /// One joint refinement; it is taken back if the picture speaks against it, by two sets of random numbers.
    fn refine_once(
        &mut self,
        state: &mut State<'_>,
        best: &mut Verified,
        depth: Depth,
        observer: &mut dyn Observer,
    ) -> Termination {
        let termination = refine::refine(state, self.options, depth, observer);
        let found = self.verifier.verify(state);
        let is_worse = self.verifier.compare(&found.score, &best.score).is_worse()
            && self.verifier.confirms_worse(state, &found.snapshot, &best.snapshot);
        if is_worse {
            state.restore(&best.snapshot);
        } else {
            *best = found;
        }
        termination
    }

    /// Other hypotheses for `groups` under the refined light.
    fn ask(
        &mut self,
        state: &mut State<'_>,
        groups: &[usize],
        observer: &dyn Observer,
    ) -> Vec<Proposal> {
        let mut proposals = Vec::new();
        for (n, &group) in groups.iter().enumerate() {
            candidates::tell(state, observer, group, n as f64 / groups.len() as f64);
            let proposal = match state.groups[group].hypothesis {
                Hypothesis::Textured => {
                    self.candidates.propose_uniform(state, group, Level::Refined)
                }
                _ => self.candidates.propose(state, group, Level::Refined),
            };
            proposals.extend(proposal);
        }
        proposals
    }
}
