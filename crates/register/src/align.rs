//! The camera that brings the model's edges onto the photograph's.
//!
//! Every edge point says how far the picture must move across the edge there, `s_i`, and the camera
//! how far it does: `s_i = n_i . (x_i(p) - x_i(0))` for small changes `p` of the camera
//! [Harris and Stennett 1990]. Gauss-Newton on Tukey's robust loss [Beaton and Tukey 1974], since some
//! of the photograph's edges are shadows and things that the model lacks. A weak prior that the camera
//! is nearly right decides what the edges leave open (far away, say, between a turn and a shift).

use super::edges::Edgel;
use glam::{Affine3A, Quat, Vec2, Vec3};
use nalgebra::{DMatrix, DVector};
use unrender_scene::Camera;

/// How a camera may be changed, in its own frame: a turn about x, y, z (radians), a move along them
/// (relative to how far away things are), the logarithm of the focal length, and the principal point
/// (relative to the picture's height).
pub const FREEDOMS: usize = 9;
/// The standard deviation of the prior of each.
const PRIOR: [f64; FREEDOMS] = [0.05, 0.05, 0.05, 0.03, 0.03, 0.03, 0.03, 0.01, 0.01];
/// Changes of this size show how the picture moves.
const SMALL: f32 = 2e-3;
/// Tukey's constant: offsets of more than this many deviations do not count.
const TUKEY: f64 = 4.685;
/// The least standard deviation of the offsets, pixels: the model's edges are only known to a
/// fraction of a pixel.
const DEVIATION_MIN: f64 = 0.15;
/// Neighbouring edge points share pixels of the photograph: those of so many pixels count as one.
const SHARED: f64 = 4.0;
const REWEIGHTINGS: usize = 12;

/// An edge point and how far the photograph's edge is from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// The model's.
    pub edgel: Edgel,
    /// Along its `across`, pixels.
    pub distance: f32,
}

/// A change of the camera and what it leaves.
#[derive(Clone, Debug)]
pub struct Alignment {
    /// The changed camera.
    pub camera: Camera,
    /// The spread of the remaining offsets that count, pixels.
    pub deviation: f64,
    /// How far a point of the picture may still be off, on the mean over the edge points, pixels.
    pub uncertainty: f64,
    /// Edge points that count.
    pub inliers: usize,
}

/// The picture's shift that most offsets agree on, pixels, and the share of them that does.
pub fn vote(offsets: &[Offset], reach: f32) -> (Vec2, f32) {
    /// Steps between the shifts that are tried, pixels, and how close an offset is to the one that it agrees with.
    const STEP: f32 = 0.5;
    const CLOSE: f32 = 0.75;
    let half = (reach / STEP) as i32;
    let mut best = (0usize, Vec2::ZERO);
    for j in -half..=half {
        for i in -half..=half {
            let shift = Vec2::new(i as f32, j as f32) * STEP;
            let agrees = |o: &&Offset| (o.distance - o.edgel.across.dot(shift)).abs() < CLOSE;
            let votes = offsets.iter().filter(agrees).count();
            let nearer = shift.length_squared() < best.1.length_squared();
            if votes > best.0 || (votes == best.0 && nearer) {
                best = (votes, shift);
            }
        }
    }
    (best.1, best.0 as f32 / offsets.len().max(1) as f32)
}

