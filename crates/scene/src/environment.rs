//! Environment maps: light from infinite distance.
//!
//! The panorama is equirectangular: columns are equal steps of heading, rows equal steps of the
//! angle from straight up. Its centre shows what lies along world -z, where a camera without any
//! rotation looks, and +x lies to the right of that, a quarter of the picture on; its upper edge is
//! +y (`docs/reference/conventions.md`). With `heading = atan2(x, -z)`, the direction (x, y, z) is at
//!
//! ```text
//! column = width  (1/2 + (heading + rotation) / (2 pi)), modulo width
//! row    = height acos(y) / pi
//! ```

use crate::color::luminance;
use crate::{Rgb, RgbImage};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

/// An environment map, visible behind the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Environment {
    #[serde(serialize_with = "crate::serial::pointee")]
    radiance: Arc<RgbImage>,
    rotation_rad: f32,
}

/// An [`Environment`] before its pixels were checked.
#[derive(Deserialize)]
struct Unchecked {
    radiance: RgbImage,
    rotation_rad: f32,
}

impl TryFrom<Unchecked> for Environment {
    type Error = EnvironmentError;

    fn try_from(read: Unchecked) -> Result<Self, EnvironmentError> {
        Self::new(read.radiance, read.rotation_rad)
    }
}

/// Why a picture is no valid environment map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// It has no pixels.
    #[error("the panorama has no pixels")]
    Empty,
    /// A pixel is negative or not finite.
    #[error("pixel {pixel} of the panorama is negative or not a finite number")]
    NotRadiance {
        /// The pixel's index.
        pixel: usize,
    },
    /// The rotation is not a finite number.
    #[error("the rotation of the environment is not a finite number")]
    Rotation,
}

impl Environment {
    /// The environment that shows `radiance` (W sr^-1 m^-2 per channel, linear), turned about world
    /// +y by `rotation_rad`, counter-clockwise seen from above: by a quarter turn, the panorama's
    /// centre comes from -z to -x.
    ///
    /// # Errors
    /// If there are no pixels, or values that are negative or not finite.
    pub fn new(radiance: RgbImage, rotation_rad: f32) -> Result<Self, EnvironmentError> {
        if radiance.pixels().is_empty() {
            return Err(EnvironmentError::Empty);
        }
        let sound = |rgb: &Rgb| rgb.is_finite() && rgb.min_element() >= 0.0;
        if let Some(pixel) = radiance.pixels().iter().position(|rgb| !sound(rgb)) {
            return Err(EnvironmentError::NotRadiance { pixel });
        }
        if !rotation_rad.is_finite() {
            return Err(EnvironmentError::Rotation);
        }
        Ok(Self { radiance: Arc::new(radiance), rotation_rad })
    }

    /// The panorama.
    pub fn panorama(&self) -> &RgbImage {
        &self.radiance
    }

    /// True if it is not black.
    pub fn is_bright(&self) -> bool {
        self.radiance.pixels().iter().any(|rgb| luminance(*rgb) > 0.0)
    }

    /// The position of the unit vector `direction` in the panorama: from its left edge and from its
    /// top, in widths and heights of it, 0 to 1.
    pub fn place(&self, direction: Vec3) -> (f32, f32) {
        let heading = direction.x.atan2(-direction.z);
        let u = 0.5 + (heading + self.rotation_rad) / TAU;
        (u - u.floor(), direction.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI)
    }

    /// The unit vector at `u` widths from the panorama's left edge and the cosine `cos_polar` of
    /// the polar angle.
    pub fn direction(&self, u: f32, cos_polar: f32) -> Vec3 {
        let (sin, cos) = ((u - 0.5) * TAU - self.rotation_rad).sin_cos();
        let ring = ((1.0 - cos_polar) * (1.0 + cos_polar)).max(0.0).sqrt();
        Vec3::new(ring * sin, cos_polar, -ring * cos)
    }

