//! Finding upward-facing surfaces to place models on.

use crate::stage::some_names;
use glam::Vec3;
use unrender_render::accel::Ray;
use unrender_render::path::Transport;
use unrender_render::{Tracer, surface::Surface};
use unrender_scene::{Scene, UpAxis};

/// Surfaces whose unit normal has at least this component upwards face upwards: slopes up to 60 degrees.
/// At 0.25 steep roofs count as ground, at 1 nothing but level floors.
const LEVEL: f32 = 0.5;

/// The highest upward-facing point of `group` at two horizontal coordinates.
pub(crate) fn highest(scene: &Scene, group: &str, at: [f64; 2]) -> Result<Vec3, String> {
    let index = scene.group_index(group).ok_or_else(|| {
        let there = some_names(group, scene.groups.iter().map(|g| g.name.as_str()));
        format!("the scene has no group \"{group}\" to stand on; it has {there}")
    })?;
    let up = scene.up;
    let [low, high] = scene.bounds().ok_or("the scene has no triangles to stand on")?;
    let tracer = Tracer::new(scene);
    let ground = scene.here(up.place(at, 0.0));
    // From above all of it, at any scale.
    let above = up.height(high) + low.distance(high) - up.height(ground);
    let mut ray = Ray::new(ground + above * up.unit(), -up.unit());
    while let Some(surface) = tracer.surface(&ray) {
        if surface.group as usize == index && is_level(&surface, up) {
            return Ok(surface.point);
        }
        ray = beyond(&surface, up);
    }
    let ([a, b], [first, second]) = (at, up.horizontal());
    Err(format!("no surface of \"{group}\" faces upwards at {first} = {a}, {second} = {b}"))
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
    if !is_level(&surface, scene.up) {
        return Err(format!(
            "that pixel shows a surface of \"{shown}\" that does not face upwards; name another \
             pixel or a position"
        ));
    }
    Ok(surface.point)
}

/// Whether the visible side of the surface faces upwards.
fn is_level(surface: &Surface, up: UpAxis) -> bool {
    up.height(surface.geometric_normal) > LEVEL
}

/// The ray straight down from the other side of `surface`.
fn beyond(surface: &Surface, up: UpAxis) -> Ray {
    let below = Surface { geometric_normal: -surface.geometric_normal, ..*surface };
    Transport::leave(&below, -up.unit())
}