/// The change of `camera`, of pictures of `size`, that fits `offsets`, none if they determine none;
/// `shift` is where to begin. A pixel of the photograph has `per_pixel` edge points along an edge.
pub fn align(
    offsets: &[Offset],
    camera: &Camera,
    size: (usize, usize),
    shift: Vec2,
    per_pixel: usize,
) -> Option<Alignment> {
    let distance = median(offsets.iter().map(|o| o.edgel.point.distance(camera.origin())))?;
    let rows = rows(offsets, camera, size, distance);
    let mut residuals: Vec<f64> =
        offsets.iter().map(|o| f64::from(o.distance - o.edgel.across.dot(shift))).collect();
    let mut deviation = spread(&residuals)?;
    let mut change = DVector::zeros(FREEDOMS);
    let mut normal = DMatrix::zeros(FREEDOMS, FREEDOMS);
    for _ in 0..REWEIGHTINGS {
        normal.fill(0.0);
        let mut right = DVector::zeros(FREEDOMS);
        for ((row, offset), residual) in rows.iter().zip(offsets).zip(&residuals) {
            let weight =
                tukey(residual / deviation) / (deviation * deviation * SHARED * per_pixel as f64);
            normal.syger(weight, row, row, 1.0);
            right += row * (weight * f64::from(offset.distance));
        }
        for (k, prior) in PRIOR.iter().enumerate() {
            normal[(k, k)] += 1.0 / (prior * prior);
        }
        normal.fill_upper_triangle_with_lower_triangle();
        change = normal.clone().cholesky()?.solve(&right);
        for ((residual, row), offset) in residuals.iter_mut().zip(&rows).zip(offsets) {
            *residual = f64::from(offset.distance) - row.dot(&change);
        }
        deviation = spread(&residuals)?;
    }
    let covariance = normal.cholesky()?.inverse();
    let counts = |r: &&f64| tukey(*r / deviation) > 0.0;
    let variance = rows.iter().map(|row| (row.transpose() * &covariance * row)[0]).sum::<f64>();
    Some(Alignment {
        camera: changed(camera, &change.map(|c| c as f32), distance),
        deviation,
        uncertainty: (variance / rows.len() as f64).sqrt(),
        inliers: residuals.iter().filter(counts).count(),
    })
}

/// How far each offset's point moves across its edge, by every freedom of the camera.
fn rows(
    offsets: &[Offset],
    camera: &Camera,
    (width, height): (usize, usize),
    distance: f32,
) -> Vec<DVector<f64>> {
    let cameras: Vec<[Camera; 2]> = (0..FREEDOMS)
        .map(|k| {
            [-SMALL, SMALL].map(|small| {
                let mut change = DVector::zeros(FREEDOMS);
                change[k] = small;
                changed(camera, &change, distance)
            })
        })
        .collect();
    let row = |offset: &Offset| {
        let at = |camera: &Camera| {
            let seen = camera.project(offset.edgel.point, width, height);
            seen.map(|(x, y)| offset.edgel.across.dot(Vec2::new(x, y)))
        };
        let derivative = |[less, more]: &[Camera; 2]| match (at(less), at(more)) {
            (Some(less), Some(more)) => f64::from((more - less) / (2.0 * SMALL)),
            _ => 0.0,
        };
        DVector::from_iterator(FREEDOMS, cameras.iter().map(derivative))
    };
    offsets.iter().map(row).collect()
}

/// `camera` with a change of its freedoms; `distance` is how far away things are, metres.
fn changed(camera: &Camera, change: &DVector<f32>, distance: f32) -> Camera {
    let turn = Quat::from_scaled_axis(Vec3::new(change[0], change[1], change[2]));
    let by = Vec3::new(change[3], change[4], change[5]) * distance;
    let camera_from_changed = Affine3A::from_rotation_translation(turn, by);
    let mut camera = camera.clone();
    camera.world_from_camera *= camera_from_changed;
    camera.fov_y_rad = 2.0 * ((0.5 * camera.fov_y_rad).tan() * (-change[6]).exp()).atan();
    camera.lens.principal_point[0] += change[7];
    camera.lens.principal_point[1] += change[8];
    camera
}

/// Tukey's biweight.
fn tukey(deviations: f64) -> f64 {
    let share = (deviations / TUKEY).powi(2);
    if share < 1.0 { (1.0 - share).powi(2) } else { 0.0 }
}

/// The robust standard deviation about zero.
fn spread(residuals: &[f64]) -> Option<f64> {
    /// The standard deviation of a Gaussian in units of the median of its absolute values.
    const OF_MEDIAN: f64 = 1.4826;
    let sizes = residuals.iter().map(|r| r.abs() as f32);
    Some((OF_MEDIAN * f64::from(median(sizes)?)).max(DEVIATION_MIN))
}

/// The middle value.
pub(super) fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    let mut values: Vec<f32> = values.collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}
