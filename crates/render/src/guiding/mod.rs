//! Where a diffuse surface should look for the light that a shiny plane throws at it.
//!
//! A floor with a gloss throws a patch of light at the wall. Directions drawn by the cosine find the
//! few square metres of floor where lamp and wall see each other in it once in a hundred times, and
//! then it is bright: most of the noise of a picture, and of all that is fitted to it. For a plane
//! the place is known: it lies towards the lamp's mirror image. A share of the directions of a
//! diffuse surface is drawn about that, by a spherical Gaussian as wide as the gloss and the lamp
//! make the patch. It is one more strategy in the mixture that directions are drawn from, so it
//! biases nothing.
//!
//! The directions that are left to the cosine weigh more, at surface after surface; so the share is
//! small, and only the first surfaces of a path look for images. Every pair of a plane and a lamp is
//! asked at each of them; so only the strongest pairs are.
//!
//! Width: with the half vector tilted by `epsilon (1 + a/b) / 2` when the direction is off by
//! `epsilon` (`a` from here to the plane, `b` on to the lamp) and Ward's slopes of the deviation
//! `alpha/sqrt 2`, the patch has the deviation `sqrt 2 alpha / (1 + a/b)`, and the lamp's own.

mod images;

pub use images::Images;
pub(crate) use images::Images4;

use crate::emitters;
use crate::surface::{Frame, Surface};
use crate::tracer::Appearance;
use glam::Vec3;
use std::f32::consts::{PI, SQRT_2};
use unrender_scene::color::luminance;
use unrender_scene::{LightKind, Mesh, Rgb, Scene};

/// The share of the directions that is drawn towards mirror images at a path's first diffuse
/// surface, the second and so on; those after look for none. The other directions weigh
/// `1/(1 - share)` as much, at every surface of a path anew: large shares make rare bright paths.
const SHARES: [f32; 4] = [0.2, 0.2, 0.1, 0.1];
/// Only the first so many surfaces of a path look for images.
pub(crate) const BOUNCES: u32 = SHARES.len() as u32;
/// Pairs of a plane and a lamp that a picture looks for at most: the strongest.
const PAIRS_MAX: usize = 16;
/// Patches narrower than this (radians) are left to chance, as are those of a mirror and a point.
const DEVIATION_MIN: f32 = 2e-3;
/// Wider ones are found by the cosine well enough.
const DEVIATION_MAX: f32 = 0.5;
/// A patch reaches this many deviations beyond its centre.
const REACH: f32 = 3.0;
/// Vectors whose angle has at least this cosine are taken for parallel.
const PARALLEL: f32 = 0.9999;

/// The planes and lamps of a scene.
#[derive(Debug, Default)]
pub(crate) struct Caustics {
    planes: Vec<Plane>,
    lamps: Vec<Lamp>,
}

/// A flat object.
#[derive(Clone, Copy, Debug)]
struct Plane {
    object: u32,
    group: u32,
    point: Vec3,
    normal: Vec3,
    bounds: [Vec3; 2],
    area: f32,
}

/// An area light as a ball, or a light at a point. Directional lights are not among them.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    source: u32,
    centre: Vec3,
    radius: f32,
    power: f32,
    /// The axis of the cone that it shines into, and the cosine of the cone's half angle.
    cone: (Vec3, f32),
}

/// A plane that shines under one appearance, and a lamp that it may throw about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shiny {
    plane: Plane,
    alpha: f32,
    lamp: Lamp,
}

impl Caustics {
    pub(crate) fn new(scene: &Scene) -> Self {
        let planes = scene.objects.iter().zip(0..).filter_map(|(object, index)| {
            let mut plane = Plane::of(&object.mesh)?;
            (plane.object, plane.group) = (index, object.group as u32);
            Some(plane)
        });
        let emitting = scene.objects.iter().filter(|o| scene.groups[o.group].is_emitter());
        let area = emitting.map(|object| {
            let emission = scene.groups[object.group].emission;
            Lamp::of_area(&object.mesh, emission, object.group as u32)
        });
        let sources = scene.groups.len() as u32..;
        let points = scene.lights.iter().zip(sources);
        let points = points.filter_map(|(light, source)| Lamp::at_point(&light.kind, source));
        Self { planes: planes.collect(), lamps: area.chain(points).collect() }
    }

