//! Cameras: `perspective` and `thinlens`, with the film that they have.

use super::paint::Context;
use super::tree::Node;
use glam::{Affine3A, Mat3};
use unrender_scene::{Camera, Lens};

/// The part of a film that is rendered, in pixels.
struct Film {
    size: [f32; 2],
    crop_size: [f32; 2],
    crop_offset: [f32; 2],
}

impl Film {
    fn read(sensor: Node) -> Result<Self, String> {
        let Some(film) = sensor.child("film")? else {
            return Ok(Self {
                size: [768.0, 576.0],
                crop_size: [768.0, 576.0],
                crop_offset: [0.0; 2],
            });
        };
        let size = [film.positive("width", 768.0)?, film.positive("height", 576.0)?];
        let crop_size =
            [film.positive("crop_width", size[0])?, film.positive("crop_height", size[1])?];
        let crop_offset = [film.number("crop_offset_x", 0.0)?, film.number("crop_offset_y", 0.0)?];
        let fits = |i: usize| crop_offset[i] >= 0.0 && crop_offset[i] + crop_size[i] <= size[i];
        if fits(0) && fits(1) {
            return Ok(Self { size, crop_size, crop_offset });
        }
        Err(film.fail("the crop of a film reaches beyond the film"))
    }
}

/// The camera `node`; none if it is not a pinhole.
pub(super) fn read(context: &Context, node: Node) -> Result<Option<Camera>, String> {
    match node.kind() {
        "perspective" => {}
        "thinlens" => {
            if node.number("aperture_radius", 0.0)? > 0.0 {
                context.warn(
                    node.fail("the aperture of a thinlens was left out: everything is sharp"),
                );
            }
        }
        kind => {
            context.warn(node.fail(format!(
                "a sensor of type \"{kind}\" was left out; supported are perspective and thinlens"
            )));
            return Ok(None);
        }
    }
    let Film { size, crop_size, crop_offset } = Film::read(node)?;
    let half_height = half_height(node, size[0] / size[1])?;
    let world = node.motion("to_world")?;
    let axes = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis];
    let [left, up, ahead] = axes.map(|axis| axis.normalize_or_zero().as_vec3());
    let axes = Mat3::from_cols(-left, up, -ahead);
    if axes.determinant().abs() < 1e-3 {
        return Err(node.wrong("to_world", "a motion: it makes the camera flat"));
    }
    // From the middle of what is rendered to the principal point, in pixels.
    let off = |i: usize, name: &str| -> Result<f32, String> {
        let offset = node.number(name, 0.0)?;
        let middle = crop_offset[i] + 0.5 * crop_size[i];
        Ok(0.5 * size[i] - offset * size[i] - middle)
    };
    let off = [off(0, "principal_point_offset_x")?, off(1, "principal_point_offset_y")?];
    let eye = (world.translation - context.scope.origin()).as_vec3();
    let id = if node.id().is_empty() { "camera" } else { node.id() };
    Ok(Some(Camera {
        name: node.note().name.clone().unwrap_or_else(|| id.into()),
        world_from_camera: Affine3A::from_mat3_translation(axes, eye),
        fov_y_rad: 2.0 * (half_height * crop_size[1] / size[1]).atan(),
        aspect: Some(crop_size[0] / crop_size[1]),
        size: Some(crop_size.map(|side| side.round() as u32)),
        lens: Lens { principal_point: off.map(|pixels| pixels / crop_size[1]), ..Lens::default() },
        near: node.number("near_clip", 1e-2)?,
    }))
}

/// Half of the height of the whole film at the distance one, for its width over its height.
fn half_height(node: Node, aspect: f32) -> Result<f32, String> {
    let diagonal = (1.0 + aspect * aspect).sqrt();
    if !node.has("fov") {
        let text = node.text("focal_length")?.unwrap_or("50mm");
        let focal: Option<f32> = text.trim().trim_end_matches("mm").trim().parse().ok();
        let focal = focal.filter(|mm| *mm > 0.0 && mm.is_finite());
        let focal = focal.ok_or_else(|| node.wrong("focal_length", "a length such as 50mm"))?;
        // The diagonal of the film is that of 24 mm x 36 mm.
        return Ok(0.5 * 36f32.hypot(24.0) / focal / diagonal);
    }
    if node.has("focal_length") {
        return Err(node.fail("there is a fov beside a focal_length; leave one of them out"));
    }
    let fov = node.number("fov", 45.0)?;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(node.wrong("fov", "between 0 and 180 degrees"));
    }
    let half = (0.5 * fov.to_radians()).tan();
    match node.text("fov_axis")?.unwrap_or("x").to_ascii_lowercase().as_str() {
        "x" => Ok(half / aspect),
        "y" => Ok(half),
        "smaller" => Ok(half / aspect.min(1.0)),
        "larger" => Ok(half / aspect.max(1.0)),
        "diagonal" => Ok(half / diagonal),
        _ => Err(node.wrong("fov_axis", "\"x\", \"y\", \"diagonal\", \"smaller\" or \"larger\"")),
    }
}
