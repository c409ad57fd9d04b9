//! The camera model of calibration: parameters, projection, and derivatives.
//!
//! In here a camera looks along its own +z, with +x to the right and +y *downwards*, so that its
//! axes are those of the picture; image points are in pixels from the picture's centre. With
//! `(X, Y, Z) = R (P - eye)`, `x = X/Z`, `y = Y/Z` and `r2 = x^2 + y^2`:
//!
//! ```text
//! image = f (1 + k1 r2 + k2 r2^2) (x, y) + principal point
//! ```

use nalgebra::{
    DMatrix, DMatrixViewMut, DVector, Matrix2, Matrix2x3, Matrix3, Rotation3, Vector2, Vector3,
};

/// The least depth of a point, as a share of its distance; points behind the camera are put at this
/// depth, where their residual is large.
const LEAST_DEPTH: f64 = 1e-3;

/// Something that the photograph shows and a camera predicts, with residuals in pixels.
pub(super) trait Observed: Copy {
    /// How many residuals there are.
    const ROWS: usize;

    /// How many of any `observed` to fit to at least.
    fn fewest(observed: &[Self], free: Free) -> usize;

    /// Whether `observed` determine the free parameters.
    fn suffice(observed: &[Self], free: Free) -> bool {
        observed.len() >= Self::fewest(observed, free)
    }

    /// What kind it is of: outliers are looked for among each kind, as without all of one the camera may not be
    /// determined.
    fn kind(&self) -> usize {
        0
    }

    /// Whether it is in front of the camera.
    fn is_in_front(&self, model: &Model) -> bool;

    /// The residuals, of which the first [`Observed::ROWS`] count; the others are zero.
    fn residual(&self, model: &Model) -> Vector2<f64>;

    /// Writes the residuals' derivatives by the steps of [`Model::moved`] into `rows`; `turn` is the
    /// derivative of the rotation, [`left_jacobian`].
    fn derive(&self, model: &Model, free: Free, turn: &Matrix3<f64>, rows: DMatrixViewMut<'_, f64>);
}

/// A point and where it was seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Pixels from the picture's centre, right and down.
    pub(super) image: Vector2<f64>,
    /// Metres, world space.
    pub(super) point: Vector3<f64>,
}

/// The free parameters beside the rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Free {
    pub(super) position: bool,
    pub(super) focal: bool,
    pub(super) principal_point: bool,
    pub(super) distortion: bool,
}

impl Free {
    /// How many numbers: rotation, eye, logarithm of the focal length, principal point, k1 and k2.
    pub(super) fn count(self) -> usize {
        let [.., (last, width)] = self.blocks();
        last + width
    }

    /// The first column of the eye, of the focal length, of the principal point and of the distortion, and the number
    /// of columns of each: none if it is not free. The rotation has the first three.
    fn blocks(self) -> [(usize, usize); 4] {
        let is_free = [self.position, self.focal, self.principal_point, self.distortion];
        let mut next = 3;
        [0, 1, 2, 3].map(|block| {
            let width = if is_free[block] { [3, 1, 2, 2][block] } else { 0 };
            next += width;
            (next - width, width)
        })
    }

    /// The column of the eye's coordinate `axis`, if it is free.
    pub(super) fn of_eye(self, axis: usize) -> Option<usize> {
        self.column(0, axis)
    }

    /// The column of the logarithm of the focal length, if it is free.
    pub(super) fn of_focal(self) -> Option<usize> {
        self.column(1, 0)
    }

    /// The column of the principal point's coordinate `axis`, if it is free.
    pub(super) fn of_principal_point(self, axis: usize) -> Option<usize> {
        self.column(2, axis)
    }

    /// The column of k1 (0) or k2 (1), if it is free.
    pub(super) fn of_distortion(self, which: usize) -> Option<usize> {
        self.column(3, which)
    }

