//! Reads a picture file into code values.

use super::{Depth, Picture, budget, jpeg_end, merged, profile};
use crate::FileError;
use crate::input::{Input, Scope};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::{Image, Rgb, Warnings};

/// More pixels than any camera has today; beyond it a header is taken to be corrupt.
const MAX_PIXELS: u64 = 1 << 28;

/// No decoder here unpacks a byte of a file to more bytes than this.
pub(super) const MAX_UNPACKING: u64 = 4096;

/// Files that claim less than this are plausible whatever their size.
pub(super) const ALWAYS_BELIEVED_BYTES: u64 = 64 << 20;

/// Reads the picture at `path` and turns it upright as its EXIF orientation says.
///
/// The content decides on the format, not the extension.
///
/// # Errors
/// If the file is missing, cut short, corrupt, or of a kind that is not read.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Picture, Warnings), FileError> {
    let input = input.into();
    read_in(&Scope::new(input), input.path)
}

/// As [`read`], as a file that the input of `scope` is or names.
pub(crate) fn read_in(scope: &Scope, path: &Path) -> Result<(Picture, Warnings), FileError> {
    let bytes = scope.read(path).map_err(|problem| FileError::new(path, problem))?;
    decode_in(scope, &bytes, path)
}

/// As [`read`], from the bytes of a file; `path` only names it in messages.
///
/// # Errors
/// If the bytes are cut short, corrupt, or of a kind that is not read.
pub fn decode(bytes: &[u8], path: &Path) -> Result<(Picture, Warnings), FileError> {
    decode_in(&Scope::new(Input::from(path)), bytes, path)
}

fn decode_in(scope: &Scope, bytes: &[u8], path: &Path) -> Result<(Picture, Warnings), FileError> {
    let format = format_of(bytes)
        .ok_or_else(|| FileError::new(path, "is not a PNG, JPEG, TIFF, EXR or HDR file"))?;
    if format == ImageFormat::Jpeg && !jpeg_end::has_end(bytes) {
        return Err(FileError::new(path, "is cut short: the end of the JPEG data is missing"));
    }
    let (decoded, icc) =
        pixels_of(scope, bytes, format).map_err(|problem| FileError::new(path, problem))?;
    let mut warnings = Warnings::default();
    if decoded.color().has_alpha() && has_transparency(&decoded) {
        warnings.push(format!("{}: the alpha channel was ignored", path.display()));
    }
    let mut picture = picture_of(&decoded);
    picture.profile = profile::of(bytes, format, icc.as_deref());
    if format == ImageFormat::OpenExr {
        put_merged(scope, &mut picture, bytes).map_err(|problem| FileError::new(path, problem))?;
    }
    if !picture.invalid.is_empty() {
        warnings.push(format!(
            "{}: {} pixel(s) are not finite numbers; they were left out",
            path.display(),
            picture.invalid.len()
        ));
    }
    Ok((picture, warnings))
}

/// Reads the variances of a merged bracket, and which pixels have no value.
fn put_merged(scope: &Scope, picture: &mut Picture, bytes: &[u8]) -> Result<(), String> {
    // All six channels as they are in the file, and the variances once more.
    let pixels = picture.values.pixels().len() as u64;
    scope.charge(pixels * 36)?;
    let Some((merged, invalid)) = merged::read_merged(bytes)? else { return Ok(()) };
    let size = |image: &Image<Rgb>| (image.width(), image.height());
    if size(&merged.variance) != size(&picture.values) {
        return Err("has variances of another size than its picture".into());
    }
    for index in invalid {
        picture.values.pixels_mut()[index] = Rgb::ZERO;
        picture.invalid.push(index);
    }
    picture.invalid.sort_unstable();
    picture.invalid.dedup();
    picture.merged = Some(merged);
    Ok(())
}

/// The format that the bytes are of, if it is one that is read.
pub(super) fn format_of(bytes: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(bytes).ok()?;
    let read = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::Tiff,
        ImageFormat::OpenExr,
        ImageFormat::Hdr,
    ];
    read.contains(&format).then_some(format)
}

/// The decoded and upright pixels and the ICC profile, or what is wrong with the file.
fn pixels_of(
    scope: &Scope,
    bytes: &[u8],
    format: ImageFormat,
) -> Result<(DynamicImage, Option<Vec<u8>>), String> {
    let name = format!("{format:?}");
    let faulty = |error: image::ImageError| fault(&name, &error);
    let mut scale = 1.0;
    if format == ImageFormat::Hdr {
        let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(faulty)?;
        // Radiance's header tells by how much the picture was multiplied after the fact.
        scale = decoder.metadata().exposure.filter(|e| e.is_finite() && *e > 0.0).unwrap_or(1.0);
    }
    budget::check(scope, bytes, Some(format))?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget::BESIDE_PIXELS);
    reader.limits(if format == ImageFormat::Png { limits } else { Limits::no_limits() });
    let mut decoder = reader.into_decoder().map_err(faulty)?;
    check_size(&decoder, bytes.len() as u64)?;
    let (width, height) = decoder.dimensions();
    // As they are in the file, and as three floats.
    let each = u64::from(decoder.color_type().bytes_per_pixel()) + 12;
    scope.charge(u64::from(width) * u64::from(height) * each).map_err(|problem| {
        format!("has {width} x {height} pixels and {problem}; or make the picture smaller")
    })?;
    let orientation = decoder.orientation().map_err(faulty)?;
    let icc = decoder.icc_profile().ok().flatten();
    let mut decoded = DynamicImage::from_decoder(decoder).map_err(faulty)?;
    decoded.apply_orientation(orientation);
    if scale != 1.0
        && let Some(rgb) = decoded.as_mut_rgb32f()
    {
        rgb.iter_mut().for_each(|value| *value /= scale);
    }
    Ok((decoded, icc))
}

