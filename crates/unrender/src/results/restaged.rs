//! What `restage` leaves in its folder.

use crate::edit::{Photograph, Restaging};
use std::path::Path;
use unrender_formats::FileError;
use unrender_formats::picture::{self, Depth};
use unrender_photo::clipping;
use unrender_recover::{Observation, Picture};
use unrender_render::{GeometryBuffers, Tracer};
use unrender_restage::composite::{self, Gain};
use unrender_restage::pair::Paired;
use unrender_restage::{grain, touched};
use unrender_scene::{Image, Rgb, RgbImage};

/// The photograph with the change in it.
pub(crate) struct Composite {
    paired: Image<Paired>,
    /// Radiance.
    radiance: RgbImage,
    touched: Image<bool>,
}

impl Composite {
    /// Puts the change between the two renderings into the photograph; `grain` is the seed of the
    /// noise for synthetic parts, if they are to have any.
    pub(crate) fn new(
        restaging: &Restaging,
        photograph: &Photograph,
        paired: Image<Paired>,
        grain: Option<u64>,
    ) -> Self {
        let scene = &restaging.start.scene;
        let (width, height) = photograph.size();
        let geometry = Tracer::new(scene).geometry(&photograph.camera, width, height);
        let touched = touched::touched(&paired, &geometry, &photograph.photo.quantum);
        let mut clipped = geometry.map(|_| false);
        for index in clipping::clipped_pixels(&photograph.picture) {
            clipped.pixels_mut()[index] = true;
        }
        let seen = composite::Photograph {
            radiance: &photograph.photo.radiance,
            clipped: &clipped,
            geometry: &geometry,
            materials: &scene.materials(),
        };
        let mut radiance = composite::composite(&seen, &paired, &touched, Gain::Auto);
        if let Some(seed) = grain {
            let shot = shot(photograph, &geometry, scene.groups.len());
            grain::add(&mut radiance, &paired, shot, seed);
        }
        Self { paired, radiance, touched }
    }
}

/// The photograph's noise: variance for each unit of radiance, the median over its groups.
fn shot(photograph: &Photograph, geometry: &GeometryBuffers, groups: usize) -> Rgb {
    let photo = &photograph.photo;
    let picture = Picture {
        values: photo.radiance.clone(),
        trusted: photo.trusted.clone(),
        quantum: photo.quantum.clone(),
    };
    let shots = Observation::new(picture, geometry, groups).shot_of_group;
    let median = |channel: usize| {
        let mut values: Vec<f32> = shots.iter().map(|s| s[channel]).filter(|s| *s > 0.0).collect();
        values.sort_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    Rgb::new(median(0), median(1), median(2))
}

/// Writes a composite and its masks; returns how many values were not finite.
pub(crate) fn write_composite(
    composite: &Composite,
    photograph: &Photograph,
    folder: &Path,
) -> Result<usize, FileError> {
    let codes = codes(photograph, &composite.radiance, Some(&composite.touched));
    let linear = linear(photograph, composite);
    let depth = photograph.picture.depth;
    let mut bad = picture::write_exr(&folder.join("composite.exr"), &linear)?;
    bad += match depth {
        Depth::Float => picture::write_png_srgb(&folder.join("composite.png"), &linear)?,
        _ => picture::write_png_codes(&folder.join("composite.png"), &codes, depth)?,
    };
    let mask = |share: &dyn Fn(&Paired) -> f32| composite.paired.map(|p| Rgb::splat(share(p)));
    let uncovered = mask(&|pixel| pixel.uncovered);
    picture::write_png_codes(&folder.join("invented.png"), &uncovered, Depth::Eight)?;
    let touched = composite.touched.map(|&touched| Rgb::splat(f32::from(u8::from(touched))));
    picture::write_png_codes(&folder.join("touched.png"), &touched, Depth::Eight)?;
    let after = unrender_restage::pair::after(&composite.paired);
    bad += write_synthetic(&after, Some(photograph), folder, None)?;
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
            let codes = codes(photograph, radiance, None);
            picture::write_png_codes(&png, &codes, photograph.picture.depth)?;
        }
        Some(photograph) => {
            picture::write_png_srgb(&png, &radiance.map(|r| *r / photograph.exposure))?;
        }
        None => {
            picture::write_png_srgb(&png, radiance)?;
        }
    }
    Ok(bad)
}

/// The codes that the photograph's camera gives `radiance`; pixels that are not `touched` keep those
/// of the photograph.
fn codes(photograph: &Photograph, radiance: &RgbImage, touched: Option<&Image<bool>>) -> RgbImage {
    let codes = radiance.map(|radiance| {
        let linear = (*radiance / photograph.exposure).to_array();
        Rgb::from_array(linear.map(|value| photograph.response.code_from_linear(value)))
    });
    keeping(codes, &photograph.picture.values, touched)
}

/// The composite in the photograph's linear values, radiance over exposure. Where the photograph has
/// linear values itself, pixels that are not touched keep them to the bit.
fn linear(photograph: &Photograph, composite: &Composite) -> RgbImage {
    let linear = composite.radiance.map(|radiance| *radiance / photograph.exposure);
    let code = |code: &Rgb| {
        Rgb::from_array(code.to_array().map(|c| photograph.response.linear_from_code(c)))
    };
    keeping(linear, &photograph.picture.values.map(code), Some(&composite.touched))
}

fn keeping(mut picture: RgbImage, old: &RgbImage, touched: Option<&Image<bool>>) -> RgbImage {
    let Some(touched) = touched else { return picture };
    let pixels = picture.pixels_mut().iter_mut().zip(old.pixels()).zip(touched.pixels());
    pixels.filter(|(_, touched)| !**touched).for_each(|((new, old), _)| *new = *old);
    picture
}
