//! Pictures of the differences between photograph and re-rendering.
//!
//! The difference of luminances, averaged over 5 x 5 pixels so that the re-rendering's noise does
//! not hide it; dark grey where the photograph is clipped or broken. Signed, it is red where the
//! re-rendering is too bright and blue where it is too dark.
//!
//! `error.png` is relative to the photograph's mean, with the colour bar below the picture. The
//! other pictures have their bars in run.json: in radiance, and in standard deviations of the joint
//! noise of photograph and re-rendering.

use super::report_folder;
use crate::run::{ErrorPicture, Stop, Unit};
use crate::{Error, Job};
use std::path::Path;
use unrender_formats::picture;
use unrender_recover::{PixelStatus, Recovery};
use unrender_scene::color::{linear_from_srgb, luminance};
use unrender_scene::{Image, Rgb, RgbImage};

/// The ends of the scale: a difference of this share of the photograph's mean.
const FULL_SCALE: f32 = 0.2;
/// The ends of the scale in noise, standard deviations.
const FULL_SCALE_NOISE: f32 = 20.0;
/// Averages reach this many pixels to each side.
const REACH: usize = 2;
/// The linear grey of pixels that are not compared.
const LEFT_OUT: f32 = 0.1;
/// Stops of a colour bar.
const STOPS: usize = 9;

/// Writes the error pictures of a recovery into its folder, with the photograph's `number` in their names; returns
/// those whose bars are in run.json.
pub(super) fn write(
    job: &Job,
    recovery: &Recovery,
    (folder, number): (&Path, &str),
) -> Result<Vec<ErrorPicture>, Error> {
    let difference = Difference::of(job, recovery);
    let full = (difference.photo_mean * FULL_SCALE).max(f32::MIN_POSITIVE);
    let (width, height) = (recovery.rerendered.width(), recovery.rerendered.height());
    let bar = super::scale_bar::height(width);
    let with_bar = RgbImage::from_fn(width, height + bar, |x, y| {
        if y >= height {
            return super::scale_bar::pixel(x, y - height, width, FULL_SCALE, diverging);
        }
        painted(*difference.radiance.at(x, y), full, diverging)
    });
    picture::write_png_srgb(&folder.join(format!("error{number}.png")), &with_bar)?;
    let mut pictures = Vec::new();
    for unit in [Unit::Radiance, Unit::Noise] {
        let (name, values, full) = match unit {
            Unit::Radiance => ("radiance", &difference.radiance, full),
            Unit::Noise => ("noise", &difference.noise, FULL_SCALE_NOISE),
        };
        for signed in [true, false] {
            let color = if signed { diverging } else { rising };
            let kind = if signed { "signed" } else { "absolute" };
            let file = report_folder(&format!("error{number}_{name}_{kind}.png"));
            let picture = values.map(|value| painted(*value, full, color));
            picture::write_png_srgb(&folder.join(&file), &picture)?;
            let bar = bar_of(signed, full, color);
            pictures.push(ErrorPicture { file, signed, unit, reach: REACH, bar });
        }
    }
    Ok(pictures)
}

/// Re-rendering minus photograph, averaged over a pixel's surroundings; none where they are not
/// compared.
struct Difference {
    /// The mean luminance of the photograph.
    photo_mean: f32,
    /// In radiance.
    radiance: Image<Option<f32>>,
    /// In standard deviations of the average's noise.
    noise: Image<Option<f32>>,
}

impl Difference {
    fn of(job: &Job, recovery: &Recovery) -> Self {
        let fixed = matches!(job.project.exposure, unrender_photo::Exposure::Fixed(_));
        let scale = if fixed { Rgb::ONE } else { recovery.exposure };
        let photo = job.photo.radiance.map(|value| luminance(*value * scale));
        let photo_mean = photo.pixels().iter().sum::<f32>() / photo.pixels().len().max(1) as f32;
        let (width, height) = (photo.width(), photo.height());
        // Pixels that the project leaves out have this status too.
        let says = |x: usize, y: usize| {
            *job.photo.valid.at(x, y) && *recovery.status.at(x, y) != PixelStatus::Clipped
        };
        // The sum of differences, that of their variances, and the number of pixels.
        let sums = Image::from_fn(width, height, |x, y| {
            if !says(x, y) {
                return (0.0, 0.0, 0.0);
            }
            let (mut sum, mut variance, mut count) = (0.0, 0.0, 0.0);
            for row in y.saturating_sub(REACH)..(y + REACH + 1).min(height) {
                for column in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                    if says(column, row) {
                        let shown = luminance(*recovery.rerendered.at(column, row));
                        sum += shown - photo.at(column, row);
                        variance += recovery.noise.at(column, row).powi(2);
                        count += 1.0;
                    }
                }
            }
            (sum, variance, count)
        });
        let radiance = sums.map(|&(sum, _, count)| (count > 0.0).then(|| sum / count));
        let noise = sums.map(|&(sum, variance, count)| {
            (count > 0.0).then(|| sum / variance.sqrt().max(f32::MIN_POSITIVE))
        });
        Self { photo_mean, radiance, noise }
    }
}

fn painted(value: Option<f32>, full: f32, color: fn(f32) -> Rgb) -> Rgb {
    value.map_or(Rgb::splat(LEFT_OUT), |value| color(value / full))
}

/// The colour bar: as in [`diverging`] and [`rising`], values grow as the square of the position, so
/// that small ones have room.
fn bar_of(signed: bool, full: f32, color: fn(f32) -> Rgb) -> Vec<Stop> {
    let stop = |i: usize| {
        let place = i as f32 / (STOPS - 1) as f32;
        let place = if signed { 2.0 * place - 1.0 } else { place };
        let value = place * place.abs();
        Stop { value: value * full, color: super::hex(color(value)) }
    };
    (0..STOPS).map(stop).collect()
}

/// The colour of a value from -1 (blue) over 0 (light grey) to 1 (red), as linear RGB.
fn diverging(value: f32) -> Rgb {
    let value = if value.is_finite() { value.clamp(-1.0, 1.0) } else { 1.0 };
    let end = if value > 0.0 { Rgb::new(0.70, 0.02, 0.15) } else { Rgb::new(0.02, 0.24, 0.62) };
    let srgb = Rgb::splat(0.93).lerp(end, value.abs().sqrt());
    Rgb::from_array(srgb.to_array().map(linear_from_srgb))
}

/// The colour of an absolute value from 0 (nearly black) over red and orange to 1 (light yellow),
/// as linear RGB.
fn rising(value: f32) -> Rgb {
    const RAMP: [Rgb; 5] = [
        Rgb::new(0.05, 0.03, 0.12),
        Rgb::new(0.36, 0.07, 0.43),
        Rgb::new(0.78, 0.22, 0.30),
        Rgb::new(0.98, 0.60, 0.15),
        Rgb::new(0.99, 0.99, 0.75),
    ];
    let value = if value.is_finite() { value.abs().min(1.0) } else { 1.0 };
    let place = value.sqrt() * (RAMP.len() - 1) as f32;
    let below = (place as usize).min(RAMP.len() - 2);
    let srgb = RAMP[below].lerp(RAMP[below + 1], place - below as f32);
    Rgb::from_array(srgb.to_array().map(linear_from_srgb))
}
