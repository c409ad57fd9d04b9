//! Photographs to linear radiance, with a valid mask, and camera calibration.
//!
//! The camera maps radiance to pixel values (digital numbers) by a transfer function. [`develop`]
//! inverts it ([`Transfer`]): black level, [`Response`], exposure, [vignetting]. The valid mask
//! excludes clipped pixels, which are a lower bound only, with their neighbours, to which charge
//! may have spread; and pixels in the noise near black, whose mean is biased ([`dark`]).
//!
//! [`bracket`](mod@bracket) merges photographs of several exposures into one picture of linear values, with
//! the camera's response from the photographs themselves.
//!
//! [`calibrate`](mod@calibrate) finds pose, focal length and lens of the camera from measured
//! points.
//!
//! Sources are cited by the keys of `docs/bibliography.md`.

mod binned;
pub mod bracket;
pub mod calibrate;
pub mod clipping;
mod curve;
pub mod dark;
mod declared;
pub mod response;
mod transfer;
pub mod vignetting;

pub use binned::squares;
pub use curve::Curve;
pub use declared::{choose_response, declared_response};
pub use response::{Response, UnknownResponse};
pub use transfer::Transfer;
pub use vignetting::Vignetting;

use serde::{Deserialize, Serialize};
use unrender_scene::{Image, Merged, Picture, Rgb, RgbImage};

/// Scene radiance per unit of linear pixel value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Exposure {
    /// Known, by channel.
    Fixed(Rgb),
    /// Unknown: estimated from a group of known reflectance.
    Auto,
}

impl Exposure {
    /// The exposure to develop with: the fixed one, or one where it is unknown.
    pub fn or_one(self) -> Rgb {
        match self {
            Self::Fixed(exposure) => exposure,
            Self::Auto => Rgb::ONE,
        }
    }
}

/// A developed photograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Photo {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
    /// The valid mask: false where a channel is clipped, beside such a pixel, in the noise near
    /// black, and where the file has no measurement.
    pub valid: Image<bool>,
    /// True for pixels with a clipped channel: their radiance is a lower bound.
    pub saturated: Image<bool>,
    /// The number of pixels with a clipped channel, without their neighbours.
    pub clipped: usize,
    /// The number of pixels in the noise near black.
    pub dark: usize,
    /// The quantisation step: the radiance between adjacent pixel values; zero for floating-point
    /// files. Quantisation has the variance step^2 / 12; a picture that was merged from a bracket has a step
    /// here whose variance is that of the merged value.
    pub quantisation_step: RgbImage,
}

/// Converts the pixel values of `picture` to radiance by the inverse of `transfer`.
///
/// ```
/// use unrender_photo::{Response, Transfer, develop};
/// use unrender_scene::{Depth, Image, Picture, Rgb};
///
/// // Eight bits with a gamma of 2: half of the code is a quarter of the radiance of white.
/// let codes = Image::new(1, 1, vec![Rgb::splat(0.5)]);
/// let transfer = Transfer::plain(Response::Gamma(2.0), Rgb::splat(8.0));
/// let photo = develop(&Picture::new(codes, Depth::Eight), &transfer);
/// assert!((photo.radiance.at(0, 0).x - 2.0).abs() < 1e-6);
/// assert!(*photo.valid.at(0, 0));
/// ```
pub fn develop(picture: &Picture, transfer: &Transfer) -> Photo {
    let shares = transfer.vignetting.as_ref().map(Vignetting::picture);
    let share = |index: usize| shares.as_ref().map_or(1.0, |shares| shares.pixels()[index]);
    let per_pixel = |f: &dyn Fn(Rgb, f32) -> Rgb| {
        let codes = picture.values.pixels().iter().enumerate();
        let values = codes.map(|(index, code)| f(*code, share(index))).collect();
        RgbImage::new(picture.values.width(), picture.values.height(), values)
    };
    let radiance = per_pixel(&|code, share| transfer.radiance(code, share));
    let quantisation_step = match (picture.depth.max_code(), &picture.merged) {
        (Some(max_code), _) => per_pixel(&|code, share| transfer.step(code, 1.0 / max_code, share)),
        (None, Some(merged)) => merged_step(merged, transfer, &share),
        (None, None) => per_pixel(&|_, _| Rgb::ZERO),
    };
    let clipped = clipping::clipped_pixels(picture, transfer);
    let dark = dark::dark_pixels(picture, transfer.floor());
    let mut valid = clipping::away_from(&picture.values, &clipped);
    for &index in picture.invalid.iter().chain(&dark) {
        valid.pixels_mut()[index] = false;
    }
    let mut saturated = picture.values.map(|_| false);
    clipped.iter().for_each(|&index| saturated.pixels_mut()[index] = true);
    let (clipped, dark) = (clipped.len(), dark.len());
    Photo { radiance, valid, saturated, clipped, dark, quantisation_step }
}

