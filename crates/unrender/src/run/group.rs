//! The entry of one group in `run.json`.

use serde::{Deserialize, Serialize};
use unrender_formats::materials::GroupEntry;
use unrender_recover::PixelStatus;
use unrender_scene::Hypothesis;

/// One group: its entry of `materials.json`, and how it was recovered.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct RunGroup {
    /// As in `materials.json`.
    #[serde(flatten)]
    pub entry: GroupEntry,
    /// Whether it was to be recovered and emits no light.
    pub asked: bool,
    /// The groups that agree with it within their standard deviations, and may be of one material.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub agrees_with: Vec<String>,
    /// Its objects, split into parts that one reflectance does not explain together; empty if one
    /// does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Vec<String>>,
    /// The group's share, 0 to 1, of the squared error of all groups.
    pub error_share: Option<f64>,
    /// How many of its pixels were used, and how many were not, by reason.
    pub counted: LeftOut,
    /// Its colour in the group map, `#rrggbb`.
    pub map_color: String,
    /// The picture of a ball of its material, relative to the file; null for black materials.
    pub ball: Option<String>,
    /// What its re-rendering misses in the photograph; left out where it was not compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub miss: Option<MissEntry>,
    /// Its material in artists' units; left out in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub artist: Option<ArtistEntry>,
    /// The candidates, in the order in which they were tried.
    #[serde(alias = "story")]
    pub selection_log: Vec<CandidateEntry>,
    /// What was said of the changes of its hypothesis that were considered, in their order.
    #[serde(default)]
    pub decisions: Vec<DecisionEntry>,
}

/// What a rule said of a change of a group's hypothesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecisionEntry {
    /// In which iteration.
    pub iteration: usize,
    /// The present hypothesis.
    pub from: Hypothesis,
    /// The other one.
    pub to: Hypothesis,
    /// The name of the [`unrender_recover::Rule`].
    pub rule: String,
    /// The squared residuals under `to` minus those under `from`, in units of their covariance.
    pub difference: Option<f64>,
    /// The standard deviation of the difference.
    pub deviation: Option<f64>,
    /// By how much the difference has to be below zero.
    pub price: Option<f64>,
    /// The gain before its price, `difference` with the other sign, in standard deviations; left out where it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigmas: Option<f64>,
    /// Whether the change was made.
    pub accepted: bool,
}

impl DecisionEntry {
    /// The gain in standard deviations; none where it has none.
    pub(crate) fn gain_in_sigmas(&self) -> Option<f64> {
        let deviation = self.deviation.filter(|deviation| *deviation > 0.0)?;
        Some(-self.difference? / deviation).filter(|sigmas| sigmas.is_finite())
    }
}

/// Where the smoothed re-rendering of a group differs from the photograph by more than two standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct MissEntry {
    /// The share, 0 to 1, of its compared pixels where the re-rendering is too bright.
    pub too_bright: f64,
    /// The share where it is too dark.
    pub too_dark: f64,
    /// The largest such difference, re-rendering minus photograph, as a share of the photograph's mean; zero where
    /// there is none.
    pub largest: f64,
    /// Where that is, as shares of the picture's width and height.
    pub place: [f64; 2],
    /// In which of several photographs, counted from one.
    pub photograph: usize,
}

/// A material in artists' units: as sRGB, and as `unrender export --to blender` writes it.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct ArtistEntry {
    /// The larger of its diffuse and specular reflectance as sRGB, `#rrggbb`.
    pub color: String,
    /// *Base Color* of Blender's Principled BSDF as sRGB, `#rrggbb`; of a texture its mean.
    pub base_color: String,
    /// *Roughness* in Blender: the square root of alpha; one without a lobe.
    pub roughness: f32,
    /// Whether *Metallic* is one.
    pub metallic: bool,
    /// *IOR* of a dielectric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ior: Option<f32>,
    /// Whether the lobe is a Glossy BSDF beside the Principled one.
    pub glossy: bool,
}

/// One rung tried on one group.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateEntry {
    /// In which iteration.
    #[serde(alias = "turn")]
    pub iteration: usize,
    /// Which rung.
    pub hypothesis: Hypothesis,
    /// Its relative error that noise does not explain.
    pub error: Option<f64>,
    /// The standard deviation of the error's square.
    pub deviation_of_square: Option<f64>,
    /// The model error that its residuals imply, as a share of the local light.
    #[serde(default)]
    pub model_error: Option<f64>,
    /// Its information criterion minus that of the accepted candidate.
    #[serde(default)]
    pub criterion: Option<f64>,
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
    /// Whether the group was on this rung afterwards.
    #[serde(alias = "taken")]
    pub accepted: bool,
}

/// Numbers of pixels: those that were used, and the others by the reason why they were not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LeftOut {
    /// Those that were used.
    #[serde(alias = "believed")]
    pub valid: usize,
    /// The model shows nothing there.
    pub nothing: usize,
    /// The photograph is clipped, too dark or broken there, or the project leaves it out.
    #[serde(alias = "cut_off")]
    pub clipped: usize,
    /// An edge is too close.
    pub edge: usize,
    /// A single bright pixel.
    pub spike: usize,
    /// It shows something that is not in the model.
    #[serde(alias = "stray")]
    pub outlier: usize,
}

impl LeftOut {
    /// Counts pixels.
    pub fn count<'a>(status: impl IntoIterator<Item = &'a PixelStatus>) -> Self {
        let mut counted = Self::default();
        for status in status {
            *match status {
                PixelStatus::Valid => &mut counted.valid,
                PixelStatus::Nothing => &mut counted.nothing,
                PixelStatus::Clipped => &mut counted.clipped,
                PixelStatus::Edge => &mut counted.edge,
                PixelStatus::Spike => &mut counted.spike,
                PixelStatus::Outlier => &mut counted.outlier,
            } += 1;
        }
        counted
    }
}
