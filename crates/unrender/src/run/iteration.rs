//! The entry of one global re-rendering in `run.json`.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use unrender_scene::Hypothesis;

/// One global re-rendering.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct IterationEntry {
    /// Counted from one.
    #[serde(alias = "turn")]
    pub iteration: usize,
    /// Whether it was a pass of the refinement, after the choice of hypotheses.
    pub refining: bool,
    /// Seconds since the recovery began.
    pub seconds: f64,
    /// The largest change of a reflectance, and of the logarithm of a roughness.
    pub change: Option<f64>,
    /// The relative error of all groups together before its step; in the paper's ladder, that of the worst
    /// group.
    pub worst_error: Option<f64>,
    /// Groups whose hypothesis did not yet explain the photograph.
    pub open_groups: Vec<String>,
    /// The groups to be recovered.
    pub groups: IndexMap<String, GroupIterationEntry>,
}

/// The state of one group after an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupIterationEntry {
    /// Its rung.
    pub hypothesis: Hypothesis,
    /// Its relative error that noise does not explain; in a refinement pass, before the step.
    pub error: Option<f64>,
    /// Diffuse reflectance.
    pub rho_d: [f32; 3],
    /// Specular reflectance.
    pub rho_s: [f32; 3],
    /// Roughness along the anisotropy direction.
    pub alpha_x: f32,
    /// Roughness across it.
    pub alpha_y: f32,
    /// Anisotropy direction, degrees.
    pub theta_deg: f32,
}
