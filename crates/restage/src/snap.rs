//! Where things are put down: onto a surface that faces upwards.

use crate::edit::some_names;
use glam::Vec3;
use unrender_render::accel::Ray;
use unrender_render::path::Transport;
use unrender_render::{Tracer, surface::Surface};
use unrender_scene::Scene;

/// Surfaces whose normal has at least this share upwards can be stood on.
const LEVEL: f32 = 0.5;

/// The highest point of `group` at `x` and `z` that can be stood on.
pub(crate) fn highest(scene: &Scene, group: &str, x: f32, z: f32) -> Result<Vec3, String> {
    let index = scene.group_index(group).ok_or_else(|| {
        let there = some_names(scene.groups.iter().map(|g| g.name.as_str()));
        format!("the scene has no group \"{group}\" to stand on; it has {there}")
    })?;
    let positions = scene.objects.iter().flat_map(|o| &o.mesh.positions);
    let top = positions.fold(f32::NEG_INFINITY, |top, p| top.max(p.y));
    let tracer = Tracer::new(scene);
    let mut ray = Ray::new(Vec3::new(x, top + 1.0, z), Vec3::NEG_Y);
    while let Some(surface) = tracer.surface(&ray) {
        if surface.group as usize == index && is_level(&surface) {
            return Ok(surface.point);
        }
        ray = beyond(&surface);
    }
    Err(format!("nothing of \"{group}\" can be stood on at x = {x}, z = {z}"))
}

/// The first point of the scene along a ray, which must be of `group` if that is stated.
pub(crate) fn seen(
    scene: &Scene,
    origin: Vec3,
    direction: Vec3,
    group: Option<&str>,
) -> Result<Vec3, String> {
    let tracer = Tracer::new(scene);
    let surface = tracer.surface(&Ray::new(origin, direction)).ok_or("that pixel shows nothing")?;
    let shown = &scene.groups[surface.group as usize].name;
    if let Some(group) = group.filter(|g| g != shown) {
        return Err(format!("that pixel shows \"{shown}\", not \"{group}\""));
    }
    if !is_level(&surface) {
        return Err(format!(
            "that pixel shows a surface of \"{shown}\" that does not face upwards; name another \
             pixel or a position"
        ));
    }
    Ok(surface.point)
}

/// Whether the side of the surface that is seen faces upwards.
fn is_level(surface: &Surface) -> bool {
    surface.geometric_normal.y > LEVEL
}

/// The ray straight down on the other side of `surface`.
fn beyond(surface: &Surface) -> Ray {
    let below = Surface { geometric_normal: -surface.geometric_normal, ..*surface };
    Transport::leave(&below, Vec3::NEG_Y)
}