    /// What shines under `appearance`: the strongest pairs of a plane and a lamp, by the power of
    /// the lamp, and the plane's area and reflectance.
    pub(crate) fn shiny(&self, appearance: &Appearance<'_>) -> Vec<Shiny> {
        let shines = |plane: &Plane| {
            let material = appearance.materials.get(plane.group as usize)?;
            let alpha = (material.alpha_x * material.alpha_y).sqrt();
            Some((plane.area * luminance(material.rho_s), (*plane, alpha)))
        };
        let planes = strongest(self.planes.iter().filter_map(shines));
        if planes.is_empty() {
            return Vec::new();
        }
        let brightness = |lamp: &Lamp| lamp.power * luminance(appearance.light(lamp.source));
        let lamps = strongest(self.lamps.iter().map(|lamp| (brightness(lamp), *lamp)));
        let pairs = planes.iter().flat_map(|&(reflectance, (plane, alpha))| {
            let pair = move |&(power, lamp): &(f32, Lamp)| {
                (reflectance * power, Shiny { plane, alpha, lamp })
            };
            lamps.iter().map(pair).filter(|(_, pair)| pair.lamp.lights(&pair.plane))
        });
        strongest(pairs).into_iter().map(|(_, pair)| pair).collect()
    }
}

/// Those of a positive strength, the strongest first, and not too many.
fn strongest<T>(items: impl Iterator<Item = (f32, T)>) -> Vec<(f32, T)> {
    let mut items: Vec<_> = items.filter(|(strength, _)| *strength > 0.0).collect();
    items.sort_by(|a, b| b.0.total_cmp(&a.0));
    items.truncate(PAIRS_MAX);
    items
}

impl Plane {
    /// The plane of a mesh that is flat, and shaded so.
    fn of(mesh: &Mesh) -> Option<Self> {
        let cross = |i: usize| {
            let [a, b, c] = mesh.corners(i);
            (b - a).cross(c - a)
        };
        let all = 0..mesh.triangles.len();
        let largest =
            all.clone().max_by(|&i, &j| cross(i).length().total_cmp(&cross(j).length()))?;
        let (size, normal) = (cross(largest).length(), cross(largest).try_normalize()?);
        // Triangles without an area have no normal, and no ray meets them.
        let flat = |i: usize| {
            let (cross, length) = (cross(i), cross(i).length());
            let along = |n: Vec3| n.dot(normal).abs() >= PARALLEL;
            let smooth = || mesh.triangles[i].iter().all(|&v| along(mesh.normals[v as usize]));
            length <= 1e-6 * size || (along(cross / length) && smooth())
        };
        let corners = || all.clone().flat_map(|i| mesh.corners(i));
        let bounds = bounds(corners());
        let point = mesh.corners(largest)[0];
        let thickness = 1e-4 * (bounds[1] - bounds[0]).length();
        let thin = |p: Vec3| (p - point).dot(normal).abs() <= thickness;
        let area = all.clone().map(|i| 0.5 * cross(i).length()).sum();
        let plane = Self { object: 0, group: 0, point, normal, bounds, area };
        (all.clone().all(flat) && corners().all(thin)).then_some(plane)
    }
}

