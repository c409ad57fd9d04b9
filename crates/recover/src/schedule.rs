//! The phases of a recovery in their order, the share of its time that each takes, and how far it has come.

use crate::effort::Effort;
use crate::problem::{GroupSpec, Options, Problem, Role};
use std::ops::Range;

/// A phase of a recovery; phases come in this order, and may come again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// All numbers are fitted together, on few paths.
    Fits,
    /// Groups are asked for other hypotheses.
    Choice,
    /// All groups without gloss are fitted with a coat.
    Coats,
    /// Groups are looked at for textures.
    Textures,
    /// All numbers are refined together, roughly.
    Refinement,
    /// Groups are asked again, under the refined light.
    Revision,
    /// All numbers are refined together, with standard deviations.
    LastRefinement,
    /// Other minima are looked for.
    OtherMinima,
    /// The last picture is rendered.
    Picture,
    /// The error of each group is measured.
    Errors,
}

/// What the time of a recovery depends on.
#[derive(Clone, Copy, Debug)]
struct Workload {
    effort: Effort,
    refine: bool,
    /// The groups to recover that the photograph shows.
    groups: f64,
    /// Pixels of the photograph, millions.
    pixels: f64,
    /// Paths of the last picture, millions.
    last_paths: f64,
}

/// Seconds that a recovery of so many unknown `groups` from a photograph of so many `pixels` takes on two cores, within a
/// factor of two or three, but for rooms by artists under a sky, which take up to five times as long: before it has begun
/// nothing better is known.
pub fn expected_seconds(groups: usize, pixels: usize, options: &Options) -> f64 {
    Workload::new(groups, pixels, options).seconds().iter().sum()
}

impl Workload {
    fn new(groups: usize, pixels: usize, options: &Options) -> Self {
        Self {
            effort: options.effort,
            refine: options.refine,
            groups: groups as f64,
            pixels: 1e-6 * pixels as f64,
            last_paths: 1e-6 * pixels as f64 * f64::from(options.spp),
        }
    }

    fn of(problem: &Problem<'_>, options: &Options) -> Self {
        let pixels_of_group = &problem.observation.pixels_of_group;
        let groups = problem.groups.iter().zip(pixels_of_group);
        let is_asked = |(spec, pixels): &(&GroupSpec, &Vec<u32>)| {
            spec.role == Role::Unknown && !pixels.is_empty()
        };
        let pixels = problem.observation.picture.values.pixels().len();
        Self::new(groups.filter(is_asked).count(), pixels, options)
    }

    /// Seconds of each phase on two cores, fitted to five drafts (Figure 8, two rooms of the corpus, the furnished room and
    /// a living room by an artist) and two recoveries of the usual effort. Where rays cost more, as in rooms of artists
    /// under a sky, all phases take several times as long, which the clock of whoever shows the time left sees in the
    /// first of them. Scenes without coats jump over theirs.
    fn seconds(self) -> [f64; 10] {
        let Self { effort, refine, groups, pixels, last_paths } = self;
        let (fits, coats, errors) = (2.0, 0.7 * groups, 0.3 * groups);
        let (choice, textures) = (0.9 * groups, 0.9 * groups);
        let picture = 1.2 + 0.6 * last_paths;
        match (effort, refine) {
            (_, false) => [fits, choice, coats, textures, 0.0, 0.0, 0.0, 0.0, picture, errors],
            (Effort::Draft, true) => {
                let (coarse, last, other) = (0.06 * groups, 1.5 * groups, 0.06 * groups);
                [fits, choice, coats, textures, coarse, 0.0, last, other, picture, errors]
            }
            (Effort::Normal | Effort::High, true) => {
                let (coarse, revision) = (0.3 * groups, 1.8 * groups);
                let last = groups * (1.2 + 8.0 * pixels);
                let (other, picture) = (0.2 * groups, 3.5 + 0.42 * last_paths);
                [fits, choice, coats, textures, coarse, revision, last, other, picture, errors]
            }
        }
    }
}

/// How far a recovery has come.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    /// The shares of the time at which the phases begin, and at which the last one ends.
    limits: [f64; 11],
    phase: Phase,
    reached: f64,
}

impl Schedule {
    /// The schedule of a recovery of `problem`, of which nothing is done.
    pub(crate) fn new(problem: &Problem<'_>, options: &Options) -> Self {
        Self::of(Workload::of(problem, options))
    }

    fn of(workload: Workload) -> Self {
        let seconds = workload.seconds();
        let all: f64 = seconds.iter().sum();
        let until = |end: usize| seconds[..end].iter().sum::<f64>() / all;
        Self { limits: std::array::from_fn(until), phase: Phase::Fits, reached: 0.0 }
    }

    /// The shares of the time at which `phase` begins and ends.
    pub(crate) fn of_phase(&self, phase: Phase) -> Range<f64> {
        self.limits[phase as usize]..self.limits[phase as usize + 1]
    }

    /// `phase` begins.
    pub(crate) fn begin(&mut self, phase: Phase) {
        self.phase = phase;
    }

    /// Whether hypotheses have been chosen, and all numbers are refined.
    pub(crate) fn is_refining(&self) -> bool {
        !matches!(self.phase, Phase::Fits | Phase::Choice | Phase::Coats | Phase::Textures)
    }

    /// The share of the whole that is done, 0 to 1, where `within` (0 to 1) of the present phase is; never less
    /// than before.
    pub(crate) fn share(&mut self, within: f64) -> f64 {
        let Range { start, end } = self.of_phase(self.phase);
        self.reached = self.reached.max(start + within.clamp(0.0, 1.0) * (end - start));
        self.reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PHASES: [Phase; 10] = [
        Phase::Fits,
        Phase::Choice,
        Phase::Coats,
        Phase::Textures,
        Phase::Refinement,
        Phase::Revision,
        Phase::LastRefinement,
        Phase::OtherMinima,
        Phase::Picture,
        Phase::Errors,
    ];

    #[test]
    fn phases_follow_each_other_and_nothing_goes_back() {
        for effort in [Effort::Draft, Effort::Normal, Effort::High] {
            let options = Options { effort, ..Options::default() };
            let workload = Workload::new(8, 50_000, &options);
            let mut schedule = Schedule::of(workload);
            let follow =
                |two: &[Phase]| schedule.of_phase(two[0]).end == schedule.of_phase(two[1]).start;
            assert!(PHASES.windows(2).all(follow));
            assert_eq!((schedule.limits[0], schedule.limits[10]), (0.0, 1.0));
            let mut last = 0.0;
            for phase in [Phase::Fits, Phase::Revision, Phase::Refinement, Phase::LastRefinement] {
                schedule.begin(phase);
                for within in [0.5, 0.2, 2.0] {
                    let reached = schedule.share(within);
                    assert!(reached >= last, "{reached} after {last}");
                    last = reached;
                }
            }
            assert_eq!(last, schedule.of_phase(Phase::LastRefinement).end);
        }
    }

    #[test]
    fn without_a_refinement_the_picture_comes_after_the_choice() {
        let options = Options { effort: Effort::Draft, refine: false, ..Options::default() };
        let schedule = Schedule::of(Workload::new(8, 50_000, &options));
        assert_eq!(schedule.of_phase(Phase::Textures).end, schedule.of_phase(Phase::Picture).start);
    }
}
