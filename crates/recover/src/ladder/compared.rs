//! All uniform hypotheses of one group compared, with as many light samples as it takes to distinguish them.
//!
//! The gain of one hypothesis over another has a standard deviation due to the noise of the light samples and of the
//! pixels ([`crate::selection`]). If that leaves open whether a more complex hypothesis is better, all are compared on
//! more of both.

use super::evidence_pair::{EvidencePair, Fits, Gathering, Searched};
use crate::compare::STRONG;
use crate::evidence::Evidence;
use crate::guess::Guess;
use crate::hypothesis::{Fit, Hypothesis};
use crate::observe::model_error::ModelError;
use crate::problem::Options;
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

    /// The hypotheses that are also possible: noise leaves them open, and they are simpler, or there is no strong evidence
    /// against them.
    pub(super) fn undecided(&self) -> Vec<Hypothesis> {
        let Choice { excess, open, chosen } = &self.choice;
        let rivals = open.iter().filter(|i| *i < chosen || excess[**i].value <= STRONG);
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

/// Compares the candidates of a group; none where nothing was seen of it. What the usual light leaves open is compared
/// once more, by more and other light.
pub(super) fn compare(guess: &Guess<'_>, by: &Gathering<'_>) -> Option<Compared> {
    let mut evidence = EvidencePair::gather(guess, by)?;
    let searched = evidence.search(guess, by.group);
    let compared = judge(guess, by, evidence, &searched)?;
    if compared.fitted.choice.open.is_empty() {
        return Some(compared);
    }
    judge(guess, by, compared.evidence.judged_again(guess, by, &searched)?, &searched)
}

/// What was `searched`, compared by the `evidence`.
fn judge(
    guess: &Guess<'_>,
    by: &Gathering<'_>,
    mut evidence: EvidencePair,
    searched: &Searched,
) -> Option<Compared> {
    let Fits { all: fits, present } = evidence.judge(searched, guess, by.group);
    if fits.is_empty() {
        return None;
    }
    let choice = decide(by.options, &fits, &evidence.judging, guess.groups[by.group].hypothesis);
    let fitted = Fitted { fits, choice, outliers: Vec::new() };
    let chosen = fitted.chosen();
    let is_other_minimum = present.is_some_and(|present| {
        chosen.hypothesis == present.hypothesis
            && !explains_alike(&present, chosen, &evidence.judging)
    });
    Some(Compared { evidence, fitted, is_other_minimum })
}

/// Model selection among all candidates.
pub(super) fn decide(
    options: &Options,
    fits: &[Fit],
    evidence: &Evidence,
    present: Hypothesis,
) -> Choice {
    Comparison::new(fits, evidence).choose(present, options.thresholds.simpler)
}

/// Whether `fit` leaves no more model error than `limit`, from block to block or from pixel to
/// pixel. From block to block none is measured below `floor`.
pub(super) fn is_explained(fit: &Fit, limit: f64, floor: ModelError) -> bool {
    let of_pixels = fit.residual.squared - 2.0 * fit.residual.deviation;
    fit.likelihood.error.share <= limit.max(floor.share) && of_pixels <= limit * limit
}
