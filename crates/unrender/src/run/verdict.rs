//! The outcome of a run in a few numbers: how many groups have which status, and why it ended.

use super::{Run, RunGroup};
use serde::{Deserialize, Serialize};
use unrender_formats::materials::{Status, StatusEntry};
use unrender_recover::Termination;

/// How many groups have which status. A group with the material of another one has its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Verdict {
    /// Recovered.
    pub recovered: usize,
    /// Doubtful: the fit is worse than noise allows, or two kinds of material fit equally well.
    pub doubtful: usize,
    /// Assumed: the photograph does not determine them.
    pub assumed: usize,
}

impl Verdict {
    /// Counts `groups`.
    pub fn of<'a>(groups: impl IntoIterator<Item = &'a RunGroup>) -> Self {
        let mut verdict = Self::default();
        for group in groups {
            match &group.entry.status {
                Some(StatusEntry::Of(Status::Recovered) | StatusEntry::SameAs(_)) => {
                    verdict.recovered += 1;
                }
                Some(StatusEntry::Of(Status::Doubtful)) => verdict.doubtful += 1,
                Some(StatusEntry::Of(Status::Assumed)) => verdict.assumed += 1,
                _ => {}
            }
        }
        verdict
    }
}

/// Why a recovery ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// No parameter changed any more.
    Converged,
    /// At the limit of passes, while a parameter still moved.
    Limit,
    /// A step of the joint refinement could not be solved.
    Failed,
    /// The user stopped it.
    Interrupted,
}

impl Ended {
    /// The word for a termination; none for one that is not known here.
    pub(crate) fn of(termination: Termination) -> Option<Self> {
        match termination {
            Termination::Settled | Termination::Refined => Some(Self::Converged),
            Termination::IterationLimit | Termination::RefinementLimit => Some(Self::Limit),
            Termination::RefinementFailed => Some(Self::Failed),
            Termination::Interrupted => Some(Self::Interrupted),
            _ => None,
        }
    }

    /// What older files say in a sentence.
    fn of_sentence(termination: &str) -> Option<Self> {
        let starts = |words: &[&str]| words.iter().any(|word| termination.starts_with(word));
        match termination {
            _ if starts(&["settled", "refined together"]) => Some(Self::Converged),
            _ if starts(&["stopped at the limit"]) => Some(Self::Limit),
            _ if starts(&["stopped after"]) => Some(Self::Failed),
            _ if starts(&["interrupted"]) => Some(Self::Interrupted),
            _ => None,
        }
    }
}

impl Run {
    /// Fills in what older files lack and what follows from the rest.
    pub(super) fn fill_in(&mut self) {
        self.verdict = Verdict::of(self.groups.values());
        self.ended = self.ended.or_else(|| Ended::of_sentence(&self.termination));
        for decision in self.groups.values_mut().flat_map(|group| &mut group.decisions) {
            decision.sigmas = decision.sigmas.or_else(|| decision.gain_in_sigmas());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_files_say_in_a_sentence_why_they_ended() {
        for (termination, ended) in [
            (Termination::Settled, Ended::Converged),
            (Termination::Refined, Ended::Converged),
            (Termination::IterationLimit, Ended::Limit),
            (Termination::RefinementLimit, Ended::Limit),
            (Termination::RefinementFailed, Ended::Failed),
            (Termination::Interrupted, Ended::Interrupted),
        ] {
            assert_eq!(Ended::of_sentence(&termination.message(7)), Some(ended));
            assert_eq!(Ended::of(termination), Some(ended));
        }
    }
}
