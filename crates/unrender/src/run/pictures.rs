//! The pictures of a run, and the meaning of the colours of false-colour ones.

use super::{LeftOut, RegistrationEntry, as_text};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use unrender_formats::materials::PhotographEntry;

/// One of several photographs of a run.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct PhotographRun {
    /// Its file.
    #[serde(serialize_with = "as_text")]
    pub photo: PathBuf,
    /// Its width, pixels.
    pub width: usize,
    /// Its height, pixels.
    pub height: usize,
    /// Scene radiance per unit of linear pixel value, by channel.
    pub exposure: [f32; 3],
    /// Its photometric parameters, if they were unknown.
    pub photograph: Option<PhotographEntry>,
    /// The lights that were off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights_off: Vec<String>,
    /// How the model was registered with it.
    pub registration: RegistrationEntry,
    /// How many of its pixels were used, and how many were not, by reason.
    pub pixels: LeftOut,
    /// Its pictures.
    pub pictures: Pictures,
}

/// The pictures of a run, as paths relative to `run.json`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Pictures {
    /// The photograph, developed, sRGB.
    pub photo: String,
    /// The re-rendering, sRGB as the photograph.
    pub rerendered: String,
    /// Which pixels were used.
    pub trust: String,
    /// Every group in its `map_color`, black where there is none.
    pub groups: String,
    /// Where photograph and re-rendering differ.
    pub errors: Vec<ErrorPicture>,
    /// How far they differ; left out in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difference: Option<DifferenceEntry>,
    /// Whether noise was removed from the re-rendering that is shown.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub denoised: bool,
}

/// How far a re-rendering is from its photograph.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct DifferenceEntry {
    /// The root mean square of the smoothed difference of luminances without that of noise, as a share of the
    /// photograph's mean; zero where noise explains all.
    pub beyond_noise: f64,
    /// That of the noise of both pictures.
    pub noise: f64,
    /// The share, 0 to 1, of the pixels that were compared.
    pub compared: f64,
    /// A picture of the values: code 128 plus 127 times the signed root of the difference, as a share of the
    /// photograph's mean, at most one; zero where pixels were not compared.
    pub values: String,
}

/// A picture of the difference of luminances, averaged over some pixels to each side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorPicture {
    /// The file.
    pub file: String,
    /// Whether its values have a sign (too bright or too dark); otherwise they are absolute.
    pub signed: bool,
    /// The unit of its values.
    pub unit: Unit,
    /// Pixels to each side in the average.
    pub reach: usize,
    /// The colour bar, evenly spaced from left to right. Values beyond its ends have the ends'
    /// colours.
    pub bar: Vec<Stop>,
}

/// The unit of the values of an error picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// A share of the photograph's mean luminance.
    Share,
    /// W sr^-1 m^-2, luminance.
    Radiance,
    /// Standard deviations of the noise of photograph and re-rendering.
    Noise,
}

/// A place on a colour bar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    /// The value there.
    pub value: f32,
    /// Its colour, `#rrggbb`.
    pub color: String,
}
