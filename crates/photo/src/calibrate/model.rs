//! The camera model of calibration: parameters, projection, and derivatives.
//!
//! In here a camera looks along its own +z, with +x to the right and +y *downwards*, so that its
//! axes are those of the picture; image points are in pixels from the picture's centre. With
//! `(X, Y, Z) = R (P - eye)`, `x = X/Z`, `y = Y/Z` and `r2 = x^2 + y^2`:
//!
//! ```text
//! image = f (1 + k1 r2 + k2 r2^2) (x, y) + principal point
//! ```

use nalgebra::{DMatrix, DVector, Matrix2x3, Matrix3, Rotation3, Vector2, Vector3};

/// The least depth of a point, as a share of its distance; points behind the camera are put at this
/// depth, where their residual is large.
const LEAST_DEPTH: f64 = 1e-3;

/// A point and where it was seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Pixels from the picture's centre, right and down.
    pub(super) image: Vector2<f64>,
    /// Metres, world space.
    pub(super) point: Vector3<f64>,
}

/// The free parameters beside the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Free {
    pub(super) focal: bool,
    pub(super) principal_point: bool,
    pub(super) distortion: bool,
}

impl Free {
    /// How many numbers: rotation, eye, logarithm of the focal length, principal point, k1 and k2.
    pub(super) fn count(self) -> usize {
        6 + usize::from(self.focal)
            + 2 * usize::from(self.principal_point)
            + 2 * usize::from(self.distortion)
    }

    /// The fewest pairs that determine them and leave an equation or two for a check.
    pub(super) fn fewest_pairs(self) -> usize {
        self.count().div_ceil(2) + 1
    }

    /// The pose, and the focal length if it is searched for.
    pub(super) fn without_lens(self) -> Self {
        Self { principal_point: false, distortion: false, ..self }
    }
}

/// A camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Model {
    /// Takes directions in the world to the camera.
    pub(super) camera_from_world: Matrix3<f64>,
    /// Metres, world space.
    pub(super) eye: Vector3<f64>,
    /// The natural logarithm of the focal length in pixels, which keeps that positive.
    pub(super) ln_focal: f64,
    /// Pixels from the picture's centre.
    pub(super) principal_point: Vector2<f64>,
    /// Radial distortion: k1 and k2.
    pub(super) k: [f64; 2],
}

impl Model {
    /// A pinhole without shift.
    pub(super) fn pinhole(camera_from_world: Matrix3<f64>, eye: Vector3<f64>, focal: f64) -> Self {
        let (ln_focal, principal_point) = (focal.ln(), Vector2::zeros());
        Self { camera_from_world, eye, ln_focal, principal_point, k: [0.0; 2] }
    }

    /// The point in the camera's frame.
    pub(super) fn in_camera(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.camera_from_world * (point - self.eye)
    }

    /// The projection of the point minus its measured pixel. A point behind the camera is put just
    /// in front of it, with a large residual.
    pub(super) fn residual(&self, sight: &Sight) -> Vector2<f64> {
        let plane = on_plane(&self.in_camera(&sight.point));
        let [k1, k2] = self.k;
        let r2 = plane.norm_squared();
        let factor = 1.0 + r2 * (k1 + r2 * k2);
        self.ln_focal.exp() * factor * plane + self.principal_point - sight.image
    }

    /// The sum of the squared residuals, pixels^2.
    pub(super) fn cost(&self, sights: &[Sight]) -> f64 {
        sights.iter().map(|sight| self.residual(sight).norm_squared()).sum()
    }

    /// Whether the camera looks towards the point.
    pub(super) fn sees(&self, sight: &Sight) -> bool {
        self.in_camera(&sight.point).z > 0.0
    }

    /// The camera after a step along the free numbers: a rotation vector in the camera's frame,
    /// then eye, ln focal, principal point, k1 and k2, as far as they are free.
    pub(super) fn moved(&self, step: &[f64], free: Free) -> Self {
        let mut model = *self;
        let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
        model.camera_from_world = turn.matrix() * self.camera_from_world;
        model.eye += Vector3::new(step[3], step[4], step[5]);
        let mut rest = step[6..].iter();
        let mut next = || rest.next().copied().unwrap_or(0.0);
        if free.focal {
            model.ln_focal += next();
        }
        if free.principal_point {
            model.principal_point += Vector2::new(next(), next());
        }
        if free.distortion {
            model.k = [self.k[0] + next(), self.k[1] + next()];
        }
        model
    }
}

