//! Pictures as file contents to embed in a page: PNG is exact, JPEG small.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use unrender_scene::{Image, Rgb};

/// The 8-bit PNG of code values, 0 to 1.
///
/// # Errors
/// If the picture has no pixels or is too large for the format.
pub fn png_bytes(codes: &Image<Rgb>) -> Result<Vec<u8>, String> {
    encode(codes, |out, bytes, width, height| {
        PngEncoder::new(out).write_image(bytes, width, height, ExtendedColorType::Rgb8)
    })
}

/// The JPEG of code values, 0 to 1; `quality` is 1 to 100.
///
/// # Errors
/// If the picture has no pixels or is too large for the format.
pub fn jpeg_bytes(codes: &Image<Rgb>, quality: u8) -> Result<Vec<u8>, String> {
    encode(codes, |out, bytes, width, height| {
        JpegEncoder::new_with_quality(out, quality).write_image(
            bytes,
            width,
            height,
            ExtendedColorType::Rgb8,
        )
    })
}

fn encode(
    codes: &Image<Rgb>,
    encoder: impl FnOnce(&mut Vec<u8>, &[u8], u32, u32) -> ImageResult<()>,
) -> Result<Vec<u8>, String> {
    let size = |n: usize| u32::try_from(n).ok().filter(|&n| n > 0);
    let (Some(width), Some(height)) = (size(codes.width()), size(codes.height())) else {
        return Err("a picture without pixels cannot be written".to_owned());
    };
    let byte = |code: f32| (255.0 * code.clamp(0.0, 1.0)).round() as u8;
    let bytes: Vec<u8> = codes.pixels().iter().flat_map(|c| c.to_array()).map(byte).collect();
    let mut out = Vec::new();
    encoder(&mut out, &bytes, width, height).map_err(|error| error.to_string())?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::decode;
    use std::path::Path;

    #[test]
    fn what_is_encoded_reads_back() {
        let codes = Image::from_fn(20, 10, |x, y| {
            Rgb::new(x as f32, y as f32, (x + y) as f32) * (8.0 / 255.0)
        });
        let back = |bytes: Vec<u8>| decode(&bytes, Path::new("p")).unwrap().0.values;
        let error = |image: &Image<Rgb>| {
            let pairs = image.pixels().iter().zip(codes.pixels());
            pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
        };
        assert!(error(&back(png_bytes(&codes).unwrap())) < 1e-6);
        assert!(error(&back(jpeg_bytes(&codes, 95).unwrap())) < 0.05);
        assert!(png_bytes(&Image::new(0, 3, Vec::new())).is_err());
    }
}
