//! The standard deviations in a `materials.json`.

use serde::{Deserialize, Serialize};

/// Standard deviations of a group's numbers; null for what the photograph does not determine.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct StdEntry {
    /// Of the diffuse reflectance, by channel.
    pub rho_d: Option<[f32; 3]>,
    /// Of the specular reflectance, by channel.
    pub rho_s: Option<[f32; 3]>,
    /// Of the roughness along the anisotropy direction.
    pub alpha_x: Option<f32>,
    /// Of the roughness across it.
    pub alpha_y: Option<f32>,
    /// Of the anisotropy direction, degrees.
    pub theta_deg: Option<f32>,
}