/// The image at distance one of a point in the camera's frame.
fn on_plane(in_camera: &Vector3<f64>) -> Vector2<f64> {
    let depth = in_camera.z.max(LEAST_DEPTH * in_camera.norm()).max(f64::MIN_POSITIVE);
    Vector2::new(in_camera.x, in_camera.y) / depth
}

/// All residuals in one vector, pixels.
pub(super) fn residuals(model: &Model, sights: &[Sight]) -> DVector<f64> {
    let each = sights.iter().flat_map(|sight| {
        let residual = model.residual(sight);
        [residual.x, residual.y]
    });
    DVector::from_iterator(2 * sights.len(), each)
}

/// The derivatives of all residuals by the steps of [`Model::moved`] at a step whose rotation is
/// `turn`; `model` is the camera after the step.
pub(super) fn jacobian(
    model: &Model,
    sights: &[Sight],
    free: Free,
    turn: &Vector3<f64>,
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(2 * sights.len(), free.count());
    let turn_jacobian = left_jacobian(turn);
    let focal = model.ln_focal.exp();
    let [k1, k2] = model.k;
    for (index, sight) in sights.iter().enumerate() {
        let in_camera = model.in_camera(&sight.point);
        let depth = in_camera.z.max(LEAST_DEPTH * in_camera.norm()).max(f64::MIN_POSITIVE);
        let plane = on_plane(&in_camera);
        let (x, y, r2) = (plane.x, plane.y, plane.norm_squared());
        let factor = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * r2 * k2);
        let bend = nalgebra::Matrix2::new(
            factor + slope * x * x,
            slope * x * y,
            slope * x * y,
            factor + slope * y * y,
        );
        let divide = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / depth;
        let by_point = focal * bend * divide;
        let mut rows = all.rows_mut(2 * index, 2);
        let by_turn = -by_point * in_camera.cross_matrix() * turn_jacobian;
        rows.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_turn);
        rows.fixed_view_mut::<2, 3>(0, 3).copy_from(&(-by_point * model.camera_from_world));
        let mut column = 6;
        if free.focal {
            rows.fixed_view_mut::<2, 1>(0, column).copy_from(&(focal * factor * plane));
            column += 1;
        }
        if free.principal_point {
            rows.fixed_view_mut::<2, 2>(0, column).fill_with_identity();
            column += 2;
        }
        if free.distortion {
            rows.fixed_view_mut::<2, 1>(0, column).copy_from(&(focal * r2 * plane));
            rows.fixed_view_mut::<2, 1>(0, column + 1).copy_from(&(focal * r2 * r2 * plane));
        }
    }
    all
}

/// How the rotation `exp(turn + d)` follows from `d`: `exp(J d) exp(turn)` to first order.
fn left_jacobian(turn: &Vector3<f64>) -> Matrix3<f64> {
    let angle = turn.norm();
    let cross = turn.cross_matrix();
    if angle < 1e-4 {
        return Matrix3::identity() + 0.5 * cross + cross * cross / 6.0;
    }
    let squared = angle * angle;
    Matrix3::identity()
        + (1.0 - angle.cos()) / squared * cross
        + (angle - angle.sin()) / (squared * angle) * cross * cross
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let turn = Rotation3::new(Vector3::new(0.3, -0.8, 0.2)).into_inner();
        let mut start = Model::pinhole(turn, Vector3::new(1.0, 2.0, -1.0), 900.0);
        start.principal_point = Vector2::new(5.0, -7.0);
        start.k = [-0.2, 0.05];
        let free = Free { focal: true, principal_point: true, distortion: true };
        let in_front = Vector3::new(0.4, -0.3, 3.0);
        let point = start.eye + turn.transpose() * in_front;
        let sights = [Sight { image: Vector2::new(100.0, -80.0), point }];
        let at = [0.1, 0.2, -0.15, 0.05, -0.02, 0.03, 0.1, 2.0, -1.0, 0.01, -0.02];
        let analytic =
            jacobian(&start.moved(&at, free), &sights, free, &Vector3::new(0.1, 0.2, -0.15));
        for column in 0..free.count() {
            let shifted = |by: f64| {
                let mut step = at;
                step[column] += by;
                residuals(&start.moved(&step, free), &sights)
            };
            let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            let difference = (analytic.column(column) - &numeric).norm();
            assert!(difference < 1e-5 * (1.0 + numeric.norm()), "column {column}: {difference}");
        }
    }
}
