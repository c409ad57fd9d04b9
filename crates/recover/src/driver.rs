//! The driver: owns iteration, verification and cancellation.
//!
//! All parameters of the present hypotheses are fitted together; other hypotheses are proposed for the groups that are
//! explained worst; a proposal is accepted if the re-rendering of the whole picture ([`crate::verify`]) does not speak
//! against it. Then all parameters are refined together, which is taken back if it ends worse, and the hypotheses are
//! compared again under the refined light; textures are extracted once more. Every change passes the same comparison, so
//! that the result is the best guess that was verified, and is noted with the numbers that decided.

use crate::compare::{CERTAIN, Measured};
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::ladder::branches::{self, Kind};
use crate::ladder::candidates::Candidates;
use crate::ladder::lacking;
use crate::ladder::proposal::Proposal;
use crate::ladder::textures;
use crate::problem::{Options, RecoverError};
use crate::progress::Progress;
use crate::record::{Rule, Termination};
use crate::refine::{self, Depth, brightness, score_test};
use crate::sample_budget::{self, Level};
use crate::schedule::Phase;
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

/// Recovers everything, the default way.
pub(crate) fn drive<'a>(
    guess: Guess<'a>,
    options: &Options,
    progress: &mut Progress<'_>,
) -> Result<(Guess<'a>, Termination), RecoverError> {
    let mut driver = Driver {
        options,
        verifier: Verifier::new(&guess, options),
        candidates: Candidates::new(&guess, options),
        spoken_for: Vec::new(),
        progress,
    };
    let (mut present, mut termination) = (driver.select_models(guess)?, Termination::Settled);
    let refines = |driver: &Driver<'_, '_>| options.refine && !driver.progress.is_cancelled();
    if refines(&driver) {
        (present, termination) = driver.refine(present)?;
    }
    let mut result = driver.extract_textures(present).guess;
    if refines(&driver) {
        driver.progress.begin(Phase::OtherMinima);
        let what = "looking for other materials that explain the photo as well";
        driver.progress.working(what, 0.0);
        refine::local_minima::find(&mut result, options);
    }
    let is_cancelled = driver.progress.is_cancelled();
    Ok((result, if is_cancelled { Termination::Interrupted } else { termination }))
}

struct Driver<'p, 'o> {
    options: &'p Options,
    verifier: Verifier,
    candidates: Candidates<'p>,
    /// Groups whose specular part is supported by the other groups' pixels, not by their own.
    spoken_for: Vec<usize>,
    progress: &'p mut Progress<'o>,
}

