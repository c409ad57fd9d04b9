//! Initial cameras from two vanishing points [Caprile and Torre 1990].
//!
//! The vanishing point of an axis is where its lines meet: the direction `v` with the least `sum (n . v)^2` over the
//! lines `n`. In pixels from the principal point, those of two perpendicular axes give the focal length and then the
//! rotation:
//!
//! ```text
//! f^2 = -(v_xy . w_xy) / (v_z w_z)
//! ```

use super::segment::Segment;
use crate::calibrate::model::Model;
use nalgebra::{Matrix3, Vector3};

/// Focal lengths outside this range, in the picture's longer side, are those of noise: fields of view across it from
/// 136 to 3 degrees. At half and double of both nothing changes but the number of useless starts.
const FOCALS: (f64, f64) = (0.2, 20.0);

/// Cameras that may have seen `segments`, the best first. Those that two vanishing points give are tried beside
/// `focals`; none but `focals` if `is_known`.
pub(super) fn starts(
    segments: &[Segment],
    focals: &[f64],
    is_known: bool,
    longer_side: f64,
) -> Vec<Model> {
    let points = [0, 1, 2].map(|axis| vanishing_point(segments, axis, longer_side));
    let mut found: Vec<(f64, Model)> = Vec::new();
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let (Some(v), Some(w)) = (points[a], points[b]) else { continue };
        let squared = -v.xy().dot(&w.xy()) / (v.z * w.z);
        let range = FOCALS.0 * longer_side..FOCALS.1 * longer_side;
        let own = Some(squared.sqrt()).filter(|focal| !is_known && range.contains(focal));
        for focal in own.iter().chain(focals) {
            found.extend(
                turned([(a, v), (b, w)], *focal).map(|model| (model.cost(segments), model)),
            );
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, model)| model).collect()
}

/// The vanishing point of an axis, homogeneous, pixels; none if fewer than two lines show it.
fn vanishing_point(segments: &[Segment], axis: usize, scale: f64) -> Option<Vector3<f64>> {
    let along: Vec<&Segment> = segments.iter().filter(|segment| segment.axis == axis).collect();
    if along.len() < 2 {
        return None;
    }
    // In units of the picture's longer side all three coordinates are of one size.
    let line = |segment: &&Segment| {
        let n = segment.line();
        Vector3::new(n.x * scale, n.y * scale, n.z) / (scale * scale)
    };
    let scatter = along.iter().map(line).map(|n| n * n.transpose()).sum::<Matrix3<f64>>();
    let eigen = scatter.symmetric_eigen();
    let (least, _) = eigen.eigenvalues.argmin();
    let point = eigen.eigenvectors.column(least);
    Some(Vector3::new(point.x * scale, point.y * scale, point.z))
}

/// The camera of this focal length under which two axes have these vanishing points; the second is moved to where it is
/// perpendicular to the first.
fn turned([(a, v), (b, w)]: [(usize, Vector3<f64>); 2], focal: f64) -> Option<Model> {
    let direction = |point: Vector3<f64>| Vector3::new(point.x, point.y, focal * point.z);
    let first = direction(v).try_normalize(0.0)?;
    let second = direction(w).try_normalize(0.0)?;
    let second = (second - first.dot(&second) * first).try_normalize(1e-6)?;
    let c = 3 - a - b;
    let mut rotation = Matrix3::zeros();
    rotation.set_column(a, &first);
    rotation.set_column(b, &second);
    rotation.set_column(c, &first.cross(&second));
    // The third axis makes the frame right-handed.
    if rotation.determinant() < 0.0 {
        rotation.set_column(c, &-first.cross(&second));
    }
    Some(Model::pinhole(rotation, Vector3::zeros(), focal))
}
