//! Pixels without a measurement though the file has a number: coverage of zero, and values for "no data".
//!
//! An alpha channel is coverage: where it is zero, nothing is shown. The numbers there stay as they are, for
//! textures and panoramas; in a photograph they are no measurement.

use super::Picture;
use image::DynamicImage;

/// The note about pixels without coverage, and about partly covered ones.
pub(super) fn note(transparent: usize, partly: bool) -> Option<String> {
    let clear = format!(
        "{transparent} pixel(s) are transparent (alpha is 0); a photograph has no measurement there"
    );
    match (transparent, partly) {
        (0, false) => None,
        (0, true) => Some("the alpha channel was ignored".into()),
        (_, false) => Some(clear),
        (_, true) => Some(format!("{clear}; between 0 and 1 alpha was ignored")),
    }
}

/// Marks the pixels of `picture` without coverage in `decoded`, if its fourth channel `is_coverage`; returns a note
/// for the user.
pub(super) fn mark(
    decoded: &DynamicImage,
    is_coverage: bool,
    picture: &mut Picture,
) -> Option<String> {
    let alphas: Box<dyn Iterator<Item = f32> + '_> = match decoded {
        DynamicImage::ImageLumaA8(p) => Box::new(p.pixels().map(|p| f32::from(p.0[1]) / 255.0)),
        DynamicImage::ImageRgba8(p) => Box::new(p.pixels().map(|p| f32::from(p.0[3]) / 255.0)),
        DynamicImage::ImageLumaA16(p) => Box::new(p.pixels().map(|p| f32::from(p.0[1]) / 65535.0)),
        DynamicImage::ImageRgba16(p) => Box::new(p.pixels().map(|p| f32::from(p.0[3]) / 65535.0)),
        DynamicImage::ImageRgba32F(p) => Box::new(p.pixels().map(|p| p.0[3])),
        _ => return None,
    };
    let [mut transparent, mut partly] = [0, 0];
    for (at, alpha) in alphas.enumerate() {
        if alpha <= 0.0 && is_coverage {
            transparent += 1;
            picture.invalid.push(at);
        } else if alpha < 1.0 {
            partly += 1;
        }
    }
    note(transparent, partly > 0)
}

/// Marks the pixels that have `no_data`, a number of the file, in some channel; returns how many.
pub(super) fn mark_no_data(picture: &mut Picture, no_data: f64) -> usize {
    let code = match picture.depth.max_code() {
        Some(max) => no_data as f32 / max,
        None => no_data as f32,
    };
    // Codes are whole numbers divided by the greatest; other codes are a whole step away.
    let near = picture.depth.max_code().map_or(0.0, |max| 0.25 / max);
    let is_missing = |value: f32| value == code || (value - code).abs() < near;
    let before = picture.invalid.len();
    for (at, value) in picture.values.pixels().iter().enumerate() {
        if value.to_array().into_iter().any(is_missing) {
            picture.invalid.push(at);
        }
    }
    picture.invalid.len() - before
}
