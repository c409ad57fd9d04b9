//! Pictures: photographs, textures and renderings as PNG, JPEG, TIFF, EXR and HDR files.
//!
//! [`read`] hands out the code values of the file, not yet radiance: `unrender-photo` knows what
//! the camera did to them. The writers take linear values.

mod budget;
mod embed;
mod exif;
mod jpeg_end;
mod panorama;
mod profile;
mod read;
mod write;

pub(crate) use budget::check as check_budget;
pub use embed::{jpeg_bytes, png_bytes};
pub use exif::exif_focal_px;
pub use panorama::read_environment;
pub use profile::Profile;
pub(crate) use read::read_in;
pub use read::{decode, read};
pub use write::{write, write_exr, write_hdr, write_png_codes, write_png_srgb};

use unrender_scene::{Image, Rgb};

/// What one channel of one pixel was stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// An integer of 8 bits; the codes 0 to 255 became 0 to 1.
    Eight,
    /// An integer of 16 bits; the codes 0 to 65535 became 0 to 1.
    Sixteen,
    /// A floating-point number, passed on as it is.
    Float,
}

impl Depth {
    /// The greatest code of an integer file; nothing for floating-point files.
    pub fn max_code(self) -> Option<f32> {
        match self {
            Self::Eight => Some(255.0),
            Self::Sixteen => Some(65535.0),
            Self::Float => None,
        }
    }
}

/// A picture as its file has it, turned upright.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Code values: 0 to 1 in the file's own encoding for integer files, as stored (by custom
    /// linear) for floating-point files. All are finite.
    pub values: Image<Rgb>,
    /// What the values were stored as.
    pub depth: Depth,
    /// Indices of the pixels that were not finite numbers in the file; `values` has zeros there.
    pub invalid: Vec<usize>,
    /// What the file declares of its colours, if it does.
    pub profile: Option<Profile>,
}

impl Picture {
    /// A picture of finite code values.
    pub fn new(values: Image<Rgb>, depth: Depth) -> Self {
        Self { values, depth, invalid: Vec::new(), profile: None }
    }

    /// The picture as linear values, where integer files are taken as sRGB and floating-point
    /// files as linear already.
    pub fn to_linear(&self) -> Image<Rgb> {
        match self.depth {
            Depth::Float => self.values.clone(),
            Depth::Eight | Depth::Sixteen => self.values.map(|code| {
                Rgb::from_array(code.to_array().map(unrender_scene::color::linear_from_srgb))
            }),
        }
    }
}
