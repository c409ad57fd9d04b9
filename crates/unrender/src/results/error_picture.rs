//! error.png: where photograph and re-rendering differ, and by how much.
//!
//! The difference of luminances relative to the photograph's mean, averaged over 5 x 5 pixels so
//! that the re-rendering's noise does not hide it: light where they agree, red where the
//! re-rendering is too bright, blue where it is too dark; dark grey where the photograph is clipped
//! or broken. A bar below the picture carries the scale.

use crate::{Error, Job};
use std::path::Path;
use unrender_formats::picture;
use unrender_recover::Recovery;
use unrender_scene::color::{linear_from_srgb, luminance};
use unrender_scene::{Rgb, RgbImage};

/// The ends of the scale: a difference of this share of the photograph's mean.
const FULL_SCALE: f32 = 0.2;
/// Averages reach this many pixels to each side.
const REACH: usize = 2;
/// The linear grey of pixels that are not compared.
const LEFT_OUT: f32 = 0.1;

/// Writes the error picture of a recovery.
pub(super) fn write(job: &Job, recovery: &Recovery, path: &Path) -> Result<(), Error> {
    let shown = &recovery.rerendered;
    let fixed = matches!(job.project.exposure, unrender_photo::Exposure::Fixed(_));
    let scale = if fixed { Rgb::ONE } else { recovery.exposure };
    let photo = job.photo.radiance.map(|value| luminance(*value * scale));
    let mean = photo.pixels().iter().sum::<f32>() / photo.pixels().len().max(1) as f32;
    let (width, height) = (shown.width(), shown.height());
    let bar = super::scale_bar::height(width);
    let picture = RgbImage::from_fn(width, height + bar, |x, y| {
        if y >= height {
            return super::scale_bar::pixel(x, y - height, width, FULL_SCALE, diverging);
        }
        if !job.photo.trusted.at(x, y) {
            return Rgb::splat(LEFT_OUT);
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
            for column in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                if *job.photo.trusted.at(column, row) {
                    sum += luminance(*shown.at(column, row)) - photo.at(column, row);
                    count += 1.0;
                }
            }
        }
        diverging(sum / count / (mean * FULL_SCALE).max(f32::MIN_POSITIVE))
    });
    picture::write_png_srgb(path, &picture)?;
    Ok(())
}

/// The colour of a value from -1 (blue) over 0 (light grey) to 1 (red), as linear RGB.
fn diverging(value: f32) -> Rgb {
    let value = if value.is_finite() { value.clamp(-1.0, 1.0) } else { 1.0 };
    let end = if value > 0.0 { Rgb::new(0.70, 0.02, 0.15) } else { Rgb::new(0.02, 0.24, 0.62) };
    let srgb = Rgb::splat(0.93).lerp(end, value.abs().sqrt());
    Rgb::from_array(srgb.to_array().map(linear_from_srgb))
}
