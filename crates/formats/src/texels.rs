//! Pictures of reflectance: PNG, JPEG and BMP to texels, and texels to sRGB PNG.

use crate::input::Scope;
use crate::picture;
use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use unrender_scene::color::{linear_from_srgb, srgb_from_linear};
use unrender_scene::{Image, Rgb};

/// A header with longer sides than this is taken to be damaged.
const MAX_SIDE: u32 = 32768;

/// The pixels of an encoded picture, 0 to 1, still with its transfer curve.
pub(crate) fn decode(scope: &Scope, bytes: &[u8]) -> Result<Image<Rgb>, String> {
    let picture = open(scope, bytes)?;
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let pixels: Vec<Rgb> = if has_16_bits(&picture) {
        let pixels = picture.into_rgb16();
        pixels.pixels().map(|p| Rgb::from_array(p.0.map(f32::from)) / 65535.0).collect()
    } else {
        let pixels = picture.into_rgb8();
        pixels.pixels().map(|p| Rgb::from_array(p.0.map(|c| f32::from(c) / 255.0))).collect()
    };
    Ok(Image::new(width, height, pixels))
}

/// The alpha of an encoded picture, 0 to 1; none if it is one everywhere.
pub(crate) fn alpha(scope: &Scope, bytes: &[u8]) -> Result<Option<Image<f32>>, String> {
    let picture = open(scope, bytes)?;
    if !picture.color().has_alpha() {
        return Ok(None);
    }
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let alphas: Vec<f32> = if has_16_bits(&picture) {
        picture.into_rgba16().pixels().map(|p| f32::from(p.0[3]) / 65535.0).collect()
    } else {
        picture.into_rgba8().pixels().map(|p| f32::from(p.0[3]) / 255.0).collect()
    };
    let is_there = alphas.iter().all(|alpha| *alpha == 1.0);
    Ok((!is_there).then(|| Image::new(width, height, alphas)))
}

fn has_16_bits(picture: &DynamicImage) -> bool {
    picture.color().bytes_per_pixel() / picture.color().channel_count() > 1
}

/// An encoded picture of at least one pixel.
fn open(scope: &Scope, bytes: &[u8]) -> Result<DynamicImage, String> {
    let undecodable = |error: &dyn std::fmt::Display| {
        format!("cannot be decoded ({error}); save it as PNG or JPEG again")
    };
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| undecodable(&e))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Bmp)) {
        let what = picture::other_kind(bytes).map_or(String::new(), |kind| format!(", but {kind}"));
        return Err(format!("is not a PNG, JPEG or BMP file{what}; convert it"));
    }
    picture::check_budget(scope, bytes, reader.format())?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| undecodable(&e))?;
    let (width, height) = decoder.dimensions();
    // Memory for the pixels as in the file, and as three floats.
    let each = u64::from(decoder.color_type().bytes_per_pixel()) + 12;
    let charged = scope.charge(u64::from(width) * u64::from(height) * each);
    charged.map_err(|problem| format!("has {width} x {height} pixels and {problem}"))?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|e| undecodable(&e))?;
    if width == 0 || height == 0 {
        return Err("has no pixels; save it again".into());
    }
    Ok(picture)
}

/// The linear value of encoded texels.
pub(crate) fn linear(encoded: &Image<Rgb>) -> Image<Rgb> {
    encoded.map(|texel| Rgb::from_array(texel.to_array().map(linear_from_srgb)))
}

/// The mean over all texels, summed in double precision.
pub(crate) fn mean(image: &Image<Rgb>) -> Rgb {
    let sum: glam::DVec3 = image.pixels().iter().map(|p| p.as_dvec3()).sum();
    (sum / image.pixels().len().max(1) as f64).as_vec3()
}

/// Linear texels as an sRGB PNG of 8 bits.
pub(crate) fn png(image: &Image<Rgb>) -> Result<Vec<u8>, String> {
    let codes = image.pixels().iter().flat_map(|texel| texel.to_array());
    let codes = codes.map(|channel| code(srgb_from_linear(channel))).collect();
    let (width, height) = (image.width() as u32, image.height() as u32);
    let picture = image::RgbImage::from_raw(width, height, codes).map(DynamicImage::ImageRgb8);
    as_png(picture)
}

/// As [`png`], with an alpha of the same size, 0 to 1.
pub(crate) fn png_with_alpha(image: &Image<Rgb>, alpha: &Image<f32>) -> Result<Vec<u8>, String> {
    let pairs = image.pixels().iter().zip(alpha.pixels());
    let codes = pairs.flat_map(|(texel, alpha)| {
        let [r, g, b] = texel.to_array().map(|channel| code(srgb_from_linear(channel)));
        [r, g, b, code(*alpha)]
    });
    let (width, height) = (image.width() as u32, image.height() as u32);
    let picture = image::RgbaImage::from_raw(width, height, codes.collect());
    as_png(picture.map(DynamicImage::ImageRgba8))
}

/// Numbers of 0 to 1 as a grey PNG of 8 bits, without a transfer curve.
pub(crate) fn png_of_numbers(image: &Image<f32>) -> Result<Vec<u8>, String> {
    let codes = image.pixels().iter().map(|number| code(*number)).collect();
    let (width, height) = (image.width() as u32, image.height() as u32);
    let picture = image::GrayImage::from_raw(width, height, codes).map(DynamicImage::ImageLuma8);
    as_png(picture)
}

/// Unit vectors as a PNG of 8 bits whose codes 0 to 1 stand for -1 to 1, as normal maps are kept.
pub(crate) fn png_of_normals(image: &Image<Vec3>) -> Result<Vec<u8>, String> {
    let codes = image.pixels().iter().flat_map(|normal| (0.5 * *normal + 0.5).to_array());
    let codes = codes.map(code).collect();
    let (width, height) = (image.width() as u32, image.height() as u32);
    let picture = image::RgbImage::from_raw(width, height, codes).map(DynamicImage::ImageRgb8);
    as_png(picture)
}

/// The code of 8 bits for a number of 0 to 1.
fn code(number: f32) -> u8 {
    (number * 255.0).round() as u8
}

fn as_png(picture: Option<DynamicImage>) -> Result<Vec<u8>, String> {
    let mut bytes = Cursor::new(Vec::new());
    picture
        .ok_or("is too large for a PNG")?
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| format!("cannot be encoded as PNG: {error}"))?;
    Ok(bytes.into_inner())
}

/// Linear texels as a Radiance picture, eight bits and a common exponent a texel.
pub(crate) fn hdr(image: &Image<Rgb>) -> Result<Vec<u8>, String> {
    let texels: Vec<image::Rgb<f32>> =
        image.pixels().iter().map(|texel| image::Rgb(texel.to_array())).collect();
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&texels, image.width(), image.height())
        .map_err(|error| format!("cannot be encoded as a Radiance picture: {error}"))?;
    Ok(bytes)
}

/// Linear texels as an OpenEXR picture of single-precision numbers.
pub(crate) fn exr(image: &Image<Rgb>) -> Result<Vec<u8>, String> {
    let texels = image.pixels().iter().flat_map(|texel| texel.to_array()).collect();
    let (width, height) = (image.width() as u32, image.height() as u32);
    let picture =
        image::Rgb32FImage::from_raw(width, height, texels).ok_or("is too large for an EXR")?;
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb32F(picture)
        .write_to(&mut bytes, ImageFormat::OpenExr)
        .map_err(|error| format!("cannot be encoded as EXR: {error}"))?;
    Ok(bytes.into_inner())
}
