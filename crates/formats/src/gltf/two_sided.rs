//! Surfaces that emit from both sides: those of a material that emits and is `doubleSided`, which
//! Blender's exporter writes unless *Backface Culling* is ticked, and which Cycles renders so.
//!
//! Ours emit from their front only. An open mesh of such a material gets a second skin behind the first,
//! which emits the other way. The inside of a closed one is not seen.

use super::Problem;
use super::document::Material as MaterialJson;
use super::geometry::append;
use super::material::emission;
use glam::{Vec3, Vec4};
use unrender_scene::{Mesh, Rgb};

/// How far the second skin lies behind the first, as a share of the mesh's extent: a tenth of a millimetre
/// for a lamp of a metre. At a tenth of this, rays in single precision confuse the two; at ten times this,
/// lamps close to a ceiling reach into it.
const BEHIND: f32 = 1e-4;

/// Whether surfaces of this material emit from both sides.
pub(super) fn emits(json: &MaterialJson) -> bool {
    json.double_sided && emission(json).is_some_and(|emission| emission != Rgb::ZERO)
}

/// Gives an open mesh its second skin.
pub(super) fn add_back(mesh: &mut Mesh) -> Result<(), Problem> {
    if mesh.normals.len() != mesh.positions.len() || mesh.is_closed() {
        return Ok(());
    }
    let low = mesh.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let behind = BEHIND * (high - low).length();
    let vertices = mesh.positions.iter().zip(&mesh.normals);
    let back = Mesh {
        positions: vertices.map(|(position, normal)| *position - behind * *normal).collect(),
        normals: mesh.normals.iter().map(|normal| -*normal).collect(),
        uvs: mesh.uvs.clone(),
        tangents: mesh.tangents.iter().map(|t| Vec4::new(t.x, t.y, t.z, -t.w)).collect(),
        triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
        ..Mesh::default()
    };
    append(mesh, back)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let positions =
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        Mesh::flat(&positions, &[], &[[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn an_open_mesh_gets_a_second_skin_that_faces_the_other_way() {
        let mut mesh = square();
        add_back(&mut mesh).unwrap();
        assert_eq!(mesh.triangles.len(), 4);
        for (triangle, towards) in [(0, 1.0), (1, 1.0), (2, -1.0), (3, -1.0)] {
            let [a, b, c] = mesh.corners(triangle);
            let normal = (b - a).cross(c - a).normalize();
            assert!((normal.z - towards).abs() < 1e-6);
            let shading = mesh.normals[mesh.triangles[triangle][0] as usize];
            assert!(shading.dot(normal) > 0.99);
            assert!(if towards > 0.0 { a.z == 0.0 } else { a.z < 0.0 && a.z > -1e-3 });
        }
    }

    #[test]
    fn a_closed_mesh_stays_as_it_is() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        // Every face has vertices of its own.
        let mut closed = Mesh::flat(&corners, &[], &faces);
        add_back(&mut closed).unwrap();
        assert_eq!(closed.triangles.len(), 4);
    }
}
