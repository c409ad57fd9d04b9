//! Pictures as their files have them: code values, how they were stored, and what the file declares
//! of its colours. `unrender-formats` reads them, `unrender-photo` makes radiance of them.

use crate::{Image, Rgb};
use glam::Mat3;
use serde::{Deserialize, Serialize};

/// How one channel of one pixel was stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Depth {
    /// An integer of 8 bits; the codes 0 to 255 became 0 to 1.
    Eight,
    /// An integer of 16 bits; the codes 0 to 65535 became 0 to 1.
    Sixteen,
    /// A floating-point number, passed on as it is.
    Float,
}

impl Depth {
    /// The greatest code of an integer file; none for floating-point files.
    pub fn max_code(self) -> Option<f32> {
        match self {
            Self::Eight => Some(255.0),
            Self::Sixteen => Some(65535.0),
            Self::Float => None,
        }
    }
}

/// A picture as its file has it, turned upright.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Code values: 0 to 1 in the file's own encoding for integer files, as stored (by custom
    /// linear) for floating-point files. All are finite.
    pub values: Image<Rgb>,
    /// How the values were stored.
    pub depth: Depth,
    /// Indices, in ascending order, of the pixels without a measurement: those that the file does not hold, or calls
    /// missing or transparent, or that are not finite. `values` has zeros where the file has no finite number, else
    /// what the file has. A photograph leaves these pixels out; textures and panoramas take the values.
    pub invalid: Vec<usize>,
    /// What the file declares of its colours, if it does.
    pub profile: Option<Profile>,
    /// Whether its format has linear values, as EXR and HDR do: no response need be stated then.
    pub is_linear: bool,
    /// What is known of the values of a picture that was merged from a bracket of exposures.
    pub merged: Option<Merged>,
}

/// What is known of the linear values of a picture that was merged from a bracket of exposures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Merged {
    /// The variance of every value, in squares of the picture's unit; finite and not negative.
    pub variance: Image<Rgb>,
    /// The value from which a channel is clipped in the shortest exposure. Infinite where nothing is clipped.
    pub white_level: Rgb,
}

impl Picture {
    /// A picture of finite code values.
    pub fn new(values: Image<Rgb>, depth: Depth) -> Self {
        Self { values, depth, invalid: Vec::new(), profile: None, is_linear: false, merged: None }
    }

    /// For each pixel, whether it has a measurement.
    pub fn measured(&self) -> Image<bool> {
        let mut measured = self.values.map(|_| true);
        self.invalid.iter().for_each(|&index| measured.pixels_mut()[index] = false);
        measured
    }

    /// The picture with left and right exchanged.
    #[must_use]
    pub fn mirrored(self) -> Self {
        let width = self.values.width();
        let across = |index: &usize| index - index % width + (width - 1 - index % width);
        let mut invalid: Vec<usize> = self.invalid.iter().map(across).collect();
        invalid.sort_unstable();
        let merged = |merged: Merged| Merged { variance: merged.variance.mirrored(), ..merged };
        Self { values: self.values.mirrored(), invalid, merged: self.merged.map(merged), ..self }
    }

    /// The picture as linear values, where integer files are taken as sRGB, whatever they declare, and
    /// floating-point files as linear already, with the primaries that they declare.
    pub fn to_linear(&self) -> Image<Rgb> {
        let srgb_from_file = self.profile.as_ref().and_then(|profile| profile.srgb_from_file);
        match (self.depth, srgb_from_file) {
            (Depth::Float, None) => self.values.clone(),
            (Depth::Float, Some(srgb_from_file)) => {
                self.values.map(|value| srgb_from_file * *value)
            }
            (Depth::Eight | Depth::Sixteen, _) => self
                .values
                .map(|code| Rgb::from_array(code.to_array().map(crate::color::linear_from_srgb))),
        }
    }
}

/// What a picture file declares of its colours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Where it says so, for messages: `its ICC profile "Display P3"`.
    pub source: String,
    /// Linear sRGB from the file's linear values; none if its primaries are those of sRGB.
    pub srgb_from_file: Option<Mat3>,
    /// The linear values of the codes 0, 1/255, 2/255 ... 1, by channel, where the file states them.
    pub curves: Option<[Vec<f32>; 3]>,
    /// False if there is a profile of a kind that is not understood; then primaries and curves are empty.
    pub understood: bool,
    /// The ICC profile itself, if the file has one for codes of red, green and blue.
    pub icc: Option<Vec<u8>>,
}