    fn column(self, block: usize, at: usize) -> Option<usize> {
        let (first, width) = self.blocks()[block];
        (at < width).then_some(first + at)
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

    /// The sum of the squared residuals, pixels^2.
    pub(super) fn cost<T: Observed>(&self, observed: &[T]) -> f64 {
        observed.iter().map(|seen| seen.residual(self).norm_squared()).sum()
    }

    /// The camera after a step along the free numbers: a rotation vector in the camera's frame,
    /// then eye, ln focal, principal point, k1 and k2, as far as they are free.
    pub(super) fn moved(&self, step: &[f64], free: Free) -> Self {
        let mut model = *self;
        let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
        model.camera_from_world = turn.matrix() * self.camera_from_world;
        let by = |column: Option<usize>| column.map_or(0.0, |column| step[column]);
        model.eye += Vector3::from_fn(|axis, _| by(free.of_eye(axis)));
        model.ln_focal += by(free.of_focal());
        model.principal_point += Vector2::from_fn(|axis, _| by(free.of_principal_point(axis)));
        model.k = [0, 1].map(|which| self.k[which] + by(free.of_distortion(which)));
        model
    }
}

impl Observed for Sight {
    const ROWS: usize = 2;

    /// One more than determine the parameters, for a check.
    fn fewest(_: &[Self], free: Free) -> usize {
        free.count().div_ceil(Self::ROWS) + 1
    }

    fn is_in_front(&self, model: &Model) -> bool {
        model.in_camera(&self.point).z > 0.0
    }

    /// The projection of the point minus its measured pixel. A point behind the camera is put just
    /// in front of it, with a large residual.
    fn residual(&self, model: &Model) -> Vector2<f64> {
        let plane = on_plane(&model.in_camera(&self.point));
        let [k1, k2] = model.k;
        let r2 = plane.norm_squared();
        let factor = 1.0 + r2 * (k1 + r2 * k2);
        model.ln_focal.exp() * factor * plane + model.principal_point - self.image
    }

    fn derive(
        &self,
        model: &Model,
        free: Free,
        turn: &Matrix3<f64>,
        mut rows: DMatrixViewMut<'_, f64>,
    ) {
        let focal = model.ln_focal.exp();
        let [k1, k2] = model.k;
        let in_camera = model.in_camera(&self.point);
        let depth = in_camera.z.max(LEAST_DEPTH * in_camera.norm()).max(f64::MIN_POSITIVE);
        let plane = on_plane(&in_camera);
        let (x, y, r2) = (plane.x, plane.y, plane.norm_squared());
        let factor = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * r2 * k2);
        let bend = Matrix2::new(
            factor + slope * x * x,
            slope * x * y,
            slope * x * y,
            factor + slope * y * y,
        );
        let divide = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / depth;
        let by_point = focal * bend * divide;
        let by_turn = -by_point * in_camera.cross_matrix() * turn;
        rows.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_turn);
        if let Some(column) = free.of_eye(0) {
            let by_eye = -by_point * model.camera_from_world;
            rows.fixed_view_mut::<2, 3>(0, column).copy_from(&by_eye);
        }
        if let Some(column) = free.of_focal() {
            rows.set_column(column, &(focal * factor * plane));
        }
        if let Some(column) = free.of_principal_point(0) {
            rows.fixed_view_mut::<2, 2>(0, column).fill_with_identity();
        }
        if let Some(column) = free.of_distortion(0) {
            rows.set_column(column, &(focal * r2 * plane));
            rows.set_column(column + 1, &(focal * r2 * r2 * plane));
        }
    }
}

/// The image at distance one of a point in the camera's frame.
fn on_plane(in_camera: &Vector3<f64>) -> Vector2<f64> {
    let depth = in_camera.z.max(LEAST_DEPTH * in_camera.norm()).max(f64::MIN_POSITIVE);
    Vector2::new(in_camera.x, in_camera.y) / depth
}

/// All residuals in one vector, pixels.
pub(super) fn residuals<T: Observed>(model: &Model, observed: &[T]) -> DVector<f64> {
    let each = observed.iter().flat_map(|seen| {
        let residual = seen.residual(model);
        (0..T::ROWS).map(move |row| residual[row])
    });
    DVector::from_iterator(T::ROWS * observed.len(), each)
}

/// The derivatives of all residuals by the steps of [`Model::moved`] at a step whose rotation is
/// `turn`; `model` is the camera after the step.
pub(super) fn jacobian<T: Observed>(
    model: &Model,
    observed: &[T],
    free: Free,
    turn: &Vector3<f64>,
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(T::ROWS * observed.len(), free.count());
    let turn = left_jacobian(turn);
    for (index, seen) in observed.iter().enumerate() {
        seen.derive(model, free, &turn, all.rows_mut(T::ROWS * index, T::ROWS));
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
        let free = Free { position: true, focal: true, principal_point: true, distortion: true };
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
