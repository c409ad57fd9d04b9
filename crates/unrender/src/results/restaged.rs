//! What `restage` leaves in its folder.

use crate::edit::{Composite, Photograph};
use std::path::Path;
use unrender_formats::FileError;
use unrender_formats::picture::{self, Depth};
use unrender_restage::pair::{self, Paired};
use unrender_scene::{Rgb, RgbImage};

/// Writes a composite and its masks; returns how many values were not finite.
///
/// `composite.exr` is radiance, or, for photographs of floating-point values, has the values that
/// the photograph's file would have.
pub(crate) fn write_composite(
    composite: &Composite,
    photograph: &Photograph,
    folder: &Path,
) -> Result<usize, FileError> {
    let codes = composite.codes(photograph);
    let (exr, png) = (folder.join("composite.exr"), folder.join("composite.png"));
    let mut bad = 0;
    match photograph.picture.depth {
        Depth::Float => {
            bad += picture::write_exr(&exr, &codes)?;
            bad += picture::write_png_srgb(&png, &as_srgb(photograph, &composite.radiance))?;
        }
        depth => {
            bad += picture::write_exr(&exr, &composite.radiance)?;
            bad += picture::write_png_codes(&png, &codes, depth)?;
        }
    }
    let share = |of: fn(&Paired) -> f32| composite.paired.map(|pixel| Rgb::splat(of(pixel)));
    let touched = composite.touched.map(|&touched| Rgb::splat(f32::from(u8::from(touched))));
    for (name, mask) in [("touched", touched), ("invented", share(|pixel| pixel.uncovered))] {
        picture::write_png_codes(&folder.join(format!("{name}.png")), &mask, Depth::Eight)?;
    }
    bad += write_synthetic(&pair::after(&composite.paired), Some(photograph), folder, None)?;
    Ok(bad)
}

/// Writes a synthetic picture, as radiance and as the photograph's camera would show it, else as
/// sRGB; returns how many values were not finite. `number` is its place in a sequence.
pub(crate) fn write_synthetic(
    radiance: &RgbImage,
    photograph: Option<&Photograph>,
    folder: &Path,
    number: Option<usize>,
) -> Result<usize, FileError> {
    let name = number.map_or("synthetic".to_owned(), |n| format!("synthetic_{n:04}"));
    let bad = picture::write_exr(&folder.join(format!("{name}.exr")), radiance)?;
    let png = folder.join(format!("{name}.png"));
    match photograph {
        Some(photograph) if photograph.picture.depth != Depth::Float => {
            let codes = photograph.transfer.codes(radiance);
            picture::write_png_codes(&png, &codes, photograph.picture.depth)?;
        }
        Some(photograph) => {
            picture::write_png_srgb(&png, &as_srgb(photograph, radiance))?;
        }
        None => {
            picture::write_png_srgb(&png, radiance)?;
        }
    }
    Ok(bad)
}

/// Linear values at the photograph's exposure.
fn as_srgb(photograph: &Photograph, radiance: &RgbImage) -> RgbImage {
    radiance.map(|radiance| *radiance / photograph.transfer.exposure)
}
