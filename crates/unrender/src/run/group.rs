//! What `run.json` says of one group.

use serde::{Deserialize, Serialize};
use unrender_formats::materials::GroupEntry;
use unrender_recover::Trust;
use unrender_scene::Hypothesis;

/// One group: its entry of `materials.json`, and how it came about.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct RunGroup {
    /// As in `materials.json`.
    #[serde(flatten)]
    pub entry: GroupEntry,
    /// Whether it was asked for and emits no light.
    pub asked: bool,
    /// The group's share, 0 to 1, of the squared error of all groups.
    pub error_share: Option<f64>,
    /// How many of its pixels counted, and how many did not, by reason.
    pub counted: LeftOut,
    /// Its colour in the group map, `#rrggbb`.
    pub map_color: String,
    /// The picture of a ball of its material, relative to the file; null for black ones.
    pub ball: Option<String>,
    /// The rungs that were tried, in the order of trial.
    pub story: Vec<TrialEntry>,
}

/// One rung tried on one group.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialEntry {
    /// In which turn.
    pub turn: usize,
    /// Which rung.
    pub hypothesis: Hypothesis,
    /// The relative error that noise does not explain.
    pub error: Option<f64>,
    /// The standard deviation of the error's square.
    pub deviation_of_square: Option<f64>,
    /// The model error that its residuals call for, as a share of the local light.
    #[serde(default)]
    pub model_error: Option<f64>,
    /// Its information criterion less that of the best candidate.
    #[serde(default)]
    pub criterion: Option<f64>,
    /// Diffuse reflectance.
    pub rho_d: [f32; 3],
    /// Specular reflectance.
    pub rho_s: [f32; 3],
    /// Roughness along the brushed direction.
    pub alpha_x: f32,
    /// Roughness across it.
    pub alpha_y: f32,
    /// Brushed direction, degrees.
    pub theta_deg: f32,
    /// Whether the group stood on this rung afterwards.
    pub taken: bool,
}

/// Numbers of pixels: those that counted, and the others by the reason why they did not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LeftOut {
    /// Those that counted.
    pub believed: usize,
    /// The model shows nothing there.
    pub nothing: usize,
    /// The photograph is clipped, too dark or broken there.
    pub cut_off: usize,
    /// An edge is too close.
    pub edge: usize,
    /// A single bright pixel.
    pub spike: usize,
    /// What is not in the model.
    pub stray: usize,
}

impl LeftOut {
    /// Counts pixels.
    pub fn count<'a>(trust: impl IntoIterator<Item = &'a Trust>) -> Self {
        let mut counted = Self::default();
        for trust in trust {
            *match trust {
                Trust::Believed => &mut counted.believed,
                Trust::Nothing => &mut counted.nothing,
                Trust::CutOff => &mut counted.cut_off,
                Trust::Edge => &mut counted.edge,
                Trust::Spike => &mut counted.spike,
                Trust::Stray => &mut counted.stray,
            } += 1;
        }
        counted
    }
}