impl Lamp {
    /// A group's mesh that emits `radiance`.
    fn of_area(mesh: &Mesh, radiance: Rgb, source: u32) -> Self {
        let (mut facing, mut area) = (Vec3::ZERO, 0.0);
        for [a, b, c] in (0..mesh.triangles.len()).map(|i| mesh.corners(i)) {
            let half = 0.5 * (b - a).cross(c - a);
            facing += half;
            area += half.length();
        }
        // A flat lamp shines to its front, others may shine everywhere.
        let flat = facing.length() >= PARALLEL * area;
        let cone = if flat { (facing.normalize_or_zero(), 0.0) } else { (Vec3::ZERO, 0.0) };
        let [low, high] =
            bounds(mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]));
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        Self { source, centre, radius, power: PI * area * luminance(radiance), cone }
    }

    /// A light without a surface that stands somewhere.
    fn at_point(kind: &LightKind, source: u32) -> Option<Self> {
        let (centre, cone) = match *kind {
            LightKind::Point { position, .. } => (position, (Vec3::ZERO, 0.0)),
            LightKind::Spot { position, direction, outer_rad, .. } => {
                (position, (direction, outer_rad.cos()))
            }
            LightKind::Directional { .. } => return None,
        };
        Some(Self { source, centre, radius: 0.0, power: emitters::power(kind, 0.0), cone })
    }

    /// Whether it shines towards `point`, by its centre.
    fn shines_at(&self, point: Vec3) -> bool {
        let (axis, cos) = self.cone;
        let to_point = point - self.centre;
        to_point.dot(axis) >= cos * to_point.length()
    }

    /// Whether it stands before or behind `plane` and can shine at its box.
    fn lights(&self, plane: &Plane) -> bool {
        let height = (self.centre - plane.point).dot(plane.normal);
        let [low, high] = plane.bounds;
        let far = self.centre.distance(low).max(self.centre.distance(high));
        // The corner of the box that is furthest along the axis of the cone.
        let axis = self.cone.0;
        let corner = Vec3::select(axis.cmpge(Vec3::ZERO), high, low);
        let before = (corner - self.centre).dot(axis) >= 0.0;
        height.abs() > 1e-4 * far && before
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.fold(nothing, |[low, high], p| [low.min(p), high.max(p)])
}

impl Shiny {
    /// The direction to the lamp's mirror image in the plane and the deviation of the patch about
    /// it, radians; none if no light can come to `surface` that way.
    fn image(&self, surface: &Surface) -> Option<(Vec3, f32)> {
        let Plane { object, point, normal, bounds, .. } = self.plane;
        let here = (surface.point - point).dot(normal);
        let there = (self.lamp.centre - point).dot(normal);
        // Both on one side, and neither in the plane.
        if surface.object == object || here * there <= 0.0 || here.abs() < 1e-4 * there.abs() {
            return None;
        }
        let to_image = self.lamp.centre - 2.0 * there * normal - surface.point;
        let distance = to_image.length();
        let direction = to_image / distance;
        if !surface.is_above(direction) {
            return None;
        }
        let share = here / (here + there);
        let of_gloss = SQRT_2 * self.alpha * (1.0 - share);
        let of_lamp = 0.5 * self.lamp.radius / distance;
        let deviation = of_gloss.hypot(of_lamp);
        if !(DEVIATION_MIN..DEVIATION_MAX).contains(&deviation) {
            return None;
        }
        let met = surface.point + share * to_image;
        let outside = met - met.clamp(bounds[0], bounds[1]);
        let reach = REACH * deviation * share * distance;
        let useful = outside.length() <= reach && self.lamp.shines_at(met);
        useful.then_some((direction, deviation))
    }
}

impl Images {
    /// The mirror images that light may reach `surface` from, in `frame`; it is the surface of the
    /// reflection number `bounce`, less than [`BOUNCES`].
    pub(crate) fn seen_from(
        surface: &Surface,
        frame: &Frame,
        shiny: &[Shiny],
        bounce: u32,
    ) -> Self {
        let mut images = Self::with_share(SHARES[bounce as usize]);
        for (direction, deviation) in shiny.iter().filter_map(|pair| pair.image(surface)) {
            if !images.push(frame.local_from_world(direction), deviation) {
                break;
            }
        }
        images
    }
}

#[cfg(test)]
mod tests;
