//! Meshes of the unit tests.

use glam::Vec3;
use unrender_scene::Mesh;

/// A rectangle around `centre` that faces along `x` cross `y`, of twice their lengths.
pub(crate) fn quad(centre: Vec3, [x, y]: [Vec3; 2]) -> Mesh {
    let corners = [centre - x - y, centre + x - y, centre + x + y, centre - x + y];
    Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]])
}

/// All meshes as one.
pub(crate) fn merged(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    meshes.into_iter().fold(Mesh::default(), |mut all, mesh| {
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.normals.extend(mesh.normals);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        all
    })
}

/// A box around `centre` that faces outwards.
pub(crate) fn cuboid(centre: Vec3, half: Vec3) -> Mesh {
    merged((0..3).flat_map(|i| {
        let axis = |j: usize| Vec3::AXES[j % 3] * half[j % 3];
        let (x, y, z) = (axis(i + 1), axis(i + 2), axis(i));
        [quad(centre + z, [x, y]), quad(centre - z, [y, x])]
    }))
}
