//! Triangle meshes in world space.

use crate::Detail;
use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::f32::consts::{PI, TAU};

/// Triangles of spheres: around, and from pole to pole.
const AROUND: u32 = 64;
const UP: u32 = 32;

/// A mesh with one entry of each attribute per vertex.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
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
    /// What its surface has below its triangles.
    #[serde(default)]
    pub detail: Detail,
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

    /// A sphere, smooth, its front outside: inscribed, with 0.2 % less area.
    pub fn sphere(centre: Vec3, radius: f32) -> Self {
        let mut mesh = Self::default();
        for (i, j) in (0..=UP).flat_map(|i| (0..=AROUND).map(move |j| (i, j))) {
            let (v, u) = (i as f32 / UP as f32, j as f32 / AROUND as f32);
            // The last corners around are where the first are, and those of a pole in one place: it is closed.
            let around = (j % AROUND) as f32 / AROUND as f32;
            let ((sin, cos), (sin_phi, cos_phi)) = ((PI * v).sin_cos(), (TAU * around).sin_cos());
            let sin = if i == UP { 0.0 } else { sin };
            let normal = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
            mesh.positions.push(centre + radius * normal);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
        for (i, j) in (0..UP).flat_map(|i| (0..AROUND).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| i * (AROUND + 1) + j;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if i + 1 < UP {
                mesh.triangles.push([a, b, c]);
            }
            if i > 0 {
                mesh.triangles.push([a, c, d]);
            }
        }
        mesh
    }

    /// The three corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|i| self.positions[i as usize])
    }
}

/// A named mesh that belongs to a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// The node's name in the scene file.
    pub name: String,
    /// Index into `Scene::groups`.
    pub group: usize,
    /// The geometry.
    pub mesh: Mesh,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_round_and_its_front_is_outside() {
        let (centre, radius) = (Vec3::new(1.0, -2.0, 3.0), 0.5);
        let sphere = Mesh::sphere(centre, radius);
        let mut area = 0.0;
        for [a, b, c] in (0..sphere.triangles.len()).map(|t| sphere.corners(t)) {
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a + b + c - 3.0 * centre) > 0.0);
            area += 0.5 * normal.length();
        }
        let share = area / (4.0 * PI * radius * radius);
        assert!((share - 0.998).abs() < 0.0005, "{share}");
        let round = |p: &Vec3| (p.distance(centre) - radius).abs() < 1e-5;
        assert!(sphere.positions.iter().all(round));
        assert!(sphere.is_closed());
    }
}
