//! Which way the axes point, and where the camera stands.
//!
//! Lines determine the rotation up to half turns about the axes, and nothing of the position: one line of known length
//! does, or the camera's height.

use super::segment::Segment;
use crate::calibrate::model::{Free, Model};
use crate::calibrate::refine::Certainty;
use nalgebra::{DMatrix, Matrix2, Matrix3, Vector2, Vector3};

/// The half turns that keep a frame right-handed.
const TURNS: [[f64; 3]; 4] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// The same camera with the axes pointing as most of the `directed` segments run, then with y upwards, then looking
/// towards -z.
pub(super) fn oriented(model: &Model, directed: &[Segment]) -> Model {
    let turned = TURNS.map(|signs| {
        let turn = Matrix3::from_diagonal(&Vector3::from(signs));
        Model { camera_from_world: model.camera_from_world * turn, ..*model }
    });
    let score = |model: &Model| {
        let votes = directed.iter().filter(|segment| segment.runs_along(model)).count();
        let axes = model.camera_from_world;
        // The camera's own axes point to the right, downwards and forwards.
        (votes, axes[(1, 1)] < 0.0, axes[(2, 2)] < 0.0)
    };
    turned.into_iter().max_by_key(score).unwrap_or(*model)
}

/// The distance of both ends along their rays, in depths, for a segment of `length` metres: the least squares of
/// `s2 r2 - s1 r1 = length R d`. None if one of them is not in front of the camera.
fn depths(model: &Model, segment: &Segment, length: f64) -> Option<[f64; 2]> {
    let [r1, r2] = rays(model, segment);
    let along = length * model.camera_from_world.column(segment.axis);
    let square = Matrix2::new(r1.dot(&r1), -r1.dot(&r2), -r1.dot(&r2), r2.dot(&r2));
    let solved = square.try_inverse()? * Vector2::new(-r1.dot(&along), r2.dot(&along));
    (solved.x > 0.0 && solved.y > 0.0).then_some(solved.into())
}

/// The rays through both ends, at depth one, in the camera's frame.
fn rays(model: &Model, segment: &Segment) -> [Vector3<f64>; 2] {
    segment.ends.map(|end| ((end - model.principal_point) / model.ln_focal.exp()).push(1.0))
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Metres, with the segment's first end as the origin.
    pub(super) eye: Vector3<f64>,
    /// Standard deviations, metres.
    pub(super) std: Vector3<f64>,
    /// The depth of the segment's middle, metres.
    pub(super) depth: f64,
}

/// The place from which `segment` is seen to be `length` metres long, from its first end in the origin.
pub(super) fn place(
    model: &Model,
    free: Free,
    certainty: &Certainty,
    segment: &Segment,
    length: f64,
) -> Option<Place> {
    let eye = |model: &Model, segment: &Segment| {
        let [near, _] = depths(model, segment, length)?;
        Some(-model.camera_from_world.transpose() * near * rays(model, segment)[0])
    };
    let [near, far] = depths(model, segment, length)?;
    let found = eye(model, segment)?;
    let mut slopes = DMatrix::zeros(3, free.count());
    for column in 0..free.count() {
        /// Radians and logarithms; the slopes are those of smooth functions, so that any small step will do.
        const STEP: f64 = 1e-6;
        let moved = |by: f64| {
            let mut step = vec![0.0; free.count()];
            step[column] = by;
            eye(&model.moved(&step, free), segment)
        };
        slopes.set_column(column, &((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP)));
    }
    let mut variance = (&slopes * &certainty.inverse * slopes.transpose()).diagonal();
    for number in 0..4 {
        /// Pixels.
        const STEP: f64 = 1e-3;
        let moved = |by: f64| {
            let mut segment = *segment;
            segment.ends[number / 2][number % 2] += by;
            eye(model, &segment)
        };
        let slope = (moved(STEP)? - moved(-STEP)?) / (2.0 * STEP);
        variance += slope.component_mul(&slope);
    }
    let std = Vector3::from_fn(|axis, _| certainty.sigma * variance[axis].sqrt());
    Some(Place { eye: found, std, depth: 0.5 * (near + far) })
}
