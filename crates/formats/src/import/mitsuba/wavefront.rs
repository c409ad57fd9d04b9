//! The geometry of OBJ files: corners, texture coordinates and normals as one mesh, without materials and groups,
//! which Mitsuba passes over.

use super::paint::Context;
use crate::obj::document::{self, Corner, Document};
use crate::polygon;
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;
use unrender_scene::Mesh;

/// An upper bound of the memory of a corner, bytes: an entry of the table of vertices, a vertex and a triangle, in
/// lists that double, and its place in the plane of its face.
const BYTES_A_CORNER: u64 = 256;

/// All faces of `bytes` as one mesh, counted from `zero`; v as the file has it, or if it `flips`, from the other
/// end. Vertices without normals or texture coordinates have zeros, and there are none at all if no vertex has
/// any. Warnings name what is not read of the `file`.
pub(super) fn mesh(
    context: &Context,
    bytes: &[u8],
    (file, zero): (&str, DVec3),
    flips: bool,
) -> Result<Mesh, String> {
    let mut document = document::read(context.scope, bytes, zero)?;
    if flips {
        document.uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
    context.scope.charge(BYTES_A_CORNER.saturating_mul(document.corners.len() as u64))?;
    let mut lists = Lists::default();
    for face in &document.faces {
        let corners = document.corners(face).iter().map(|corner| lists.vertex(&document, *corner));
        let corners = corners.collect::<Result<Vec<u32>, String>>();
        let corners = corners.map_err(|problem| format!("line {} {problem}", face.line))?;
        let Mesh { positions, triangles, .. } = &mut lists.mesh;
        polygon::split(&corners, |&i| positions[i as usize], triangles)
            .map_err(|problem| format!("line {} {problem}", face.line))?;
    }
    document.tell_of_shapes(file, &mut context.warnings.borrow_mut());
    let Lists { mut mesh, has_uvs, has_normals, .. } = lists;
    if !has_uvs {
        mesh.uvs.clear();
    }
    if !has_normals {
        mesh.normals.clear();
    }
    Ok(mesh)
}

#[derive(Default)]
struct Lists {
    vertices: BTreeMap<Corner, u32>,
    mesh: Mesh,
    has_uvs: bool,
    has_normals: bool,
}

impl Lists {
    /// The vertex of `corner`.
    fn vertex(&mut self, document: &Document, corner: Corner) -> Result<u32, String> {
        if let Some(known) = self.vertices.get(&corner) {
            return Ok(*known);
        }
        let [v, vt, vn] = corner.map(|index| index as usize);
        let position = document.positions[v - 1].as_vec3();
        let uv = if vt > 0 { document.uvs[vt - 1] } else { Vec2::ZERO };
        let normal = if vn > 0 { document.normals[vn - 1] } else { Vec3::ZERO };
        for (word, index, is_finite) in [
            ("v", v, position.is_finite()),
            ("vt", vt, uv.is_finite()),
            ("vn", vn, normal.is_finite()),
        ] {
            if !is_finite {
                return Err(format!(
                    "has a face at {word} {index}, which is not finite; export the mesh again"
                ));
            }
        }
        let new = u32::try_from(self.mesh.positions.len())
            .map_err(|_| "has a face too many: there are too many vertices; split the mesh")?;
        self.vertices.insert(corner, new);
        self.has_uvs |= vt > 0;
        self.has_normals |= vn > 0;
        self.mesh.positions.push(position);
        self.mesh.uvs.push(uv);
        self.mesh.normals.push(normal.normalize_or_zero());
        Ok(new)
    }
}
