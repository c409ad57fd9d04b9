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
