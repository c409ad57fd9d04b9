//! Primitives to meshes in world space.

use super::document::{Attributes, Primitive};
use super::source::Source;
use super::transform::Layout;
use super::{Problem, accessor, extensions};
use crate::numbers::coarse_step;
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use serde_json::Value;
use unrender_scene::{Mesh, Warnings};

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// The mesh of `primitive` in world space; none if it is made of points or lines.
pub(super) fn world_mesh(
    source: &Source,
    primitive: &Primitive,
    world_from_node: &DAffine3,
    warnings: &mut Warnings,
) -> Result<Option<Mesh>, Problem> {
    if !(TRIANGLES..=FAN).contains(&primitive.mode) {
        warnings.push("Points and lines of the scene were left out; only triangles count.");
        return Ok(None);
    }
    if lacks_data(source, primitive) {
        warnings.push("Some meshes are in buffers that are missing; they were left out.");
        return Ok(None);
    }
    let layout = Layout::of(&source.document, primitive.material)?;
    let Some(mut mesh) = local_mesh(source, primitive, layout.set)? else { return Ok(None) };
    keep_used_vertices(&mut mesh);
    if source.scope().origin() != DVec3::ZERO {
        warnings.0.extend(coarse(&mesh.positions, world_from_node));
    }
    place(&mut mesh, world_from_node);
    let has_zero_normal = mesh.normals.contains(&Vec3::ZERO);
    if has_zero_normal {
        warnings.push("Some normals have no length; their meshes were given flat normals.");
    }
    if mesh.normals.is_empty() || has_zero_normal {
        if mesh.triangles.len() > (u32::MAX / 3) as usize {
            return Err(too_large());
        }
        mesh = Mesh::flat(&mesh.positions, &mesh.uvs, &mesh.triangles);
    }
    layout.apply(&mut mesh);
    Ok(Some(mesh))
}

/// Appends `part` to `mesh`; both have the same attributes.
pub(super) fn append(mesh: &mut Mesh, part: Mesh) -> Result<(), Problem> {
    let first = u32::try_from(mesh.positions.len()).map_err(|_| too_large())?;
    u32::try_from(mesh.positions.len() + part.positions.len()).map_err(|_| too_large())?;
    mesh.positions.extend(part.positions);
    mesh.normals.extend(part.normals);
    mesh.uvs.extend(part.uvs);
    mesh.tangents.extend(part.tangents);
    mesh.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|i| i + first)));
    Ok(())
}

fn too_large() -> Problem {
    "has a mesh of more than 2^32 vertices; split it into several nodes".into()
}

/// The attributes as they stand in the file, every index in range, with the texture coordinates of
/// `set`.
fn local_mesh(source: &Source, primitive: &Primitive, set: usize) -> Result<Option<Mesh>, Problem> {
    let attributes = &primitive.attributes;
    let Some(position) = attributes.position else { return Ok(None) };
    refuse_compressed(source, primitive)?;
    let positions = accessor::vec3s(source, position)?;
    let count = positions.len();
    let fits = |length: usize, name: &str| {
        if length == count {
            return Ok(());
        }
        Err(format!(
            "a mesh has {count} POSITION but {length} {name} vertices; export the scene again"
        ))
    };
    let mut mesh = Mesh { positions, ..Mesh::default() };
    if let Some(index) = attributes.normal {
        mesh.normals = accessor::vec3s(source, index)?;
        fits(mesh.normals.len(), "NORMAL")?;
        // glTF says that tangents without normals are to be ignored.
        if let Some(index) = attributes.tangent {
            mesh.tangents = accessor::vec4s(source, index)?;
            fits(mesh.tangents.len(), "TANGENT")?;
        }
    }
    if let Some(index) = attributes.texcoord(set) {
        mesh.uvs = accessor::vec2s(source, index)?;
        fits(mesh.uvs.len(), &format!("TEXCOORD_{set}"))?;
    }
    let indices = match primitive.indices {
        Some(index) => accessor::indices(source, index)?,
        None => {
            source.scope().charge(count as u64 * accessor::BYTES_A_INDEX)?;
            (0..u32::try_from(count).map_err(|_| too_large())?).collect()
        }
    };
    if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
        return Err(format!(
            "a mesh uses vertex {index}, but there are only {count}; export the scene again"
        ));
    }
    mesh.triangles = triangles(&indices, primitive.mode);
    Ok(Some(mesh))
}

