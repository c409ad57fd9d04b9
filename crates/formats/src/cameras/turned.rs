//! Cameras of the pixels that a file stores, for the picture that its EXIF orientation turns upright.

use super::{Intrinsics, Pose, is_alike};
use crate::picture::Orientation;
use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The pixels of a photograph that its EXIF orientation turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pixels {
    /// As they are stored in the file.
    Stored,
    /// Turned upright, as pictures are shown.
    Upright,
}

impl Pixels {
    /// The pixels that a calibration of pictures of the size `calibrated` refers to, where the size decides;
    /// `upright` is the size of the upright photograph.
    pub fn by_size(
        calibrated: [f64; 2],
        upright: [f64; 2],
        orientation: Orientation,
    ) -> Option<Self> {
        let [width, height] = upright;
        let is_of = |size| is_alike(calibrated, size);
        match (is_of([height, width]), is_of(upright)) {
            (true, false) if orientation.swaps_sides() => Some(Self::Stored),
            (false, true) if orientation.swaps_sides() => Some(Self::Upright),
            _ => None,
        }
    }
}

/// What `orientation` does to the axes of a camera (right, down, forwards).
pub fn turn(orientation: Orientation) -> DMat3 {
    let flat = orientation.upright_from_stored();
    DMat3::from_cols(flat.x_axis.extend(0.0), flat.y_axis.extend(0.0), DVec3::Z)
}

impl Intrinsics {
    /// The intrinsics of the upright picture, from those of the stored one; `stored` is its size if they
    /// state none.
    #[must_use]
    pub fn turned(self, orientation: Orientation, stored: [f64; 2]) -> Self {
        let upright_from_stored = orientation.upright_from_stored();
        let side = |sides: DVec2| (upright_from_stored * sides).abs();
        let size = DVec2::from_array(self.size.unwrap_or(stored));
        let focal = side(DVec2::new(self.fx, self.fy));
        let off = DVec2::new(self.cx, self.cy) - 0.5 * size;
        let axis = 0.5 * side(size) + upright_from_stored * off;
        // Brown's tangential terms move a point x by 2 (q x) x + (x x) q with the vector q = (p2, p1), which
        // turns as the points do.
        let [k1, k2, p1, p2, k3] = self.distortion;
        let tilt = upright_from_stored * DVec2::new(p2, p1);
        Self {
            fx: focal.x,
            fy: focal.y,
            cx: axis.x,
            cy: axis.y,
            distortion: [k1, k2, tilt.y, tilt.x, k3],
            size: self.size.map(|_| side(size).to_array()),
        }
    }
}

impl Pose {
    /// The pose for the upright picture, from that for the stored one; none if one is a mirror image of
    /// the other, which no camera takes.
    #[must_use]
    pub fn turned(self, orientation: Orientation) -> Option<Self> {
        let turn = turn(orientation);
        let turned = Self { rotation: turn * self.rotation, translation: turn * self.translation };
        (!orientation.mirrors()).then_some(turned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DQuat};

    const STORED: Intrinsics = Intrinsics {
        fx: 700.0,
        fy: 690.0,
        cx: 331.0,
        cy: 222.0,
        distortion: [-0.12, 0.02, 3e-3, -2e-3, 0.01],
        size: Some([640.0, 480.0]),
    };

    fn orientation(number: u8) -> Orientation {
        Orientation::from_exif(number).unwrap()
    }

    /// A pixel of the stored picture in the upright one, by what EXIF says of its eight
    /// orientations.
    fn upright([x, y]: [f64; 2], number: u8) -> [f64; 2] {
        let [w, h] = [640.0, 480.0];
        match number {
            2 => [w - x, y],
            3 => [w - x, h - y],
            4 => [x, h - y],
            5 => [y, x],
            6 => [h - y, x],
            7 => [h - y, w - x],
            8 => [y, w - x],
            _ => [x, y],
        }
    }

    fn seen(k: &Intrinsics, pose: &Pose, point: DVec3) -> [f64; 2] {
        let size = k.size.unwrap();
        let size = (size[0] as usize, size[1] as usize);
        let placed = pose.world_from_camera(&DAffine3::IDENTITY);
        let camera = k.camera("c", placed, size).unwrap();
        let (x, y) = camera.project(point.as_vec3(), size.0, size.1).unwrap();
        [x.into(), y.into()]
    }

    #[test]
    fn a_turned_camera_shows_points_where_the_turned_picture_does() {
        let rotation = DQuat::from_euler(glam::EulerRot::XYZ, 2.9, 0.3, -0.2);
        let pose = Pose::new(DMat3::from_quat(rotation), DVec3::new(0.2, 0.1, 3.0)).unwrap();
        for number in 1..=8 {
            let orientation = orientation(number);
            // Once a mirrored picture is mirrored back, a rotation is left.
            let (turn, mirrored) = match orientation.mirrors() {
                true => (orientation.mirrored_back(), true),
                false => (orientation, false),
            };
            let k = STORED.turned(turn, [1.0; 2]);
            let turned = pose.turned(turn).unwrap();
            assert_eq!(pose.turned(orientation).is_none(), mirrored);
            for point in [[0.0, 0.0, 0.0], [0.5, 0.4, -0.3], [-0.6, 0.5, 0.4], [0.3, -0.5, 0.2]] {
                let point = DVec3::from(point);
                let mut expected = upright(seen(&STORED, &pose, point), number);
                if mirrored {
                    expected[0] = k.size.unwrap()[0] - expected[0];
                }
                let [x, y] = seen(&k, &turned, point);
                let off = (x - expected[0]).hypot(y - expected[1]);
                assert!(off < 2e-3, "orientation {number}: {x} {y}, not {expected:?}");
            }
        }
    }

    #[test]
    fn intrinsics_turn_where_the_pose_is_not_theirs() {
        // By hand: a quarter clockwise takes right to down, and left of the middle to above it.
        let k = STORED.turned(orientation(6), [1.0; 2]);
        assert_eq!((k.fx, k.fy, k.cx, k.cy), (690.0, 700.0, 480.0 - 222.0, 331.0));
        assert_eq!(k.size, Some([480.0, 640.0]));
        let mirrored = Intrinsics { size: None, ..STORED }.turned(orientation(2), [640.0, 480.0]);
        assert_eq!((mirrored.cx, mirrored.cy, mirrored.size), (640.0 - 331.0, 222.0, None));
        assert_eq!(mirrored.distortion, [-0.12, 0.02, 3e-3, 2e-3, 0.01]);
    }

    #[test]
    fn sizes_tell_where_sides_are_exchanged() {
        let of = |size, photo, number| Pixels::by_size(size, photo, orientation(number));
        let [wide, high] = [[640.0, 480.0], [480.0, 640.0]];
        assert_eq!(of(wide, high, 6), Some(Pixels::Stored));
        assert_eq!(of(high, high, 6), Some(Pixels::Upright));
        assert_eq!(of(wide, [240.0, 320.0], 5), Some(Pixels::Stored), "made smaller");
        assert_eq!(of(wide, wide, 3), None);
        assert_eq!(of([500.0; 2], [500.0; 2], 8), None);
        assert_eq!(of([500.0; 2], high, 8), None, "another picture");
    }
}
