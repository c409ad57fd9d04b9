//! The colours that a picture file declares: an ICC profile (PNG, JPEG, BMP, TIFF), the chunks `cICP`, `gAMA` and
//! `cHRM` of PNG, the header of Radiance, tags of TIFF, or the EXIF data's code for Adobe RGB.
//!
//! Profiles of three primaries and three curves are understood; those made of tables are not. The declarations of
//! EXR are read with its channels.

use super::curves::sampled;
use super::exif::is_adobe_rgb;
use super::primaries::{matrix, of_primaries};
use super::tiff::{self, Directory, Tiff};
use super::{bmp, cicp, icc, png_chunks, tiff_says};
use glam::Mat3;
use image::ImageFormat;
use std::io::Cursor;
use unrender_scene::Profile;

/// The `gAMA` that writers of sRGB pictures give.
const GAMMA_OF_SRGB: f32 = 0.454_55;

/// The profile that the file `bytes` declares; `icc` is its ICC profile, if any, and `tiff` the page, if it
/// is a TIFF.
///
/// # Errors
/// If its codes do not represent scene light.
pub(super) fn of(
    bytes: &[u8],
    format: ImageFormat,
    icc: Option<&[u8]>,
    tiff: Option<(&Tiff<'_>, &Directory)>,
) -> Result<Option<Profile>, String> {
    // The order of precedence in PNG: cICP, iCCP, sRGB, and then gAMA and cHRM.
    if format == ImageFormat::Png
        && let Some(data) = png_chunks::find(bytes, &png_chunks::CICP)
    {
        return cicp::profile(data).map(Some);
    }
    // The decoder of TIFF passes over profiles that are not small beside the pixels.
    let of_page = tiff.and_then(|(tiff, page)| tiff.bytes(page, tiff::tag::ICC_PROFILE));
    if let Some(icc) = of_page.or(icc) {
        return Ok(Some(icc::profile(icc)));
    }
    let stated = tiff.and_then(|(tiff, page)| tiff_says::profile(tiff, page));
    Ok(match format {
        ImageFormat::Png => of_png(bytes),
        ImageFormat::Bmp => bmp::profile(bytes),
        _ if stated.is_some() => stated,
        ImageFormat::Jpeg | ImageFormat::Tiff if is_adobe_rgb(bytes) => {
            Some(icc::adobe_rgb("its EXIF data (Adobe RGB)"))
        }
        _ => None,
    })
}

fn of_png(bytes: &[u8]) -> Option<Profile> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() || (info.gama_chunk.is_none() && info.chrm_chunk.is_none()) {
        return None;
    }
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_value);
    let gamma = gamma.filter(|g| *g > 0.05 && (g - GAMMA_OF_SRGB).abs() > 1e-3);
    let primaries = info.chrm_chunk.map(|chrm| {
        let of = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x.into_value(), y.into_value()];
        matrix([of(chrm.red), of(chrm.green), of(chrm.blue), of(chrm.white)])
    });
    let curves = gamma.map(|gamma: f32| {
        let curve = sampled(|code| code.powf(1.0 / gamma));
        [curve.clone(), curve.clone(), curve]
    });
    let primaries = primaries.unwrap_or(Some(Mat3::IDENTITY));
    Some(Profile { curves, ..of_primaries(primaries, "its chunks gAMA and cHRM") })
}