/// Whether some numbers of `primitive` are in a file that is missing.
fn lacks_data(source: &Source, primitive: &Primitive) -> bool {
    let Attributes { position, normal, tangent, texcoord_0, .. } = primitive.attributes;
    let others = primitive.attributes.others.values().filter_map(Value::as_u64);
    let others = others.filter_map(|index| usize::try_from(index).ok());
    let own = [position, normal, tangent, texcoord_0, primitive.indices].into_iter().flatten();
    own.chain(others).any(|index| source.lacks(index))
}

/// The accessors of a compressed mesh have no data of their own.
fn refuse_compressed(source: &Source, primitive: &Primitive) -> Result<(), Problem> {
    let Attributes { position, normal, tangent, texcoord_0, .. } = primitive.attributes;
    let accessors =
        [position, normal, tangent, texcoord_0, primitive.indices].into_iter().flatten();
    let is_empty = |index: usize| {
        let accessor = source.document.accessors.get(index);
        accessor.is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
    };
    let compression = primitive.unread.extensions.keys().find(|name| name.contains("compression"));
    match compression {
        Some(name) if accessors.into_iter().any(is_empty) => Err(extensions::refused(name)),
        _ => Ok(()),
    }
}

fn triangles(indices: &[u32], mode: u32) -> Vec<[u32; 3]> {
    match mode {
        STRIP => {
            let windows = indices.windows(3).enumerate();
            let turn = |(i, w): (usize, &[u32])| {
                if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] }
            };
            windows.map(turn).collect()
        }
        FAN => indices.windows(2).skip(1).map(|w| [w[0], w[1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// Drops vertices that no triangle uses: primitives may share one large list.
fn keep_used_vertices(mesh: &mut Mesh) {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
    if used.iter().all(|&u| u) {
        return;
    }
    let mut next = 0;
    let number = |&u: &bool| {
        let own = next;
        next += u32::from(u);
        own
    };
    let renumbered: Vec<u32> = used.iter().map(number).collect();
    mesh.triangles.iter_mut().flatten().for_each(|i| *i = renumbered[*i as usize]);
    retain(&mut mesh.positions, &used);
    retain(&mut mesh.normals, &used);
    retain(&mut mesh.uvs, &used);
    retain(&mut mesh.tangents, &used);
}

fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    items.retain(|_| flags.next().copied().unwrap_or(false));
}

/// The precision lost in `positions`, which a file has in single precision, if they lie far from their node's
/// zero.
fn coarse(positions: &[Vec3], world_from_node: &DAffine3) -> Option<String> {
    let low = positions.iter().copied().reduce(Vec3::min)?;
    let high = positions.iter().copied().reduce(Vec3::max)?;
    let step = coarse_step(low, high)?;
    let scale = world_from_node.matrix3.determinant().abs().cbrt();
    Some(format!(
        "some vertices stand in the file in steps of {} m: they are so far from the zero of their node that \
         single precision has no more digits; export the meshes with their vertices near that zero, and the \
         nodes where they are (in Blender: Object > Set Origin > Origin to Geometry)",
        (step * scale) as f32
    ))
}

/// Moves `mesh` by `world_from_node`; a mirroring reverses the winding, so that the front stays.
fn place(mesh: &mut Mesh, world_from_node: &DAffine3) {
    let matrix = world_from_node.matrix3;
    let mirrors = matrix.determinant() < 0.0;
    let cofactors = cofactors(&matrix) * if mirrors { -1.0 } else { 1.0 };
    for position in &mut mesh.positions {
        *position = world_from_node.transform_point3(position.as_dvec3()).as_vec3();
    }
    for normal in &mut mesh.normals {
        *normal = unit(cofactors * normal.as_dvec3());
    }
    for tangent in &mut mesh.tangents {
        let direction = unit(matrix * tangent.truncate().as_dvec3());
        *tangent = direction.extend(if mirrors { -tangent.w } else { tangent.w });
    }
    if mirrors {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
}

/// The inverse transpose times the determinant; it exists for singular matrices, too.
fn cofactors(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// `v` at length one. A unit vector, up to rounding, stays as it is, to the bit.
pub(super) fn unit(v: DVec3) -> Vec3 {
    let length = v.length();
    if length == 0.0 || (length - 1.0).abs() < 1e-6 {
        return v.as_vec3();
    }
    (v / length).as_vec3()
}

/// The `w` of a tangent is a sign; some exporters leave it zero.
pub(super) fn repair_handedness(tangents: &mut [Vec4], warnings: &mut Warnings) {
    for tangent in tangents.iter_mut().filter(|t| t.w.is_finite() && t.w.abs() != 1.0) {
        tangent.w = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        warnings.push("Some tangents have a handedness other than 1 and -1; its sign was taken.");
    }
}
