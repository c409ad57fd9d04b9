//! Meshes from PLY files: positions, and where there are any, normals and texture coordinates.

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use unrender_scene::Mesh;

/// The mesh in `bytes`; polygons become fans of triangles. Without normals it is flat.
///
/// # Errors
/// If it is not PLY, or if a face names a vertex that is not there.
pub(super) fn mesh(bytes: &[u8]) -> Result<Mesh, String> {
    let mut reader = bytes;
    let ply = Parser::<DefaultElement>::new()
        .read_ply(&mut reader)
        .map_err(|error| format!("is no valid PLY: {error}"))?;
    let vertices = ply.payload.get("vertex").ok_or("has no vertices")?;
    let numbers = |names: [&str; 2]| -> Option<Vec<f32>> {
        vertices.iter().map(|v| names.iter().find_map(|name| number(v.get(*name)?))).collect()
    };
    let vectors = |names: [&str; 3]| -> Option<Vec<Vec3>> {
        let [x, y, z] = names.map(|name| numbers([name, name]));
        Some(x?.into_iter().zip(y?).zip(z?).map(|((x, y), z)| Vec3::new(x, y, z)).collect())
    };
    let positions = vectors(["x", "y", "z"]).ok_or("has vertices without x, y and z")?;
    let normals = vectors(["nx", "ny", "nz"]);
    let uvs = numbers(["u", "s"]).zip(numbers(["v", "t"]));
    let uvs: Vec<Vec2> =
        uvs.map_or(Vec::new(), |(u, v)| u.into_iter().zip(v).map(Vec2::from).collect());
    let mut triangles = Vec::new();
    for face in ply.payload.get("face").into_iter().flatten() {
        let list = face.get("vertex_indices").or_else(|| face.get("vertex_index"));
        let corners = list.and_then(indices).ok_or("has faces without vertex_indices")?;
        if corners.iter().any(|&i| i as usize >= positions.len()) {
            return Err("has a face with a vertex that is not there".into());
        }
        triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
    }
    Ok(match normals {
        Some(normals) => {
            let normals = normals.into_iter().map(Vec3::normalize_or_zero).collect();
            Mesh { positions, normals, uvs, tangents: Vec::new(), triangles }
        }
        None => Mesh::flat(&positions, &uvs, &triangles),
    })
}

fn number(property: &Property) -> Option<f32> {
    match *property {
        Property::Float(v) => Some(v),
        Property::Double(v) => Some(v as f32),
        _ => None,
    }
}

fn indices(property: &Property) -> Option<Vec<u32>> {
    let signed = |list: &[i32]| list.iter().map(|&i| u32::try_from(i).ok()).collect();
    match property {
        Property::ListInt(list) => signed(list),
        Property::ListUInt(list) => Some(list.clone()),
        Property::ListShort(list) => list.iter().map(|&i| u32::try_from(i).ok()).collect(),
        Property::ListUShort(list) => Some(list.iter().map(|&i| u32::from(i)).collect()),
        Property::ListChar(list) => list.iter().map(|&i| u32::try_from(i).ok()).collect(),
        Property::ListUChar(list) => Some(list.iter().map(|&i| u32::from(i)).collect()),
        _ => None,
    }
}
