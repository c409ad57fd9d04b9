//! Environment maps: light from infinite distance.
//!
//! The panorama is equirectangular: columns are equal steps of heading, rows equal steps of the
//! angle from straight up. Its centre shows what lies along world -z, where a camera without any
//! rotation looks, and +x lies to the right of that, a quarter of the picture on; its upper edge is
//! +y (`docs/reference/conventions.md`). In a scene of which +z points upwards ([`UpAxis`]), it is turned as a whole: its
//! centre shows what lies along +y, and its upper edge is +z. With `heading = atan2(x, -z)`, the direction (x, y, z) is at
//!
//! ```text
//! column = width  (1/2 + (heading + rotation) / (2 pi)), modulo width
//! row    = height acos(y) / pi
//! ```

use crate::color::luminance;
use crate::{Rgb, RgbImage, UpAxis};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::f64::consts::PI as PI_64;
use std::sync::Arc;

/// An environment map, visible behind the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Environment {
    #[serde(serialize_with = "crate::serial::pointee")]
    radiance: Arc<RgbImage>,
    rotation_rad: f32,
    is_in_parts: bool,
    up: UpAxis,
    #[serde(skip_serializing)]
    mean: Rgb,
}

/// Where a direction lies between the centres of a panorama's pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corners {
    /// The pixels about it: above left, above right, below left, below right.
    pub pixels: [usize; 4],
    /// How far it lies to the right of the left ones, and below the upper ones, 0 to 1.
    right: f32,
    down: f32,
}

impl Corners {
    /// Those of the place (u, v), in widths and heights from the upper left corner of a panorama of `columns` and
    /// `rows`; columns wrap around, rows end at the poles.
    fn at((u, v): (f32, f32), columns: usize, rows: usize) -> Self {
        let (x, y) = (u * columns as f32 - 0.5, v * rows as f32 - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let at = |i: i32, j: i32| {
            let x = (column as i32 + i).rem_euclid(columns as i32) as usize;
            let y = (row as i32 + j).clamp(0, rows as i32 - 1) as usize;
            y * columns + x
        };
        let pixels = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        Self { pixels, right: x - column, down: y - row }
    }

    /// The share of each of the pixels; they sum to one.
    pub fn shares(&self) -> [f32; 4] {
        let Self { right, down, .. } = *self;
        let (left, up) = (1.0 - right, 1.0 - down);
        [left * up, right * up, left * down, right * down]
    }

    /// The bilinear interpolation between the pixels `of`.
    fn between(&self, of: impl Fn(usize) -> Rgb) -> Rgb {
        let [a, b, c, d] = self.pixels.map(of);
        let upper = a * (1.0 - self.right) + b * self.right;
        let lower = c * (1.0 - self.right) + d * self.right;
        upper * (1.0 - self.down) + lower * self.down
    }
}

/// An [`Environment`] before its pixels were checked.
#[derive(Deserialize)]
struct Unchecked {
    radiance: RgbImage,
    rotation_rad: f32,
    #[serde(default)]
    is_in_parts: bool,
    #[serde(default)]
    up: UpAxis,
}

impl TryFrom<Unchecked> for Environment {
    type Error = EnvironmentError;

    fn try_from(read: Unchecked) -> Result<Self, EnvironmentError> {
        let environment = Self::new(read.radiance, read.rotation_rad)?;
        Ok(Self { is_in_parts: read.is_in_parts, up: read.up, ..environment })
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
        let mean = mean_over_directions(&radiance);
        let (radiance, up) = (Arc::new(radiance), UpAxis::Y);
        Ok(Self { radiance, rotation_rad, is_in_parts: false, up, mean })
    }

    /// The same environment in a scene of which `up` points upwards: its upper edge lies there, its middle to the north.
    pub fn with_up(self, up: UpAxis) -> Self {
        Self { up, ..self }
    }

