//! A straight segment in the picture whose direction in the scene is one of the axes.
//!
//! All lines along an axis `d` meet in its vanishing point `v = K R d`, in homogeneous pixels. For ends `p` and `q` with
//! independent errors, the residual is the distance of the segment from a line through `v`, to first order
//! [Sampson 1982]:
//!
//! ```text
//! r = det(p, q, v) / sqrt(|v_xy - v_z p|^2 + |v_xy - v_z q|^2)
//! ```
//!
//! It does not depend on the scale of `v`, and holds for vanishing points at infinity, where `v_z = 0`.

use crate::calibrate::model::{Free, Model, Observed};
use nalgebra::{DMatrixViewMut, Matrix3, Vector2, Vector3};

/// A segment along an axis of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Pixels from the picture's centre, right and down.
    pub(super) ends: [Vector2<f64>; 2],
    /// 0, 1 or 2 for x, y or z.
    pub(super) axis: usize,
}

impl Segment {
    /// The line through both ends: `n . (x, y, 1) = 0`, as long as the segment.
    pub(super) fn line(&self) -> Vector3<f64> {
        let [p, q] = self.ends.map(|end| end.push(1.0));
        p.cross(&q)
    }

    /// From each end to the vanishing point, times the point's third coordinate.
    fn ways(&self, vanishing: &Vector3<f64>) -> [Vector2<f64>; 2] {
        self.ends.map(|end| vanishing.xy() - vanishing.z * end)
    }

    /// Whether the second end is further along the axis than the first.
    pub(super) fn runs_along(&self, model: &Model) -> bool {
        let [way, _] = self.ways(&vanishing(model, self.axis));
        way.dot(&(self.ends[1] - self.ends[0])) > 0.0
    }
}

/// How many of the segments are along x, y and z.
pub(super) fn counts(segments: &[Segment]) -> [usize; 3] {
    [0, 1, 2].map(|axis| segments.iter().filter(|segment| segment.axis == axis).count())
}

/// How many axes have a vanishing point.
fn axes_with_two(segments: &[Segment]) -> usize {
    counts(segments).iter().filter(|count| **count >= 2).count()
}

/// How many axes must have a vanishing point: two for the focal length and the rotation.
pub(super) fn axes_needed(free: Free) -> usize {
    if free.principal_point { 3 } else { 2 }
}

/// The vanishing point of an axis, homogeneous, pixels from the picture's centre.
fn vanishing(model: &Model, axis: usize) -> Vector3<f64> {
    to_picture(model, &model.camera_from_world.column(axis).into_owned())
}

/// The camera matrix times a direction in the camera's frame.
fn to_picture(model: &Model, direction: &Vector3<f64>) -> Vector3<f64> {
    let plane = model.ln_focal.exp() * direction.xy() + direction.z * model.principal_point;
    plane.push(direction.z)
}

impl Observed for Segment {
    const ROWS: usize = 1;

    /// Also two of each axis, as a single one has no vanishing point.
    fn fewest(observed: &[Self], free: Free) -> usize {
        let pairs: usize = counts(observed).iter().map(|count| count.min(&2)).sum();
        pairs.max(free.count())
    }

    fn suffice(observed: &[Self], free: Free) -> bool {
        axes_with_two(observed) >= axes_needed(free) && observed.len() >= free.count()
    }

    fn kind(&self) -> usize {
        self.axis
    }

    /// Both ends are on one side of the vanishing point, behind which no line is seen.
    fn is_in_front(&self, model: &Model) -> bool {
        let [first, second] = self.ways(&vanishing(model, self.axis));
        first.dot(&second) > 0.0
    }

    fn residual(&self, model: &Model) -> Vector2<f64> {
        let vanishing = vanishing(model, self.axis);
        let [first, second] = self.ways(&vanishing);
        let norm = (first.norm_squared() + second.norm_squared()).sqrt().max(f64::MIN_POSITIVE);
        Vector2::new(self.line().dot(&vanishing) / norm, 0.0)
    }

