//! Proposals: another hypothesis for one group, with its numbers and what is tried after it.

use crate::hypothesis::{Fit, Hypothesis};
use crate::likelihood::Likelihood;
use crate::model_error::Allowance;
use crate::record::CandidateRecord;
use crate::residual::ResidualStats;
use crate::selection::parameters;
use crate::state::State;
use serde::{Deserialize, Serialize};
use unrender_scene::Material;

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
    /// Whether it is the present hypothesis in another minimum, which explains the group better than the one
    /// that the present numbers lead to.
    pub(crate) is_other_minimum: bool,
    /// Whether it was chosen on paths that were used for no fit: the group's own pixels support it.
    pub(super) is_borne_out: bool,
    /// The model error below which its gain does not count, if not that of all changes.
    pub(crate) least: Option<Allowance>,
    /// The one to try if the picture speaks against this one.
    pub(super) next: Option<Box<Proposal>>,
    /// The one to try next, whether this one was accepted or not: the group without outliers, or a texture. These
    /// explain more than any uniform hypothesis does, and have to be compared with the best of them.
    pub(super) then: Option<Box<Proposal>>,
}

impl Proposal {
    /// The change to the result of `fit`.
    pub(super) fn uniform(
        state: &State<'_>,
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
            ..Self::unasked(state, group, to, fit.residual)
        }
    }

    /// The change to a candidate that was not chosen in the group's last comparison.
    pub(super) fn of_record(state: &State<'_>, group: usize, record: &CandidateRecord) -> Self {
        let to = (record.hypothesis, record.material.clone());
        Self::unasked(state, group, to, record.residual)
    }

    /// The change to a hypothesis with its material that the group's own pixels do not call for, and their residual.
    pub(super) fn unasked(
        state: &State<'_>,
        group: usize,
        (hypothesis, material): (Hypothesis, Material),
        residual: ResidualStats,
    ) -> Self {
        let present = state.groups[group].hypothesis;
        Self {
            group,
            hypothesis,
            is_more_complex: hypothesis > present,
            adds: added(state, group, (hypothesis, &material)),
            material,
            residual,
            likelihood: None,
            outliers: Vec::new(),
            is_other_minimum: false,
            is_borne_out: false,
            least: None,
            next: None,
            then: None,
        }
    }

    /// Whether it changes anything of `state`.
    pub(super) fn moves(&self, state: &State<'_>) -> bool {
        self.is_other_minimum
            || self.hypothesis != state.groups[self.group].hypothesis
            || !self.outliers.is_empty()
    }

    /// Whether the group's own pixels still have to support it: nothing else speaks for it.
    pub(crate) fn is_to_be_borne_out(&self) -> bool {
        (self.is_more_complex || self.is_other_minimum) && !self.is_borne_out
    }

    /// The one to try if the picture speaks against this one.
    pub(crate) fn otherwise(self, state: &State<'_>) -> Option<Self> {
        let next = self.next.map(|next| *next).filter(|next| next.moves(state));
        match next {
            Some(next) => Some(Self { then: self.then, ..next }),
            None => self.then.map(|then| *then),
        }
    }

    /// The one to try after this one was accepted, as it now is in `state`.
    pub(crate) fn afterwards(self, state: &State<'_>) -> Option<Self> {
        let then = *self.then?;
        let present = state.groups[then.group].hypothesis;
        let is_more_complex = then.hypothesis > present;
        let adds = added(state, then.group, (then.hypothesis, &then.material));
        Some(Self { is_more_complex, adds, ..then })
    }

    /// Writes into the group's selection log whether the change was accepted.
    pub(crate) fn record(&self, state: &mut State<'_>, accepted: bool) {
        state.groups[self.group].set_accepted(self.hypothesis, accepted);
    }

    /// Makes the change.
    pub(crate) fn apply(&self, state: &mut State<'_>) {
        if self.hypothesis == Hypothesis::Textured {
            state.observation.forget_outliers(self.group);
        }
        state.observation.mark_outliers(self.group, &self.outliers);
        let outliers = state.observation.outlier_share(self.group);
        let of_group = &mut state.groups[self.group];
        of_group.hypothesis = self.hypothesis;
        of_group.residual = Some(self.residual);
        of_group.likelihood = self.likelihood;
        of_group.note = (outliers > 0.0).then(|| {
            format!(
                "{:.0} % of its pixels show something that is not in the model and do not count",
                100.0 * outliers
            )
        });
        if self.hypothesis != Hypothesis::Textured {
            of_group.seen_texels = None;
        }
        state.materials[self.group] = self.material.clone();
    }
}

/// How many more free parameters `next` has than the present hypothesis of `group`.
pub(super) fn added(state: &State<'_>, group: usize, next: (Hypothesis, &Material)) -> f64 {
    let present = state.groups[group].hypothesis;
    parameters(next.0, next.1) - parameters(present, &state.materials[group])
}