fn fault(format: &str, error: &image::ImageError) -> String {
    match error {
        image::ImageError::Unsupported(_) => {
            format!("is a kind of {format} file that is not read ({error}); save it as RGB")
        }
        image::ImageError::Limits(_) => {
            "has a colour profile or texts that are too large; save it again without them".into()
        }
        _ => format!("is cut short or corrupt ({error})"),
    }
}

/// Refuses sizes that the file cannot hold, before any memory is asked for.
fn check_size(decoder: &impl ImageDecoder, file_bytes: u64) -> Result<(), String> {
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err("has no pixels".into());
    }
    let unpacked = pixels.saturating_mul(u64::from(decoder.color_type().bytes_per_pixel()));
    if pixels > MAX_PIXELS || unpacked > budget::plausible(file_bytes) {
        return Err(budget::unbelievable(width.into(), height.into(), file_bytes));
    }
    Ok(())
}

/// True if some pixel's alpha is not full; a full alpha channel says nothing worth a warning.
fn has_transparency(decoded: &DynamicImage) -> bool {
    match decoded {
        DynamicImage::ImageLumaA8(p) => p.pixels().any(|p| p.0[1] != u8::MAX),
        DynamicImage::ImageRgba8(p) => p.pixels().any(|p| p.0[3] != u8::MAX),
        DynamicImage::ImageLumaA16(p) => p.pixels().any(|p| p.0[1] != u16::MAX),
        DynamicImage::ImageRgba16(p) => p.pixels().any(|p| p.0[3] != u16::MAX),
        DynamicImage::ImageRgba32F(p) => p.pixels().any(|p| p.0[3] < 1.0),
        _ => false,
    }
}

fn picture_of(decoded: &DynamicImage) -> Picture {
    use DynamicImage as D;
    let depth = match decoded {
        D::ImageLuma8(_) | D::ImageLumaA8(_) | D::ImageRgb8(_) | D::ImageRgba8(_) => Depth::Eight,
        D::ImageLuma16(_) | D::ImageLumaA16(_) | D::ImageRgb16(_) | D::ImageRgba16(_) => {
            Depth::Sixteen
        }
        _ => Depth::Float,
    };
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let mut pixels = code_values(decoded);
    let mut invalid = Vec::new();
    for (index, value) in pixels.iter_mut().enumerate() {
        if !value.is_finite() {
            *value = Rgb::ZERO;
            invalid.push(index);
        }
    }
    Picture { invalid, ..Picture::new(Image::new(width, height, pixels), depth) }
}

/// The code values of all pixels, grey repeated in all channels, alpha left out.
fn code_values(decoded: &DynamicImage) -> Vec<Rgb> {
    let of8 = |code: u8| f32::from(code) / 255.0;
    let of16 = |code: u16| f32::from(code) / 65535.0;
    let rgb8 = |p: [u8; 3]| Rgb::from_array(p.map(of8));
    let rgb16 = |p: [u16; 3]| Rgb::from_array(p.map(of16));
    match decoded {
        DynamicImage::ImageLuma8(p) => p.pixels().map(|p| Rgb::splat(of8(p.0[0]))).collect(),
        DynamicImage::ImageLumaA8(p) => p.pixels().map(|p| Rgb::splat(of8(p.0[0]))).collect(),
        DynamicImage::ImageRgb8(p) => p.pixels().map(|p| rgb8(p.0)).collect(),
        DynamicImage::ImageRgba8(p) => p.pixels().map(|p| rgb8([p.0[0], p.0[1], p.0[2]])).collect(),
        DynamicImage::ImageLuma16(p) => p.pixels().map(|p| Rgb::splat(of16(p.0[0]))).collect(),
        DynamicImage::ImageLumaA16(p) => p.pixels().map(|p| Rgb::splat(of16(p.0[0]))).collect(),
        DynamicImage::ImageRgb16(p) => p.pixels().map(|p| rgb16(p.0)).collect(),
        DynamicImage::ImageRgba16(p) => {
            p.pixels().map(|p| rgb16([p.0[0], p.0[1], p.0[2]])).collect()
        }
        DynamicImage::ImageRgba32F(p) => {
            p.pixels().map(|p| Rgb::new(p.0[0], p.0[1], p.0[2])).collect()
        }
        other => other.to_rgb32f().pixels().map(|p| Rgb::from_array(p.0)).collect(),
    }
}
