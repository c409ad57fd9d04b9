//! Lamps that are balls. Radiance samples each polygon of a lamp on its own, so a ball of hundreds
//! of triangles takes it hours; as one sphere it takes seconds.

use glam::{DVec3, Vec3};
use unrender_scene::Mesh;

/// How far corners may lie from the sphere, in radii.
const TOLERANCE: f64 = 1e-3;
/// Meshes of fewer triangles are left as they are.
const LEAST: usize = 64;

/// The centre and radius of the sphere that `mesh` stands for: all its corners lie on one, it is
/// closed, and it faces outwards. The radius is that of a sphere with the mesh's area, which sends
/// as much light.
pub(super) fn sphere(mesh: &Mesh) -> Option<(Vec3, f32)> {
    if mesh.triangles.len() < LEAST {
        return None;
    }
    let corners = || mesh.positions.iter().map(|p| p.as_dvec3());
    let (low, high) = corners().fold((DVec3::MAX, DVec3::MIN), |(a, b), p| (a.min(p), b.max(p)));
    let centre = 0.5 * (low + high);
    let mean = corners().map(|p| p.distance(centre)).sum::<f64>() / mesh.positions.len() as f64;
    if !corners().all(|p| (p.distance(centre) - mean).abs() <= TOLERANCE * mean) {
        return None;
    }
    let (mut area, mut volume) = (0.0, 0.0);
    for index in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(index).map(|p| p.as_dvec3() - centre);
        area += 0.5 * (b - a).cross(c - a).length();
        volume += a.dot(b.cross(c)) / 6.0;
    }
    // With holes it has less area than the sphere, and with its front inside no volume.
    let radius = (area / (4.0 * std::f64::consts::PI)).sqrt();
    let is_whole = radius > 0.98 * mean && volume > 0.98 * area * radius / 3.0;
    is_whole.then(|| (centre.as_vec3(), radius as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of `4 n^2` quads, each two triangles.
    fn ball(n: usize, radius: f64) -> Mesh {
        let at = |i: usize, j: usize| {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
            let (y, x) = (std::f64::consts::TAU * j as f64 / (2 * n) as f64).sin_cos();
            (DVec3::new(1.0, 2.0, 3.0) + radius * DVec3::new(sin * x, sin * y, cos)).as_vec3()
        };
        let quads = (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j)));
        let corners = quads.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        let positions: Vec<Vec3> = corners.flatten().collect();
        let quads = (0..positions.len() as u32).step_by(4);
        let triangles =
            quads.flat_map(|k| [[k, k + 1, k + 2], [k, k + 2, k + 3]]).collect::<Vec<_>>();
        Mesh::flat(&positions, &[], &triangles)
    }

    #[test]
    fn balls_are_known_by_their_shape() {
        let (centre, radius) = sphere(&ball(24, 0.5)).unwrap();
        assert!((centre - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-5, "{centre}");
        assert!(radius < 0.5 && radius > 0.495, "{radius}");
    }

    #[test]
    fn what_is_no_whole_ball_is_none() {
        let whole = ball(24, 0.5);
        let half = whole.triangles[..whole.triangles.len() / 2].to_vec();
        assert_eq!(sphere(&Mesh { triangles: half, ..whole.clone() }), None);
        let mut inside_out = whole.clone();
        inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert_eq!(sphere(&inside_out), None);
        let mut egg = whole;
        egg.positions.iter_mut().for_each(|p| p.x *= 1.1);
        assert_eq!(sphere(&egg), None);
    }
}
