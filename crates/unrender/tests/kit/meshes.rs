//! Meshes from which scenes of tests are built. They have flat normals and no texture coordinates.

use glam::Vec3;
use unrender::scene::{Group, Material, Mesh, Object, Rgb, Scene};

/// A parallelogram from a corner and two edges, its front towards `across` x `up`.
pub(crate) fn quad(corner: Vec3, across: Vec3, up: Vec3) -> Mesh {
    of_corners([corner, corner + across, corner + across + up, corner + up])
}

/// A square about `centre`, its front towards `normal`, which lies along an axis. Its sides are twice as long
/// as `half`.
pub(crate) fn square(centre: Vec3, normal: Vec3, half: f32) -> Mesh {
    let x = if normal.x.abs() > 0.5 { Vec3::Z } else { Vec3::X };
    let y = normal.cross(x);
    let corner = |u: f32, v: f32| centre + half * (u * x + v * y);
    of_corners([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}

/// A box between two corners, its fronts outwards.
pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Mesh {
    let side = high - low;
    let [x, y, z] = [side.x * Vec3::X, side.y * Vec3::Y, side.z * Vec3::Z];
    let mut whole = Mesh::default();
    for (corner, across, up) in [
        (low + z, x, y),
        (low + x, -x, y),
        (low, z, y),
        (low + x + z, -z, y),
        (low + y + z, x, -z),
        (low, x, z),
    ] {
        append(&mut whole, &quad(corner, across, up));
    }
    whole
}

/// Adds the triangles of `part` to `whole`.
pub(crate) fn append(whole: &mut Mesh, part: &Mesh) {
    let first = whole.positions.len() as u32;
    whole.positions.extend(&part.positions);
    whole.normals.extend(&part.normals);
    whole.triangles.extend(part.triangles.iter().map(|t| t.map(|i| first + i)));
}

/// Adds an object in a group of its own, both called `name`, of the diffuse reflectance `rho_d`.
pub(crate) fn add(scene: &mut Scene, name: &str, rho_d: Rgb, mesh: Mesh) {
    let group = scene.groups.len();
    let material = Material::diffuse(rho_d);
    scene.groups.push(Group { name: name.into(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: name.into(), group, mesh });
}

/// Two triangles between four corners.
fn of_corners(corners: [Vec3; 4]) -> Mesh {
    Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]])
}
