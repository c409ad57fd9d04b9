//! Anisotropy directions in the world, triangle by triangle, by the rules of `docs/reference/conventions.md`.

use glam::{Vec2, Vec3};
use unrender_scene::Mesh;

/// The unit vector along the anisotropy direction of triangle `index`, `theta_rad` from its tangent
/// counter-clockwise seen from the front. Where tangents turn within the triangle it is their mean.
pub(super) fn direction(mesh: &Mesh, index: usize, theta_rad: f32) -> Vec3 {
    let normal = front_normal(mesh, index);
    let tangent = tangent(mesh, index, normal);
    let across = normal.cross(tangent).normalize_or(normal.any_orthonormal_vector());
    let along = across.cross(normal);
    let (sin, cos) = theta_rad.sin_cos();
    along * cos + across * sin
}

/// The unit normal of the front of triangle `index`.
pub(super) fn front_normal(mesh: &Mesh, index: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(index).map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// `mesh` with texture coordinates that grow along the anisotropy direction, metre by metre, for
/// programs that measure it from u. Every triangle gets corners of its own.
pub(super) fn along_u(mesh: &Mesh, theta_rad: f32) -> Mesh {
    let mut turned = Mesh::default();
    for index in 0..mesh.triangles.len() {
        let along = direction(mesh, index, theta_rad);
        let across = front_normal(mesh, index).cross(along);
        let first = turned.positions.len() as u32;
        for corner in mesh.triangles[index].map(|i| i as usize) {
            let position = mesh.positions[corner];
            turned.positions.push(position);
            turned.normals.push(mesh.normals[corner]);
            turned.uvs.push(Vec2::new(position.dot(along), position.dot(across)));
        }
        turned.triangles.push([first, first + 1, first + 2]);
    }
    turned
}

fn tangent(mesh: &Mesh, index: usize, normal: Vec3) -> Vec3 {
    let corners = mesh.triangles[index].map(|i| i as usize);
    let usable = |t: &Vec3| t.is_finite() && t.reject_from(normal).length_squared() > 1e-12;
    let given = (!mesh.tangents.is_empty())
        .then(|| corners.iter().map(|&i| mesh.tangents[i].truncate()).sum::<Vec3>() / 3.0);
    let growing_u = (!mesh.uvs.is_empty()).then(|| direction_of_u(mesh, corners));
    let along_axis = if normal.x.abs() < 0.999_95 { Vec3::X } else { Vec3::Z };
    [given, growing_u].into_iter().flatten().find(usable).unwrap_or(along_axis)
}

fn direction_of_u(mesh: &Mesh, [a, b, c]: [usize; 3]) -> Vec3 {
    let edges: [Vec3; 2] = [b, c].map(|i| mesh.positions[i] - mesh.positions[a]);
    let [d1, d2]: [Vec2; 2] = [b, c].map(|i| mesh.uvs[i] - mesh.uvs[a]);
    let area = d1.perp_dot(d2);
    if area.abs() <= f32::EPSILON * d1.length() * d2.length() {
        return Vec3::ZERO;
    }
    ((edges[0] * d2.y - edges[1] * d1.y) * area.signum()).normalize_or_zero()
}
