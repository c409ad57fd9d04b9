//! Reads a picture file into code values.

use super::kind::format_of;
use super::tiff::{Directory, Tiff};
use super::{
    Decoded, Orientation, Picture, bmp, budget, claims, codes, coverage, exr_picture, hdr_header,
    hdr_resolution, jpeg, merged, pixel_shape, png_chunks, primaries, profile, raw, tiff_page,
    tiff_says,
};
use crate::FileError;
use crate::input::{Input, Scope};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;
use unrender_scene::{Image, Rgb, Warnings};

/// The warning of colours for a printer.
const INKS: &str = "holds inks (CMYK), which were converted to red, green and blue without a \
profile; save it as RGB";

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
    let decoded = decoded(scope, bytes).map_err(|problem| FileError::new(path, problem))?;
    let Decoded { mut picture, notes } = decoded;
    let mut warnings = Warnings::default();
    for note in notes {
        warnings.push(format!("{}: {note}", path.display()));
    }
    let broken = codes::leave_out_what_is_not_finite(&mut picture);
    if broken > 0 {
        warnings.push(format!(
            "{}: {broken} pixel(s) are not finite numbers; they were left out",
            path.display()
        ));
    }
    picture.invalid.sort_unstable();
    picture.invalid.dedup();
    Ok((picture, warnings))
}

fn decoded(scope: &Scope, bytes: &[u8]) -> Result<Decoded, String> {
    if let Some(kind) = raw::of_beginning(bytes) {
        return Err(raw::refusal(kind));
    }
    let format = format_of(bytes).ok_or_else(|| match raw::other(bytes) {
        Some(kind) => format!(
            "is not a PNG, JPEG, BMP, TIFF, EXR or HDR file, but {kind}, which is not read; save it as one of these"
        ),
        None => "is not a PNG, JPEG, BMP, TIFF, EXR or HDR file".to_owned(),
    })?;
    budget::check(scope, bytes, Some(format))?;
    match format {
        ImageFormat::OpenExr => {
            let mut decoded = exr_picture::read(scope, bytes)?;
            put_merged(scope, &mut decoded.picture, bytes)?;
            Ok(decoded)
        }
        ImageFormat::Tiff => tiff(scope, bytes),
        ImageFormat::Jpeg => plain_jpeg(scope, bytes),
        ImageFormat::Hdr => hdr(scope, bytes),
        ImageFormat::Bmp => {
            let mut decoded = plain(scope, bytes, format, None)?;
            decoded.notes.extend(pixel_shape::note(bmp::pixel_aspect(bytes), "its header"));
            Ok(decoded)
        }
        _ => {
            let mut decoded = plain(scope, bytes, format, None)?;
            let aspect = png_chunks::pixel_aspect(bytes);
            decoded.notes.extend(pixel_shape::note(aspect, "its chunk pHYs"));
            Ok(decoded)
        }
    }
}

