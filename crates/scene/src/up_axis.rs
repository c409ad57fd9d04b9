//! Which axis of a scene points upwards.

use glam::{DVec3, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_PI_2;

/// The axis of a scene that points upwards: +y as in glTF, or +z as programs for CAD, buildings and photogrammetry have
/// it. Panoramas stand on it, and so do models that are put into the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", expecting = "up_axis is \"y\" or \"z\"")]
pub enum UpAxis {
    /// +y is up, and -z north.
    #[default]
    Y,
    /// +z is up, and +y north.
    Z,
}

/// A camera looks down where the cosine between its axis and -y is above this. Then +z upwards in its picture says nothing
/// of the world: at half of it cameras that look down a little are asked about, at one those of floor plans are not.
const DOWN: f32 = 0.7;
/// An axis that a file states may be off by so much in single precision and four decimals.
const ROUNDING: f32 = 1e-3;

impl UpAxis {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// The unit vector upwards.
    pub fn unit(self) -> Vec3 {
        self.from_y_up(Vec3::Y)
    }

    /// A vector of a scene whose y points upwards, in this scene.
    ///
    /// ```
    /// use glam::Vec3;
    /// use unrender_scene::UpAxis;
    ///
    /// assert_eq!(UpAxis::Z.from_y_up(Vec3::NEG_Z), Vec3::Y, "north");
    /// assert_eq!(UpAxis::Z.to_y_up(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(1.0, 3.0, -2.0));
    /// ```
    #[inline]
    pub fn from_y_up(self, v: Vec3) -> Vec3 {
        match self {
            Self::Y => v,
            Self::Z => Vec3::new(v.x, -v.z, v.y),
        }
    }

    /// A vector of this scene, in one whose y points upwards.
    #[inline]
    pub fn to_y_up(self, v: Vec3) -> Vec3 {
        match self {
            Self::Y => v,
            Self::Z => Vec3::new(v.x, v.z, -v.y),
        }
    }

    /// The rotation of [`UpAxis::from_y_up`].
    pub fn rotation(self) -> Quat {
        match self {
            Self::Y => Quat::IDENTITY,
            Self::Z => Quat::from_rotation_x(FRAC_PI_2),
        }
    }

    /// The place with two horizontal coordinates, x and z or x and y, at a height.
    pub fn place(self, [a, b]: [f64; 2], height: f64) -> DVec3 {
        match self {
            Self::Y => DVec3::new(a, height, b),
            Self::Z => DVec3::new(a, b, height),
        }
    }

    /// The names of the two horizontal coordinates.
    pub fn horizontal(self) -> [&'static str; 2] {
        match self {
            Self::Y => ["x", "z"],
            Self::Z => ["x", "y"],
        }
    }

    /// The height of a point.
    #[inline]
    pub fn height(self, v: Vec3) -> f32 {
        match self {
            Self::Y => v.y,
            Self::Z => v.z,
        }
    }

    /// The axis that a camera says, which looks along the unit vector `ahead` with the unit vector `up` upwards in its
    /// picture: z if that is +z. Floor plans have it so too, where y is up; they look down.
    pub fn of_camera(ahead: Vec3, up: Vec3) -> Option<Self> {
        let is_along = |axis: Vec3| (up - axis).length() < ROUNDING;
        match () {
            () if is_along(Vec3::Y) => Some(Self::Y),
            () if is_along(Vec3::Z) && ahead.dot(Vec3::NEG_Y) < DOWN => Some(Self::Z),
            () => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_up_is_a_rotation_of_y_up() {
        for v in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.3, -0.4, 0.5)] {
            for up in [UpAxis::Y, UpAxis::Z] {
                assert!((up.rotation() * v - up.from_y_up(v)).length() < 1e-6);
                assert_eq!(up.to_y_up(up.from_y_up(v)), v);
                assert_eq!(up.height(v), up.to_y_up(v).y);
            }
        }
        assert_eq!(UpAxis::Z.place([1.0, 2.0], 3.0), DVec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn a_camera_says_which_axis_is_up_unless_it_looks_down() {
        let ahead = Vec3::new(0.0, 0.9, -0.3).normalize();
        assert_eq!(UpAxis::of_camera(ahead, Vec3::Z), Some(UpAxis::Z));
        assert_eq!(UpAxis::of_camera(Vec3::X, Vec3::Z), Some(UpAxis::Z));
        assert_eq!(UpAxis::of_camera(Vec3::NEG_Z, Vec3::Y), Some(UpAxis::Y));
        // A floor plan where y is up.
        assert_eq!(UpAxis::of_camera(Vec3::NEG_Y, Vec3::Z), None);
        assert_eq!(UpAxis::of_camera(Vec3::NEG_Y, Vec3::NEG_Z), None);
        assert_eq!(UpAxis::of_camera(Vec3::NEG_Z, Vec3::new(0.6, 0.8, 0.0)), None);
    }
}
