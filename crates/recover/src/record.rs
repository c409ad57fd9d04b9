//! The records of a recovery: everything that tables, reports and files say is a field here.

use crate::compare::residual::ResidualStats;
use crate::hypothesis::Hypothesis;
use crate::observe::observation::PixelStatus;
use crate::observe::photometric::PhotometricEstimate;
use crate::unknown::Unknown;
use glam::Vec3;
use serde::{Deserialize, Serialize};
pub use unrender_scene::Status;
use unrender_scene::{Image, Material, Rgb, RgbImage};

/// The result of a recovery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Recovery {
    /// All groups of the scene, in its order.
    pub groups: Vec<GroupResult>,
    /// Scene radiance per unit of the photograph's linear values.
    pub exposure: Rgb,
    /// The standard deviation of the exposure, where it was estimated.
    pub exposure_std: Option<Rgb>,
    /// The sources of light whose brightness was estimated.
    pub lights: Vec<LightResult>,
    /// The parameters of the camera that were estimated.
    pub photometric: PhotometricEstimate,
    /// The joint covariance of all numbers that were refined; none where nothing was.
    pub covariance: Option<Covariance>,
    /// The photograph's view rendered with the recovered materials, radiance.
    pub rerendered: RgbImage,
    /// The standard deviation that noise gives the luminance of photograph minus re-rendering, the
    /// photograph's and the rendering's together, radiance; zero where no group is seen.
    pub noise: Image<f32>,
    /// One sample of the noise of the re-rendering's luminance: half the difference of its two halves, radiance. Pixels
    /// that share paths have it in common, which `noise` does not say.
    pub noise_sample: Image<f32>,
    /// Which pixels of the photograph were valid in the end, and why others were not.
    pub status: Image<PixelStatus>,
    /// One record a global re-rendering.
    pub iterations: Vec<IterationRecord>,
    /// Why it ended.
    pub termination: Termination,
}

/// The result for one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupResult {
    /// The group's name.
    pub name: String,
    /// Whether the numbers come from the photograph.
    pub status: Status,
    /// The rung that was accepted.
    pub hypothesis: Hypothesis,
    /// The parameters.
    pub material: Material,
    /// Other parameters that explain the photograph as well.
    pub alternatives: Vec<Alternative>,
    /// Their standard deviations; none where nothing was free or nothing was refined.
    pub std: Option<Deviations>,
    /// The anisotropy direction in world space where the group is seen best: the tangent of its middle
    /// pixel turned by theta. None where no pixel shows the group.
    pub direction: Option<Vec3>,
    /// For textured groups: which texels the photograph shows.
    pub seen_texels: Option<Image<bool>>,
    /// Pixels of the photograph that show the group.
    pub pixels: usize,
    /// Pixels among them that were valid.
    pub valid_pixels: usize,
    /// Relative root mean square of photograph minus re-rendering over the valid pixels, without
    /// the rendering noise. None where no pixel shows the group, or the photograph is black wherever it does.
    pub error: Option<f64>,
    /// The group's share, 0 to 1, of the squared error of all groups' valid pixels.
    pub error_share: Option<f64>,
    /// The candidates, in the order in which they were tried.
    pub selection_log: Vec<CandidateRecord>,
    /// The changes of its hypothesis that were considered, in their order.
    pub decisions: Vec<Decision>,
    /// What the user should know about it.
    pub note: Option<String>,
}

/// Other parameters of a group that explain the photograph as well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Alternative {
    /// The rung.
    pub hypothesis: Hypothesis,
    /// The parameters.
    pub material: Material,
    /// The relative error that they leave.
    pub error: f64,
}

/// Standard deviations of a group's numbers; none for numbers that were not free.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Deviations {
    /// Of the diffuse reflectance; of a textured group, of one texel.
    pub rho_d: Option<Rgb>,
    /// Of the specular reflectance.
    pub rho_s: Option<Rgb>,
    /// Of the roughness along the anisotropy direction, relative to it.
    pub ln_alpha_x: Option<f32>,
    /// Of the roughness across it, relative to it.
    pub ln_alpha_y: Option<f32>,
    /// Of the anisotropy direction, radians.
    pub theta_rad: Option<f32>,
}

/// The joint covariance of the numbers that were refined, each in the unit of its [`crate::Quantity`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// The numbers.
    pub of: Vec<Unknown>,
    /// Their covariance, row by row; symmetric, the squared standard deviations on the diagonal.
    pub matrix: Vec<Vec<f64>>,
}

/// The result for one source of light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LightResult {
    /// Its number, as in [`unrender_render::Appearance::lights`].
    pub source: usize,
    /// How many times as bright as in the scene it is.
    pub factor: Rgb,
    /// The standard deviation of that.
    pub std: Rgb,
}

/// One rung tried on one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CandidateRecord {
    /// In which iteration.
    pub iteration: usize,
    /// Which rung.
    pub hypothesis: Hypothesis,
    /// Its parameters.
    pub material: Material,
    /// What it left unexplained.
    pub residual: ResidualStats,
    /// The model error that its residuals call for, as a share of the local light.
    pub model_error: f64,
    /// Its information criterion less that of the accepted candidate; zero with the paper's ladder.
    pub criterion: f64,
    /// Whether the group stood on this rung afterwards.
    pub accepted: bool,
}

