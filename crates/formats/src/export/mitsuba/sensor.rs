//! The camera and its film.

use super::{comment, float, to_world};
use crate::export::SceneView;
use crate::near;
use glam::{Affine3A, Mat3};
use unrender_scene::Warnings;

/// The perspective sensor. Mitsuba's looks along its own +z, with +x to the left.
pub(super) fn text(shot: &SceneView, warnings: &mut Warnings) -> String {
    let camera = shot.camera;
    let (width, height) = shot.size;
    if camera.lens.distorts() {
        warnings.push(format!(
            "camera \"{}\": Mitsuba's perspective knows no distortion; the picture is that of the \
             pinhole",
            camera.name
        ));
    }
    if camera.lens.fx_over_fy != 1.0 {
        warnings.push(format!(
            "camera \"{}\": Mitsuba's pixels are square; the picture is not stretched by {}",
            camera.name, camera.lens.fx_over_fy
        ));
    }
    let axes = Mat3::from(camera.world_from_camera.matrix3);
    let axes = Mat3::from_cols(-axes.x_axis, axes.y_axis, -axes.z_axis);
    let place = Affine3A::from_mat3_translation(axes, camera.origin());
    let [right, down] = camera.lens.principal_point;
    let numbers = [
        float("fov", camera.fov_y_rad.to_degrees()),
        float("principal_point_offset_x", -right * height as f32 / width as f32),
        float("principal_point_offset_y", -down),
        float("near_clip", near::written(shot.scene, camera)),
        float("far_clip", 1e5),
    ]
    .join("\n        ");
    format!(
        "    {}\n    <sensor type=\"perspective\">\n\
         \x20       <string name=\"fov_axis\" value=\"y\"/>\n        {numbers}\n        {}\n\
         \x20       <film type=\"hdrfilm\">\n\
         \x20           <integer name=\"width\" value=\"{width}\"/>\n\
         \x20           <integer name=\"height\" value=\"{height}\"/>\n\
         \x20           <string name=\"pixel_format\" value=\"rgb\"/>\n\
         \x20           <string name=\"component_format\" value=\"float32\"/>\n\
         \x20           <rfilter type=\"box\"/>\n\
         \x20       </film>\n\
         \x20       <sampler type=\"independent\"><integer name=\"sample_count\" value=\"256\"/></sampler>\n\
         \x20   </sensor>\n",
        comment("camera", &camera.name),
        to_world(place, shot.scene.origin)
    )
}
