//! Proposals: another hypothesis for one group, with its numbers and what is tried after it.

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::ResidualStats;
use crate::guess::Guess;
use crate::hypothesis::{Fit, Hypothesis};
use crate::record::CandidateRecord;
use crate::selection::parameters;
use crate::verify::Claim;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_scene::{Image, Material};

/// Another hypothesis for one group.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Proposal {
    pub(crate) group: usize,
    pub(crate) hypothesis: Hypothesis,
    /// Whether it is more complex than the present one.
    pub(crate) is_more_complex: bool,
    /// How many more free parameters it has than the present one.
    pub(crate) adds: f64,
    pub(super) material: Material,
    pub(super) residual: ResidualStats,
    /// None where it was not found in the present light.
    pub(super) likelihood: Option<Likelihood>,
    /// Pixels that show something that is not in the model.
    pub(super) outliers: Vec<u32>,
    /// Of a texture: which texels the photograph shows.
    pub(super) seen_texels: Option<Image<bool>>,
    /// Whether it is the present hypothesis in another minimum, which explains the group better than the one
    /// that the present numbers lead to.
    pub(crate) is_other_minimum: bool,
    /// Whether it was chosen on paths that were used for no fit: the group's own pixels support it.
    pub(super) is_borne_out: bool,
    /// The one to try if the picture speaks against this one.
    pub(super) next: Option<Box<Proposal>>,
}

impl Proposal {
    /// The change to the result of `fit`.
    pub(super) fn uniform(
        guess: &Guess<'_>,
        group: usize,
        fit: &Fit,
        outliers: &[u32],
        next: Option<Box<Self>>,
    ) -> Self {
        let to = (fit.hypothesis, fit.material.clone());
        Self {
            likelihood: Some(fit.likelihood),
            outliers: outliers.to_vec(),
            next,
            ..Self::unasked(guess, group, to, fit.residual)
        }
    }

    /// The change to a candidate that was not chosen in the group's last comparison.
    pub(super) fn of_record(guess: &Guess<'_>, group: usize, record: &CandidateRecord) -> Self {
        let to = (record.hypothesis, record.material.clone());
        Self::unasked(guess, group, to, record.residual)
    }

    /// The change to a hypothesis with its material that the group's own pixels do not call for, and their residual.
    pub(super) fn unasked(
        guess: &Guess<'_>,
        group: usize,
        (hypothesis, material): (Hypothesis, Material),
        residual: ResidualStats,
    ) -> Self {
        let present = guess.groups[group].hypothesis;
        Self {
            group,
            hypothesis,
            is_more_complex: hypothesis > present,
            adds: added(guess, group, (hypothesis, &material)),
            material,
            residual,
            likelihood: None,
            outliers: Vec::new(),
            seen_texels: None,
            is_other_minimum: false,
            is_borne_out: false,
            next: None,
        }
    }

    /// Whether it changes anything of `guess`.
    pub(super) fn moves(&self, guess: &Guess<'_>) -> bool {
        self.is_other_minimum
            || self.hypothesis != guess.groups[self.group].hypothesis
            || !self.outliers.is_empty()
    }

    /// Whether the group's own pixels still have to support it: nothing else speaks for it.
    pub(crate) fn is_to_be_borne_out(&self) -> bool {
        (self.is_more_complex || self.is_other_minimum) && !self.is_borne_out
    }

    /// The one to try if the picture speaks against this one.
    pub(crate) fn otherwise(self, guess: &Guess<'_>) -> Option<Self> {
        self.next.map(|next| *next).filter(|next| next.moves(guess))
    }

    /// Writes into the group's selection log whether the change was accepted.
    pub(crate) fn record(&self, guess: &mut Guess<'_>, accepted: bool) {
        guess.groups[self.group].set_accepted(self.hypothesis, accepted);
    }

    /// What it claims of its group, for the comparison by the group's own pixels.
    pub(crate) fn claim(&self) -> Claim {
        let Self { group, adds, is_other_minimum, .. } = *self;
        Claim { group, adds, is_other_minimum }
    }

    /// Makes the change.
    pub(crate) fn apply(&self, guess: &mut Guess<'_>) {
        if self.hypothesis == Hypothesis::Textured {
            guess.forget_outliers(self.group);
        }
        if !self.outliers.is_empty() {
            Arc::make_mut(&mut guess.observation).mark_outliers(self.group, &self.outliers);
        }
        let outliers = guess.observation.outlier_share(self.group);
        let of_group = &mut guess.groups[self.group];
        of_group.hypothesis = self.hypothesis;
        of_group.residual = Some(self.residual);
        of_group.likelihood = self.likelihood;
        of_group.note = (outliers > 0.0).then(|| {
            format!(
                "{:.0} % of its pixels show something that is not in the model and do not count",
                100.0 * outliers
            )
        });
        of_group.seen_texels.clone_from(&self.seen_texels);
        guess.materials[self.group] = self.material.clone();
    }

    /// The guess that `guess` becomes by the change.
    pub(crate) fn applied<'a>(&self, guess: &Guess<'a>) -> Guess<'a> {
        let mut guess = guess.clone();
        self.apply(&mut guess);
        guess
    }
}

/// How many more free parameters `next` has than the present hypothesis of `group`.
pub(super) fn added(guess: &Guess<'_>, group: usize, next: (Hypothesis, &Material)) -> f64 {
    let present = guess.groups[group].hypothesis;
    parameters(next.0, next.1) - parameters(present, &guess.materials[group])
}