    fn derive(
        &self,
        model: &Model,
        free: Free,
        turn: &Matrix3<f64>,
        mut rows: DMatrixViewMut<'_, f64>,
    ) {
        let direction: Vector3<f64> = model.camera_from_world.column(self.axis).into_owned();
        let vanishing = to_picture(model, &direction);
        let line = self.line();
        let [first, second] = self.ways(&vanishing);
        let norm = (first.norm_squared() + second.norm_squared()).sqrt().max(f64::MIN_POSITIVE);
        let residual = line.dot(&vanishing) / norm;
        let [p, q] = self.ends;
        // r = n . v / S, so dr = (n - r dS/dv) . dv / S.
        let by_xy = (first + second) / norm;
        let by_z = -(first.dot(&p) + second.dot(&q)) / norm;
        let by_vanishing = (line - residual * by_xy.push(by_z)) / norm;
        let mut set = |column: Option<usize>, step: Vector3<f64>| {
            if let Some(column) = column {
                rows[(0, column)] = by_vanishing.dot(&step);
            }
        };
        let by_turn = -direction.cross_matrix() * turn;
        let of_direction = |step: Vector3<f64>| to_picture(model, &step);
        for column in 0..3 {
            set(Some(column), of_direction(by_turn.column(column).into_owned()));
        }
        set(free.of_focal(), (model.ln_focal.exp() * direction.xy()).push(0.0));
        for axis in 0..2 {
            let mut step = Vector3::zeros();
            step[axis] = direction.z;
            set(free.of_principal_point(axis), step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::model::{jacobian, residuals};
    use nalgebra::Rotation3;

    fn camera() -> Model {
        let turn = Rotation3::new(Vector3::new(0.3, 0.8, -0.2)).into_inner();
        let mut camera = Model::pinhole(turn, Vector3::new(0.5, 1.5, 3.0), 800.0);
        camera.principal_point = Vector2::new(12.0, -8.0);
        camera
    }

    /// Where a point of the camera's frame is seen.
    fn seen(camera: &Model, point: Vector3<f64>) -> Vector2<f64> {
        let image = to_picture(camera, &point);
        image.xy() / image.z
    }

    #[test]
    fn lines_of_the_scene_have_no_residual() {
        let camera = camera();
        for axis in 0..3 {
            let along = camera.camera_from_world.column(axis).into_owned();
            for begin in [Vector3::new(-1.0, 0.4, 5.0), Vector3::new(0.7, -0.9, 8.0)] {
                let ends = [begin, begin + 1.5 * along].map(|point| seen(&camera, point));
                let segment = Segment { ends, axis };
                assert!(segment.residual(&camera).x.abs() < 1e-9);
                assert!(segment.is_in_front(&camera) && segment.runs_along(&camera));
                let back = Segment { ends: [ends[1], ends[0]], axis };
                assert!(back.is_in_front(&camera) && !back.runs_along(&camera));
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let free = Free { position: false, focal: true, principal_point: true, distortion: false };
        let at = [0.1, 0.2, -0.15, 0.1, 2.0, -1.0];
        let turn = Vector3::new(at[0], at[1], at[2]);
        let ends = [Vector2::new(100.0, -80.0), Vector2::new(230.0, 40.0)];
        let segments = [0, 1, 2].map(|axis| Segment { ends, axis });
        let analytic = jacobian(&camera().moved(&at, free), &segments, free, &turn);
        for column in 0..free.count() {
            let shifted = |by: f64| {
                let mut step = at;
                step[column] += by;
                residuals(&camera().moved(&step, free), &segments)
            };
            let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            let difference = (analytic.column(column) - &numeric).norm();
            assert!(difference < 1e-6 * (1.0 + numeric.norm()), "column {column}: {difference}");
        }
    }
}
