//! The developed photograph for composites.

use unrender_formats::picture::{self, Picture};
use unrender_photo::{Photo, Response, Transfer, declared_response};
use unrender_scene::{Camera, Rgb};

/// The photograph, and the camera that took it.
#[derive(Debug)]
pub struct Photograph {
    /// The code values of the file.
    pub picture: Picture,
    /// The photograph as radiance.
    pub photo: Photo,
    /// The transfer function between radiance and its code values.
    pub transfer: Transfer,
    /// The camera.
    pub camera: Camera,
}

impl Photograph {
    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.picture.values.width(), self.picture.values.height())
    }

    /// The ICC profile of its codes: that of its file, or, where the file has none or the project states another
    /// response, one of the response and the primaries that were taken. None for plain sRGB.
    ///
    /// # Errors
    /// If the profile cannot be encoded.
    pub fn icc(&self) -> Result<Option<Vec<u8>>, String> {
        let Transfer { response, black_level, srgb_from_file, .. } = &self.transfer;
        let from_black = *black_level == Rgb::ZERO;
        if let Some(profile) = &self.picture.profile
            && let Some(icc) = &profile.icc
        {
            let is_taken = || from_black && declared_response(profile).as_ref() == Some(response);
            if !profile.understood || is_taken() {
                return Ok(Some(icc.clone()));
            }
        }
        if from_black && *response == Response::Srgb && srgb_from_file.is_none() {
            return Ok(None);
        }
        let linear = |channel, code: f32| {
            let black = black_level[channel];
            response.linear_from_code(channel, (code - black) / (1.0 - black))
        };
        picture::icc_profile("The photograph's encoding", linear, *srgb_from_file).map(Some)
    }
}