/// The step whose variance as a quantisation, step^2 / 12, is that of the merged values.
fn merged_step(merged: &Merged, transfer: &Transfer, share: &dyn Fn(usize) -> f32) -> RgbImage {
    let step = |(index, variance): (usize, &Rgb)| {
        transfer.spread((12.0 * *variance).map(f32::sqrt), share(index))
    };
    let steps = merged.variance.pixels().iter().enumerate().map(step).collect();
    RgbImage::new(merged.variance.width(), merged.variance.height(), steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::Depth;
    use unrender_scene::color::srgb_from_linear;

    fn picture(depth: Depth, values: Vec<Rgb>) -> Picture {
        let width = values.len();
        Picture::new(Image::new(width, 1, values), depth)
    }

    #[test]
    fn developing_inverts_the_camera() {
        let radiance = Rgb::new(0.02, 0.3, 0.9);
        let exposure = Rgb::new(2.0, 1.0, 0.5);
        let in_file = (radiance / exposure).to_array();
        let check = |response: Response, encode: &dyn Fn(f32) -> f32| {
            let code = Rgb::from_array(in_file.map(encode));
            let photo = develop(
                &picture(Depth::Float, vec![code]),
                &Transfer::plain(response.clone(), exposure),
            );
            let back = photo.radiance.pixels()[0];
            assert!((back - radiance).abs().max_element() < 1e-5, "{response:?}: {back}");
        };
        check(Response::Linear, &|v| v);
        check(Response::Gamma(2.2), &|v| v.powf(1.0 / 2.2));
        let code = Rgb::from_array([0.01, 0.3, 0.9].map(srgb_from_linear));
        let photo =
            develop(&picture(Depth::Eight, vec![code]), &Transfer::plain(Response::Srgb, Rgb::ONE));
        assert!((photo.radiance.pixels()[0] - Rgb::new(0.01, 0.3, 0.9)).length() < 1e-5);
    }

    #[test]
    fn clipped_pixels_and_their_neighbours_are_not_valid() {
        let mut values = vec![Rgb::splat(0.5); 8];
        values[1].y = 1.0;
        let mut integer = picture(Depth::Eight, values.clone());
        integer.invalid.push(6);
        let photo = develop(&integer, &Transfer::plain(Response::Srgb, Rgb::ONE));
        assert_eq!(photo.clipped, 1);
        let expected = [false, false, false, true, true, true, false, true];
        assert_eq!(photo.valid.pixels(), expected);
        let saturated = [false, true, false, false, false, false, false, false];
        assert_eq!(photo.saturated.pixels(), saturated);
        let float =
            develop(&picture(Depth::Float, values), &Transfer::plain(Response::Linear, Rgb::ONE));
        assert!(float.clipped == 0 && float.valid.pixels().iter().all(|t| *t));
    }

    #[test]
    fn the_quantisation_step_is_the_distance_between_neighbouring_pixel_values() {
        for code in 1..255u8 {
            let at = |code: u8| Rgb::splat(f32::from(code) / 255.0);
            let values = vec![at(code - 1), at(code), at(code + 1)];
            let photo = develop(
                &picture(Depth::Eight, values),
                &Transfer::plain(Response::Srgb, Rgb::splat(3.0)),
            );
            let [before, _, after] = [0, 1, 2].map(|i| photo.radiance.pixels()[i].x);
            let step = photo.quantisation_step.pixels()[1].x;
            assert!((step / (0.5 * (after - before)) - 1.0).abs() < 0.02, "code {code}");
        }
        let values = vec![Rgb::splat(0.5)];
        let photo = develop(
            &picture(Depth::Sixteen, values.clone()),
            &Transfer::plain(Response::Linear, Rgb::ONE),
        );
        assert!((photo.quantisation_step.pixels()[0].x - 1.0 / 65535.0).abs() < 1e-9);
        let photo =
            develop(&picture(Depth::Float, values), &Transfer::plain(Response::Linear, Rgb::ONE));
        assert_eq!(photo.quantisation_step.pixels()[0], Rgb::ZERO);
    }
}