    /// Which axis of the scene its upper edge lies along.
    pub fn up(&self) -> UpAxis {
        self.up
    }

    /// The same environment, of which each pixel is a source of light of its own, whose brightness may be estimated.
    pub fn in_parts(self) -> Self {
        Self { is_in_parts: true, ..self }
    }

    /// The columns and rows of its parts: of the panorama if each pixel is a source of its own, else one.
    pub fn parts(&self) -> [usize; 2] {
        if self.is_in_parts { [self.radiance.width(), self.radiance.height()] } else { [1, 1] }
    }

    /// The radiance from everywhere, W sr^-1 m^-2, its mean over all directions.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// The share of the mean over all directions that one of its parts has: the solid angle of a pixel of its row
    /// over that of the sphere.
    pub fn share(&self, part: usize) -> f64 {
        let [columns, rows] = self.parts();
        row_share(part / columns, rows) / columns as f64
    }

    /// Multiplies its radiance by `factor`, channel by channel; factors that are negative or not finite, and those that
    /// would make a pixel infinite, change nothing.
    pub fn scale(&mut self, factor: Rgb) {
        self.change(self.radiance.map(|radiance| *radiance * factor));
    }

    /// Multiplies the radiance of one part by `factor`; see [`Environment::scale`].
    pub fn scale_part(&mut self, part: usize, factor: Rgb) {
        if !self.is_in_parts {
            return self.scale(factor);
        }
        let mut scaled = (*self.radiance).clone();
        if let Some(radiance) = scaled.pixels_mut().get_mut(part) {
            *radiance *= factor;
        }
        self.change(scaled);
    }

    /// Shows `radiance` if it is valid.
    fn change(&mut self, radiance: RgbImage) {
        if let Ok(changed) = Self::new(radiance, self.rotation_rad) {
            *self = Self { is_in_parts: self.is_in_parts, up: self.up, ..changed };
        }
    }

    /// The panorama.
    pub fn panorama(&self) -> &RgbImage {
        &self.radiance
    }

    /// How far the panorama is turned about the axis upwards, counter-clockwise seen from above, radians.
    pub fn rotation_rad(&self) -> f32 {
        self.rotation_rad
    }

    /// True if it is not black.
    pub fn is_bright(&self) -> bool {
        self.radiance.pixels().iter().any(|rgb| luminance(*rgb) > 0.0)
    }

    /// The position of the unit vector `direction` in the panorama: from its left edge and from its
    /// top, in widths and heights of it, 0 to 1.
    pub fn place(&self, direction: Vec3) -> (f32, f32) {
        let direction = self.up.to_y_up(direction);
        let heading = direction.x.atan2(-direction.z);
        let u = 0.5 + (heading + self.rotation_rad) / TAU;
        (u - u.floor(), direction.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI)
    }

    /// The unit vector at `u` widths from the panorama's left edge and the cosine `cos_polar` of
    /// the polar angle.
    pub fn direction(&self, u: f32, cos_polar: f32) -> Vec3 {
        let (sin, cos) = ((u - 0.5) * TAU - self.rotation_rad).sin_cos();
        let ring = ((1.0 - cos_polar) * (1.0 + cos_polar)).max(0.0).sqrt();
        self.up.from_y_up(Vec3::new(ring * sin, cos_polar, -ring * cos))
    }

    /// The radiance from the direction of the unit vector `direction`, bilinear between the pixels'
    /// centres; columns wrap around, rows end at the poles.
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        self.radiance_at(self.place(direction))
    }

    /// The radiance at the place (u, v) of the panorama, in widths and heights of it from its upper left corner;
    /// interpolated as [`Environment::radiance`] is.
    pub fn radiance_at(&self, place: (f32, f32)) -> Rgb {
        self.corners_at(place).between(|pixel| self.radiance.pixels()[pixel])
    }

