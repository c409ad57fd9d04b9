//! The photometric parameters in a `materials.json`.

use serde::{Deserialize, Serialize};

/// The photometric parameters of the camera that were recovered.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PhotographEntry {
    /// The gamma: linear = code^gamma.
    pub gamma: Option<f64>,
    /// a1, a2, a3 of the share of light 1 + a1 r^2 + a2 r^4 + a3 r^6, r = 1 at half the diagonal.
    pub vignetting: Option<[f64; 3]>,
    /// That share at r = 1.
    pub corner: Option<f64>,
    /// Scene radiance per unit of linear pixel value, by channel; each of several photographs has its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<[f32; 3]>,
    /// Standard deviations; null if nothing was refined.
    pub std: Option<PhotographStd>,
    /// A note on parameters that the photograph hardly determines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Standard deviations of the photometric parameters.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PhotographStd {
    /// Of the gamma.
    pub gamma: Option<f64>,
    /// Of each coefficient of vignetting; they are correlated, and together better determined.
    pub vignetting: Option<[f64; 3]>,
    /// Of the share of light at r = 1.
    pub corner: Option<f64>,
    /// Of the exposure, if it was estimated relative to that of the first photograph.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<[f32; 3]>,
}
