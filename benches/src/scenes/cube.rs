//! Balls without seams or poles, made from a cube.

use glam::{IVec3, Vec3};
use std::collections::HashMap;
use unrender::scene::Mesh;

/// A cube of `cells` x `cells` x 6 quadrilaterals, each vertex moved to `surface` of the unit vector
/// towards it. Front faces are outside; there are no normals yet.
pub(crate) fn blown_up_cube(cells: i32, surface: impl Fn(Vec3) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let mut index_of: HashMap<IVec3, u32> = HashMap::new();
    let mut vertex = |at: IVec3| {
        *index_of.entry(at).or_insert_with(|| {
            mesh.positions.push(surface(at.as_vec3().normalize()));
            mesh.positions.len() as u32 - 1
        })
    };
    for (normal, across) in [(IVec3::X, IVec3::Y), (IVec3::Y, IVec3::Z), (IVec3::Z, IVec3::X)]
        .into_iter()
        .flat_map(|(normal, across)| [(normal, across), (-normal, across)])
    {
        let up = normal.cross(across);
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let mut corner = |di: i32, dj: i32| {
                let (a, b) = (2 * (i + di) - cells, 2 * (j + dj) - cells);
                vertex(normal * cells + across * a + up * b)
            };
            let corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            mesh.triangles.push([corners[0], corners[1], corners[2]]);
            mesh.triangles.push([corners[0], corners[2], corners[3]]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_no_seams_and_fronts_are_outside() {
        let mesh = blown_up_cube(8, |direction| 2.0 * direction);
        assert_eq!(mesh.triangles.len(), 8 * 8 * 12);
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([*from.min(to), *from.max(to)]).or_default() +=
                    if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|balance| *balance == 0), "each edge there and back");
        for index in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(index);
            assert!((b - a).cross(c - a).dot(a) > 0.0);
        }
    }
}
