//! Writes linear pictures: 8-bit sRGB PNG, and EXR and HDR with the linear values.
//!
//! Values that are not finite become zero in the file and are counted, so that one pixel does not
//! spoil a long rendering.

use super::colour_space::{ColourSpace, declared};
use super::primaries::corners;
use super::{Depth, one_layer};
use crate::{FileError, atomic};
use glam::Mat3;
use image::codecs::hdr::HdrEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::RgbImage;
use unrender_scene::color::srgb_from_linear;

/// Why an HDR file has no other primaries.
pub const HDR_OF_REC709: &str = "an .hdr file cannot say its colour space, and has that of Rec. 709; end the name in .exr, \
                                 or leave out --colour-space";

/// Writes `picture` in the format of `path`'s extension: png (8-bit sRGB), exr or hdr (linear).
///
/// Returns how many values were not finite and were written as zero.
///
/// ```
/// use unrender_formats::picture;
/// use unrender_scene::{Image, Rgb};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("picture.exr");
/// let radiance = Image::new(2, 1, vec![Rgb::splat(0.25), Rgb::splat(40.0)]);
/// assert_eq!(picture::write(&path, &radiance)?, 0);
/// let (back, _) = picture::read(&path)?;
/// assert_eq!(back.to_linear(), radiance);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the extension is another one or the file cannot be written.
pub fn write(path: &Path, picture: &RgbImage) -> Result<usize, FileError> {
    write_in(path, picture, ColourSpace::LinRec709)
}

/// As [`write()`], with the values of `space` in an EXR. A PNG is sRGB in any case; an HDR cannot say its primaries, and has
/// those of Rec. 709.
///
/// # Errors
/// If the extension is another one, the format has no such space, or the file cannot be written.
pub fn write_in(path: &Path, picture: &RgbImage, space: ColourSpace) -> Result<usize, FileError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "png" => write_png_srgb(path, picture),
        "exr" => write_exr_in(path, picture, space),
        "hdr" if space != ColourSpace::LinRec709 => Err(FileError::new(path, HDR_OF_REC709)),
        "hdr" => write_hdr(path, picture),
        _ => {
            Err(FileError::new(path, "no such picture format; end the name in .exr, .hdr or .png"))
        }
    }
}

/// Writes linear `picture` as an 8-bit sRGB PNG; returns how many values were not finite.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png_srgb(path: &Path, picture: &RgbImage) -> Result<usize, FileError> {
    let (values, bad) = finite_values(picture);
    let codes: Vec<u8> =
        values.iter().map(|&v| (255.0 * srgb_from_linear(v)).round() as u8).collect();
    encode(path, picture, |out, width, height| {
        PngEncoder::new(out).write_image(&codes, width, height, ExtendedColorType::Rgb8)
    })?;
    Ok(bad)
}

/// Writes code values, 0 to 1 in the file's own encoding, as a PNG of `depth`: the inverse of
/// [`read`](super::read). Floating-point numbers are written with 16 bits. Returns how many values
/// were not finite.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png_codes(path: &Path, codes: &RgbImage, depth: Depth) -> Result<usize, FileError> {
    write_png_as(path, codes, depth, None)
}

/// As [`write_png_codes`], with the ICC profile of the codes, unless they are those of sRGB.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png_as(
    path: &Path,
    codes: &RgbImage,
    depth: Depth,
    icc: Option<&[u8]>,
) -> Result<usize, FileError> {
    let (values, bad) = finite_values(codes);
    let code = |value: f32, max: f32| (max * value.clamp(0.0, 1.0)).round();
    let (bytes, kind): (Vec<u8>, _) = match depth {
        Depth::Eight => {
            (values.iter().map(|&v| code(v, 255.0) as u8).collect(), ExtendedColorType::Rgb8)
        }
        Depth::Sixteen | Depth::Float => {
            let words = values.iter().map(|&v| code(v, 65535.0) as u16);
            (words.flat_map(u16::to_ne_bytes).collect(), ExtendedColorType::Rgb16)
        }
    };
    encode(path, codes, |out, width, height| {
        let mut encoder = PngEncoder::new(out);
        if let Some(icc) = icc {
            encoder.set_icc_profile(icc.to_vec()).map_err(image::ImageError::Unsupported)?;
        }
        encoder.write_image(&bytes, width, height, kind)
    })?;
    Ok(bad)
}

/// Writes `picture` as an EXR of 32-bit floats, which says that it has the primaries of Rec. 709; returns how many values
/// were not finite.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr(path: &Path, picture: &RgbImage) -> Result<usize, FileError> {
    write_exr_in(path, picture, ColourSpace::LinRec709)
}

/// As [`write_exr`], with the values of `space`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr_in(
    path: &Path,
    picture: &RgbImage,
    space: ColourSpace,
) -> Result<usize, FileError> {
    one_layer::write(path, &space.of(picture), space, |_, _| ())
}

/// As [`write_exr`], of linear values whose matrix to those of sRGB is `srgb_from_file`; none for sRGB.
///
/// # Errors
/// If the file cannot be written.
pub fn write_exr_as(
    path: &Path,
    values: &RgbImage,
    srgb_from_file: Option<Mat3>,
) -> Result<usize, FileError> {
    let Some(corners) = srgb_from_file.and_then(corners) else { return write_exr(path, values) };
    one_layer::write(path, values, ColourSpace::LinRec709, |shared, _| {
        shared.chromaticities = Some(declared(corners));
    })
}

/// Writes `picture` as a Radiance HDR (8 bits and a common exponent a pixel, no negative values);
/// returns how many values were not finite.
///
/// # Errors
/// If the file cannot be written.
pub fn write_hdr(path: &Path, picture: &RgbImage) -> Result<usize, FileError> {
    let (values, bad) = finite_values(picture);
    let pixels: Vec<image::Rgb<f32>> = values
        .chunks_exact(3)
        .map(|rgb| image::Rgb([rgb[0].max(0.0), rgb[1].max(0.0), rgb[2].max(0.0)]))
        .collect();
    encode(path, picture, |out, width, height| {
        HdrEncoder::new(out).encode(&pixels, width as usize, height as usize)
    })?;
    Ok(bad)
}

/// All channels of all pixels, with zeros for what is not finite, and the number of those.
fn finite_values(picture: &RgbImage) -> (Vec<f32>, usize) {
    let mut bad = 0;
    let values = picture.pixels().iter().flat_map(|rgb| rgb.to_array()).map(|value| {
        if value.is_finite() {
            value
        } else {
            bad += 1;
            0.0
        }
    });
    (values.collect(), bad)
}

fn encode(
    path: &Path,
    picture: &RgbImage,
    encoder: impl FnOnce(&mut Cursor<Vec<u8>>, u32, u32) -> ImageResult<()>,
) -> Result<(), FileError> {
    let size = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
    let (Some(width), Some(height)) = (size(picture.width()), size(picture.height())) else {
        return Err(FileError::new(path, "a picture without pixels cannot be written"));
    };
    let mut out = Cursor::new(Vec::new());
    encoder(&mut out, width, height)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    atomic::write(path, out.get_ref())
}
