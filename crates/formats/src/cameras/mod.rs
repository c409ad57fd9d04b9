//! Cameras as other programs calibrate them: a 3 x 3 matrix, distortion, and a pose.
//!
//! [OpenCV and COLMAP] have a camera that looks along its own +z, with x to the right and y downwards;
//! a pose takes the world to the camera, `x_camera = R x_world + t`. Ours looks along -z with y upwards:
//! the axes of [`unrender_scene::Camera`] are the rows of R, of which the second and the third change
//! their sign, and its centre is `-R^T t`.
//!
//! Pixels are counted here from the top left corner of the picture, so that the first one's centre is
//! (0.5, 0.5), as COLMAP has it. OpenCV puts that centre at (0, 0); [`opencv`] adds the half.
//!
//! Calibrations may be of the pixels that a file stores, and ours are of the upright picture: [`Pixels`].

pub mod colmap;
pub mod opencv;
mod storage;
mod turned;

use glam::{Affine3A, DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use unrender_scene::{Camera, Lens};

pub use turned::{Pixels, turn};

/// What is read of cameras of other programs.
pub(crate) fn tables() -> [crate::entry::Table; 2] {
    [colmap::table(), opencv::table()]
}

/// Rotations are orthonormal up to this: files are written with six digits or more.
const RIGID: f64 = 1e-3;

/// Focal lengths, principal point and distortion, in pixels of one size of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// The focal length in pixels across.
    pub fx: f64,
    /// The focal length in pixels down.
    pub fy: f64,
    /// The principal point, pixels from the left edge.
    pub cx: f64,
    /// The principal point, pixels from the upper edge.
    pub cy: f64,
    /// The distortion: k1, k2, p1, p2, k3, in OpenCV's order.
    pub distortion: [f64; 5],
    /// The width and the height of the picture whose pixels these are, where that is known.
    pub size: Option<[f64; 2]>,
}

/// From world to camera: `x_camera = rotation x_world + translation`, with y downwards and z forwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The rotation R.
    pub rotation: DMat3,
    /// The translation t, in lengths of the world.
    pub translation: DVec3,
}

impl Pose {
    /// The pose with this rotation and translation.
    ///
    /// # Errors
    /// If the matrix is not a rotation, or a number is not finite.
    pub fn new(rotation: DMat3, translation: DVec3) -> Result<Self, String> {
        let off = rotation.transpose() * rotation - DMat3::IDENTITY;
        let is_rigid = off.to_cols_array().iter().all(|e| e.abs() < RIGID);
        if is_rigid && rotation.determinant() > 0.0 && translation.is_finite() {
            return Ok(Self { rotation, translation });
        }
        Err("its pose is no rotation with a translation; write R and t as cv2.solvePnP and \
             cv2.Rodrigues give them"
            .into())
    }

    /// The pose with a rotation vector, as long as the angle in radians, as for `cv2.Rodrigues`.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn of_rotation_vector(vector: DVec3, translation: DVec3) -> Result<Self, String> {
        let angle = vector.length();
        let rotation = match vector.try_normalize() {
            Some(axis) => DMat3::from_axis_angle(axis, angle),
            None if vector.is_finite() => DMat3::IDENTITY,
            None => DMat3::NAN,
        };
        Self::new(rotation, translation)
    }

    /// The camera's axes and centre as ours has them, after `scene_from_world`, a similarity.
    pub fn world_from_camera(&self, scene_from_world: &DAffine3) -> Affine3A {
        let rows = self.rotation.transpose();
        let axes = DMat3::from_cols(rows.x_axis, -rows.y_axis, -rows.z_axis);
        let eye = scene_from_world.transform_point3(-(rows * self.translation));
        let turned = scene_from_world.matrix3 * axes;
        let unit = |axis: DVec3| axis.normalize().as_vec3();
        Affine3A::from_mat3_translation(
            glam::Mat3::from_cols(unit(turned.x_axis), unit(turned.y_axis), unit(turned.z_axis)),
            eye.as_vec3(),
        )
    }
}

impl Intrinsics {
    /// The intrinsics of a window of the picture, whose upper left corner is `left`, `top`, pixels.
    #[must_use]
    pub fn cropped(self, [left, top]: [f64; 2]) -> Self {
        Self { cx: self.cx - left, cy: self.cy - top, size: None, ..self }
    }

    /// The camera of a photograph of `width` x `height` pixels: these pixels, or the same picture at
    /// another size.
    ///
    /// # Errors
    /// If a number is impossible for a camera, or the photograph does not match
    /// [`Intrinsics::size`].
    pub fn camera(
        &self,
        name: &str,
        world_from_camera: Affine3A,
        (width, height): (usize, usize),
    ) -> Result<Camera, String> {
        self.check()?;
        let (wide, high) = (width as f64, height as f64);
        let [across, down] = match self.size {
            Some([w, h]) => {
                self.check_size([w, h], [wide, high])?;
                [wide / w, high / h]
            }
            None => [1.0, 1.0],
        };
        let (fx, fy) = (self.fx * across, self.fy * down);
        let (right, below) = (self.cx * across - 0.5 * wide, self.cy * down - 0.5 * high);
        let [k1, k2, p1, p2, k3] = self.distortion.map(|number| number as f32);
        let lens = Lens {
            principal_point: [(right / high) as f32, (below / high) as f32],
            fx_over_fy: (fx / fy) as f32,
            k1,
            k2,
            k3,
            p1,
            p2,
        };
        let fov_y_rad = (2.0 * (0.5 * high / fy).atan()) as f32;
        let aspect = Some((wide / high) as f32);
        if !(lens.is_valid() && fov_y_rad > 0.0) {
            return Err("its focal length or its distortion is far too large".into());
        }
        let (name, size, near) = (name.to_owned(), None, 0.0);
        Ok(Camera { name, world_from_camera, fov_y_rad, aspect, size, lens, near })
    }

