//! Panoramas as PBRT v4 has them: the sphere folded into a square whose pixels all cover the same solid angle.
//!
//! The square's middle is +z and its corners are -z; a diamond between the middles of its edges is the equator.
//! In the diamond, the distance `r` from the middle, 0 to 1 by the sum of both coordinates, has `z = 1 - r^2`, and the
//! angle about z grows evenly along the side of a smaller diamond. What is outside of it is the other half of the
//! sphere, folded over the diamond's sides. [Clarberg 2008; Pharr, Jakob, Humphreys: pbrt-v4, `EqualAreaSquareToSphere`]

use crate::export::environment;
use glam::Vec3;
use std::f32::consts::FRAC_PI_4;
use unrender_scene::{Environment, Image, Rgb, RgbImage};

/// A pixel is the mean of this many places along each side. At half of it (one place), what is as small as a pixel of
/// the panorama is met by chance; double of it costs four times the time (neither tried).
const FINER: usize = 2;

/// `environment` in the axes of the world, turned as it is, in a square of as many pixels as its panorama is written in
/// ([`environment::size`]). PBRT does not interpolate between them.
pub(super) fn panorama(environment: &Environment) -> RgbImage {
    let (width, height) = environment::size(environment);
    let side = ((width * height) as f32).sqrt().ceil() as usize;
    Image::from_fn(side, side, |x, y| {
        let places = (0..FINER * FINER).map(|k| [(x, k % FINER), (y, k / FINER)]);
        let step =
            |(at, k): (usize, usize)| (at as f32 + (k as f32 + 0.5) / FINER as f32) / side as f32;
        let sum: Rgb = places.map(|place| environment.radiance(direction(place.map(step)))).sum();
        sum / (FINER * FINER) as f32
    })
}

/// The unit vector at a place of the square, 0 to 1 from its upper left corner.
fn direction(place: [f32; 2]) -> Vec3 {
    let [u, v] = place.map(|p| 2.0 * p - 1.0);
    let above = 1.0 - (u.abs() + v.abs());
    let r = 1.0 - above.abs();
    let around = if r == 0.0 { 1.0 } else { (v.abs() - u.abs()) / r + 1.0 };
    let (sin, cos) = (around * FRAC_PI_4).sin_cos();
    let ring = r * (2.0 - r * r).max(0.0).sqrt();
    let z = (1.0 - r * r).copysign(above);
    Vec3::new((ring * cos).copysign(u), (ring * sin).copysign(v), z)
}
