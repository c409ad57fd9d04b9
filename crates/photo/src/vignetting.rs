//! Vignetting: the fall-off of a lens away from its axis.
//!
//! The vignetting factor `v` of a pixel is 1 on the optical axis. Two laws:
//!
//! - [`Law::Cos4`]: `v = cos^4` of the angle between the pixel's ray and the axis, the natural
//!   vignetting of a lens [Reiss 1945; Gardner 1947].
//! - [`Law::Radial`]: `v = 1 + a1 r^2 + a2 r^4 + a3 r^6`, with `r` the distance in the picture from
//!   the optical axis, in units of half the picture's diagonal: 1 in the corners of a picture whose
//!   axis is in the middle.

use serde::{Deserialize, Serialize};
use unrender_scene::{Camera, Image};

/// The law of the fall-off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Law {
    /// With the fourth power of the cosine of the angle to the axis.
    Cos4,
    /// The polynomial of the module head with a1, a2, a3.
    Radial([f32; 3]),
}

/// The vignetting of the pictures of one camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vignetting {
    /// The law.
    pub law: Law,
    /// The camera.
    pub camera: Camera,
    /// Width and height of its pictures, pixels.
    pub size: (usize, usize),
}

/// Factors below this are refused: a signal of 2 % is mostly noise. At 1 % eight-bit files have two
/// steps left, at 4 % some real wide-angle lenses would be refused.
pub const DARKEST: f32 = 0.02;

impl Vignetting {
    /// The factor at the point (`x`, `y`), in pixels from the top left.
    pub fn share(&self, x: f32, y: f32) -> f32 {
        match self.law {
            Law::Cos4 => {
                let (width, height) = self.size;
                let axis = -self.camera.world_from_camera.matrix3.z_axis;
                let cos = self.camera.direction(x, y, width, height).dot(axis.into());
                cos.powi(4)
            }
            Law::Radial([a1, a2, a3]) => {
                let r2 = radius(&self.camera, self.size, x, y).powi(2);
                1.0 + r2 * (a1 + r2 * (a2 + r2 * a3))
            }
        }
    }

    /// The factor at the centre of every pixel.
    pub fn picture(&self) -> Image<f32> {
        let (width, height) = self.size;
        Image::from_fn(width, height, |x, y| self.share(x as f32 + 0.5, y as f32 + 0.5))
    }

    /// The smallest factor at the centre of a pixel.
    pub fn darkest(&self) -> f32 {
        self.picture().pixels().iter().copied().fold(1.0, f32::min)
    }
}

/// The distance of an image point from the optical axis of `camera`, in units of half the diagonal.
pub fn radius(camera: &Camera, (width, height): (usize, usize), x: f32, y: f32) -> f32 {
    let (centre_x, centre_y) = camera.principal_point(width, height);
    2.0 * (x - centre_x).hypot(y - centre_y) / (width as f32).hypot(height as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn vignetting(law: Law) -> Vignetting {
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::new(1.0, 2.0, -3.0), Vec3::Y, 1.0);
        Vignetting { law, camera, size: (400, 300) }
    }

    #[test]
    fn cos4_follows_the_angle() {
        let vignetting = vignetting(Law::Cos4);
        assert!((vignetting.share(200.0, 150.0) - 1.0).abs() < 1e-6);
        // The upper edge's middle is half the field of view away.
        assert!((vignetting.share(200.0, 0.0) - 0.5f32.cos().powi(4)).abs() < 1e-5);
    }

    #[test]
    fn polynomials_count_from_the_axis_to_the_corner() {
        let mut vignetting = vignetting(Law::Radial([-0.5, 0.2, -0.1]));
        assert!((vignetting.share(0.0, 300.0) - 0.6).abs() < 1e-6);
        assert!((vignetting.share(200.0, 25.0) - (1.0 - 0.125 + 0.0125 - 0.1 / 64.0)).abs() < 1e-6);
        vignetting.camera.lens.principal_point = [0.1, 0.0];
        assert_eq!(vignetting.share(230.0, 150.0), 1.0);
        assert!(vignetting.darkest() < 0.6);
    }
}
