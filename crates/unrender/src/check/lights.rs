//! Lights in the wrong place: inside walls and shades, behind them, or turned to them.
//!
//! Straight lines are tested from each light to points of the picture. If a light reaches none, or
//! shines right onto something, rays around it find what is in its way.

use super::finding::{Findings, Gravity};
use super::{Subject, length, surface_behind};
use glam::Vec3;
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use unrender_render::accel::{Ray, clearance};
use unrender_render::surface::{Frame, Surface};
use unrender_render::{NOTHING, Tracer};
use unrender_scene::{Light, LightKind, Mesh, Object};

/// Points of the picture to which lines are tested.
const POINTS: usize = 400;
/// Points on an area light, for each of those.
const FROM: usize = 4;
/// Rays that look around a light.
const AROUND: usize = 256;
/// A surface nearer to a light than this share of the scene is right beside it.
const BESIDE: f32 = 1e-3;
/// A surface nearer to an area light than this share of the light's size is right before it ...
const BEFORE: f32 = 0.05;
/// ... if it stops this share of the light.
const MOST: f32 = 0.9;
/// The golden ratio, without whole turns.
const GOLDEN: f32 = 0.618_034;

/// Warnings of the lights.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let scene = &subject.job.scene;
    let seen = seen_points(subject);
    if seen.is_empty() {
        return found;
    }
    for (index, object) in scene.objects.iter().enumerate() {
        if scene.groups[object.group].is_emitter() && !object.mesh.triangles.is_empty() {
            found.extend(area_light(subject, (index as u32, object), &seen));
        }
    }
    for light in &scene.lights {
        found.extend(small_light(subject, light, &seen));
    }
    found
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) point: Vec3,
    /// Unit normal on the side that is looked at: the viewer's, or the front.
    pub(super) normal: Vec3,
    /// How far off the surface rays start, metres: what is nearer is one with it to them.
    pub(super) clearance: f32,
}

impl SurfacePoint {
    /// Where rays that leave it start.
    pub(super) fn start(&self) -> Vec3 {
        self.point + self.clearance * self.normal
    }
}

impl From<Surface> for SurfacePoint {
    fn from(surface: Surface) -> Self {
        let Surface { point, geometric_normal: normal, clearance, .. } = surface;
        Self { point, normal, clearance }
    }
}

pub(super) fn seen_points(subject: &Subject<'_>) -> Vec<SurfacePoint> {
    let (geometry, camera) = (subject.geometry, &subject.registered.camera);
    let (width, height) = (geometry.width(), geometry.height());
    let is_seen = |i: &u32| geometry.pixels()[*i as usize].object != NOTHING;
    let pixels: Vec<u32> = (0..(width * height) as u32).filter(is_seen).collect();
    let point = |pixel: u32| surface_behind(subject.tracer, camera, (width, height), pixel);
    let sample = unrender_recover::observe::blocks::spread(&pixels, POINTS, 0);
    sample.into_iter().filter_map(point).map(SurfacePoint::from).collect()
}

/// Whether nothing stands between two points.
pub(super) fn is_free(tracer: &Tracer, from: Vec3, to: Vec3) -> bool {
    let distance = from.distance(to);
    let ray =
        Ray { origin: from, direction: (to - from) / distance, t_max: distance * (1.0 - 1e-4) };
    distance > 0.0 && tracer.surface(&ray).is_none()
}

fn area_light(
    subject: &Subject<'_>,
    (index, lamp): (u32, &Object),
    seen: &[SurfacePoint],
) -> Findings {
    let mut found = Findings::default();
    let tracer = subject.tracer;
    let points = spread_over(&lamp.mesh, AROUND);
    let reaches = |i: usize, to: &SurfacePoint| {
        (0..FROM).any(|k| {
            let from = points[(i * FROM + k) % points.len()];
            let way = to.point - from.point;
            way.dot(from.normal) > 0.0
                && way.dot(to.normal) < 0.0
                && is_free(tracer, from.start(), to.start())
        })
    };
    let lights = seen.iter().enumerate().filter(|(i, seen)| reaches(*i, seen)).count();
    let size = area(&lamp.mesh).sqrt();
    let (stopped, by) = stopped(tracer, &points, BEFORE * size);
    let name = &lamp.name;
    if stopped > MOST && by != Some(index) {
        found.push(Gravity::All, format!(
            "area light \"{name}\" shines right onto {}, less than {} before it: move it away, or \
             flip its faces if it is meant to shine the other way",
            by.map_or("something".to_owned(), |by| format!(
                "object \"{}\"",
                subject.object_name(by)
            )),
            length(BEFORE * size)
        ));
    } else if lights == 0 && is_turned_inwards(tracer, &points, index) {
        found.push(Gravity::All, format!(
            "area light \"{name}\" shines into itself: flip its faces, so that the normals point \
             outwards"
        ));
    } else if lights == 0 {
        found.push(Gravity::Part, out_of_sight("area light", name));
    }
    found
}

