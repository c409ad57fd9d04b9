//! The pictures of a run, and what the colours of the false ones mean.

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
    /// The camera's numbers, where they were asked for.
    pub photograph: Option<PhotographEntry>,
    /// The lights that were off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights_off: Vec<String>,
    /// How the model was registered with it.
    pub registration: RegistrationEntry,
    /// How many of its pixels counted, and how many did not, by reason.
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
    /// Which pixels counted.
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
    /// Whether it tells too bright from too dark; else it has the absolute value.
    pub signed: bool,
    /// What its numbers count.
    pub unit: Unit,
    /// Pixels to each side in the average.
    pub reach: usize,
    /// The colour bar, evenly spaced from left to right. Values beyond its ends have the ends'
    /// colours.
    pub bar: Vec<Stop>,
}

/// What the numbers of an error picture count.
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
