//! The spatial configuration of the measured points: collinear, coplanar, or general.

use super::model::Sight;
use nalgebra::{Matrix3, Vector3};

/// Points lie on a line if they spread across it by less than this share of its length.
const LINE: f64 = 1e-3;
/// ... in a plane if they spread across it by less than this share of its width.
const PLANE: f64 = 1e-4;
/// ... and nearly in a plane below this share.
const NEAR_PLANE: f64 = 0.15;

/// The spread of points along their three main directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Root mean square distances from the middle, the largest first, metres.
    pub(super) spread: [f64; 3],
}

impl Layout {
    pub(super) fn of(sights: &[Sight]) -> Self {
        let (_, scatter) = scatter(sights);
        let mut spread = scatter.symmetric_eigenvalues().map(|value| value.max(0.0).sqrt());
        spread.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
        Self { spread: spread.into() }
    }

    /// Middle and unit normal of the plane that the points nearly lie in, if they do.
    pub(super) fn plane(sights: &[Sight]) -> Option<(Vector3<f64>, Vector3<f64>)> {
        if !Self::of(sights).nearly_planar() {
            return None;
        }
        let (centre, scatter) = scatter(sights);
        let eigen = scatter.symmetric_eigen();
        let (thinnest, _) = eigen.eigenvalues.argmin();
        Some((centre, eigen.eigenvectors.column(thinnest).into_owned()))
    }

    pub(super) fn is_line(&self) -> bool {
        let [length, width, _] = self.spread;
        // Both are zero if there is no spread.
        width <= LINE * length
    }

    pub(super) fn is_planar(&self) -> bool {
        let [_, width, thickness] = self.spread;
        thickness < PLANE * width
    }

    pub(super) fn nearly_planar(&self) -> bool {
        let [_, width, thickness] = self.spread;
        thickness < NEAR_PLANE * width
    }
}

/// The points' centroid and covariance matrix.
fn scatter(sights: &[Sight]) -> (Vector3<f64>, Matrix3<f64>) {
    let count = sights.len().max(1) as f64;
    let centre = sights.iter().map(|s| s.point).sum::<Vector3<f64>>() / count;
    let ways = sights.iter().map(|sight| sight.point - centre);
    (centre, ways.map(|way| way * way.transpose()).sum::<Matrix3<f64>>() / count)
}
