//! Panoramas that light a scene.

use super::Depth;
use crate::{FileError, Input};
use unrender_scene::{Environment, Rgb, Warnings};

/// Panoramas of the whole sphere are twice as wide as high; beyond this share there is a warning.
const ASPECT_TOLERANCE: f64 = 0.02;

/// Reads the equirectangular panorama at `path` as an environment, turned by `rotation_rad` (see
/// [`Environment::new`]), whose radiance is `scale` times the picture's linear values. Transparent pixels
/// give the light that the file has there; pixels without a value give none, with a warning.
///
/// # Errors
/// If the picture cannot be read, or if `scale` makes its radiance infinite.
pub fn read_environment<'a>(
    input: impl Into<Input<'a>>,
    rotation_rad: f32,
    scale: f32,
) -> Result<(Environment, Warnings), FileError> {
    let input = input.into();
    let path = input.path;
    let (picture, mut warnings) = super::read(input)?;
    if picture.depth != Depth::Float {
        warnings.push(format!(
            "{}: was taken for an sRGB picture, which lacks light brighter than its white, such as \
             lamps and sun; use a .hdr or .exr file",
            path.display()
        ));
    }
    let black = |index: &&usize| picture.values.pixels()[**index] == Rgb::ZERO;
    let missing = picture.invalid.iter().filter(black).count();
    if missing > 0 {
        warnings.push(format!(
            "{}: {missing} pixel(s) without a value give no light here",
            path.display()
        ));
    }
    let mut negative = 0;
    let radiance = picture.to_linear().map(|rgb| {
        negative += usize::from(rgb.min_element() < 0.0);
        rgb.max(Rgb::ZERO) * scale
    });
    if negative > 0 {
        warnings.push(format!(
            "{}: {negative} pixel(s) have negative values, which were taken as zero",
            path.display()
        ));
    }
    let (width, height) = (radiance.width(), radiance.height());
    if (width as f64 / (2.0 * height as f64) - 1.0).abs() > ASPECT_TOLERANCE {
        warnings.push(format!(
            "{}: a panorama of all directions is twice as wide as high; this one has {width} x \
             {height} pixels and was stretched over the sphere",
            path.display()
        ));
    }
    let environment =
        Environment::new(radiance, rotation_rad).map_err(|error| FileError::new(path, error))?;
    if !environment.is_bright() {
        warnings.push(format!("{}: is black and gives no light", path.display()));
    }
    Ok((environment, warnings))
}
