//! Triangle meshes in world space.

use glam::{Vec2, Vec3, Vec4};

/// A mesh with one entry of each attribute per vertex.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    /// Vertex positions in world space, metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals in world space; as many as positions.
    pub normals: Vec<Vec3>,
    /// `TEXCOORD_0`: empty, or as many as positions.
    pub uvs: Vec<Vec2>,
    /// `TANGENT` in world space, w the handedness of glTF: empty, or as many as positions.
    pub tangents: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh with flat normals: every triangle has its own vertices.
    ///
    /// `positions`, `uvs` and `triangles` as in the fields; `uvs` may be empty.
    pub fn flat(positions: &[Vec3], uvs: &[Vec2], triangles: &[[u32; 3]]) -> Self {
        let mut mesh = Self::default();
        for triangle in triangles {
            let corners = triangle.map(|i| positions[i as usize]);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.normals.extend([normal.normalize_or(Vec3::Y); 3]);
            if !uvs.is_empty() {
                mesh.uvs.extend(triangle.map(|i| uvs[i as usize]));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        mesh
    }

    /// The three corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|i| self.positions[i as usize])
    }
}

/// A named mesh that belongs to a group.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The node's name in the scene file.
    pub name: String,
    /// Index into `Scene::groups`.
    pub group: usize,
    /// The geometry.
    pub mesh: Mesh,
}
