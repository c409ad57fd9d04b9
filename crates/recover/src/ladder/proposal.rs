//! Proposals: another hypothesis for one group, with its numbers.

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::ResidualStats;
use crate::guess::Guess;
use crate::hypothesis::{Fit, Hypothesis};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_scene::{Image, Material};

/// Another hypothesis for one group.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Proposal {
    pub(crate) group: usize,
    pub(crate) hypothesis: Hypothesis,
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
    pub(super) is_other_minimum: bool,
}

impl Proposal {
    /// The change of `group` to the result of `fit`.
    pub(super) fn uniform(group: usize, fit: &Fit, outliers: &[u32]) -> Self {
        let to = (fit.hypothesis, fit.material.clone());
        Self {
            likelihood: Some(fit.likelihood),
            outliers: outliers.to_vec(),
            ..Self::to(group, to, fit.residual)
        }
    }

    /// The change to a hypothesis with its material, whose residual is this.
    pub(super) fn to(
        group: usize,
        (hypothesis, material): (Hypothesis, Material),
        residual: ResidualStats,
    ) -> Self {
        Self {
            group,
            hypothesis,
            material,
            residual,
            likelihood: None,
            outliers: Vec::new(),
            seen_texels: None,
            is_other_minimum: false,
        }
    }

    /// Whether it changes anything of `guess`.
    pub(super) fn moves(&self, guess: &Guess<'_>) -> bool {
        self.is_other_minimum
            || self.hypothesis != guess.groups[self.group].hypothesis
            || !self.outliers.is_empty()
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
}
