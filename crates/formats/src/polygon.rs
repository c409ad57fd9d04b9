//! Polygons to triangles: a fan where the polygon is convex, ear clipping [Meisters 1975] where it is not.
//!
//! The plane of a polygon is that of its Newell normal, the sum over its edges of `(p_k - p_0) x
//! (p_(k+1) - p_0)` [Tampieri 1992]. A fan costs linear, ear clipping up to quadratic time.

use glam::{DVec2, Vec3};

/// The most corners of a polygon that is not convex: ear clipping takes quadratic time, a second for
/// this many. Half of it is still ten times what modellers make; double takes four seconds a polygon.
const MAX_CONCAVE: usize = 20_000;

/// Corners bend inwards if the sine of the angle is below minus this. Single-precision corners of a
/// straight edge have 1e-7 or so; at double and half of it, the same polygons are convex.
const STRAIGHT: f64 = 1e-5;

/// Adds the triangles of the polygon `corners`, which turn as it does, to `triangles`.
///
/// # Errors
/// If it is not convex and has too many corners.
pub(crate) fn split<T: Copy>(
    corners: &[T],
    position: impl Fn(&T) -> Vec3,
    triangles: &mut Vec<[T; 3]>,
) -> Result<(), String> {
    let fan = (2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]);
    if corners.len() <= 3 {
        triangles.extend(fan);
        return Ok(());
    }
    let flat = flattened(corners, position);
    if flat.is_empty() || is_convex(&flat) {
        triangles.extend(fan);
        return Ok(());
    }
    if corners.len() > MAX_CONCAVE {
        return Err(format!(
            "has a polygon of {} corners that is not convex; make triangles of it",
            corners.len()
        ));
    }
    let numbers: Vec<f64> = flat.iter().flat_map(|p| p.to_array()).collect();
    let found = earcutr::earcut(&numbers, &[], 2).unwrap_or_default();
    if found.is_empty() {
        triangles.extend(fan);
        return Ok(());
    }
    triangles.extend(found.chunks_exact(3).map(|ear| {
        let [a, b, c] = [ear[0], ear[1], ear[2]];
        let turns_left = (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]) >= 0.0;
        let [b, c] = if turns_left { [b, c] } else { [c, b] };
        [corners[a], corners[b], corners[c]]
    }));
    Ok(())
}

/// The corners in the polygon's plane, where it turns left; empty if it has no area.
fn flattened<T>(corners: &[T], position: impl Fn(&T) -> Vec3) -> Vec<DVec2> {
    let first = position(&corners[0]).as_dvec3();
    let from_first: Vec<_> = corners.iter().map(|c| position(c).as_dvec3() - first).collect();
    let normal: glam::DVec3 = from_first.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    let Some(normal) = normal.try_normalize() else { return Vec::new() };
    let (x, y) = normal.any_orthonormal_pair();
    from_first.iter().map(|p| DVec2::new(p.dot(x), p.dot(y))).collect()
}

/// Whether no corner bends inwards, and all of them together turn once.
fn is_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    let edge = |k: usize| flat[(k + 1) % count] - flat[k % count];
    let edges: Vec<DVec2> = (0..count).map(edge).filter(|e| e.length_squared() > 0.0).collect();
    let mut turned = 0.0;
    for k in 0..edges.len() {
        let (a, b) = (edges[k], edges[(k + 1) % edges.len()]);
        if a.perp_dot(b) < -STRAIGHT * a.length() * b.length() {
            return false;
        }
        turned += a.angle_to(b).abs();
    }
    turned < 3.0 * std::f64::consts::PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn area_of(corners: &[Vec3], triangles: &[[usize; 3]]) -> (Vec3, f32) {
        let area = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            0.5 * (b - a).cross(c - a)
        };
        let sum: Vec3 = triangles.iter().map(area).sum();
        (sum, triangles.iter().map(|t| area(t).length()).sum())
    }

    fn triangles(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let mut found = Vec::new();
        let all: Vec<usize> = (0..corners.len()).collect();
        split(&all, |&i| corners[i], &mut found).unwrap();
        found
    }

    #[test]
    fn an_l_is_not_half_filled() {
        let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        for start in 0..6 {
            for back in [false, true] {
                let turn = Quat::from_rotation_x(1.0) * Quat::from_rotation_z(0.3);
                let mut corners: Vec<Vec3> = (0..6)
                    .map(|k| l[(k + start) % 6])
                    .map(|[x, y]| turn * Vec3::new(x, y, 5.0))
                    .collect();
                if back {
                    corners.reverse();
                }
                let (sum, total) = area_of(&corners, &triangles(&corners));
                assert!((total - 3.0).abs() < 1e-4, "{total} instead of 3 from corner {start}");
                let front = turn * Vec3::Z * if back { -3.0 } else { 3.0 };
                assert!(sum.abs_diff_eq(front, 1e-4), "{sum} faces elsewhere than {front}");
            }
        }
    }

    #[test]
    fn convex_polygons_are_fans_and_nothing_panics() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles(&[Vec3::ZERO; 5]).len(), 3);
        assert_eq!(triangles(&[Vec3::NAN; 4]).len(), 2);
        assert!(triangles(&[Vec3::ZERO, Vec3::X]).is_empty());
        let star: Vec<Vec3> = (0..5)
            .map(|k| Vec3::from_array([(k as f32 * 2.513).cos(), (k as f32 * 2.513).sin(), 0.0]))
            .collect();
        assert!(!triangles(&star).is_empty());
        let mut many = vec![Vec3::new(30_000., -5., 0.), Vec3::new(0., -5., 0.)];
        many.extend((0..30_000).map(|k| Vec3::new(k as f32, (k % 2) as f32, 0.)));
        let all: Vec<usize> = (0..many.len()).collect();
        assert!(split(&all, |&i| many[i], &mut Vec::new()).is_err());
    }
}
