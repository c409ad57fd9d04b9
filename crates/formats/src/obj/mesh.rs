//! The faces of an OBJ as meshes: one for each name and material, and with and without texture coordinates.
//!
//! A triangle has texture coordinates or normals if all of its three corners have them. A triangle
//! without normals is flat.

use super::document::{Corner, Document, Face, push};
use super::unread::Unread;
use crate::input::Scope;
use crate::polygon;
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;
use unrender_scene::Mesh;

/// Upper bounds of memory, bytes: of a part beside its lists, and of a vertex in the map by corners.
const BYTES_A_PART: u64 = 512;
const BYTES_A_PLACE: u64 = 48;
/// The memory that `polygon` needs for a corner, for its position in the plane.
const BYTES_TO_SPLIT: usize = 80;

const NO_NORMALS: &str = "faces of smoothing groups (s) have no normals (vn) and are flat; export \
                          the scene with its normals if it is smooth";
const BAD_NORMALS: &str = "normals of a face are missing at some corners, or have no length; those \
triangles are flat";
const BAD_UVS: &str = "texture coordinates of a face are missing at some corners, or are not \
finite; those triangles have none";

/// Triangles of one name and one material, all with texture coordinates or all without.
pub(super) struct Piece {
    /// Index into [`Document::objects`].
    pub(super) object: u32,
    /// Index into [`Document::materials`].
    pub(super) material: u32,
    pub(super) mesh: Mesh,
    /// The vertices of smooth triangles.
    places: HashMap<Corner, u32>,
}

/// The pieces of `document` in the order in which they begin.
///
/// # Errors
/// If a face cannot be split into triangles, or if all take too much memory.
pub(super) fn parts(scope: &Scope, document: &mut Document) -> Result<Vec<Piece>, String> {
    let mut unread = std::mem::take(&mut document.unread);
    let mut builder = Builder { scope, document, parts: Vec::new(), by_kind: HashMap::new() };
    let mut ears = Vec::new();
    for face in &document.faces {
        builder.face(face, &mut ears, &mut unread)?;
    }
    let parts = builder.parts;
    document.unread = unread;
    Ok(parts)
}

struct Builder<'a> {
    scope: &'a Scope,
    document: &'a Document,
    parts: Vec<Piece>,
    /// The parts by name, material, and whether they have texture coordinates.
    by_kind: HashMap<(u32, u32, bool), usize>,
}

impl Builder<'_> {
    /// Adds the triangles of `face`; `ears` is a buffer.
    fn face(
        &mut self,
        face: &Face,
        ears: &mut Vec<[Corner; 3]>,
        unread: &mut Unread,
    ) -> Result<(), String> {
        let corners = self.document.corners(face);
        self.check(face, corners)?;
        let first = self.position(corners[0]);
        ears.clear();
        self.scope.charge(Self::more(ears, corners.len()))?;
        polygon::split(corners, |c| (self.position(*c) - first).as_vec3(), ears)
            .map_err(|problem| format!("line {} {problem}", face.line))?;
        let has = |index: usize| move |corner: &Corner| corner[index] > 0;
        let (mut bad_uvs, mut bad_normals) = (false, false);
        for ear in ears.iter() {
            let uvs = self.uvs(ear);
            let normals = self.normals(ear);
            bad_uvs |= uvs.is_none() && ear.iter().any(has(1));
            bad_normals |= normals.is_none() && ear.iter().any(has(2));
            self.add(face, ear, uvs, normals)?;
        }
        let is_bare = !corners.iter().any(has(2));
        for (what, is_so) in [
            (BAD_UVS, bad_uvs),
            (BAD_NORMALS, bad_normals),
            (NO_NORMALS, face.is_smooth && is_bare),
        ] {
            if is_so {
                unread.note(what, face.line, None);
            }
        }
        Ok(())
    }

    /// The memory that splitting a polygon of `corners` needs beyond that of `ears`.
    fn more(ears: &Vec<[Corner; 3]>, corners: usize) -> u64 {
        let more = corners.saturating_sub(ears.capacity());
        (more * (2 * size_of::<[Corner; 3]>() + BYTES_TO_SPLIT)) as u64
    }

    fn check(&self, face: &Face, corners: &[Corner]) -> Result<(), String> {
        match corners.iter().find(|c| !self.position(**c).as_vec3().is_finite()) {
            None => Ok(()),
            Some([vertex, ..]) => Err(format!(
                "line {} has a face at v {vertex}, whose position is not finite; export the scene \
                 again",
                face.line
            )),
        }
    }

    fn position(&self, corner: Corner) -> DVec3 {
        self.document.positions[corner[0] as usize - 1]
    }

    /// The texture coordinates of a triangle, if all of its corners have some.
    fn uvs(&self, ear: &[Corner; 3]) -> Option<[Vec2; 3]> {
        let mut uvs = [Vec2::ZERO; 3];
        for (uv, corner) in uvs.iter_mut().zip(ear) {
            let found = self.document.uvs[(corner[1] as usize).checked_sub(1)?];
            // OBJ counts v from the bottom, glTF from the top.
            *uv = Vec2::new(found.x, 1.0 - found.y);
        }
        uvs.iter().all(|uv| uv.is_finite()).then_some(uvs)
    }

    /// The normals of a triangle, if all of its corners have some.
    fn normals(&self, ear: &[Corner; 3]) -> Option<[Vec3; 3]> {
        let mut normals = [Vec3::ZERO; 3];
        for (normal, corner) in normals.iter_mut().zip(ear) {
            let found = self.document.normals[(corner[2] as usize).checked_sub(1)?];
            *normal = found.try_normalize()?;
        }
        Some(normals)
    }

    fn add(
        &mut self,
        face: &Face,
        ear: &[Corner; 3],
        uvs: Option<[Vec2; 3]>,
        normals: Option<[Vec3; 3]>,
    ) -> Result<(), String> {
        let (scope, points) = (self.scope, ear.map(|corner| self.position(corner)));
        let part = self.part((face.object, face.material, uvs.is_some()))?;
        let mut triangle = [0; 3];
        for k in 0..3 {
            // Corners whose texture coordinates are not finite share one vertex, without any.
            let place = if uvs.is_some() { ear[k] } else { [ear[k][0], 0, ear[k][2]] };
            if normals.is_some()
                && let Some(vertex) = part.places.get(&place)
            {
                triangle[k] = *vertex;
                continue;
            }
            let next = part.mesh.positions.len();
            triangle[k] = u32::try_from(next).map_err(|_| "has too many vertices; split it")?;
            push(scope, &mut part.mesh.positions, points[k].as_vec3())?;
            push(scope, &mut part.mesh.normals, normals.map_or_else(|| flat(points), |n| n[k]))?;
            if let Some(uvs) = uvs {
                push(scope, &mut part.mesh.uvs, uvs[k])?;
            }
            if normals.is_some() {
                scope.charge(BYTES_A_PLACE)?;
                part.places.insert(place, triangle[k]);
            }
        }
        push(scope, &mut part.mesh.triangles, triangle)
    }

    fn part(&mut self, kind: (u32, u32, bool)) -> Result<&mut Piece, String> {
        let next = self.parts.len();
        let place = *self.by_kind.entry(kind).or_insert(next);
        if place == next {
            self.scope.charge(BYTES_A_PART)?;
            let (object, material, _) = kind;
            let (mesh, places) = (Mesh::default(), HashMap::new());
            self.parts.push(Piece { object, material, mesh, places });
        }
        Ok(&mut self.parts[place])
    }
}

/// The normal of a triangle; upwards if it has no area.
fn flat([a, b, c]: [DVec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3()
}