    /// The radiance, W sr^-1 m^-2, if it is the same from everywhere.
    pub fn uniform(&self) -> Option<Rgb> {
        let (first, others) = self.radiance.pixels().split_first()?;
        others.iter().all(|other| other == first).then_some(*first)
    }

    /// The pixels about the direction of the unit vector `direction`.
    pub fn corners(&self, direction: Vec3) -> Corners {
        self.corners_at(self.place(direction))
    }

    fn corners_at(&self, place: (f32, f32)) -> Corners {
        Corners::at(place, self.radiance.width(), self.radiance.height())
    }

    /// The cosine of the polar angle at `v` heights from the panorama's top.
    pub fn cos_polar(v: f32) -> f32 {
        (v * PI).cos()
    }
}

/// The solid angle of one of `rows` rows over that of the sphere.
fn row_share(row: usize, rows: usize) -> f64 {
    let cos_polar = |row: usize| (PI_64 * row as f64 / rows as f64).cos();
    0.5 * (cos_polar(row) - cos_polar(row + 1))
}

/// The mean of `panorama` over all directions: a row counts as much as the part of the sphere that it covers.
fn mean_over_directions(panorama: &RgbImage) -> Rgb {
    let (width, height) = (panorama.width(), panorama.height());
    let mut mean = DVec3::ZERO;
    for (row, pixels) in panorama.pixels().chunks(width).enumerate() {
        mean += row_share(row, height) / width as f64
            * pixels.iter().map(|rgb| rgb.as_dvec3()).sum::<DVec3>();
    }
    mean.as_vec3()
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

    #[test]
    fn corners_share_what_lies_between_them() {
        let environment = numbered(30.0);
        for direction in [Vec3::NEG_Z, Vec3::Y, Vec3::new(0.3, -0.4, 0.5).normalize()] {
            let corners = environment.corners(direction);
            let shares = corners.pixels.iter().zip(corners.shares());
            let sum: Rgb =
                shares.map(|(pixel, share)| environment.panorama().pixels()[*pixel] * share).sum();
            assert!((sum - environment.radiance(direction)).abs().max_element() < 1e-4);
        }
    }

    #[test]
    fn it_is_uniform_if_all_pixels_are_alike() {
        assert_eq!(numbered(0.0).uniform(), None);
        let alike = RgbImage::new(2, 1, vec![Rgb::new(1.0, 2.0, 3.0); 2]);
        let alike = Environment::new(alike, 0.4).unwrap();
        assert_eq!(alike.uniform(), Some(Rgb::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn each_part_may_be_a_source_of_its_own() {
        let mut whole = numbered(0.0);
        whole.scale_part(3, Rgb::splat(2.0));
        assert_eq!((whole.parts(), whole.panorama().pixels()[4].x), ([1, 1], 20.0));
        let mut apart = numbered(0.0).in_parts();
        apart.scale_part(3, Rgb::splat(2.0));
        assert_eq!(apart.parts(), [4, 2]);
        assert_eq!(apart.panorama().pixels()[3..5], [6.0, 10.0].map(Rgb::splat));
    }

    #[test]
    fn its_mean_is_over_the_sphere() {
        // Half of the sphere is less than a quarter turn from straight up, and a quarter of it within 60 degrees.
        let rows = [1.0, 2.0, 4.0].map(Rgb::splat);
        let mut environment = Environment::new(RgbImage::new(1, 3, rows.to_vec()), 0.3).unwrap();
        assert!((environment.mean() - Rgb::splat(0.25 + 1.0 + 1.0)).length() < 1e-6);
        environment.scale(Rgb::new(2.0, 0.0, 1.0));
        assert!((environment.mean() - Rgb::new(4.5, 0.0, 2.25)).length() < 1e-6);
        let before = environment.clone();
        for odd in [Rgb::splat(-1.0), Rgb::splat(f32::NAN), Rgb::MAX] {
            environment.scale(odd);
        }
        assert_eq!(environment, before);
    }
}