/// What a rule said of a change of a group's hypothesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Decision {
    /// The number of global re-renderings before it.
    pub iteration: usize,
    /// The present hypothesis of the group.
    pub from: Hypothesis,
    /// The other one.
    pub to: Hypothesis,
    /// The squared residuals under `to` less those under `from`, in units of their covariance: below zero where `to`
    /// explains the photograph better. Zero where the rule compares none.
    pub difference: f64,
    /// The standard deviation of the difference.
    pub deviation: f64,
    /// By how much the difference has to be below zero for the additional numbers of `to`.
    pub price: f64,
    /// Whether the change was made.
    pub accepted: bool,
    /// By which rule.
    pub rule: Rule,
}

/// The rules that decide over a change of a hypothesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Rule {
    /// On samples of the light that arrives at the group's pixels: the simplest hypothesis that no other beats by two
    /// standard deviations is taken, unless the present one is such and no simpler one is expected to be better. Where none is
    /// taken, `to` is the one that came nearest.
    LightSamples,
    /// Texels from some of the group's pixels have to predict the others better than a uniform reflectance does.
    Prediction,
    /// The last refinement speaks for the values that a simpler one has, or says that its additional numbers are negligible.
    Simpler,
    /// The project allows no other.
    Project,
    /// A method other than the default one goes by rules of its own: the paper's by thresholds of the error.
    Method,
    /// It was taken back: with a texture the group's re-rendered pixels were explained worse.
    TakenBack,
}

impl Rule {
    /// Its name in `run.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LightSamples => "light samples",
            Self::Prediction => "prediction",
            Self::Simpler => "simpler",
            Self::Project => "project",
            Self::Method => "method",
            Self::TakenBack => "taken back",
        }
    }
}

/// One global re-rendering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct IterationRecord {
    /// Whether it was a pass of the refinement, after the choice of hypotheses.
    pub refining: bool,
    /// Counted from one.
    pub iteration: usize,
    /// The largest change of a reflectance, and of the logarithm of a roughness.
    pub change: f64,
    /// The relative error of all groups together that noise does not explain; in the paper's ladder that of the worst
    /// group.
    pub worst_error: f64,
    /// Groups whose hypothesis does not explain the photograph yet.
    pub open_groups: Vec<String>,
    /// Where each group of the scene stands after it, in the scene's order.
    pub groups: Vec<GroupIteration>,
    /// A rough share of the work that is done, 0 to 1, never less than before.
    pub done: f64,
}

/// Where one group stands after a global re-rendering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GroupIteration {
    /// Its rung.
    pub hypothesis: Hypothesis,
    /// Its parameters; a texture is left out.
    pub material: Material,
    /// Its relative error that noise does not explain: of its pixels in an iteration of the ladder, of the
    /// means over its blocks in a pass of the refinement. None where it was not measured, as of
    /// textures in the default ladder.
    pub error: Option<f64>,
}

/// Why a recovery ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Termination {
    /// No parameter changes any more.
    Settled,
    /// The limit of global re-renderings was reached.
    IterationLimit,
    /// All parameters were refined together, until no step was larger than its uncertainty.
    Refined,
    /// They were refined together, and still moved by more than that at the limit of passes.
    RefinementLimit,
    /// A step of the refinement could not be solved.
    RefinementFailed,
    /// The user stopped it; the results are as far as it had come.
    Interrupted,
}

impl Termination {
    /// A sentence for people.
    pub fn message(self, iterations: usize) -> String {
        match self {
            Self::Settled => format!("settled after {iterations} global re-renderings"),
            Self::Refined => format!(
                "refined together until no step was larger than its own uncertainty, after {iterations} \
                 global re-renderings"
            ),
            Self::RefinementLimit => format!(
                "stopped at the limit of passes, after {iterations} global re-renderings, while a step \
                 was still larger than its own uncertainty"
            ),
            Self::RefinementFailed => format!(
                "stopped after {iterations} global re-renderings, because a step of the joint refinement \
                 could not be solved; the results are those before it"
            ),
            Self::Interrupted => format!(
                "interrupted after {iterations} global re-renderings; the results are as far as it had come"
            ),
            Self::IterationLimit => {
                format!("stopped at the limit of {iterations} global re-renderings before settling")
            }
        }
    }
}

/// Is told of each iteration as it ends.
pub trait Observer: Sync {
    /// After a global re-rendering.
    fn iteration(&mut self, record: &IterationRecord);
    /// Between iterations and during the last picture, from any thread: what is being done, in some words, and a
    /// rough share of the work that is done, 0 to 1.
    fn working(&self, what: &str, done: f64);
    /// Whether a picture of the present state is wanted now; it takes as long as a few paths for each of its pixels.
    fn wants_picture(&self) -> bool {
        false
    }
    /// Receives it: radiance, as the photograph of the problem has it.
    fn picture(&mut self, _rough: RgbImage) {}
    /// Whether to stop with the present results; asked between iterations.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// An observer that ignores all calls.
impl Observer for () {
    fn iteration(&mut self, _: &IterationRecord) {}
    fn working(&self, _: &str, _: f64) {}
}