    fn check(&self) -> Result<(), String> {
        let Self { fx, fy, cx, cy, distortion, .. } = *self;
        if !(fx > 0.0 && fy > 0.0 && fx.is_finite() && fy.is_finite()) {
            return Err(format!(
                "its focal lengths are {fx} and {fy}; they are positive, in pixels"
            ));
        }
        if !(cx.is_finite() && cy.is_finite() && distortion.iter().all(|k| k.is_finite())) {
            return Err("its principal point or its distortion is not finite".into());
        }
        Ok(())
    }

    fn check_size(&self, [w, h]: [f64; 2], [wide, high]: [f64; 2]) -> Result<(), String> {
        if !(w >= 1.0 && h >= 1.0) {
            return Err(format!("its picture has {w} x {h} pixels"));
        }
        if is_alike([w, h], [wide, high]) {
            return Ok(());
        }
        let remedy = if (wide - high) * (w - h) < 0.0 {
            "the photo is turned; calibrate with upright pictures"
        } else {
            "if the photo was cut out of such a picture, say where by crop = [left, top], pixels"
        };
        Err(format!(
            "it is of a picture of {w} x {h} pixels, and the photo has {wide} x {high}: {remedy}"
        ))
    }
}

/// Whether one size is the other scaled: the sides have the same ratio, up to a pixel.
fn is_alike([w, h]: [f64; 2], [wide, high]: [f64; 2]) -> bool {
    (wide * h - high * w).abs() <= w.max(h)
}

/// A similarity that takes the world of a calibration to the scene, from the rows of its matrix.
///
/// # Errors
/// If it is not one: sheared, mirrored or not finite.
pub fn similarity(rows: &[[f64; 4]]) -> Result<DAffine3, String> {
    let fault = || {
        "it is no rotation with one scale and a translation: three rows of four numbers, as \
         CloudCompare and model_aligner write them"
            .to_owned()
    };
    if !(rows.len() == 3 || rows.len() == 4 && rows[3] == [0.0, 0.0, 0.0, 1.0]) {
        return Err(fault());
    }
    let linear = DMat3::from_cols_array_2d(&[0, 1, 2].map(|c| [0, 1, 2].map(|r| rows[r][c])));
    let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
    let scale = linear.determinant().cbrt();
    if !(scale > 0.0 && scale.is_finite() && translation.is_finite()) {
        return Err(fault());
    }
    let rotation = linear * (1.0 / scale);
    let off = rotation.transpose() * rotation - DMat3::IDENTITY;
    if off.to_cols_array().iter().any(|e| e.is_nan() || e.abs() > RIGID) {
        return Err(fault());
    }
    Ok(DAffine3 { matrix3: linear, translation })
}

