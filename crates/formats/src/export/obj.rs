//! One object as Wavefront OBJ, for programs that take smooth and textured meshes that way.

use super::identifiers::quoted;
use crate::numbers::triple_at;
use glam::DVec3;
use std::fmt::Write;
use unrender_scene::Mesh;

/// The text of the object called `name`, whose `mesh` counts from `origin`; `material` names the material of each of
/// its triangles.
pub(super) fn text(
    name: &str,
    mesh: &Mesh,
    origin: DVec3,
    material: impl Fn(usize) -> String,
) -> String {
    let mut text = format!("# object {}\n", quoted(name));
    for p in &mesh.positions {
        let [x, y, z] = triple_at(origin, *p);
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for uv in &mesh.uvs {
        // OBJ counts v from the bottom.
        let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
    }
    for n in &mesh.normals {
        let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
    }
    let mut current = String::new();
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let wanted = material(index);
        if wanted != current {
            let _ = writeln!(text, "usemtl {wanted}");
            current = wanted;
        }
        let corner = |i: u32| {
            let i = i + 1;
            if mesh.uvs.is_empty() { format!("{i}//{i}") } else { format!("{i}/{i}/{i}") }
        };
        let [a, b, c] = triangle.map(corner);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
