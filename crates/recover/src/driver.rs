//! The driver: owns iteration and cancellation.
//!
//! All parameters of the present hypotheses are fitted together. The groups are asked for other hypotheses, those that are
//! explained worst first, each in the light of all the others as they are now, and take what their comparison chooses; all
//! parameters are fitted again, and the groups whose light has changed are asked again, until none changes. Groups without
//! gloss get a coat if all surfaces of the scene's format have one and that leaves less of the whole photograph.
//! Then all parameters are refined together, and the hypotheses are compared once more under the refined light; textures
//! are extracted at the end. A texture with which the group's re-rendered pixels are explained worse ([`crate::verify`]) is
//! not taken.
//!
//! A change is judged by its own group's pixels, and the whole picture has no say in it: where groups light each other,
//! the first of several right changes leaves the picture worse until the others have followed.

use crate::compare::{CERTAIN, Measured};
use crate::effort::Effort;
use crate::guess::{GroupGuess, Guess};
use crate::hypothesis::Hypothesis;
use crate::ladder::candidates::Candidates;
use crate::ladder::proposal::Proposal;
use crate::ladder::textures;
use crate::problem::{Options, RecoverError};
use crate::progress::Progress;
use crate::record::{Rule, Termination};
use crate::refine::{self, Depth, brightness};
use crate::sample_budget::{self, Level};
use crate::schedule::Phase;
use crate::verify::{Score, Verified, Verifier};
use std::collections::BTreeSet;
use unrender_scene::Material;

/// How hypotheses are compared and numbers are fitted: while hypotheses are chosen, and under the refined light.
const ROUGHLY: (Level, Depth) = (Level::Choice, Depth::Rough);
const REFINED: (Level, Depth) = (Level::Refined, Depth::Coarse);
/// Samples of the highest effort, at most, by which it is judged whether the scene's surfaces have coats. With one of them six
/// matt rooms are told with certainty 17 times of 24; each takes a room of 17 groups 6 % more time.
const COAT_ROUNDS: u64 = 4;

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
        progress,
    };
    let (mut present, mut termination) = (driver.select_models(guess)?, Termination::Settled);
    let refines = |driver: &Driver<'_, '_>| options.refine && !driver.progress.is_cancelled();
    if refines(&driver) {
        (present, termination) = driver.refine(present)?;
    }
    let mut result = driver.extract_textures(present);
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
    progress: &'p mut Progress<'o>,
}

