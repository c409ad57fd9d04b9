//! The picture trust.png: which pixels of the photograph were used, and why the others were not.
//!
//! The photograph in grey where it was valid. Elsewhere a colour: blue beside an edge, violet where
//! the photograph is clipped or broken or the project leaves it out, yellow for a single bright
//! pixel, orange for things that are not in the model; black where the model shows nothing.

use crate::{Error, Job};
use std::path::Path;
use unrender_formats::picture;
use unrender_recover::{PixelStatus, Recovery};
use unrender_scene::color::{linear_from_srgb, luminance};
use unrender_scene::{Rgb, RgbImage};

/// Writes the valid mask of a recovery.
pub(super) fn write(job: &Job, recovery: &Recovery, path: &Path) -> Result<(), Error> {
    let photo = job.photo.radiance.map(|value| luminance(*value));
    let brightest = photo.pixels().iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let (width, height) = (photo.width(), photo.height());
    let picture = RgbImage::from_fn(width, height, |x, y| {
        let grey = (*photo.at(x, y) / brightest).max(0.0);
        color(*recovery.status.at(x, y)).unwrap_or(Rgb::splat(grey))
    });
    picture::write_png_srgb(path, &picture)?;
    Ok(())
}

/// The colour of a reason, linear RGB; none for pixels that were used.
fn color(status: PixelStatus) -> Option<Rgb> {
    let srgb = match status {
        PixelStatus::Valid => return None,
        PixelStatus::Nothing => Rgb::ZERO,
        PixelStatus::Clipped => Rgb::new(0.60, 0.30, 0.65),
        PixelStatus::Edge => Rgb::new(0.20, 0.45, 0.75),
        PixelStatus::Spike => Rgb::new(0.95, 0.85, 0.25),
        PixelStatus::Outlier => Rgb::new(0.90, 0.50, 0.15),
    };
    Some(srgb.map(linear_from_srgb))
}
