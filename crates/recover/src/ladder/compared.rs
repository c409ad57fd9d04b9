//! All uniform hypotheses of one group compared, with as many light samples as it takes to distinguish them.
//!
//! The gain of one hypothesis over another has a standard deviation due to the noise of the light samples
//! ([`crate::selection`]). Few samples are enough if they clearly confirm the present hypothesis, as they do for most
//! groups once the light is refined; if the usual number leaves open whether a more complex hypothesis is better, both
//! are fitted and compared on paths ([`crate::refine::side_by_side`]) with all other groups fixed, or with more samples
//! as long as these are not refined.

use super::evidence_pair::{EvidencePair, Fits, Gathering, LightAmount, Searched};
use crate::compare::STRONG;
use crate::evidence::Evidence;
use crate::guess::Guess;
use crate::hypothesis::{self, Fit, Hypothesis, Search};
use crate::observe::model_error::ModelError;
use crate::problem::Options;
use crate::refine::contenders::Rung;
use crate::refine::side_by_side::{self, Compared as OnPaths, Criteria};
use crate::sample_budget::Level;
use crate::selection::{Choice, Comparison, explains_alike};

/// All candidates of one group: their fits, the choice among them, and the pixels that none of them was fitted to.
pub(super) struct Fitted {
    pub(super) fits: Vec<Fit>,
    pub(super) choice: Choice,
    pub(super) outliers: Vec<u32>,
}

impl Fitted {
    /// What was chosen.
    pub(super) fn chosen(&self) -> &Fit {
        &self.fits[self.choice.chosen]
    }

    /// The hypotheses that are also possible: noise leaves them open, and there is no strong evidence against them.
    pub(super) fn undecided(&self) -> Vec<Hypothesis> {
        let Choice { excess, open, .. } = &self.choice;
        let rivals = open.iter().filter(|i| excess[**i].value <= STRONG);
        rivals.map(|i| self.fits[*i].hypothesis).collect()
    }
}

/// One group's candidates, and the evidence that they were compared by.
pub(super) struct Compared {
    pub(super) evidence: EvidencePair,
    pub(super) fitted: Fitted,
    /// Whether the present hypothesis was chosen in another minimum, which explains the group better than the one
    /// that the present numbers lead to.
    pub(super) is_other_minimum: bool,
}

/// How the hypotheses of one group are compared.
pub(super) struct Asking<'a> {
    pub(super) by: Gathering<'a>,
    pub(super) level: Level,
    /// The model error up to which a uniform hypothesis explains the group.
    pub(super) explained: f64,
    /// Whether the group is expected to keep its hypothesis.
    pub(super) stands: bool,
}

impl Asking<'_> {
    /// Compares the candidates; none where nothing was seen of the group.
    pub(super) fn compare(&self, guess: &Guess<'_>) -> Option<Compared> {
        if self.stands {
            let little = self.compare_by(guess, LightAmount::Little)?;
            if self.confirms(guess, &little) {
                return Some(little);
            }
        }
        self.compare_by(guess, LightAmount::Usual)
    }

    /// The same with so many light samples, or more where that may change the decision.
    fn compare_by(&self, guess: &Guess<'_>, light: LightAmount) -> Option<Compared> {
        let group = self.by.group;
        let mut evidence = EvidencePair::gather(guess, &self.by, light)?;
        let searched = evidence.search(guess, group);
        let mut compared = self.judge(guess, evidence, &searched)?;
        if matches!(light, LightAmount::Usual) && !compared.fitted.choice.open.is_empty() {
            if self.stands {
                self.decide_on_paths(guess, &mut compared);
            } else {
                evidence = compared.evidence.judged_again(guess, &self.by)?;
                compared = self.judge(guess, evidence, &searched)?;
            }
        }
        Some(compared)
    }

    /// Decides on paths between the chosen one and the more complex ones that the evidence leaves open.
    fn decide_on_paths(&self, guess: &Guess<'_>, compared: &mut Compared) {
        let Fitted { fits, choice, .. } = &mut compared.fitted;
        let mut open = vec![choice.chosen];
        open.append(&mut choice.open);
        let rung = |&i: &usize| Rung {
            hypothesis: fits[i].hypothesis,
            material: fits[i].material.clone(),
        };
        let rungs = open.iter().map(rung).collect();
        let effort = self.level.effort(self.by.options, &guess.problem.unknown_lights);
        let by = Criteria { options: self.by.options, effort, allowance: self.by.budget.allowance };
        let OnPaths { rungs, choice: Choice { chosen, excess, open: still } } =
            side_by_side::compare(guess, &by, self.by.group, rungs);
        choice.open = still.into_iter().map(|i| open[i]).collect();
        if chosen == 0 {
            return;
        }
        let evidence = &compared.evidence.judging;
        let Rung { hypothesis, material } = &rungs[chosen];
        fits[open[chosen]] = hypothesis::fit(*hypothesis, evidence, material, Search::Kept);
        choice.chosen = open[chosen];
        let behind = choice.excess[choice.chosen].value;
        choice.excess.iter_mut().for_each(|excess| excess.value -= behind);
        open.iter().zip(excess).for_each(|(i, excess)| choice.excess[*i] = excess);
    }

    /// What was `searched`, compared by the `evidence`.
    fn judge(
        &self,
        guess: &Guess<'_>,
        mut evidence: EvidencePair,
        searched: &Searched,
    ) -> Option<Compared> {
        let Fits { all: fits, present } = evidence.judge(searched, guess, self.by.group);
        if fits.is_empty() {
            return None;
        }
        let choice = decide(self.by.options, &fits, &evidence.judging);
        let fitted = Fitted { fits, choice, outliers: Vec::new() };
        let chosen = fitted.chosen();
        let is_other_minimum = present.is_some_and(|present| {
            chosen.hypothesis == present.hypothesis
                && !explains_alike(&present, chosen, &evidence.judging)
        });
        Some(Compared { evidence, fitted, is_other_minimum })
    }

    /// Whether the present hypothesis is clearly confirmed.
    fn confirms(&self, guess: &Guess<'_>, compared: &Compared) -> bool {
        let chosen = compared.fitted.chosen();
        chosen.hypothesis == guess.groups[self.by.group].hypothesis
            && compared.fitted.choice.open.is_empty()
            && !compared.is_other_minimum
            && is_explained(chosen, self.explained, self.by.budget.allowance.floor)
    }
}

/// Model selection among all candidates.
pub(super) fn decide(options: &Options, fits: &[Fit], evidence: &Evidence) -> Choice {
    Comparison::new(fits, evidence).choose(options.thresholds.simpler)
}

/// Whether `fit` leaves no more model error than `limit`, from block to block or from pixel to
/// pixel. From block to block none is measured below `floor`.
pub(super) fn is_explained(fit: &Fit, limit: f64, floor: ModelError) -> bool {
    let of_pixels = fit.residual.squared - 2.0 * fit.residual.deviation;
    fit.likelihood.error.share <= limit.max(floor.share) && of_pixels <= limit * limit
}