impl Driver<'_, '_> {
    /// All numbers are fitted together, on few paths, and hypotheses are chosen.
    fn select_models<'a>(&mut self, guess: Guess<'a>) -> Result<Verified<'a>, RecoverError> {
        self.progress.begin(Phase::Fits);
        let start = refine::settle_nuisances(guess, self.options)?;
        let (mut present, _) = self.refine_once(start.clone(), Depth::Rough);
        let is_off =
            |present: &Verified<'_>| brightness::find(&present.guess, self.options, &start);
        let is_suspect = !self.options.force && is_off(&present).is_some();
        present = self.enforce(present);
        self.progress.begin(Phase::Choice);
        present = self.choose(present, ROUGHLY)?;
        // While all are diffuse, a specular part may look like other light. An interrupted choice keeps its results.
        if is_suspect
            && !self.progress.is_cancelled()
            && let Some(off) = brightness::find(&present.guess, self.options, &start)
        {
            return Err(off.into());
        }
        present = self.add_coats(present)?;
        self.progress.begin(Phase::Textures);
        present = self.find_textures(present, ROUGHLY)?;
        let open = self.candidates.open(&present.guess, Level::Choice);
        self.progress.note_open(&present.guess, &open);
        Ok(present)
    }

    /// Gives groups whose hypothesis is not allowed the best one that is.
    fn enforce<'a>(&mut self, present: Verified<'a>) -> Verified<'a> {
        let mut guess = present.guess;
        for proposal in self.candidates.allowed(&mut guess, Level::Choice, self.progress) {
            let both = [guess.groups[proposal.group].hypothesis, proposal.hypothesis];
            let measured = Measured { holds: true, ..Measured::default() };
            self.progress.decide(proposal.group, both, measured, Rule::Project);
            proposal.apply(&mut guess);
        }
        self.verifier.verify(guess)
    }

    /// Compares the hypotheses of all groups, those that are explained worst first, until none changes in its present light.
    /// What was before and comes again is no reason to ask again: between these noise decides.
    fn choose<'a>(
        &mut self,
        mut present: Verified<'a>,
        by: (Level, Depth),
    ) -> Result<Verified<'a>, RecoverError> {
        let mut been = BTreeSet::new();
        while !self.progress.is_cancelled() {
            present.guess = refine::settle_nuisances(present.guess, self.options)?;
            if been.insert(place(&present.guess)) {
                let asked_in = |group| self.candidates.asked_in(group);
                self.candidates.ask_again(&self.changed(&present, asked_in, by.0));
            }
            let proposals = self.candidates.propose_worst(&mut present, by.0, self.progress);
            if proposals.is_empty() {
                break;
            }
            present = self.take(present, proposals, by.1);
        }
        Ok(present)
    }

    /// Makes the changes of `proposals` and fits all numbers again.
    fn take<'a>(
        &mut self,
        present: Verified<'a>,
        mut proposals: Vec<Proposal>,
        depth: Depth,
    ) -> Verified<'a> {
        self.progress.working("looking at the whole photo with the change", 0.0);
        let refused = self.refused_textures(&present, &proposals);
        proposals.retain(|of| !refused.contains(&of.group));
        if proposals.is_empty() {
            return present;
        }
        self.refine_once(with(&present.guess, &proposals), depth).0
    }

    /// The groups of textures among `proposals` with which their re-rendered pixels are explained worse than before: texels
    /// are judged and found by the light in the middle of each pixel, which the edge of a shadow passes beside.
    fn refused_textures(&mut self, present: &Verified<'_>, proposals: &[Proposal]) -> Vec<usize> {
        let textures = proposals.iter().filter(|of| of.hypothesis == Hypothesis::Textured);
        let mut textures: Vec<usize> = textures.map(|of| of.group).collect();
        if !textures.is_empty() {
            let made = self.verifier.verify(with(&present.guess, proposals));
            let worse = self.verifier.worse(&made.score, &present.score);
            textures.retain(|group| worse.contains(group));
        }
        textures.iter().for_each(|group| self.progress.refuse(*group));
        textures
    }

    /// Gives the groups a texture whose pixels predict each other by one; those whose light has changed by that are
    /// compared again, and those that are not explained: what was left of the textured groups was allowed for in theirs.
    /// Textures whose light these change are looked at again, and go where they predict no more.
    fn find_textures<'a>(
        &mut self,
        mut present: Verified<'a>,
        by: (Level, Depth),
    ) -> Result<Verified<'a>, RecoverError> {
        let groups = present.guess.visible_unknowns();
        let mut proposals =
            self.candidates.textures(&mut present.guess, &groups, by.0, self.progress);
        while !proposals.is_empty() && !self.progress.is_cancelled() {
            let found = self.take(present, proposals, by.1);
            let before = found.score.clone();
            self.candidates.ask_again(&self.candidates.open(&found.guess, by.0));
            present = self.choose(found, by)?;
            let mut again = self.changed(&present, |_| Some(&*before), by.0);
            again.retain(|group| is_textured(&present.guess, *group));
            proposals = self.candidates.textures(&mut present.guess, &again, by.0, self.progress);
            proposals.retain(|other| other.hypothesis != Hypothesis::Textured);
        }
        Ok(present)
    }

    /// Where all surfaces of the scene's format have a coat, groups that show no gloss are dull plastics if that leaves less of
    /// the whole photograph. One group's pixels hardly tell: slow errors of its light look the same.
    fn add_coats<'a>(&mut self, present: Verified<'a>) -> Result<Verified<'a>, RecoverError> {
        let coated = present.guess.clone().coated();
        if coated.materials == present.guess.materials || self.progress.is_cancelled() {
            return Ok(present);
        }
        self.progress.begin(Phase::Coats);
        let coated = refine::settle_nuisances(coated, self.options)?;
        let (coated, _) = self.refine_once(coated, Depth::Rough);
        if self.is_matt(&coated, &present) {
            return Ok(present);
        }
        self.choose(coated, ROUGHLY)
    }

    /// Whether coats leave more of the whole photograph, on as many pixels and paths as it takes to tell.
    fn is_matt(&self, coated: &Verified<'_>, matt: &Verified<'_>) -> bool {
        let (mut more, mut variance) = (0.0, 0.0);
        for round in 0..COAT_ROUNDS {
            let seed = self.options.seed.wrapping_add(round);
            let options = Options { effort: Effort::High, seed, ..self.options.clone() };
            let judge = Verifier::new(&matt.guess, &options);
            let [with, without] = [coated, matt].map(|of| judge.verify(of.guess.clone()).score);
            let [of_round, noise] = judge.difference(&with, &without);
            (more, variance) = (more + of_round, variance + noise);
            if f64::abs(more) > CERTAIN * f64::sqrt(variance) {
                break;
            }
        }
        more > 0.0
    }

    /// Refines all parameters together, roughly at first; under that light the hypotheses are compared again.
    fn refine<'a>(
        &mut self,
        present: Verified<'a>,
    ) -> Result<(Verified<'a>, Termination), RecoverError> {
        self.verifier.begin_refined(self.options);
        self.progress.begin(Phase::Refinement);
        let (mut present, _) = self.refine_once(present.guess, Depth::Coarse);
        if self.options.effort.asks_again() {
            self.progress.begin(Phase::Revision);
            present = self.choose(present, REFINED)?;
            present = self.find_textures(present, REFINED)?;
        }
        self.progress.begin(Phase::LastRefinement);
        Ok(self.refine_once(present.guess, Depth::Fine))
    }

    /// The groups whose light differs between a guess and a score of `before` by more than the error that is always
    /// allowed for: a smaller change decides nothing.
    fn changed<'s>(
        &self,
        now: &Verified<'_>,
        before: impl Fn(usize) -> Option<&'s Score>,
        level: Level,
    ) -> Vec<usize> {
        let tolerated = sample_budget::allowance(level, self.options).light.share;
        let is_changed = |group: &usize| {
            let scores = before(*group).map(|before| [&*now.score, before]);
            scores.is_some_and(|scores| self.verifier.is_changed(*group, scores, tolerated))
        };
        now.guess.visible_unknowns().into_iter().filter(is_changed).collect()
    }

    /// One joint refinement.
    fn refine_once<'a>(&mut self, guess: Guess<'a>, depth: Depth) -> (Verified<'a>, Termination) {
        let (guess, termination) = refine::refine(guess, self.options, depth, self.progress);
        let present = self.verifier.verify(guess);
        self.progress.show(&present.guess, self.options);
        (present, termination)
    }

    /// The textures once more, with more light samples, under the final light, but for those with which their groups'
    /// re-rendered pixels are explained worse than before.
    fn extract_textures<'a>(&self, present: Verified<'a>) -> Guess<'a> {
        if !(0..present.guess.groups.len()).any(|group| is_textured(&present.guess, group)) {
            return present.guess;
        }
        let found = self.verifier.verify(textures::last(&present.guess, self.options));
        let worse = self.verifier.worse(&found.score, &present.score);
        let mut guess = found.guess;
        for group in worse {
            guess.materials[group].clone_from(&present.guess.materials[group]);
            guess.groups[group].clone_from(&present.guess.groups[group]);
        }
        guess
    }
}

/// `guess` with the changes of `proposals`.
fn with<'a>(guess: &Guess<'a>, proposals: &[Proposal]) -> Guess<'a> {
    let mut guess = guess.clone();
    proposals.iter().for_each(|proposal| proposal.apply(&mut guess));
    guess
}

/// Where all groups stand: their hypotheses, and about how rough they are.
fn place(guess: &Guess<'_>) -> Vec<(Hypothesis, i32)> {
    /// Roughnesses are told apart in steps of about this factor. Half and double of its difference from one were not tried.
    const STEP: f32 = 1.3;
    let step = |alpha: f32| if alpha > 0.0 { (alpha.ln() / STEP.ln()).round() as i32 } else { 0 };
    let of = |(of_group, material): (&GroupGuess, &Material)| {
        (of_group.hypothesis, step((material.alpha_x * material.alpha_y).sqrt()))
    };
    guess.groups.iter().zip(&guess.materials).map(of).collect()
}

fn is_textured(guess: &Guess<'_>, group: usize) -> bool {
    guess.groups[group].hypothesis == Hypothesis::Textured
}
