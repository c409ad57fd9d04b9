//! The phases of a recovery in their order, the share of its time that each takes, and how far it has come.

use crate::effort::Effort;
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
    /// its time on the last refinement; before it, only half of the remaining time is reported.
    fn shares(self, effort: Effort) -> Range<f64> {
        let ends = match effort {
            Effort::Draft => [0.08, 0.42, 0.45, 0.45, 0.83, 0.87, 1.0],
            Effort::Normal | Effort::High => [0.03, 0.14, 0.18, 0.48, 0.87, 0.92, 1.0],
        };
        let phase = self as usize;
        phase.checked_sub(1).map_or(0.0, |before| ends[before])..ends[phase]
    }
}

/// How far a recovery has come.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    effort: Effort,
    phase: Range<f64>,
    reached: f64,
    is_refining: bool,
}

impl Schedule {
    /// Nothing is done. Without separate phases, the progress ends where the last picture begins.
    pub(crate) fn new(effort: Effort) -> Self {
        let phase = 0.0..Phase::Picture.shares(effort).start;
        Self { effort, phase, reached: 0.0, is_refining: false }
    }

    /// `phase` begins.
    pub(crate) fn begin(&mut self, phase: Phase) {
        self.phase = phase.shares(self.effort);
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
pub(crate) fn of_picture(effort: Effort, within: f64) -> f64 {
    let Range { start, end } = Phase::Picture.shares(effort);
    start + within * (end - start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_and_nothing_goes_back() {
        let parts = [
            Phase::Fits,
            Phase::Choice,
            Phase::Refinement,
            Phase::Revision,
            Phase::LastRefinement,
            Phase::OtherMinima,
            Phase::Picture,
        ];
        for effort in [Effort::Draft, Effort::Normal, Effort::High] {
            let share = |phase: Phase| phase.shares(effort);
            let follow = parts.windows(2).all(|two| share(two[0]).end == share(two[1]).start);
            assert!(follow && share(parts[0]).start == 0.0 && of_picture(effort, 1.0) == 1.0);
            let mut schedule = Schedule::new(effort);
            let mut last = 0.0;
            for phase in [Phase::Fits, Phase::Revision, Phase::Refinement, Phase::LastRefinement] {
                schedule.begin(phase);
                for within in [0.5, 0.2, 2.0] {
                    let reached = schedule.share(within);
                    assert!(
                        reached >= last && reached <= of_picture(effort, 0.0),
                        "{reached} after {last}"
                    );
                    last = reached;
                }
            }
            assert_eq!(last, share(Phase::LastRefinement).end);
        }
    }
}