/// The similarity of a world whose z points upwards, as Blender's: its (x, y, z) is our (x, z, -y).
pub const Z_UP: DAffine3 = DAffine3 {
    matrix3: DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    translation: DVec3::ZERO,
};

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, Vec3};

    /// Half a turn about x: a camera of OpenCV that looks as ours does without a pose.
    fn half_turn() -> Pose {
        Pose::of_rotation_vector(DVec3::X * std::f64::consts::PI, DVec3::ZERO).unwrap()
    }

    const K: Intrinsics = Intrinsics {
        fx: 700.0,
        fy: 500.0,
        cx: 330.0,
        cy: 225.0,
        distortion: [-0.2, 0.05, 1e-3, -2e-3, 0.01],
        size: Some([640.0, 480.0]),
    };

    /// Brown's model by hand, in double precision.
    fn pixel(k: &Intrinsics, pose: &Pose, point: DVec3) -> [f64; 2] {
        let p = pose.rotation * point + pose.translation;
        let (x, y) = (p.x / p.z, p.y / p.z);
        let r2 = x * x + y * y;
        let [k1, k2, p1, p2, k3] = k.distortion;
        let radial = 1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3);
        let bent_x = radial * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
        let bent_y = radial * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
        [k.fx * bent_x + k.cx, k.fy * bent_y + k.cy]
    }

    #[test]
    fn y_down_and_z_forward_become_y_up_and_z_back() {
        let pose = half_turn().world_from_camera(&DAffine3::IDENTITY);
        assert!(pose.abs_diff_eq(Affine3A::IDENTITY, 1e-6), "{pose}");
        let pinhole = Intrinsics { distortion: [0.0; 5], ..K };
        let camera = pinhole.camera("c", pose, (640, 480)).unwrap();
        // Right of the axis and above it, by hand.
        let (x, y) = camera.project(Vec3::new(0.1, 0.2, -1.0), 640, 480).unwrap();
        assert!((x - 400.0).abs() < 1e-3 && (y - 125.0).abs() < 1e-3, "{x} {y}");
        // The ray through the first pixel's centre.
        let ray = camera.direction(0.5, 0.5, 640, 480);
        let by_hand = Vec3::new((0.5 - 330.0) / 700.0, (225.0 - 0.5) / 500.0, -1.0).normalize();
        assert!((ray - by_hand).length() < 1e-6, "{ray} {by_hand}");
    }

    #[test]
    fn any_pose_shows_points_where_the_equations_do() {
        let rotation = DQuat::from_euler(glam::EulerRot::XYZ, 2.9, 0.3, -0.2);
        let pose = Pose::new(DMat3::from_quat(rotation), DVec3::new(0.2, 0.1, 3.0)).unwrap();
        let camera =
            K.camera("c", pose.world_from_camera(&DAffine3::IDENTITY), (640, 480)).unwrap();
        let half = K.camera("c", pose.world_from_camera(&DAffine3::IDENTITY), (320, 240)).unwrap();
        for point in [[0.0, 0.0, 0.0], [0.5, 0.4, -0.3], [-0.9, 0.5, 0.4], [0.3, -0.8, 0.2]] {
            let point = DVec3::from(point);
            let [x, y] = pixel(&K, &pose, point);
            let seen = camera.project(point.as_vec3(), 640, 480).unwrap();
            let off = (f64::from(seen.0) - x).hypot(f64::from(seen.1) - y);
            assert!(off < 1e-3, "{point}: {seen:?}, not {x} {y}");
            let small = half.project(point.as_vec3(), 320, 240).unwrap();
            let off = (2.0 * f64::from(small.0) - x).hypot(2.0 * f64::from(small.1) - y);
            assert!(off < 2e-3, "{point}: {small:?}");
        }
        let cut = K.cropped([100.0, 40.0]);
        let cut = cut.camera("c", pose.world_from_camera(&DAffine3::IDENTITY), (300, 240)).unwrap();
        let (x, y) = camera.project(Vec3::ZERO, 640, 480).unwrap();
        let seen = cut.project(Vec3::ZERO, 300, 240).unwrap();
        assert!((seen.0 + 100.0 - x).abs() < 1e-3 && (seen.1 + 40.0 - y).abs() < 1e-3);
    }

    #[test]
    fn worlds_are_turned_moved_and_scaled_into_the_scene() {
        // A camera at (1, -4, 2) of a world with z upwards, that looks along its y.
        let rotation = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
        let pose = Pose::new(rotation, -(rotation * DVec3::new(1.0, -4.0, 2.0))).unwrap();
        let place = pose.world_from_camera(&Z_UP);
        assert!(place.translation.abs_diff_eq(glam::Vec3A::new(1.0, 2.0, 4.0), 1e-6), "{place}");
        assert!(place.matrix3.abs_diff_eq(glam::Mat3A::IDENTITY, 1e-6), "{place}");
        let rows = [[2.0, 0.0, 0.0, 1.0], [0.0, 0.0, 2.0, 0.0], [0.0, -2.0, 0.0, 0.0]];
        let place = pose.world_from_camera(&similarity(&rows).unwrap());
        assert!(place.translation.abs_diff_eq(glam::Vec3A::new(3.0, 4.0, 8.0), 1e-6), "{place}");
        assert!(place.matrix3.abs_diff_eq(glam::Mat3A::IDENTITY, 1e-6), "{place}");
        for bad in [
            vec![[1.0, 0.0, 0.0, 0.0]; 3],
            vec![[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]],
            vec![[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]],
            vec![[1.0, 0.0, 0.0, 0.0], [0.0, 1.1, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            vec![[1.0, 0.0, 0.0, f64::NAN], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        ] {
            assert!(similarity(&bad).unwrap_err().contains("no rotation"), "{bad:?}");
        }
    }

    #[test]
    fn cameras_that_cannot_be_meant_are_reported() {
        let pose = half_turn().world_from_camera(&DAffine3::IDENTITY);
        let fault = |k: Intrinsics, size| k.camera("c", pose, size).unwrap_err();
        assert!(fault(Intrinsics { fx: 0.0, ..K }, (640, 480)).contains("focal lengths are 0"));
        assert!(fault(Intrinsics { cx: f64::NAN, ..K }, (640, 480)).contains("not finite"));
        assert!(fault(K, (480, 640)).contains("the photo is turned"));
        assert!(fault(K, (600, 480)).contains("crop = [left, top]"));
        assert!(K.camera("c", pose, (213, 160)).is_ok(), "a third, rounded");
        let mirrored = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        assert!(Pose::new(mirrored, DVec3::ZERO).unwrap_err().contains("no rotation"));
        assert!(Pose::of_rotation_vector(DVec3::NAN, DVec3::ZERO).is_err());
    }
}