/// Reads a file whose decoder returns all that matters; `page` is that of a TIFF.
fn plain(
    scope: &Scope,
    bytes: &[u8],
    format: ImageFormat,
    page: Option<(&Tiff<'_>, &Directory)>,
) -> Result<Decoded, String> {
    let (decoded, icc) = pixels_of(scope, bytes, format)?;
    let mut picture = codes::picture_of(&decoded);
    let is_coverage = page.is_none_or(|(tiff, page)| tiff_says::has_coverage(tiff, page));
    let notes = coverage::mark(&decoded, is_coverage, &mut picture).into_iter().collect();
    picture.profile = profile::of(bytes, format, icc.as_deref(), page)?;
    Ok(Decoded { picture, notes })
}

fn plain_jpeg(scope: &Scope, bytes: &[u8]) -> Result<Decoded, String> {
    if let Some(problem) = jpeg::unread(bytes) {
        return Err(problem);
    }
    if !jpeg::has_end(bytes) {
        return Err("is cut short: the end of the JPEG data is missing".into());
    }
    let mut decoded = plain(scope, bytes, ImageFormat::Jpeg, None)?;
    decoded.notes.extend(pixel_shape::note(jpeg::pixel_aspect(bytes), "its JFIF header"));
    decoded.notes.extend(jpeg::has_inks(bytes).then(|| INKS.to_owned()));
    Ok(decoded)
}

/// Radiance's header states the factor by which the picture was multiplied, and its primaries.
fn hdr(scope: &Scope, bytes: &[u8]) -> Result<Decoded, String> {
    let header = hdr_header::read(bytes)?;
    let (rows, number) = hdr_resolution::as_rows(bytes)?;
    let orientation = Orientation::from_exif(number).unwrap_or(Orientation::UPRIGHT);
    if let Cow::Owned(rows) = &rows {
        scope.charge(rows.len() as u64)?;
    }
    let mut decoded = plain(scope, &rows, ImageFormat::Hdr, None)?;
    if orientation != Orientation::UPRIGHT {
        let values = &mut decoded.picture.values;
        scope.charge(values.pixels().len() as u64 * size_of::<Rgb>() as u64)?;
        *values = orientation.upright(values);
    }
    if header.factor != [1.0; 3] {
        let factor = Rgb::from_array(header.factor);
        decoded.picture.values.pixels_mut().iter_mut().for_each(|value| *value /= factor);
    }
    let source = "the line PRIMARIES= of its header";
    let stated =
        header.primaries.map(|corners| primaries::of_primaries(primaries::matrix(corners), source));
    decoded.picture.profile = stated;
    decoded.picture.is_linear = true;
    let aspect = Some(1.0 / header.height_of_pixels);
    decoded.notes.extend(pixel_shape::note(aspect, "the line PIXASPECT= of its header"));
    Ok(decoded)
}

fn tiff(scope: &Scope, bytes: &[u8]) -> Result<Decoded, String> {
    let Some(file) = Tiff::of(bytes) else { return plain(scope, bytes, ImageFormat::Tiff, None) };
    let Some(page) = tiff_page::choose(&file)? else {
        return plain(scope, bytes, ImageFormat::Tiff, None);
    };
    if let Some(problem) = tiff_says::unread(&file, &page.directory) {
        return Err(problem);
    }
    // The decoder reads the first page only.
    let bytes = if page.is_first {
        Cow::Borrowed(bytes)
    } else {
        scope.charge(bytes.len() as u64)?;
        Cow::Owned(file.beginning_at(page.directory.at))
    };
    let mut decoded = plain(scope, &bytes, ImageFormat::Tiff, Some((&file, &page.directory)))?;
    if let Some(no_data) = tiff_says::no_data(&file, &page.directory) {
        let count = coverage::mark_no_data(&mut decoded.picture, no_data);
        if count > 0 {
            decoded.notes.push(format!(
                "{count} pixel(s) have the value {no_data} for no data (GDAL_NODATA); they were left out"
            ));
        }
    }
    decoded.notes.extend(page.note);
    decoded.notes.extend(tiff_says::other_channels(&file, &page.directory));
    decoded.notes.extend(tiff_says::has_inks(&file, &page.directory).then(|| INKS.to_owned()));
    let aspect = tiff_says::pixel_aspect(&file, &page.directory);
    decoded.notes.extend(pixel_shape::note(aspect, "its resolutions"));
    Ok(decoded)
}

/// Reads the variances of a merged bracket, and which pixels have no value.
fn put_merged(scope: &Scope, picture: &mut Picture, bytes: &[u8]) -> Result<(), String> {
    // Memory for all six channels as in the file, and for the variances once more.
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
    picture.merged = Some(merged);
    Ok(())
}

/// Whether a file that begins with `bytes` is a picture, also of a format that is not read.
pub(crate) fn is_picture(bytes: &[u8]) -> bool {
    image::guess_format(bytes).is_ok() || raw::of_beginning(bytes).or(raw::other(bytes)).is_some()
}

/// The decoded and upright pixels and the ICC profile, or what is wrong with the file.
fn pixels_of(
    scope: &Scope,
    bytes: &[u8],
    format: ImageFormat,
) -> Result<(DynamicImage, Option<Vec<u8>>), String> {
    let faulty = |error: image::ImageError| fault(bytes, format, &error);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget::BESIDE_PIXELS);
    reader.limits(if format == ImageFormat::Png { limits } else { Limits::no_limits() });
    let mut decoder = reader.into_decoder().map_err(faulty)?;
    check_size(&decoder, bytes.len() as u64)?;
    let (width, height) = decoder.dimensions();
    // Memory for the pixels as in the file, and as three floats.
    let each = u64::from(decoder.color_type().bytes_per_pixel()) + 12;
    scope.charge(u64::from(width) * u64::from(height) * each).map_err(|problem| {
        format!("has {width} x {height} pixels and {problem}; or make the picture smaller")
    })?;
    let orientation = decoder.orientation().map_err(faulty)?;
    let icc = decoder.icc_profile().ok().flatten();
    let mut decoded = DynamicImage::from_decoder(decoder).map_err(faulty)?;
    decoded.apply_orientation(orientation);
    Ok((decoded, icc))
}

fn fault(bytes: &[u8], format: ImageFormat, error: &image::ImageError) -> String {
    match error {
        image::ImageError::Unsupported(_) => {
            // A TIFF's decoder returns only a number.
            let first = Tiff::of(bytes).and_then(|tiff| {
                let page = tiff.directory(tiff.first()?)?;
                Some(tiff_says::kind(&tiff, &page))
            });
            let what = first.unwrap_or_else(|| error.to_string());
            format!("is a kind of {format:?} file that is not read ({what}); save it as RGB")
        }
        image::ImageError::Limits(_) => {
            "has a colour profile or texts that are too large; save it again without them".into()
        }
        _ => format!("is cut short or corrupt ({error})"),
    }
}

/// Refuses sizes that the file cannot hold, before any memory is allocated.
fn check_size(decoder: &impl ImageDecoder, file_bytes: u64) -> Result<(), String> {
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err("has no pixels".into());
    }
    let unpacked = pixels.saturating_mul(u64::from(decoder.color_type().bytes_per_pixel()));
    if pixels > claims::MAX_PIXELS || unpacked > claims::plausible(file_bytes) {
        return Err(claims::unbelievable(width.into(), height.into(), file_bytes));
    }
    Ok(())
}
