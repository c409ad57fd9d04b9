//! The phases of a recovery in their order, the share of its time that each takes, and how far it has come.

use crate::effort::Effort;
use crate::problem::Options;
use std::ops::Range;

/// A phase of a recovery; phases come in this order, and may come again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// All numbers are fitted together, on few paths.
    Fits,
    /// Groups are asked for other hypotheses.
    Choice,
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
}

impl Phase {
    /// The shares of the time at which it begins and ends: about those of two rooms of 9 and 13 groups at 240 x 180
    /// with the usual effort, and of one as a draft, which asks no group again. A room of metal spends twice as much of
    /// its time on the last refinement; before it, only half of the remaining time is reported. Without `refine` the
    /// phases between the choice and the picture do not come.
    fn shares(self, effort: Effort, refine: bool) -> Range<f64> {
        let durations = match effort {
            Effort::Draft => [0.08, 0.34, 0.03, 0.0, 0.38, 0.04, 0.13],
            Effort::Normal | Effort::High => [0.03, 0.11, 0.04, 0.30, 0.39, 0.05, 0.08],
        };
        let comes = |phase: usize| {
            refine || phase <= Self::Choice as usize || phase == Self::Picture as usize
        };
        let until = |end: usize| -> f64 {
            (0..end).filter(|phase| comes(*phase)).map(|phase| durations[phase]).sum()
        };
        let all = until(durations.len());
        let phase = self as usize;
        until(phase) / all..until(phase + 1) / all
    }
}

/// How far a recovery has come.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    effort: Effort,
    refine: bool,
    phase: Range<f64>,
    reached: f64,
    is_refining: bool,
}

impl Schedule {
    /// Nothing is done. Without separate phases, the progress ends where the last picture begins.
    pub(crate) fn new(options: &Options) -> Self {
        let Options { effort, refine, .. } = *options;
        let phase = 0.0..Phase::Picture.shares(effort, refine).start;
        Self { effort, refine, phase, reached: 0.0, is_refining: false }
    }

    /// `phase` begins.
    pub(crate) fn begin(&mut self, phase: Phase) {
        self.phase = phase.shares(self.effort, self.refine);
        self.is_refining = !matches!(phase, Phase::Fits | Phase::Choice);
    }

    /// Whether hypotheses have been chosen, and all numbers are refined.
    pub(crate) fn is_refining(&self) -> bool {
        self.is_refining
    }

    /// The share of the whole that is done, 0 to 1, where `within` (0 to 1) of the present phase is; never less
    /// than before.
    pub(crate) fn share(&mut self, within: f64) -> f64 {
        let Range { start, end } = self.phase;
        self.reached = self.reached.max(start + within.clamp(0.0, 1.0) * (end - start));
        self.reached
    }
}

/// The share of the whole that is done where `within` (0 to 1) of the last picture is.
pub(crate) fn of_picture(options: &Options, within: f64) -> f64 {
    let Range { start, end } = Phase::Picture.shares(options.effort, options.refine);
    start + within * (end - start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_follow_each_other_and_nothing_goes_back() {
        let phases = [
            Phase::Fits,
            Phase::Choice,
            Phase::Refinement,
            Phase::Revision,
            Phase::LastRefinement,
            Phase::OtherMinima,
            Phase::Picture,
        ];
        for effort in [Effort::Draft, Effort::Normal, Effort::High] {
            let share = |phase: Phase| phase.shares(effort, true);
            let follow = phases.windows(2).all(|two| share(two[0]).end == share(two[1]).start);
            let options = Options { effort, ..Options::default() };
            assert!(follow && share(phases[0]).start == 0.0 && of_picture(&options, 1.0) == 1.0);
            let mut schedule = Schedule::new(&options);
            let mut last = 0.0;
            for phase in [Phase::Fits, Phase::Revision, Phase::Refinement, Phase::LastRefinement] {
                schedule.begin(phase);
                for within in [0.5, 0.2, 2.0] {
                    let reached = schedule.share(within);
                    assert!(
                        reached >= last && reached <= of_picture(&options, 0.0),
                        "{reached} after {last}"
                    );
                    last = reached;
                }
            }
            assert_eq!(last, share(Phase::LastRefinement).end);
            // Without a refinement the picture comes after the choice.
            let options = Options { refine: false, ..options };
            assert_eq!(Phase::Choice.shares(effort, false).end, of_picture(&options, 0.0));
        }
    }
}
