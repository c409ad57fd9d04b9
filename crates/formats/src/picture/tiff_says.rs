//! What the tags of a TIFF page say of its numbers: kind, coverage, missing values, colours.

use super::curves::{DARKEST_STEP, SAMPLES};
use super::primaries::{Corners, matrix, of_primaries};
use super::tiff::{Directory, Tiff, tag};
use unrender_scene::Profile;

/// The white of sRGB, for files that state primaries alone.
const D65: [f32; 2] = [0.3127, 0.3290];
/// The primaries of sRGB, for files that state a white alone.
const SRGB: [f32; 6] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06];

/// The error of a kind of numbers that is not read, as the end of a sentence about the file.
pub(super) fn unread(tiff: &Tiff<'_>, page: &Directory) -> Option<String> {
    let bits = tiff.code(page, tag::BITS).unwrap_or(1);
    let is_float = tiff.code(page, tag::SAMPLE_FORMAT) == Some(3);
    (is_float && bits != 32).then(|| {
        format!(
            "has floating-point numbers of {bits} bits, which are not read; save it with 32 bits, or as an EXR"
        )
    })
}

/// A description of the page, for files that the decoder does not know.
pub(super) fn kind(tiff: &Tiff<'_>, page: &Directory) -> String {
    let code = |tag| tiff.code(page, tag).unwrap_or(0);
    let format = match code(tag::SAMPLE_FORMAT) {
        2 => "signed whole numbers",
        3 => "floating-point numbers",
        5 | 6 => "complex numbers",
        _ => "whole numbers",
    };
    let colours = match code(tag::PHOTOMETRIC) {
        0 | 1 => "grey",
        2 => "RGB",
        3 => "a palette",
        4 => "a mask",
        5 => "CMYK",
        6 => "YCbCr",
        8..=10 => "CIE L*a*b*",
        32_844 | 32_845 => "LogLuv",
        _ => "unknown colours",
    };
    format!(
        "{colours}, {} channel(s) of {format} of {} bits, compression {}",
        code(tag::SAMPLES).max(1),
        tiff.code(page, tag::BITS).unwrap_or(1),
        code(tag::COMPRESSION).max(1)
    )
}

/// Whether the file declares the channel after the colours as coverage.
pub(super) fn has_coverage(tiff: &Tiff<'_>, page: &Directory) -> bool {
    matches!(tiff.code(page, tag::EXTRA_SAMPLES), Some(1 | 2))
}

/// Whether its colours are those of four inks.
pub(super) fn has_inks(tiff: &Tiff<'_>, page: &Directory) -> bool {
    tiff.code(page, tag::PHOTOMETRIC) == Some(5)
}

/// The note about channels beside the colours that the file does not declare as coverage.
pub(super) fn other_channels(tiff: &Tiff<'_>, page: &Directory) -> Option<String> {
    let is_other = page.has(tag::EXTRA_SAMPLES) && !has_coverage(tiff, page);
    is_other.then(|| "a channel beside the colours, not declared as alpha, was ignored".into())
}

/// The number that stands for a missing value (GDAL_NODATA), as the decoder returns it.
pub(super) fn no_data(tiff: &Tiff<'_>, page: &Directory) -> Option<f64> {
    let number: f64 = tiff.text(page, tag::NO_DATA)?.parse().ok()?;
    let is_inverted = tiff.code(page, tag::PHOTOMETRIC) == Some(0);
    let bits = tiff.code(page, tag::BITS).unwrap_or(1).min(32);
    let is_float = tiff.code(page, tag::SAMPLE_FORMAT) == Some(3);
    let max = ((1u64 << bits) - 1) as f64;
    Some(if is_inverted && !is_float { max - number } else { number })
}

/// How many times as wide as high its pixels are.
pub(super) fn pixel_aspect(tiff: &Tiff<'_>, page: &Directory) -> Option<f64> {
    let across = tiff.number(page, tag::X_RESOLUTION, 0)?;
    let down = tiff.number(page, tag::Y_RESOLUTION, 0)?;
    Some(down / across)
}

/// The primaries and curves that it states without an ICC profile.
pub(super) fn profile(tiff: &Tiff<'_>, page: &Directory) -> Option<Profile> {
    let curves = curves(tiff, page);
    let stated = [tag::PRIMARIES, tag::WHITE_POINT].iter().any(|tag| page.has(*tag));
    if !stated && curves.is_none() {
        return None;
    }
    let of = |tag, index, else_| tiff.number(page, tag, index).map_or(else_, |n| n as f32);
    let primary = |k: usize| [0, 1].map(|c| of(tag::PRIMARIES, 2 * k + c, SRGB[2 * k + c]));
    let white = [0, 1].map(|c| of(tag::WHITE_POINT, c, D65[c]));
    let corners: Corners = [primary(0), primary(1), primary(2), white];
    let source = "its tags PrimaryChromaticities, WhitePoint and TransferFunction";
    let profile = of_primaries(matrix(corners), source);
    let grows = |curve: &Vec<f32>| curve.windows(2).all(|w| w[0] < w[1]);
    let understood = profile.understood && curves.as_ref().is_none_or(|c| c.iter().all(grows));
    if understood {
        return Some(Profile { curves, ..profile });
    }
    Some(Profile { srgb_from_file: None, understood, ..profile })
}

/// The linear values of the codes by TransferFunction: a table for each channel, or one for all.
fn curves(tiff: &Tiff<'_>, page: &Directory) -> Option<[Vec<f32>; 3]> {
    let bits = tiff.code(page, tag::BITS).filter(|bits| (1..=16).contains(bits))?;
    let (codes, count) = (1usize << bits, tiff.count(page, tag::TRANSFER_FUNCTION));
    let tables = if count >= 3 * codes { 3 } else { 1 };
    if count < codes {
        return None;
    }
    let value = |channel: usize, k: u16| {
        let at = (f64::from(k) / f64::from(SAMPLES - 1) * (codes - 1) as f64).round() as usize;
        let index = channel.min(tables - 1) * codes + at;
        let linear = tiff.number(page, tag::TRANSFER_FUNCTION, index)? / 65_535.0;
        // The darkest codes are rounded to the same number, but curves must grow.
        Some((linear + DARKEST_STEP * f64::from(k)) as f32)
    };
    let curve = |channel| (0..SAMPLES).map(|k| value(channel, k)).collect::<Option<Vec<f32>>>();
    Some([curve(0)?, curve(1)?, curve(2)?])
}
