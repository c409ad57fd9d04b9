//! Which faces see which lamps, and which faces they would mirror them into: found once a scene by a few
//! rays, so that vertices do not ask for lamps that no mirror can show.

use super::lamps::Lamp;
use crate::accel::{self, Ray};
use crate::emitters::{Emitters, PoolOrigin};
use crate::sampler::Sampler;
use crate::tracer::Tracer;
use glam::Vec3;

/// Rays from each face to each lamp. A face of which less than a hundredth sees a lamp may be left out:
/// area lights are then found by chance as by any other surface. With half of it that is a fiftieth, double
/// of it takes twice the time.
const RAYS: u32 = 256;

/// The lamps of a scene, and which faces see them.
#[derive(Debug, Default)]
pub(crate) struct Sight {
    pub(super) lamps: Vec<Lamp>,
    /// Face and lamp that see each other.
    singles: Vec<(u16, usize)>,
    /// Two faces and a lamp whose light the second face mirrors into the first.
    pairs: Vec<(u16, u16, usize)>,
}

impl Sight {
    /// Looks from all flat faces of a scene to all lamps.
    pub(crate) fn new(tracer: &Tracer) -> Self {
        let lamps = Lamp::all(&tracer.emitters);
        let mut sight = Self { lamps, ..Self::default() };
        for (face, triangles) in (0..).zip(tracer.flat_faces.triangles()) {
            for lamp in 0..sight.lamps.len() {
                sight.look(tracer, face, &triangles, lamp);
            }
        }
        sight
    }

    /// Whether `face` sees the lamp.
    pub(super) fn is_lit(&self, face: u16, lamp: usize) -> bool {
        self.singles.binary_search(&(face, lamp)).is_ok()
    }

    /// Whether `second` mirrors the lamp into `first`.
    pub(super) fn is_lit_by(&self, first: u16, second: u16, lamp: usize) -> bool {
        self.pairs.contains(&(first, second, lamp))
    }

    /// Looks from a face with the given triangles to a lamp, and from there as a mirror would.
    fn look(&mut self, tracer: &Tracer, face: u16, triangles: &[u32], lamp: usize) {
        let mut is_lit = false;
        let mut others: Vec<u16> = Vec::new();
        for index in 0..RAYS {
            let mut sampler = Sampler::new(u64::from(face), lamp as u64, index);
            let [pick, u, v, _] = sampler.next4();
            let triangle =
                triangles[((pick * triangles.len() as f32) as usize).min(triangles.len() - 1)];
            let point = tracer.point_of(triangle, [u, v]);
            let Some(to_light) = towards(&self.lamps[lamp], point, &mut sampler) else {
                is_lit = true;
                break;
            };
            let front = tracer.front_normal(triangle);
            let normal = if to_light.dot(front) > 0.0 { front } else { -front };
            let origin = accel::offset(point, normal);
            if !reaches(tracer, &tracer.emitters, origin, to_light) {
                continue;
            }
            is_lit = true;
            let out = (2.0 * to_light.dot(normal) * normal - to_light).normalize();
            let hit = tracer.accel.closest(&Ray::new(origin, out));
            let other = hit.and_then(|hit| tracer.flat_faces.of(hit.triangle));
            if let Some(other) = other.filter(|other| *other != face && !others.contains(other)) {
                others.push(other);
            }
        }
        if is_lit {
            self.singles.push((face, lamp));
        }
        self.pairs.extend(others.into_iter().map(|other| (other, face, lamp)));
    }
}

/// A vector from `point` to a random point of the lamp's bounding sphere, or far along its direction; none
/// if the lamp is all around.
fn towards(lamp: &Lamp, point: Vec3, sampler: &mut Sampler) -> Option<Vec3> {
    match lamp.origin {
        PoolOrigin::Anywhere => None,
        PoolOrigin::Direction(direction) => Some(FAR * direction),
        PoolOrigin::Sphere(sphere) => {
            let [x, y, z, _] = sampler.next4();
            let within = 2.0 * Vec3::new(x, y, z) - 1.0;
            Some(sphere.centre + sphere.radius * within.clamp_length_max(1.0) - point)
        }
    }
}

/// Farther than anything, metres; twice or half of it as well.
const FAR: f32 = 1e9;

/// Whether nothing but a lamp lies on the way from `origin` along `way`.
fn reaches(tracer: &Tracer, emitters: &Emitters, origin: Vec3, way: Vec3) -> bool {
    let distance = way.length();
    let ray = Ray { origin, direction: way / distance, t_max: 0.999 * distance };
    tracer.accel.closest(&ray).is_none_or(|hit| emitters.pool_of(hit.triangle).is_some())
}
