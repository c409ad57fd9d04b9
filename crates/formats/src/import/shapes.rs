//! Shapes that other programs know by name, as meshes.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use std::f32::consts::TAU;
use unrender_scene::Mesh;

/// Triangles around a cone.
const AROUND: u32 = 64;

/// The memory that `mesh` takes.
pub(super) fn bytes_of(mesh: &Mesh) -> u64 {
    let vertices = mesh.positions.len() * size_of::<Vec3>()
        + mesh.normals.len() * size_of::<Vec3>()
        + mesh.uvs.len() * size_of::<Vec2>();
    (vertices + mesh.triangles.len() * size_of::<[u32; 3]>()) as u64
}

/// The side of a cone cut off between two circles, smooth, its front outside; no ends.
pub(super) fn frustum(ends: [Vec3; 2], radii: [f32; 2]) -> Mesh {
    let along = ends[1] - ends[0];
    let axis = along.normalize_or(Vec3::Z);
    let x = axis.any_orthonormal_vector();
    let y = axis.cross(x);
    let mut mesh = Mesh::default();
    for (end, j) in (0..2).flat_map(|end| (0..=AROUND).map(move |j| (end, j))) {
        let u = j as f32 / AROUND as f32;
        // At the tip, a triangle faces the middle between its two corners on the other circle.
        let half = [0.5, -0.5][end] / AROUND as f32;
        let facing = if radii[end] > 0.0 { u } else { u + half };
        let (sin, cos) = (TAU * facing).sin_cos();
        let outwards = cos * x + sin * y;
        // It leans towards the narrower end.
        let lean = (radii[0] - radii[1]) * axis;
        mesh.positions.push(ends[end] + radii[end] * outwards);
        mesh.normals.push((along.length() * outwards + lean).normalize_or(outwards));
        mesh.uvs.push(Vec2::new(u, end as f32));
    }
    mesh.triangles = strip(radii);
    mesh
}

/// The flat ring between two circles about `centre`, its front towards `normal`.
pub(super) fn ring(centre: Vec3, normal: Vec3, radii: [f32; 2]) -> Mesh {
    let normal = normal.normalize_or(Vec3::Z);
    let [inner, outer] = [radii[0].min(radii[1]), radii[0].max(radii[1])];
    let flat = frustum([centre, centre + normal], [outer, inner]);
    let onto_plane = |(i, p): (usize, &Vec3)| {
        if i > AROUND as usize { *p - normal } else { *p }
    };
    let positions: Vec<Vec3> = flat.positions.iter().enumerate().map(onto_plane).collect();
    Mesh { normals: vec![normal; positions.len()], positions, ..flat }
}

/// Triangles between two circles of corners; an end without a radius is a point.
fn strip(radii: [f32; 2]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for j in 0..AROUND {
        let [a, b, c, d] = [j, j + 1, j + AROUND + 2, j + AROUND + 1];
        if radii[0] > 0.0 {
            triangles.push([a, b, c]);
        }
        if radii[1] > 0.0 {
            triangles.push([a, c, d]);
        }
    }
    triangles
}

/// Where `origin`, the scene's zero in the world, lies in the coordinates of a mesh: its vertices near that point
/// are near zero in the scene, whatever the transform. Zero for scenes that count from their file's zero.
pub(super) fn in_mesh(origin: DVec3, world_from_mesh: &DAffine3) -> DVec3 {
    if origin == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let zero = world_from_mesh.inverse().transform_point3(origin);
    if zero.is_finite() { zero } else { DVec3::ZERO }
}

/// The transform from a mesh that counts from `zero` of its coordinates to a scene that counts from `origin`
/// of the world.
pub(super) fn here_from_mesh(world_from_mesh: &DAffine3, zero: DVec3, origin: DVec3) -> DAffine3 {
    let translation = world_from_mesh.transform_point3(zero) - origin;
    DAffine3 { matrix3: world_from_mesh.matrix3, translation }
}

/// `mesh` moved; a motion that mirrors does not exchange front and back.
pub(super) fn moved(mut mesh: Mesh, world_from_mesh: &DAffine3) -> Mesh {
    for position in &mut mesh.positions {
        *position = world_from_mesh.transform_point3(position.as_dvec3()).as_vec3();
    }
    if world_from_mesh.matrix3 == DMat3::IDENTITY {
        return mesh;
    }
    let of_normals = world_from_mesh.matrix3.inverse().transpose();
    for normal in &mut mesh.normals {
        *normal = (of_normals * normal.as_dvec3()).normalize_or_zero().as_vec3();
    }
    if world_from_mesh.matrix3.determinant() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// `mesh` with its front where its back was.
pub(super) fn turned_over(mut mesh: Mesh) -> Mesh {
    mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// All of `meshes` as one; those without texture coordinates get zeros, if others have some.
pub(super) fn joined(meshes: impl Iterator<Item = Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.positions.len();
        if !mesh.uvs.is_empty() {
            all.uvs.resize(first, Vec2::ZERO);
            all.uvs.extend(mesh.uvs);
        }
        all.positions.extend(mesh.positions);
        all.normals.extend(mesh.normals);
        all.triangles.extend(mesh.triangles.into_iter().map(|t| t.map(|i| i + first as u32)));
    }
    if !all.uvs.is_empty() {
        all.uvs.resize(all.positions.len(), Vec2::ZERO);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::frustum;
    use glam::Vec3;

    #[test]
    fn a_cone_faces_where_its_triangles_face() {
        let ends = [Vec3::ZERO, Vec3::new(0.0, 0.0, 1.7)];
        for radii in [[0.4, 0.0], [0.0, 0.4], [0.4, 0.15], [0.3, 0.3]] {
            let mesh = frustum(ends, radii);
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                let flat = (b - a).cross(c - a).normalize();
                let smooth: Vec3 = triangle.map(|i| mesh.normals[i as usize]).iter().sum();
                // A corner at a side's end is half a segment, 2.8 degrees, from its middle.
                let sideways = if radii[0] * radii[1] > 0.0 { 0.018 } else { 1e-5 };
                assert!(flat.dot(smooth.normalize()) > 0.9995, "{radii:?}");
                assert!(flat.cross(smooth.normalize()).z.abs() < sideways, "{radii:?}");
            }
        }
    }
}
