//! Meshes as binary PLY, with normals and, where there are any, texture coordinates `u`, `v`.

use unrender_scene::Mesh;

/// The bytes of `mesh`.
pub(super) fn bytes(mesh: &Mesh) -> Vec<u8> {
    let has_uvs = !mesh.uvs.is_empty();
    let properties: &[&str] = if has_uvs {
        &["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    } else {
        &["x", "y", "z", "nx", "ny", "nz"]
    };
    let properties: String = properties.iter().map(|p| format!("property float {p}\n")).collect();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    );
    let mut bytes = header.into_bytes();
    for (index, (position, normal)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
        let place = position.to_array().into_iter().chain(normal.to_array());
        bytes.extend(place.flat_map(f32::to_le_bytes));
        if has_uvs {
            bytes.extend(mesh.uvs[index].to_array().into_iter().flat_map(f32::to_le_bytes));
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    bytes
}
