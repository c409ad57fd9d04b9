//! POSIT: pose from orthography and scaling with iterations [DeMenthon and Davis 1995].
//!
//! With image points on the plane at distance one, `x_i = X_i / Z_i`, a reference point `M_0` at
//! depth `Z_0`, and the camera's axes `i`, `j`, `k` in the world:
//!
//! ```text
//! (M_i - M_0) . I = x_i (1 + e_i) - x_0      I = i / Z_0
//! (M_i - M_0) . J = y_i (1 + e_i) - y_0      J = j / Z_0      e_i = (M_i - M_0) . k / Z_0
//! ```
//!
//! Were the `e_i` known, this would be linear. They are zero for a scaled orthographic camera;
//! solve, take the pose, compute them again, and iterate.
//!
//! Points in one plane with unit normal `u` leave `I = I_0 + a u`, `J = J_0 + b u` open; that `I`
//! and `J` are perpendicular and equally long gives `(a + ib)^2 = J_0^2 - I_0^2 - 2i I_0 . J_0`,
//! two poses. The first iteration follows both, later ones the better of the two [Oberkampf et al.
//! 1996].

use super::model::{Model, Observed, Sight};
use nalgebra::{Complex, Matrix3, Vector2, Vector3};

const ITERATIONS: usize = 60;
/// The iteration ends where no e_i changes by more than this.
const SETTLED: f64 = 1e-7;
/// Limits of the depth of a point in an iteration, in depths of the reference point: a point behind
/// the camera in one iteration may be in front in the next.
const DEPTHS: (f64, f64) = (0.05, 50.0);

/// The part of the iteration that depends on the points alone; one pair is the reference.
pub(super) struct Posit<'a> {
    sights: &'a [Sight],
    reference: usize,
    /// Vectors from the reference to all points.
    ways: Vec<Vector3<f64>>,
    /// Maps sums over these vectors to I and J.
    inverse: Matrix3<f64>,
    /// The unit normal, where the points are taken to lie in a plane.
    normal: Option<Vector3<f64>>,
}

