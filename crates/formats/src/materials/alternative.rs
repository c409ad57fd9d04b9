//! The other explanations in a `materials.json`.

use super::{Hypothesis, drop_number, drop_triple};
use serde::{Deserialize, Serialize};

/// Another material that explains a group's photograph as well as the delivered one.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct AlternativeEntry {
    /// What the group would be.
    pub hypothesis: Option<Hypothesis>,
    /// Diffuse reflectance.
    pub rho_d: Option<[f32; 3]>,
    /// Specular reflectance.
    pub rho_s: Option<[f32; 3]>,
    /// Roughness along the anisotropy direction.
    pub alpha_x: Option<f32>,
    /// Roughness across it.
    pub alpha_y: Option<f32>,
    /// Anisotropy direction from the surface's tangent, degrees counter-clockwise.
    pub theta_deg: Option<f32>,
    /// The relative error of its re-rendering over the group's pixels.
    pub error: Option<f64>,
}

impl AlternativeEntry {
    pub(super) fn drop_not_finite(&mut self) {
        drop_triple(&mut self.rho_d);
        drop_triple(&mut self.rho_s);
        drop_number(&mut self.alpha_x);
        drop_number(&mut self.alpha_y);
        drop_number(&mut self.theta_deg);
        self.error = self.error.filter(|e| e.is_finite());
    }
}
