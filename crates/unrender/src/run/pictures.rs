//! The pictures of a run, and what the colours of the false ones mean.

use serde::{Deserialize, Serialize};

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