impl<'a> Posit<'a> {
    /// Prepares for `sights`; if `planar`, their points are taken to lie in the nearest plane.
    pub(super) fn new(sights: &'a [Sight], planar: bool) -> Option<Self> {
        let count = sights.len() as f64;
        let centre = sights.iter().map(|s| s.point).sum::<Vector3<f64>>() / count;
        let off = |index: &usize| (sights[*index].point - centre).norm_squared();
        let reference = (0..sights.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let origin = sights[reference].point;
        let ways: Vec<_> = sights.iter().map(|sight| sight.point - origin).collect();
        let scatter = ways.iter().map(|way| way * way.transpose()).sum::<Matrix3<f64>>();
        let eigen = scatter.symmetric_eigen();
        let (thinnest, _) = eigen.eigenvalues.argmin();
        let mut inverse = Matrix3::zeros();
        for axis in (0..3).filter(|axis| !planar || *axis != thinnest) {
            let direction = eigen.eigenvectors.column(axis);
            inverse += direction * direction.transpose() / eigen.eigenvalues[axis];
        }
        let normal = planar.then(|| eigen.eigenvectors.column(thinnest).into_owned());
        let usable = inverse.iter().all(|value| value.is_finite());
        usable.then_some(Self { sights, reference, ways, inverse, normal })
    }

    /// The poses for a pinhole camera of `focal` pixels: one, or two for a plane, without those
    /// that have points behind the camera.
    pub(super) fn poses(&self, focal: f64) -> Vec<Model> {
        let image: Vec<_> = self.sights.iter().map(|sight| sight.image / focal).collect();
        let branches = if self.normal.is_some() { 2 } else { 1 };
        (0..branches).filter_map(|branch| self.iterate(&image, focal, branch)).collect()
    }

    fn iterate(&self, image: &[Vector2<f64>], focal: f64, branch: usize) -> Option<Model> {
        let mut depths = vec![1.0; image.len()];
        let mut best = *self.solve(image, &depths, focal).get(branch)?;
        for _ in 0..ITERATIONS {
            let reference_depth = best.in_camera(&self.sights[self.reference].point).z;
            let axis = best.camera_from_world.row(2).transpose();
            let mut change: f64 = 0.0;
            for (depth, way) in depths.iter_mut().zip(&self.ways) {
                let next = (1.0 + way.dot(&axis) / reference_depth).clamp(DEPTHS.0, DEPTHS.1);
                change = change.max((next - *depth).abs());
                *depth = next;
            }
            if change < SETTLED {
                break;
            }
            let poses = self.solve(image, &depths, focal).into_iter();
            best = poses.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)))?;
        }
        self.sights.iter().all(|sight| sight.is_in_front(&best)).then_some(best)
    }

    fn cost(&self, model: &Model) -> f64 {
        model.cost(self.sights)
    }

    /// The poses of a scaled orthographic camera, once the image is stretched by the `depths`.
    fn solve(&self, image: &[Vector2<f64>], depths: &[f64], focal: f64) -> Vec<Model> {
        let origin = image[self.reference];
        let (mut right, mut down) = (Vector3::zeros(), Vector3::zeros());
        for ((point, depth), way) in image.iter().zip(depths).zip(&self.ways) {
            let stretched = point * *depth - origin;
            right += stretched.x * way;
            down += stretched.y * way;
        }
        let (right, down) = (self.inverse * right, self.inverse * down);
        let Some(normal) = &self.normal else {
            return self.pose(right, down, origin, focal).into_iter().collect();
        };
        let real = down.norm_squared() - right.norm_squared();
        let root = Complex::new(real, -2.0 * right.dot(&down)).sqrt();
        let poses = [1.0, -1.0].into_iter().filter_map(|sign| {
            let (a, b) = (sign * root.re, sign * root.im);
            self.pose(right + a * normal, down + b * normal, origin, focal)
        });
        poses.collect()
    }

    /// The rigid pose nearest to scaled axes.
    fn pose(
        &self,
        right: Vector3<f64>,
        down: Vector3<f64>,
        origin: Vector2<f64>,
        focal: f64,
    ) -> Option<Model> {
        let scale = (right.norm() * down.norm()).sqrt();
        let forward = right.cross(&down).try_normalize(f64::MIN_POSITIVE)?;
        // Both axes are turned by the same angle, so that neither is preferred.
        let (i, j) = (right.normalize(), down.normalize());
        let (sum, difference) = ((i + j).normalize(), (i - j).normalize());
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let (i, j) = ((sum + difference) * half, (sum - difference) * half);
        let rotation = Matrix3::from_rows(&[i.transpose(), j.transpose(), forward.transpose()]);
        let in_camera = Vector3::new(origin.x, origin.y, 1.0) / scale;
        let eye = self.sights[self.reference].point - rotation.transpose() * in_camera;
        let valid = rotation.iter().chain(eye.iter()).all(|value| value.is_finite());
        valid.then(|| Model::pinhole(rotation, eye, focal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn truth() -> Model {
        let turn = Rotation3::from_euler_angles(0.5, -0.4, 0.1).into_inner();
        let eye = turn.transpose() * Vector3::new(-0.2, 0.1, -6.0);
        Model::pinhole(turn, eye, 800.0)
    }

    fn sights(points: &[[f64; 3]]) -> Vec<Sight> {
        let seen = |point: &[f64; 3]| {
            let point = Vector3::from(*point);
            let image = Sight { image: Vector2::zeros(), point }.residual(&truth());
            Sight { image, point }
        };
        points.iter().map(seen).collect()
    }

    fn error(pose: &Model) -> f64 {
        let turned = (pose.camera_from_world - truth().camera_from_world).norm();
        turned + (pose.eye - truth().eye).norm()
    }

    #[test]
    fn noiseless_points_give_the_pose() {
        let cube = sights(&[
            [0.0, 0.0, 0.0],
            [1.0, 0.1, 0.0],
            [0.0, 1.0, 0.2],
            [-1.0, 0.3, 1.0],
            [0.4, -0.9, -1.0],
        ]);
        let poses = Posit::new(&cube, false).unwrap().poses(800.0);
        assert!(poses.len() == 1 && error(&poses[0]) < 1e-5, "{poses:?}");
    }

    #[test]
    fn noiseless_coplanar_points_give_the_pose_and_another() {
        let plane = sights(&[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.2],
            [-1.0, 0.0, 1.0],
            [0.4, 0.0, -1.0],
            [0.9, 0.0, 0.8],
        ]);
        let poses = Posit::new(&plane, true).unwrap().poses(800.0);
        assert!(poses.len() == 2, "{poses:?}");
        let best = poses.iter().map(error).fold(f64::INFINITY, f64::min);
        assert!(best < 1e-4, "{poses:?}");
    }
}
