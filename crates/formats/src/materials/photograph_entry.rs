//! What a `materials.json` says of how the photograph was made.

use serde::{Deserialize, Serialize};

/// The numbers of the camera that were asked for.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PhotographEntry {
    /// The gamma: linear = code^gamma.
    pub gamma: Option<f64>,
    /// a1, a2, a3 of the share of light 1 + a1 r^2 + a2 r^4 + a3 r^6, r = 1 at half the diagonal.
    pub vignetting: Option<[f64; 3]>,
    /// That share at r = 1.
    pub corner: Option<f64>,
    /// Scene radiance per unit of linear pixel value, by channel; of several photographs each has its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<[f32; 3]>,
    /// Standard deviations; null if nothing was refined.
    pub std: Option<PhotographStd>,
    /// What the photograph hardly determines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Standard deviations of the numbers of the camera.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PhotographStd {
    /// Of the gamma.
    pub gamma: Option<f64>,
    /// Of the coefficients of vignetting, one by one; together they are known better.
    pub vignetting: Option<[f64; 3]>,
    /// Of the share of light at r = 1.
    pub corner: Option<f64>,
    /// Of the exposure, where it was found beside that of the first photograph.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<[f32; 3]>,
}
