//! Meshes and cameras of USD. [OpenUSD, UsdGeom]

use super::stage::{Prim, Value};
use crate::near;
use glam::{DMat4, Mat4, Vec2, Vec3};
use unrender_scene::{Camera, Mesh, Scene, Warnings};

/// The height of a film, in the tenths of a scene's unit that USD measures films in: 24 mm. Only ratios to it show in a
/// picture; half or double of it would make the focal lengths that users read half or double as long.
const FILM: f64 = 0.24;
/// The depth of the far clipping plane, metres. Half of it would cut away parts of landscapes; double of it makes depth buffers
/// coarser.
const FAR: f32 = 1e5;

/// The prim called `id` of `mesh`, whose texture coordinates count v from the bottom and whose material is at the path
/// `material`.
pub(super) fn mesh(id: &str, mesh: &Mesh, material: String) -> Prim {
    let mut prim = Prim::new("Mesh", id).with_schema("MaterialBindingAPI");
    let corners = mesh.triangles.iter().flatten().map(|index| *index as i32).collect();
    prim.set_uniform("bool", "doubleSided", Value::Bool(true));
    prim.set("float3[]", "extent", Value::Float3s(extent(&mesh.positions)));
    prim.set("int[]", "faceVertexCounts", Value::Ints(vec![3; mesh.triangles.len()]));
    prim.set("int[]", "faceVertexIndices", Value::Ints(corners));
    prim.relate("material:binding", material);
    prim.set_by_vertex("normal3f[]", "normals", Value::Float3s(mesh.normals.clone()));
    prim.set("point3f[]", "points", Value::Float3s(mesh.positions.clone()));
    if !mesh.uvs.is_empty() {
        prim.set_by_vertex("texCoord2f[]", "primvars:st", Value::Float2s(mesh.uvs.clone()));
    }
    prim.set_uniform("token", "subdivisionScheme", Value::token("none"));
    prim
}

/// The lowest and the highest corner of the box around `points`.
fn extent(points: &[Vec3]) -> Vec<Vec3> {
    let corners = points.iter().map(|p| [*p, *p]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    corners.map_or_else(Vec::new, Vec::from)
}

/// The prim called `id` of `camera`, whose pictures are `aspect` times as wide as high.
pub(super) fn camera(id: &str, scene: &Scene, camera: &Camera, aspect: f64) -> Prim {
    let mut prim = Prim::new("Camera", id).named(&camera.name);
    let lens = &camera.lens;
    let film = |length: f64| Value::Float(length as f32);
    let [right, down] = lens.principal_point.map(f64::from);
    let near = near::written(scene, camera);
    prim.set("float2", "clippingRange", Value::Float2(Vec2::new(near, FAR)));
    let focal_length = 0.5 * FILM / (0.5 * f64::from(camera.fov_y_rad)).tan();
    prim.set("float", "focalLength", film(focal_length));
    prim.set("float", "horizontalAperture", film(FILM * aspect / f64::from(lens.fx_over_fy)));
    // Where the axis is right of the middle, the film lies left of the axis.
    let stretch = f64::from(lens.fx_over_fy);
    prim.set("float", "horizontalApertureOffset", film(-right * FILM / stretch));
    prim.set("float", "verticalAperture", film(FILM));
    prim.set("float", "verticalApertureOffset", film(down * FILM));
    prim.set("token", "projection", Value::token("perspective"));
    prim.place(Mat4::from(camera.world_from_camera).as_dmat4());
    prim
}

/// Warns of what USD's cameras lack.
pub(super) fn warn_of_lens(camera: &Camera, warnings: &mut Warnings) {
    if camera.lens.distorts() {
        warnings.push(format!(
            "camera \"{}\": USD's camera knows no distortion; the picture is that of the pinhole",
            camera.name
        ));
    }
}

/// The transform that moves the scene's origin to its place in the world; none if it is there.
pub(super) fn root(scene: &Scene) -> Option<DMat4> {
    (scene.origin != glam::DVec3::ZERO).then(|| DMat4::from_translation(scene.origin))
}
