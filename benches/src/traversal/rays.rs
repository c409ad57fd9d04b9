//! The rays: from the camera, scattered once, and to the lamp.

use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use unrender::render::Settings;
use unrender::render::accel::{Accel, Ray, clearance};
use unrender::render::camera_sample::camera_ray;
use unrender::scene::Scene;

/// The names of the sets.
pub(crate) const NAMES: [&str; 3] = ["primary", "bounce", "shadow"];

/// Rays of one kind.
pub(crate) struct RaySet {
    /// One of [`NAMES`].
    pub(crate) name: &'static str,
    /// Whether the query is only if they are blocked.
    pub(crate) any: bool,
    /// In the order of the picture.
    pub(crate) rays: Vec<Ray>,
}

/// The rays of a picture of `side` x `side` pixels, one path each.
pub(crate) fn sets(scene: &Scene, triangles: &[[Vec3; 3]], side: usize) -> [RaySet; 3] {
    let accel = Accel::build(triangles);
    let lamp = Lamp::of(scene);
    let [mut primary, mut bounce, mut shadow] = [const { Vec::new() }; 3];
    for pixel in 0..(side * side) as u32 {
        let mut sampler =
            Settings { seed: 1, ..Settings::default() }.pixels(side).sampler(pixel, 0);
        let ray = camera_ray(&scene.cameras[0], (side, side), pixel, &mut sampler);
        primary.push(ray);
        let Some(hit) = accel.closest(&ray) else { continue };
        let [a, b, c] = triangles[hit.triangle as usize];
        let front = (b - a).cross(c - a).normalize();
        let normal = if front.dot(ray.direction) < 0.0 { front } else { -front };
        let point = ray.origin + hit.t * ray.direction + clearance([a, b, c]) * normal;
        let [u, v, s, t] = sampler.next4();
        bounce.push(Ray::new(point, by_cosine(normal, u, v)));
        let to_lamp = lamp.point(s, t) - point;
        let distance = to_lamp.length();
        // It ends before the lamp itself.
        let t_max = 0.999 * distance;
        shadow.push(Ray { origin: point, direction: to_lamp / distance, t_max });
    }
    [(primary, false), (bounce, false), (shadow, true)]
        .into_iter()
        .zip(NAMES)
        .map(|((rays, any), name)| RaySet { name, any, rays })
        .collect::<Vec<_>>()
        .try_into()
        .unwrap_or_else(|_| unreachable!("three sets with three names"))
}

/// A direction about `normal` with a density of cosine / pi (Duff et al., JCGT 2017, for the axes).
fn by_cosine(normal: Vec3, u: f32, v: f32) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let disk = u.sqrt() * Vec2::from_angle(TAU * v);
    (disk.x * x + disk.y * y + (1.0 - u).sqrt() * normal).normalize()
}

/// A scene's first group that emits, as a triangle or a parallelogram of two.
struct Lamp {
    corner: Vec3,
    sides: [Vec3; 2],
}

impl Lamp {
    fn of(scene: &Scene) -> Self {
        let is_lamp = |o: &&unrender::scene::Object| scene.groups[o.group].is_emitter();
        let Some(lamp) = scene.objects.iter().find(is_lamp) else {
            return Self { corner: Vec3::Y, sides: [Vec3::X, Vec3::Z] };
        };
        let (low, high) = lamp
            .mesh
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let size = high - low;
        Self { corner: low, sides: [Vec3::X * size.x, Vec3::Z * size.z] }
    }

    fn point(&self, s: f32, t: f32) -> Vec3 {
        self.corner + s * self.sides[0] + t * self.sides[1]
    }
}
