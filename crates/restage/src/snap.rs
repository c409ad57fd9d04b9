//! Finding upward-facing surfaces to place models on.

use crate::stage::some_names;
use glam::{DVec3, Vec3};
use unrender_render::accel::Ray;
use unrender_render::path::Transport;
use unrender_render::{Tracer, surface::Surface};
use unrender_scene::Scene;

/// Surfaces whose unit normal has at least this y component face upwards: slopes up to 60 degrees.
/// At 0.25 steep roofs count as ground, at 1 nothing but level floors.
const LEVEL: f32 = 0.5;

/// The highest upward-facing point of `group` at `x` and `z`.
pub(crate) fn highest(scene: &Scene, group: &str, x: f64, z: f64) -> Result<Vec3, String> {
    let index = scene.group_index(group).ok_or_else(|| {
        let there = some_names(scene.groups.iter().map(|g| g.name.as_str()));
        format!("the scene has no group \"{group}\" to stand on; it has {there}")
    })?;
    let positions = scene.objects.iter().flat_map(|o| &o.mesh.positions);
    let top = positions.fold(f32::NEG_INFINITY, |top, p| top.max(p.y));
    let tracer = Tracer::new(scene);
    let mut ray = Ray::new(scene.here(DVec3::new(x, 0.0, z)).with_y(top + 1.0), Vec3::NEG_Y);
    while let Some(surface) = tracer.surface(&ray) {
        if surface.group as usize == index && is_level(&surface) {
            return Ok(surface.point);
        }
        ray = beyond(&surface);
    }
    Err(format!("no surface of \"{group}\" faces upwards at x = {x}, z = {z}"))
}

/// The first hit of a ray, which must be on `group` if that is stated, and face upwards.
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

/// Whether the visible side of the surface faces upwards.
fn is_level(surface: &Surface) -> bool {
    surface.geometric_normal.y > LEVEL
}

/// The ray straight down from the other side of `surface`.
fn beyond(surface: &Surface) -> Ray {
    let below = Surface { geometric_normal: -surface.geometric_normal, ..*surface };
    Transport::leave(&below, Vec3::NEG_Y)
}
