//! Environments for other programs: as one radiance, or as a panorama beside the scene.
//!
//! Programs interpolate panoramas in ways of their own at the poles, which shows in those of few pixels, as a recovery
//! finds them. They are written in more pixels, between which there is nothing left to choose.

use super::Target;
use crate::texels;
use std::borrow::Cow;
use unrender_scene::{Environment, Image, Rgb, RgbImage, Scene, UpAxis};

/// The panorama's file, beside the scene's.
pub(super) const FILE: &str = "environment.exr";

/// The rows that a panorama has at least, 0.7 degrees each. Cycles takes the last half row at a pole for a mixture with
/// the other pole: at half of this 0.7 degrees of the sphere are wrong, at double 0.2 (not tried).
const ROWS: usize = 256;

/// What lights a scene from all around.
pub(super) enum Around<'a> {
    /// The same radiance from everywhere, W sr^-1 m^-2.
    Uniform(Rgb),
    /// A radiance for each direction, with +y upwards.
    Panorama(Cow<'a, Environment>),
}

/// The environment of `scene`; none if it has none, or a black one.
pub(super) fn around(scene: &Scene) -> Option<Around<'_>> {
    let environment = scene.environment.as_ref().filter(|around| around.is_bright())?;
    let uniform = environment.uniform().map(Around::Uniform);
    Some(uniform.unwrap_or_else(|| Around::Panorama(upright(environment))))
}

/// The environment as a panorama whose upper edge is +y, in the pixels of its own.
fn upright(environment: &Environment) -> Cow<'_, Environment> {
    if environment.up() == UpAxis::Y {
        return Cow::Borrowed(environment);
    }
    let (width, height) = (environment.panorama().width(), environment.panorama().height());
    let place = |at: usize, count: usize| (at as f32 + 0.5) / count as f32;
    let turned = |plain: Environment| {
        let panorama = Image::from_fn(width, height, |x, y| {
            let cos_polar = Environment::cos_polar(place(y, height));
            environment.radiance(plain.direction(place(x, width), cos_polar))
        });
        Environment::new(panorama, 0.0)
    };
    let plain = Environment::new(environment.panorama().clone(), 0.0);
    // What lies between pixels that are sound is sound, too.
    plain.and_then(turned).map_or(Cow::Borrowed(environment), Cow::Owned)
}

/// The columns and rows in which the panorama of `environment` is written: its own, or an even multiple of them.
pub(super) fn size(environment: &Environment) -> (usize, usize) {
    let (width, height) = (environment.panorama().width(), environment.panorama().height());
    let times = if height < ROWS { 2 * ROWS.div_ceil(2 * height) } else { 1 };
    (times * width, times * height)
}

/// The panorama of `environment` as it is, not turned, at its [`size`].
pub(super) fn panorama(environment: &Environment) -> RgbImage {
    let (width, height) = size(environment);
    if height == environment.panorama().height() {
        return environment.panorama().clone();
    }
    Image::from_fn(width, height, |x, y| {
        let place = |at: usize, count: usize| (at as f32 + 0.5) / count as f32;
        environment.radiance_at((place(x, width), place(y, height)))
    })
}

/// `picture` as the contents of [`FILE`].
///
/// # Errors
/// If it is too large for an EXR file.
pub(super) fn file(picture: &RgbImage) -> Result<(String, Vec<u8>), String> {
    Ok((FILE.into(), texels::exr(picture)?))
}

/// What a user of a format that has no environments has to do in the other program; none without an environment.
pub(super) fn left_out(scene: &Scene, target: Target) -> Option<String> {
    let what = match around(scene)? {
        Around::Uniform(radiance) => {
            let [r, g, b] = radiance.to_array();
            format!("a radiance of [{r}, {g}, {b}] from everywhere")
        }
        Around::Panorama(environment) => {
            let panorama = environment.panorama();
            let [r, g, b] = environment.mean().to_array();
            format!(
                "a panorama of {} x {} pixels that shows in its middle what lies along -z, with +x to the right, \
                 turned about +y by {:.1} degrees, counter-clockwise seen from above; the mean of its radiance over \
                 all directions is [{r:.4}, {g:.4}, {b:.4}]",
                panorama.width(),
                panorama.height(),
                environment.rotation_rad().to_degrees()
            )
        }
    };
    Some(format!("{target} has no words for the environment: add it in the other program, {what}"))
}