fn out_of_sight(kind: &str, name: &str) -> String {
    format!(
        "no light comes straight from {kind} \"{name}\" to anything that the picture shows: does it \
         stand outside, behind a wall, inside a shade that lets nothing through, or turned away? \
         If it is meant to light the scene indirectly, all is well"
    )
}

/// Points spread evenly over `mesh`, with the normals of the fronts.
pub(super) fn spread_over(mesh: &Mesh, count: usize) -> Vec<SurfacePoint> {
    let areas: Vec<f32> = (0..mesh.triangles.len()).map(|t| normal(mesh, t).length()).collect();
    let total: f32 = areas.iter().sum();
    let (mut triangle, mut before) = (0, 0.0);
    let at = |i: usize| {
        let place = (i as f32 + 0.5) / count as f32 * total;
        while triangle + 1 < areas.len() && before + areas[triangle] < place {
            before += areas[triangle];
            triangle += 1;
        }
        // Along the plastic number's lattice [Roberts 2018], starting at a half, so that no point is a
        // corner, which belongs to other faces, too.
        let step = i as f32 + 0.5;
        let (u, v) = ((0.754_877_7 * step).fract(), (0.569_840_3 * step).fract());
        let root = u.sqrt();
        let [a, b, c] = mesh.corners(triangle);
        let point = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
        let normal = normal(mesh, triangle).normalize_or_zero();
        SurfacePoint { point, normal, clearance: clearance([a, b, c]) }
    };
    (0..count).map(at).collect()
}

/// The front's normal, twice the triangle's area long.
fn normal(mesh: &Mesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a)
}

pub(super) fn area(mesh: &Mesh) -> f32 {
    (0..mesh.triangles.len()).map(|t| 0.5 * normal(mesh, t).length()).sum()
}

/// The first surface along a ray from each of `points`, in cosine-distributed directions about its
/// normal.
fn first_met(tracer: &Tracer, points: &[SurfacePoint]) -> Vec<Option<(f32, u32)>> {
    let met = |(i, from): (usize, &SurfacePoint)| {
        let (radius, angle) = ((GOLDEN * i as f32).fract().sqrt(), 0.414_213_6 * i as f32 * TAU);
        let (sin, cos) = angle.sin_cos();
        let local = Vec3::new(radius * cos, radius * sin, (1.0 - radius * radius).max(0.0).sqrt());
        let frame = Frame::new(from.normal, from.normal.any_orthonormal_vector(), true);
        let origin = from.start();
        let surface = tracer.surface(&Ray::new(origin, frame.world_from_local(local)))?;
        Some((surface.point.distance(origin), surface.object))
    };
    points.iter().enumerate().map(met).collect()
}

/// The share of an area light's rays that are stopped within `distance`, and the object that stops
/// most of them.
fn stopped(tracer: &Tracer, points: &[SurfacePoint], distance: f32) -> (f32, Option<u32>) {
    let mut by: BTreeMap<u32, usize> = BTreeMap::new();
    for (_, object) in first_met(tracer, points).into_iter().flatten().filter(|m| m.0 < distance) {
        *by.entry(object).or_default() += 1;
    }
    let share = by.values().sum::<usize>() as f32 / points.len() as f32;
    (share, by.into_iter().max_by_key(|(_, count)| *count).map(|(object, _)| object))
}

