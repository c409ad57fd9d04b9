//! How far a recovery has come, and what happened on the way: for whoever watches, and for the record.

use crate::compare::Measured;
use crate::guess::{GroupGuess, Guess};
use crate::hypothesis::Hypothesis;
use crate::problem::{Options, Problem, Role};
use crate::record::{Decision, GroupIteration, IterationRecord, Observer, Rule};
use crate::schedule::{Phase, Schedule};
use crate::streams::Stream;
use unrender_render::{Integrator, Settings};
use unrender_scene::{Material, RgbImage};

/// The course of a recovery.
pub(crate) struct Progress<'o> {
    observer: &'o mut dyn Observer,
    schedule: Schedule,
    pub(crate) iterations: Vec<IterationRecord>,
    /// Those over each group, by its number.
    pub(crate) decisions: Vec<(usize, Decision)>,
}

impl<'o> Progress<'o> {
    /// Of a recovery of `problem` that begins.
    pub(crate) fn new(
        problem: &Problem<'_>,
        options: &Options,
        observer: &'o mut dyn Observer,
    ) -> Self {
        Self {
            observer,
            schedule: Schedule::new(problem, options),
            iterations: Vec::new(),
            decisions: Vec::new(),
        }
    }

    /// `phase` begins.
    pub(crate) fn begin(&mut self, phase: Phase) {
        self.schedule.begin(phase);
    }

    /// The shares of the time at which `phase` begins and ends.
    pub(crate) fn of_phase(&self, phase: Phase) -> std::ops::Range<f64> {
        self.schedule.of_phase(phase)
    }

    /// Whether hypotheses have been chosen, and all numbers are refined.
    pub(crate) fn is_refining(&self) -> bool {
        self.schedule.is_refining()
    }

    /// Says what is being done, where the share `within` of the present phase is done.
    pub(crate) fn working(&mut self, what: &str, within: f64) {
        let done = self.schedule.share(within);
        self.observer.working(what, done);
    }

    /// Who watches.
    pub(crate) fn observer(&self) -> &dyn Observer {
        self.observer
    }

    /// Shows a picture of `guess`, if one is wanted.
    pub(crate) fn show(&mut self, guess: &Guess<'_>, options: &Options) {
        /// Paths a pixel, and pixels nearby share theirs: half of them is as noisy as a photograph at night, double takes
        /// twice as long.
        const SPP: u32 = 4;
        if !self.observer.wants_picture() {
            return;
        }
        let settings = Settings {
            spp: SPP,
            seed: Stream::RoughPicture.seed(options.seed),
            max_bounces: options.max_bounces,
            integrator: Integrator::PathReuse,
            ..Settings::default()
        };
        let renderer = guess.problem.renderer;
        let radiance = renderer.picture(guess.appearance(), &settings, &|_| {});
        let values = radiance.into_iter().map(|radiance| radiance / guess.exposure).collect();
        let (width, height) = (renderer.geometry().width(), renderer.geometry().height());
        self.observer.picture(RgbImage::new(width, height, values));
    }

    /// Whether to stop with the present results.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }

    /// Notes the end of a pass over all groups, with the error that it started from: of all groups together, and of each,
    /// and the share `within` of the present phase that is done.
    pub(crate) fn end_pass(
        &mut self,
        guess: &Guess<'_>,
        change: f64,
        (error, errors): (f64, &[Option<f64>]),
        within: f64,
    ) {
        let groups = group_iterations(guess, |group| errors[group]);
        let done = self.schedule.share(within);
        self.note(IterationRecord {
            refining: self.is_refining(),
            iteration: self.iterations.len() + 1,
            change,
            worst_error: error,
            open_groups: Vec::new(),
            groups,
            done,
        });
    }

    /// Notes the end of an iteration in which the largest change was `change`; `open` groups are not explained yet, and
    /// the share `within` of the present phase is done.
    pub(crate) fn end_iteration(
        &mut self,
        guess: &Guess<'_>,
        change: f64,
        open: &[usize],
        within: f64,
    ) {
        let is_asked = |group: usize| guess.problem.groups[group].role == Role::Unknown;
        let error = |group: usize| {
            guess.groups[group].residual.filter(|_| is_asked(group)).map(|r| r.relative())
        };
        let done = self.schedule.share(within);
        self.note(IterationRecord {
            refining: false,
            iteration: self.iterations.len() + 1,
            change,
            worst_error: (0..guess.groups.len()).filter_map(error).fold(0.0, f64::max),
            open_groups: names(guess, open),
            groups: group_iterations(guess, error),
            done,
        });
    }

    fn note(&mut self, record: IterationRecord) {
        self.observer.iteration(&record);
        self.iterations.push(record);
    }

    /// Notes a change of `group` from one hypothesis to another, by what it was `measured`, and whether it was made.
    pub(crate) fn decide(
        &mut self,
        group: usize,
        [from, to]: [Hypothesis; 2],
        measured: Measured,
        rule: Rule,
    ) {
        let Measured { holds: accepted, difference, deviation, price } = measured;
        let iteration = self.iterations.len();
        let decision =
            Decision { iteration, from, to, difference, deviation, price, accepted, rule };
        self.decisions.push((group, decision));
    }

    /// Notes that the last change of `group` was not made: its pixels, re-rendered, speak against it.
    pub(crate) fn refuse(&mut self, group: usize) {
        let of_group = self.decisions.iter_mut().rev().find(|(of, _)| *of == group);
        if let Some((_, decision)) = of_group.filter(|(_, decision)| decision.accepted) {
            (decision.accepted, decision.rule) = (false, Rule::TakenBack);
        }
    }

    /// Notes in the last iteration so far that the groups `open` are not explained.
    pub(crate) fn note_open(&mut self, guess: &Guess<'_>, open: &[usize]) {
        if let Some(last) = self.iterations.last_mut() {
            last.open_groups = names(guess, open);
        }
    }
}

/// Where each group stands now, with its error.
fn group_iterations(
    guess: &Guess<'_>,
    error: impl Fn(usize) -> Option<f64>,
) -> Vec<GroupIteration> {
    let iteration = |(group, of_group): (usize, &GroupGuess)| GroupIteration {
        hypothesis: of_group.hypothesis,
        material: Material { texture: None, ..guess.materials[group].clone() },
        error: error(group),
    };
    guess.groups.iter().enumerate().map(iteration).collect()
}

fn names(guess: &Guess<'_>, groups: &[usize]) -> Vec<String> {
    groups.iter().map(|group| guess.problem.groups[*group].name.clone()).collect()
}
