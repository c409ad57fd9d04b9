//! Perspective cameras: glTF's pinhole, which looks along its own -z with +y up and +x to the
//! right, with the distortion of a lens.

use crate::Lens;
use glam::{Affine3A, Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// A perspective camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// The node's name in the scene file.
    pub name: String,
    /// The pose: a rigid transform from camera to world coordinates.
    pub world_from_camera: Affine3A,
    /// Full vertical field of view, radians, of the pinhole with its axis through the picture's
    /// centre: 2 atan(height / (2 fy)), fy the focal length in pixels down. Independent of the
    /// picture's aspect.
    pub fov_y_rad: f32,
    /// The aspect (width over height) that the scene file states, if any.
    pub aspect: Option<f32>,
    /// The columns and rows of the picture that the scene file states, if any.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
    /// Principal point and distortion.
    pub lens: Lens,
    /// The depth of the near clipping plane, metres: what is nearer along the axis is not seen. Zero where nothing is cut
    /// away.
    #[serde(default)]
    pub near: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target` with `up` upwards in the picture.
    ///
    /// ```
    /// use glam::Vec3;
    /// use unrender_scene::Camera;
    ///
    /// let camera = Camera::look_at("camera", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5);
    /// let (x, y) = camera.project(Vec3::ZERO, 640, 480).unwrap();
    /// assert!((x - 320.0).abs() < 1e-3 && (y - 240.0).abs() < 1e-3);
    /// assert_eq!(camera.project(2.0 * Vec3::Z, 640, 480), None, "behind the camera");
    /// ```
    pub fn look_at(name: &str, eye: Vec3, target: Vec3, up: Vec3, fov_y_rad: f32) -> Self {
        let back = (eye - target).normalize();
        let right = up.cross(back).normalize();
        let axes = Mat3::from_cols(right, back.cross(right), back);
        let world_from_camera = Affine3A::from_mat3_translation(axes, eye);
        let lens = Lens::default();
        let (name, aspect, size, near) = (name.to_owned(), None, None, 0.0);
        Self { name, world_from_camera, fov_y_rad, aspect, size, lens, near }
    }

    /// Where the ray along the unit vector `direction` begins: at the camera's centre, or at its near clipping plane.
    #[inline]
    pub fn start(&self, direction: Vec3) -> Vec3 {
        if self.near == 0.0 {
            return self.origin();
        }
        let cos = -direction.dot(self.world_from_camera.matrix3.z_axis.into());
        self.origin() + (self.near / cos) * direction
    }

    /// The camera's centre in world space.
    pub fn origin(&self) -> Vec3 {
        self.world_from_camera.translation.into()
    }

    /// The projection of a world point into a picture of `width` x `height` pixels, in pixels from
    /// the top left; none if it lies outside of the picture or behind the camera.
    pub fn project(&self, point: Vec3, width: usize, height: usize) -> Option<(f32, f32)> {
        let to_point = point - self.origin();
        let axes = self.world_from_camera.matrix3;
        let depth = -to_point.dot(axes.z_axis.into());
        let half_height = (0.5 * self.fov_y_rad).tan();
        let (right, up) = (to_point.dot(axes.x_axis.into()), to_point.dot(axes.y_axis.into()));
        let (right, down) = if self.lens.distorts() {
            let pixels = 0.5 * height as f32 / half_height;
            let (right, down) = self.lens.distorted(right / depth, -up / depth)?;
            (right * pixels, down * pixels)
        } else {
            let pixels = 0.5 * height as f32 / (half_height * depth);
            (right * pixels, -up * pixels)
        };
        let (centre_x, centre_y) = self.principal_point(width, height);
        let (x, y) = (centre_x + right * self.lens.fx_over_fy, centre_y + down);
        let inside =
            depth > 0.0 && (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y);
        inside.then_some((x, y))
    }

    /// The unit direction in world space of the ray through the point (`x`, `y`) of a picture of
    /// `width` x `height` pixels; pixel (0, 0) is at the top left, its centre at (0.5, 0.5).
    #[inline]
    pub fn direction(&self, x: f32, y: f32, width: usize, height: usize) -> Vec3 {
        let half_height = (0.5 * self.fov_y_rad).tan();
        let pixel = 2.0 * half_height / height as f32;
        let (centre_x, centre_y) = self.principal_point(width, height);
        let (right, up) = ((x - centre_x) * pixel / self.lens.fx_over_fy, (centre_y - y) * pixel);
        let (right, down) = self.lens.undistorted(right, -up);
        let in_camera = Vec3::new(right, -down, -1.0);
        self.world_from_camera.transform_vector3(in_camera).normalize()
    }

    /// Whether the lens model is invertible over all of a picture of `width` x `height` pixels; too
    /// strong a distortion folds over before the corners.
    pub fn covers(&self, width: usize, height: usize) -> bool {
        let pixel = 2.0 * (0.5 * self.fov_y_rad).tan() / height as f32;
        let (x, y) = self.principal_point(width, height);
        let (side_x, side_y) = (x.max(width as f32 - x), y.max(height as f32 - y));
        self.lens.reaches(pixel * (side_x / self.lens.fx_over_fy).hypot(side_y))
    }

    /// The camera of a part of the picture of `size`, width and height in pixels, that this one takes: the part has
    /// its top left at `corner`, pixels, and the size `part`. It may reach beyond the picture, as the whole does for a
    /// part.
    ///
    /// ```
    /// use glam::Vec3;
    /// use unrender_scene::Camera;
    ///
    /// let whole = Camera::look_at("camera", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5);
    /// let part = whole.part((640, 480), (100, 30), (512, 401));
    /// let [a, b] = [whole.direction(300.0, 200.0, 640, 480), part.direction(200.0, 170.0, 512, 401)];
    /// assert!((a - b).length() < 1e-6);
    /// ```
    #[must_use]
    pub fn part(&self, size: (usize, usize), corner: (i64, i64), part: (usize, usize)) -> Self {
        if corner == (0, 0) && part == size {
            return self.clone();
        }
        let scale = part.1 as f64 / size.1 as f64;
        let half_height = (0.5 * f64::from(self.fov_y_rad)).tan() * scale;
        let centre = |principal: f32, side: usize, corner: i64, of_part: usize| {
            let at = 0.5 * side as f64 + f64::from(principal) * size.1 as f64 - corner as f64;
            ((at - 0.5 * of_part as f64) / part.1 as f64) as f32
        };
        let [right, down] = self.lens.principal_point;
        let principal_point =
            [centre(right, size.0, corner.0, part.0), centre(down, size.1, corner.1, part.1)];
        let stretched = part.0 as f64 / part.1 as f64 * size.1 as f64 / size.0 as f64;
        Self {
            fov_y_rad: (2.0 * half_height.atan()) as f32,
            aspect: self.aspect.map(|aspect| (f64::from(aspect) * stretched) as f32),
            size: None,
            lens: Lens { principal_point, ..self.lens },
            ..self.clone()
        }
    }

    /// The principal point of a picture of `width` x `height` pixels, in pixels from the top left.
    pub fn principal_point(&self, width: usize, height: usize) -> (f32, f32) {
        let [right, down] = self.lens.principal_point;
        let (width, height) = (width as f32, height as f32);
        (0.5 * width + right * height, 0.5 * height + down * height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_upright_and_not_mirrored() {
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        let (w, h) = (40, 20);
        let centre = camera.direction(20.0, 10.0, w, h);
        assert!((centre - Vec3::NEG_Z).length() < 1e-6);
        let top_left = camera.direction(0.0, 0.0, w, h);
        assert!(top_left.x < 0.0 && top_left.y > 0.0);
        let top = camera.direction(20.0, 0.0, w, h);
        assert!((top.angle_between(Vec3::NEG_Z) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn a_part_of_a_picture_has_its_directions_and_leads_back() {
        let mut whole =
            Camera::look_at("c", Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, 0.1, -1.0), Vec3::Y, 0.9);
        whole.lens = Lens {
            principal_point: [0.05, -0.03],
            k1: -0.15,
            fx_over_fy: 1.1,
            p1: 0.01,
            ..Lens::default()
        };
        let (size, part) = ((641, 483), (240, 160));
        let of_part = whole.part(size, (200, 81), part);
        for (x, y) in [(0.5, 0.5), (239.5, 159.5), (100.25, 31.0)] {
            let there = whole.direction(x + 200.0, y + 81.0, size.0, size.1);
            let here = of_part.direction(x, y, part.0, part.1);
            assert!((here - there).length() < 1e-6, "{here} {there}");
        }
        let back = of_part.part(part, (-200, -81), size);
        assert!((back.fov_y_rad - whole.fov_y_rad).abs() < 1e-6);
        let [a, b] = [back, whole.clone()].map(|camera| camera.lens.principal_point);
        assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6);
        assert_eq!(whole.part(size, (0, 0), size), whole);
    }

    #[test]
    fn projecting_a_direction_gives_its_pixel_back() {
        let camera =
            Camera::look_at("c", Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, 0.1, -1.0), Vec3::Y, 0.9);
        let (x, y) = (17.25, 30.5);
        let point = camera.origin() + 4.0 * camera.direction(x, y, 64, 48);
        let back = camera.project(point, 64, 48).unwrap();
        assert!((back.0 - x).abs() < 1e-3 && (back.1 - y).abs() < 1e-3, "{back:?}");
        assert_eq!(camera.project(camera.origin() * 2.0 - point, 64, 48), None);
    }

    #[test]
    fn a_lens_shifts_and_bends_and_projection_follows() {
        let target = Vec3::new(0.2, 0.1, -1.0);
        let mut camera = Camera::look_at("c", Vec3::new(1.0, 2.0, 3.0), target, Vec3::Y, 0.9);
        camera.lens =
            Lens { principal_point: [0.05, -0.03], k1: -0.15, k2: 0.02, ..Lens::default() };
        let (w, h) = (640, 480);
        let axis = camera.direction(320.0 + 0.05 * 480.0, 240.0 - 0.03 * 480.0, w, h);
        assert!((axis - (target - camera.origin()).normalize()).length() < 1e-6);
        for (x, y) in [(0.5, 0.5), (639.5, 479.5), (17.25, 300.5), (344.0, 225.6)] {
            let point = camera.origin() + 4.0 * camera.direction(x, y, w, h);
            let back = camera.project(point, w, h).unwrap();
            assert!((back.0 - x).abs() < 2e-3 && (back.1 - y).abs() < 2e-3, "{back:?}");
        }
        let all = Lens { fx_over_fy: 1.1, k3: 0.01, p1: 2e-3, p2: -1e-3, ..camera.lens };
        let all = Camera { lens: all, ..camera.clone() };
        for (x, y) in [(0.5, 0.5), (639.5, 479.5), (17.25, 300.5), (344.0, 225.6)] {
            let point = all.origin() + 4.0 * all.direction(x, y, w, h);
            let back = all.project(point, w, h).unwrap();
            assert!((back.0 - x).abs() < 2e-3 && (back.1 - y).abs() < 2e-3, "{back:?}");
        }
        // Barrel distortion enlarges the field of view.
        let plain = Camera { lens: Lens::default(), ..camera.clone() };
        let corner = |c: &Camera| c.direction(0.0, 0.0, w, h).dot(axis);
        assert!(corner(&camera) < corner(&plain));
        assert!(camera.covers(w, h));
        camera.lens.k1 = -0.9;
        assert!(!camera.covers(w, h));
    }

    #[test]
    fn pixels_may_be_wider_than_high() {
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        let lens = Lens { fx_over_fy: 0.5, ..Lens::default() };
        let wide = Camera { lens, ..camera.clone() };
        let (w, h) = (40, 20);
        let point = Vec3::new(0.3, 0.2, -1.0);
        let (x, y) = camera.project(point, w, h).unwrap();
        let (wide_x, wide_y) = wide.project(point, w, h).unwrap();
        assert!((wide_x - 20.0 - 0.5 * (x - 20.0)).abs() < 1e-5 && wide_y == y);
        assert!((wide.direction(wide_x, y, w, h) - point.normalize()).length() < 1e-6);
    }

    #[test]
    fn the_default_lens_leaves_the_bits_as_they_were() {
        let eye = Vec3::new(1.0, 2.0, 3.0);
        let camera = Camera::look_at("c", eye, Vec3::new(0.2, 0.1, -1.0), Vec3::Y, 0.9);
        let (w, h) = (641, 479);
        let pixel = 2.0 * (0.5f32 * 0.9).tan() / h as f32;
        for (x, y) in [(0.5f32, 0.5f32), (320.7, 17.1), (640.5, 478.5)] {
            let plain = Vec3::new((x - 0.5 * w as f32) * pixel, (0.5 * h as f32 - y) * pixel, -1.0);
            let plain = camera.world_from_camera.transform_vector3(plain).normalize();
            assert_eq!(camera.direction(x, y, w, h), plain);
            let point = eye + 3.7 * plain;
            let axes = camera.world_from_camera.matrix3;
            let to_point = point - camera.origin();
            let depth = -to_point.dot(axes.z_axis.into());
            let pixels = 0.5 * h as f32 / ((0.5f32 * 0.9).tan() * depth);
            let shown = (
                0.5 * w as f32 + to_point.dot(axes.x_axis.into()) * pixels,
                0.5 * h as f32 - to_point.dot(axes.y_axis.into()) * pixels,
            );
            assert_eq!(camera.project(point, w, h), Some(shown));
        }
    }
}