/// Whether light may come in from outside: some of the rays from `points` meet nothing.
pub(super) fn is_open(tracer: &Tracer, points: &[SurfacePoint]) -> bool {
    /// The share of them. At half of it cracks between walls count, at five times narrow windows do not.
    const OPEN: f32 = 0.002;
    /// Rays from each point. Half and double of them find the same rooms open.
    const RAYS: usize = 16;
    let often = points.iter().cycle().take(RAYS * points.len());
    let met = first_met(tracer, &often.copied().collect::<Vec<SurfacePoint>>());
    let free = met.iter().filter(|met| met.is_none()).count();
    free as f32 > OPEN * met.len() as f32
}

fn is_turned_inwards(tracer: &Tracer, points: &[SurfacePoint], lamp: u32) -> bool {
    let itself = first_met(tracer, points).into_iter().flatten().filter(|m| m.1 == lamp).count();
    itself as f32 > MOST * points.len() as f32
}

/// A light without a surface.
fn small_light(subject: &Subject<'_>, light: &Light, seen: &[SurfacePoint]) -> Findings {
    let mut found = Findings::default();
    let tracer = subject.tracer;
    let (kind, position) = match light.kind {
        LightKind::Point { position, .. } => ("point light", Some(position)),
        LightKind::Spot { position, .. } => ("spot light", Some(position)),
        LightKind::Directional { .. } => ("directional light", None),
        LightKind::Profiled { position, .. } => ("lamp", Some(position)),
    };
    let [low, high] = subject.bounds();
    let size = low.distance(high);
    let lit = |at: &&SurfacePoint| {
        let from = at.start();
        let (wi, distance, irradiance) = light.kind.illuminate(from);
        let to = from + wi * distance.min(2.0 * size);
        irradiance.max_element() > 0.0 && wi.dot(at.normal) > 0.0 && is_free(tracer, from, to)
    };
    let lights = seen.iter().filter(lit).count();
    let name = &light.name;
    let around = position.and_then(|position| around(tracer, position));
    let beside =
        around.as_ref().map(|a| a.nearest).filter(|(distance, _)| *distance < BESIDE * size);
    let shut_in_by = around.as_ref().and_then(|a| a.shut_in_by).filter(|_| lights == 0);
    if let Some((distance, object)) = beside {
        found.push(Gravity::Part, format!(
            "{kind} \"{name}\" stands at object \"{}\", {} from its surface: move it into the open",
            subject.object_name(object),
            length(distance)
        ));
    } else if let Some(object) = shut_in_by {
        found.push(Gravity::All, format!(
            "{kind} \"{name}\" is enclosed by object \"{}\" and lights nothing that the picture \
             shows: move it out of the wall or shade, or remove that object from the scene",
            subject.object_name(object)
        ));
    } else if lights == 0 {
        found.push(Gravity::Part, out_of_sight(kind, name));
    }
    found
}

/// The surfaces around a light.
struct Around {
    /// The distance to the nearest surface, and its object.
    nearest: (f32, u32),
    /// The object on most sides of it, if no side is open.
    shut_in_by: Option<u32>,
}

/// The surfaces around `position`; none if there are none.
fn around(tracer: &Tracer, position: Vec3) -> Option<Around> {
    // Fibonacci's sphere.
    let direction = |i: usize| {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / AROUND as f32;
        let (sin, cos) = (TAU * (GOLDEN * i as f32).fract()).sin_cos();
        let ring = (1.0 - z * z).sqrt();
        Vec3::new(ring * cos, ring * sin, z)
    };
    let met: Vec<(f32, u32)> = (0..AROUND)
        .filter_map(|i| tracer.surface(&Ray::new(position, direction(i))))
        .map(|surface| (surface.point.distance(position), surface.object))
        .collect();
    let mut sides: BTreeMap<u32, usize> = BTreeMap::new();
    met.iter().for_each(|(_, object)| *sides.entry(*object).or_default() += 1);
    let (&most, &count) = sides.iter().max_by_key(|(_, count)| **count)?;
    Some(Around {
        nearest: met.iter().min_by(|a, b| a.0.total_cmp(&b.0)).copied()?,
        shut_in_by: (met.len() == AROUND && 2 * count > AROUND).then_some(most),
    })
}
