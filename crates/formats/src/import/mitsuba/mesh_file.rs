//! Meshes from files as Mitsuba takes them: smooth where they have no normals, unless `face_normals` is
//! set.

use super::paint::Context;
use super::tree::Node;
use super::{serialized, shapes, wavefront};
use crate::import::ply;
use crate::numbers::coarse_step;
use glam::{DAffine3, DVec3, Vec2, Vec3};
use unrender_scene::Mesh;

/// Memory of a corner of a triangle that is not shared, bytes.
const CORNER_BYTES: u64 = 36;

/// The precision lost in a mesh that its file has in single precision, if it lies far from the file's zero and
/// nearer to the scene's; `mesh` still counts from `zero`.
fn coarse(mesh: &Mesh, (here_from_mesh, zero): (&DAffine3, DVec3)) -> Option<String> {
    let positions = || mesh.positions.iter().copied();
    let [low, high] = [positions().reduce(Vec3::min)?, positions().reduce(Vec3::max)?];
    let in_file = |corner: Vec3| (corner.as_dvec3() + zero).as_vec3();
    let step = coarse_step(in_file(low), in_file(high))?;
    let scale = here_from_mesh.matrix3.determinant().abs().cbrt();
    // A small thing may be as far from zero in its file as in the room, where the steps are not visible.
    let middle = 0.5 * (low + high);
    let is_nearer = 2.0 * here_from_mesh.transform_point3(middle.as_dvec3()).length()
        < scale * in_file(middle).as_dvec3().length();
    is_nearer.then(|| {
        format!(
            "has vertices in steps of {} units of the scene: they are so far from the zero of their file that single \
             precision has no more digits; write them in double precision, or near zero with a to_world that puts \
             them where they are",
            (step * scale) as f32
        )
    })
}

/// The mesh that the shape `node` of the kind `ply`, `obj` or `serialized` names, in the scene's coordinates:
/// `here_from_mesh` moves it there when it counts from `zero`. It has texture coordinates in any case, if it
/// `wants_uvs`. None if the file is missing.
pub(super) fn read(
    context: &Context,
    node: Node,
    (here_from_mesh, zero): (&DAffine3, DVec3),
    wants_uvs: bool,
) -> Result<Option<Mesh>, String> {
    let scope = context.scope;
    let path = node.file(scope, "filename")?;
    let file = node.text("filename")?.unwrap_or_default();
    let Some(path) = path else {
        context.warn(node.fail(format!("the mesh \"{file}\" is missing; its shape was left out")));
        node.pass_all();
        return Ok(None);
    };
    let within = |problem: String| node.fail(format!("\"{file}\" {problem}"));
    let bytes = scope.read(&path).map_err(within)?;
    let mut is_flat = node.flag("face_normals", false)?;
    // Mitsuba counts v from the top of a picture, as we do; OBJ counts from the bottom.
    let flips = node.flag("flip_tex_coords", node.kind() == "obj")?;
    let (mut mesh, is_single) = match node.kind() {
        // Text may have more digits.
        "obj" => wavefront::mesh(context, &bytes, (file, zero), flips).map(|mesh| (mesh, false)),
        "serialized" => {
            let read = serialized::mesh(scope, &bytes, node.number("shape_index", 0.0)?, zero);
            read.map(|stated| {
                is_flat |= stated.is_flat;
                (stated.mesh, stated.is_single)
            })
        }
        _ => ply::mesh(scope, &bytes, zero),
    }
    .map_err(within)?;
    if let Some(coarse) = coarse(&mesh, (here_from_mesh, zero)).filter(|_| is_single) {
        context.warn(within(coarse));
    }
    if mesh.triangles.is_empty() {
        return Err(within("has no faces".into()));
    }
    if flips && node.kind() != "obj" {
        mesh.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(uv.x, 1.0 - uv.y));
    }
    if is_flat {
        mesh.normals.clear();
    }
    let mut mesh = shapes::placed(mesh, here_from_mesh);
    if is_flat || (wants_uvs && mesh.uvs.is_empty()) {
        scope.charge(mesh.triangles.len() as u64 * 3 * CORNER_BYTES).map_err(within)?;
    }
    mesh = if is_flat {
        Mesh::flat(&mesh.positions, &mesh.uvs, &mesh.triangles)
    } else {
        shapes::smooth(mesh)
    };
    if wants_uvs && mesh.uvs.is_empty() {
        mesh = shapes::with_own_uvs(&mesh);
    }
    Ok(Some(shapes::facing_outwards(mesh)))
}