    /// The radiance from the direction of the unit vector `direction`, bilinear between the pixels'
    /// centres; columns wrap around, rows end at the poles.
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        let (u, v) = self.place(direction);
        let (width, height) = (self.radiance.width(), self.radiance.height());
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (right, down) = (x - column, y - row);
        let at = |i: i32, j: i32| {
            let x = (column as i32 + i).rem_euclid(width as i32) as usize;
            let y = (row as i32 + j).clamp(0, height as i32 - 1) as usize;
            *self.radiance.at(x, y)
        };
        let upper = at(0, 0) * (1.0 - right) + at(1, 0) * right;
        let lower = at(0, 1) * (1.0 - right) + at(1, 1) * right;
        upper * (1.0 - down) + lower * down
    }

    /// The cosine of the polar angle at `v` heights from the panorama's top.
    pub fn cos_polar(v: f32) -> f32 {
        (v * PI).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four columns and two rows of eight colours.
    fn numbered(rotation_deg: f32) -> Environment {
        let panorama = RgbImage::from_fn(4, 2, |x, y| Rgb::splat((10 * y + x) as f32));
        Environment::new(panorama, rotation_deg.to_radians()).unwrap()
    }

    #[test]
    fn the_centre_is_ahead_right_is_right_and_up_is_up() {
        let environment = numbered(0.0);
        for (direction, place) in [
            (Vec3::NEG_Z, (0.5, 0.5)),
            (Vec3::X, (0.75, 0.5)),
            (Vec3::NEG_X, (0.25, 0.5)),
            (Vec3::new(0.0, 1.0, -1.0).normalize(), (0.5, 0.25)),
        ] {
            let (u, v) = environment.place(direction);
            assert!((u - place.0).abs() < 1e-6 && (v - place.1).abs() < 1e-6, "{direction}");
            assert!(
                (environment.direction(u, Environment::cos_polar(v)) - direction).length() < 1e-6
            );
        }
        assert_eq!(environment.place(Vec3::Y).1, 0.0);
        assert_eq!(environment.place(Vec3::NEG_Y).1, 1.0);
        // The middle of the third column, above and below the horizon.
        let ahead_right = |y| Vec3::new(1.0, y, -1.0).normalize();
        assert!((environment.radiance(ahead_right(9.0)).x - 2.0).abs() < 1e-5);
        assert!((environment.radiance(ahead_right(-9.0)).x - 12.0).abs() < 1e-5);
    }

    #[test]
    fn rotation_is_counter_clockwise_seen_from_above() {
        let (plain, turned) = (numbered(0.0), numbered(90.0));
        for direction in [Vec3::NEG_Z, Vec3::new(0.3, 0.4, -0.5).normalize()] {
            let moved = glam::Quat::from_rotation_y(90f32.to_radians()) * direction;
            let off = plain.radiance(direction) - turned.radiance(moved);
            assert!(off.abs().max_element() < 1e-4, "{direction}");
            let (u, v) = turned.place(moved);
            assert!((turned.direction(u, Environment::cos_polar(v)) - moved).length() < 1e-5);
        }
        assert!((turned.place(Vec3::NEG_X).0 - 0.5).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_radiance_is_refused() {
        let of = |value| Environment::new(RgbImage::new(1, 1, vec![Rgb::splat(value)]), 0.0);
        assert!(of(0.0).is_ok_and(|e| !e.is_bright()) && of(1.0).is_ok_and(|e| e.is_bright()));
        for odd in [-1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(of(odd), Err(EnvironmentError::NotRadiance { pixel: 0 }));
        }
        let empty = Environment::new(RgbImage::new(0, 0, Vec::new()), 0.0);
        assert_eq!(empty, Err(EnvironmentError::Empty));
        let one = RgbImage::new(1, 1, vec![Rgb::ONE]);
        assert_eq!(Environment::new(one, f32::NAN), Err(EnvironmentError::Rotation));
    }
}