impl Driver<'_, '_> {
    /// All numbers are fitted together, on few paths; other hypotheses are proposed, accepted or taken back.
    fn select_models<'a>(&mut self, guess: Guess<'a>) -> Result<Verified<'a>, RecoverError> {
        let level = Level::Choice;
        self.progress.begin(Phase::Fits);
        let first = self.verifier.verify(refine::settle_nuisances(guess, self.options)?);
        let start = first.guess.clone();
        let (mut present, _) = self.refine_once(first, Depth::Rough);
        let is_off =
            |present: &Verified<'_>| brightness::find(&present.guess, self.options, &start);
        let is_suspect = !self.options.force && is_off(&present).is_some();
        present = self.enforce(present, level);
        self.progress.begin(Phase::Choice);
        present = self.choose(present)?;
        // While all are diffuse, a specular part may look like other light. An interrupted choice keeps its results.
        if is_suspect
            && !self.progress.is_cancelled()
            && let Some(off) = brightness::find(&present.guess, self.options, &start)
        {
            return Err(off.into());
        }
        if self.options.effort.asks_again() {
            present = self.branch(present)?;
            present = self.add_lacking(present)?;
        }
        self.progress.begin(Phase::Textures);
        present = self.find_textures(present, level, Depth::Rough)?;
        let open = self.candidates.open(&present.guess, level);
        self.progress.note_open(&present.guess, &open);
        Ok(present)
    }

    /// Gives groups whose hypothesis is not allowed the best one that is, whatever the picture says.
    fn enforce<'a>(&mut self, present: Verified<'a>, level: Level) -> Verified<'a> {
        let mut guess = present.guess;
        for proposal in self.candidates.allowed(&mut guess, level, self.progress) {
            let both = [guess.groups[proposal.group].hypothesis, proposal.hypothesis];
            let measured = Measured { holds: true, ..Measured::default() };
            self.progress.decide(proposal.group, both, measured, Rule::Project);
            proposal.apply(&mut guess);
        }
        self.verifier.verify(guess)
    }

    /// Compares the hypotheses of the groups that are explained worst, until none changes in its present light.
    fn choose<'a>(&mut self, mut present: Verified<'a>) -> Result<Verified<'a>, RecoverError> {
        let level = Level::Choice;
        while !self.progress.is_cancelled() {
            present.guess = refine::settle_nuisances(present.guess, self.options)?;
            let guess = &mut present.guess;
            let proposals = self.candidates.propose_worst(guess, level, self.progress);
            if proposals.is_empty() {
                break;
            }
            let before = present.score.clone();
            let proposed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
            let accepted;
            (present, accepted) = self.try_all(present, proposals, Depth::Rough);
            if accepted {
                (present, _) = self.refine_once(present, Depth::Rough);
                let mut changed = self.changed(&present, &before, level);
                changed.retain(|group| !proposed.contains(group));
                self.candidates.ask_again(&changed);
            }
        }
        Ok(present)
    }

    /// Gives the groups a texture whose pixels predict each other by one; while hypotheses are chosen, those whose light has
    /// changed by that are compared again, and those that are not explained: what was left of the textured groups was
    /// allowed for in theirs.
    fn find_textures<'a>(
        &mut self,
        mut present: Verified<'a>,
        level: Level,
        depth: Depth,
    ) -> Result<Verified<'a>, RecoverError> {
        let proposals = self.candidates.textures(&mut present.guess, level, self.progress);
        if proposals.is_empty() || self.progress.is_cancelled() {
            return Ok(present);
        }
        let before = present.score.clone();
        let (present, accepted) = self.try_all(present, proposals, depth);
        if !accepted {
            return Ok(present);
        }
        let (present, _) = self.refine_once(present, depth);
        if level == Level::Refined {
            return Ok(present);
        }
        self.candidates.ask_again(&self.changed(&present, &before, level));
        self.candidates.ask_again(&self.candidates.open(&present.guess, level));
        self.choose(present)
    }

    /// Groups that light each other may keep each other wrong: one that stays unexplained gets another kind of
    /// hypothesis, those of the groups that it lights are compared again, and the better of both results is kept.
    fn branch<'a>(&mut self, mut present: Verified<'a>) -> Result<Verified<'a>, RecoverError> {
        let (level, mut tried) = (Level::Choice, Vec::new());
        let allowed = sample_budget::allowance(level, self.options).floor;
        while tried.len() < BRANCHES && !self.progress.is_cancelled() {
            let Some(other) = branches::next(&present.guess, allowed, &tried) else { break };
            tried.extend(Kind::of(other.hypothesis).map(|kind| (other.group, kind)));
            let before = (self.candidates.clone(), self.progress.decisions.len());
            let changed = other.applied(&present.guess);
            let (guess, _) = refine::refine(changed, self.options, Depth::Rough, self.progress);
            let found = self.verifier.verify(guess);
            self.candidates.hold(Some(other.group));
            self.candidates.ask_again(&self.changed(&found, &present.score, level));
            let found = self.choose(found)?;
            // The present one has to be worse, and not the other one as good.
            let now = self.verifier.compare(&present.score, &found.score).measured();
            let measured = Measured { holds: !now.holds, difference: -now.difference, ..now };
            if measured.holds {
                self.note(&present.guess, &other, measured, Rule::Branch);
                self.candidates.hold(None);
                present = self.choose(found)?;
            } else {
                self.progress.take_back(before.1);
                self.note(&present.guess, &other, measured, Rule::Branch);
                self.candidates = before.0;
            }
        }
        Ok(present)
    }

    /// Where the picture stays unexplained, the diffuse group that would explain most of it by a specular part gets
    /// one, and keeps it if that explains the other groups better and the whole picture not worse; then the hypotheses
    /// of the groups whose light changed are compared again.
    fn add_lacking<'a>(&mut self, mut present: Verified<'a>) -> Result<Verified<'a>, RecoverError> {
        let (level, mut tried) = (Level::Choice, Vec::new());
        let allowed = sample_budget::allowance(level, self.options).floor;
        while !self.progress.is_cancelled() {
            let others = lacking::all(&present.guess, self.options, allowed, &tried);
            let found = others.into_iter().take(LACKING).find_map(|other| {
                tried.push(other.group);
                let changed = other.applied(&present.guess);
                let (guess, _) = refine::refine(changed, self.options, Depth::Rough, self.progress);
                let others = self.others_gain(other.group, [&guess, &present.guess]);
                self.note(&present.guess, &other, others, Rule::OtherGroups);
                let found = others.holds.then(|| self.verifier.verify(guess))?;
                let picture = self.verifier.compare(&found.score, &present.score).measured();
                self.note(&present.guess, &other, picture, Rule::Picture);
                picture.holds.then_some((other.group, found))
            });
            let Some((group, found)) = found else { break };
            self.spoken_for.push(group);
            self.candidates.ask_again(&self.changed(&found, &present.score, level));
            present = self.choose(found)?;
        }
        Ok(present)
    }

    /// By how much the other groups are explained better by the first guess than by the second, where `group` is diffuse.
    fn others_gain(&self, group: usize, both: [&Guess<'_>; 2]) -> Measured {
        let gain = score_test::gain_of_others(self.options, group, both);
        Measured { holds: -gain.difference - gain.price > CERTAIN * gain.deviation, ..gain }
    }

    fn note(&mut self, present: &Guess<'_>, other: &Proposal, measured: Measured, rule: Rule) {
        let both = [present.groups[other.group].hypothesis, other.hypothesis];
        self.progress.decide(other.group, both, measured, rule);
    }

    /// Makes the changes of `proposals` together; if the picture speaks against them, tries each half of them alone.
    /// Returns the guess with what was accepted, and whether anything was.
    fn try_all<'a>(
        &mut self,
        mut present: Verified<'a>,
        proposals: Vec<Proposal>,
        depth: Depth,
    ) -> (Verified<'a>, bool) {
        let mut accepted = false;
        let (alone, together): (Vec<Proposal>, Vec<Proposal>) =
            proposals.into_iter().partition(|one| self.spoken_for.contains(&one.group));
        let mut waiting: Vec<Vec<Proposal>> = alone.into_iter().map(|one| vec![one]).collect();
        waiting.extend((!together.is_empty()).then_some(together));
        while let Some(mut proposals) = waiting.pop() {
            let found = self.try_one(&present, &proposals, depth);
            if let Some(found) = found {
                (present, accepted) = (found, true);
                proposals.iter().for_each(|one| one.record(&mut present.guess, true));
            } else if proposals.len() > 1 {
                let other = proposals.split_off(proposals.len() / 2);
                waiting.extend([other, proposals]);
            } else if let Some(proposal) = proposals.pop() {
                self.candidates.reject(&proposal);
                proposal.record(&mut present.guess, false);
                waiting.extend(proposal.otherwise(&present.guess).map(|next| vec![next]));
            }
        }
        (present, accepted)
    }

    /// The guess with the changes of `proposals`, if the picture does not speak against it. Other groups were fitted in
    /// the light of the groups that change here, right or wrong: where these gain and others lose, all are fitted again
    /// before the decision. A more complex hypothesis, or another minimum of the same, has to be supported by its own
    /// group's pixels: nothing else speaks for it.
    fn try_one<'a>(
        &mut self,
        present: &Verified<'a>,
        proposals: &[Proposal],
        depth: Depth,
    ) -> Option<Verified<'a>> {
        let mut guess = present.guess.clone();
        proposals.iter().for_each(|proposal| proposal.apply(&mut guess));
        if let [one] = proposals
            && self.spoken_for.contains(&one.group)
            && one.hypothesis == Hypothesis::Diffuse
        {
            (guess, _) = refine::refine(guess, self.options, depth, self.progress);
            let lost = self.others_gain(one.group, [&present.guess, &guess]);
            if lost.holds {
                let measured = Measured { holds: false, difference: -lost.difference, ..lost };
                self.note(&present.guess, one, measured, Rule::OtherGroups);
                return None;
            }
        }
        for proposal in proposals.iter().filter(|proposal| proposal.is_to_be_borne_out()) {
            let own = self.verifier.bears_out(&guess, present, proposal.claim());
            self.note(&present.guess, proposal, own, Rule::OwnPixels);
            if !own.holds {
                return None;
            }
        }
        self.progress.working("comparing the change with the whole photo", 0.0);
        let mut found = self.verifier.verify(guess);
        let changed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
        let mut comparison = self.verifier.compare(&found.score, &present.score);
        if comparison.is_worse() && comparison.gains(&changed) {
            let (guess, _) = refine::refine(found.guess, self.options, depth, self.progress);
            found = self.verifier.verify(guess);
            comparison = self.verifier.compare(&found.score, &present.score);
        }
        let picture = comparison.measured();
        proposals.iter().for_each(|one| self.note(&present.guess, one, picture, Rule::Picture));
        picture.holds.then_some(found)
    }

    /// Refines all parameters together, roughly at first; under that light the hypotheses are compared again.
    fn refine<'a>(
        &mut self,
        present: Verified<'a>,
    ) -> Result<(Verified<'a>, Termination), RecoverError> {
        self.verifier.begin_refined(self.options);
        self.candidates.forget_rejections();
        let present = self.verifier.verify(present.guess);
        self.progress.begin(Phase::Refinement);
        let (mut present, _) = self.refine_once(present, Depth::Coarse);
        if self.options.effort.asks_again() {
            self.progress.begin(Phase::Revision);
            present = self.revise(present)?;
            present = self.find_textures(present, Level::Refined, Depth::Coarse)?;
        }
        self.progress.begin(Phase::LastRefinement);
        let (mut present, termination) = self.refine_once(present, Depth::Fine);
        self.candidates.forget_explained(&mut present.guess);
        Ok((present, termination))
    }

    /// The groups whose light differs between a guess and the score `before` by more than the error that is always
    /// allowed for: a smaller change decides nothing.
    fn changed(&self, now: &Verified<'_>, before: &Score, level: Level) -> Vec<usize> {
        let tolerated = sample_budget::allowance(level, self.options).light.share;
        let changed = self.verifier.changed(&now.score, before, tolerated);
        now.guess.visible_unknowns().into_iter().filter(|group| changed.contains(group)).collect()
    }

    /// Compares the hypotheses of all groups again, and then of those whose light has changed.
    fn revise<'a>(&mut self, mut present: Verified<'a>) -> Result<Verified<'a>, RecoverError> {
        let is_uniform = |guess: &Guess<'_>, group: &usize| {
            guess.groups[*group].hypothesis != Hypothesis::Textured
        };
        let mut groups = present.guess.visible_unknowns();
        for _ in 0..REVISIONS {
            groups.retain(|group| is_uniform(&present.guess, group));
            present.guess = refine::settle_nuisances(present.guess, self.options)?;
            let before = present.score.clone();
            let proposals = self.ask(&mut present.guess, &groups);
            let proposed: Vec<usize> = proposals.iter().map(|proposal| proposal.group).collect();
            if proposals.is_empty() || self.progress.is_cancelled() {
                break;
            }
            let accepted;
            (present, accepted) = self.try_all(present, proposals, Depth::Coarse);
            if !accepted {
                break;
            }
            (present, _) = self.refine_once(present, Depth::Coarse);
            groups = self.changed(&present, &before, Level::Refined);
            groups.retain(|group| !proposed.contains(group));
        }
        Ok(present)
    }

    /// One joint refinement; it is taken back if the picture speaks against it, by two sets of random numbers.
    fn refine_once<'a>(
        &mut self,
        present: Verified<'a>,
        depth: Depth,
    ) -> (Verified<'a>, Termination) {
        let decisions = self.progress.decisions.len();
        let guess = present.guess.clone();
        let (guess, termination) = refine::refine(guess, self.options, depth, self.progress);
        let (present, is_taken_back) = self.better(present, guess);
        if is_taken_back {
            self.progress.take_back(decisions);
        }
        self.progress.show(&present.guess, self.options);
        (present, termination)
    }

    /// `guess`, or the `present` one where the picture speaks against `guess` by two sets of random numbers; and whether
    /// it does.
    fn better<'a>(&self, present: Verified<'a>, guess: Guess<'a>) -> (Verified<'a>, bool) {
        let found = self.verifier.verify(guess);
        let is_worse = self.verifier.compare(&found.score, &present.score).is_worse()
            && self.verifier.confirms_worse(&found.guess, &present.guess);
        (if is_worse { present } else { found }, is_worse)
    }

    /// The textures once more, with more light samples, under the final light.
    fn extract_textures<'a>(&self, present: Verified<'a>) -> Verified<'a> {
        let mut groups = present.guess.groups.iter();
        if groups.all(|of_group| of_group.hypothesis != Hypothesis::Textured) {
            return present;
        }
        let guess = textures::last(&present.guess, self.options);
        self.better(present, guess).0
    }

    /// Other hypotheses for `groups` under the refined light.
    fn ask(&mut self, guess: &mut Guess<'_>, groups: &[usize]) -> Vec<Proposal> {
        let mut proposals = Vec::new();
        for (n, &group) in groups.iter().enumerate() {
            let done = n as f64 / groups.len() as f64;
            let (level, progress) = (Level::Refined, &mut *self.progress);
            proposals.extend(self.candidates.propose(guess, group, level, done, progress));
        }
        proposals
    }
}
