//! Which mirrors see which lamps, and which other mirrors see the lamps in them: found by a few rays before a
//! rendering, so that vertices do not test lamps that no mirror can show.

use super::chain::Mirror;
use super::faces::FlatFaces;
use super::lamps::Lamp;
use crate::accel::{Accel, Ray};
use crate::emitters::{Emitters, PoolOrigin};
use crate::sampler::Sampler;
use glam::Vec3;

/// Rays from each mirror to each lamp. A mirror of which less than a fiftieth sees a lamp may be left out; with half
/// of the rays that is a twenty-fifth, double of them take twice the time.
const RAYS: u32 = 64;
/// A mirror counts as if it saw a lamp from at least this share of its area: points of the scene may be lit
/// from just there. With half of it such light is noisier, with double of it more rays meet what hides the lamp.
const SHARE_MIN: f32 = 0.1;
/// Farther than anything, metres; half or double of it are so as well.
const FAR: f32 = 1e9;

/// The lamps of a scene, and which mirrors see them.
pub(super) struct Sight {
    pub(super) lamps: Vec<Lamp>,
    /// Mirror and lamp that see each other, and the share of the rays between them that are open.
    singles: Vec<((u16, usize), f32)>,
    /// Two mirrors and a lamp that the second mirror shows to the first, and the share of the rays that do.
    pairs: Vec<((u16, u16, usize), f32)>,
}

/// What rays meet.
struct Surroundings<'a> {
    faces: &'a FlatFaces,
    accel: &'a Accel,
    emitters: &'a Emitters,
}

impl Sight {
    /// Looks from all `mirrors` to all lamps.
    pub(super) fn new(
        mirrors: &[Mirror],
        faces: &FlatFaces,
        accel: &Accel,
        emitters: &Emitters,
    ) -> Self {
        let around = Surroundings { faces, accel, emitters };
        let lamps = Lamp::all(emitters);
        let mut sight = Self { lamps, singles: Vec::new(), pairs: Vec::new() };
        for mirror in mirrors {
            for lamp in 0..sight.lamps.len() {
                sight.look(&around, mirror, lamp);
            }
        }
        sight
    }

    /// The share of the mirror at the place `mirror` that sees the lamp; none if no part does.
    pub(super) fn of(&self, mirror: u16, lamp: usize) -> Option<f32> {
        share_of(&self.singles, (mirror, lamp))
    }

    /// The share of `second` that shows the lamp to `first`; none if no part does.
    pub(super) fn of_pair(&self, first: u16, second: u16, lamp: usize) -> Option<f32> {
        share_of(&self.pairs, (first, second, lamp))
    }

    /// Traces rays from a mirror to a lamp, and their reflections to other mirrors.
    fn look(&mut self, around: &Surroundings<'_>, mirror: &Mirror, lamp: usize) {
        let mut open = 0;
        let mut others: Vec<(u16, u32)> = Vec::new();
        let triangles = around.faces.triangles(mirror.place);
        for index in 0..RAYS {
            let mut sampler = Sampler::new(u64::from(mirror.place), lamp as u64, index);
            let point = point_of(triangles, sampler.next4());
            let Some(to_light) = towards(&self.lamps[lamp], point, &mut sampler) else {
                open = RAYS;
                break;
            };
            let normal = mirror.face.normal * to_light.dot(mirror.face.normal).signum();
            let origin = point + mirror.face.clearance * normal;
            if !around.are_open(origin, to_light) {
                continue;
            }
            open += 1;
            let out = (2.0 * to_light.dot(normal) * normal - to_light).normalize();
            let hit = around.accel.closest(&Ray::new(origin, out));
            let other = hit.and_then(|hit| around.faces.of(hit.triangle));
            let Some(other) = other.filter(|other| *other != mirror.place) else { continue };
            match others.iter_mut().find(|(known, _)| *known == other) {
                Some((_, count)) => *count += 1,
                None => others.push((other, 1)),
            }
        }
        let share = |count: u32| (count as f32 / RAYS as f32).max(SHARE_MIN);
        if open > 0 {
            self.singles.push(((mirror.place, lamp), share(open)));
        }
        let pair = |(other, count)| ((other, mirror.place, lamp), share(count));
        self.pairs.extend(others.into_iter().map(pair));
    }
}

fn share_of<K: PartialEq>(shares: &[(K, f32)], key: K) -> Option<f32> {
    shares.iter().find(|(known, _)| *known == key).map(|(_, share)| *share)
}

impl Surroundings<'_> {
    /// Whether nothing but a lamp lies on the way from `origin` along `way`.
    fn are_open(&self, origin: Vec3, way: Vec3) -> bool {
        let distance = way.length();
        let ray = Ray { origin, direction: way / distance, t_max: 0.999 * distance };
        let hit = self.accel.closest(&ray);
        hit.is_none_or(|hit| self.emitters.pool_of(hit.triangle).is_some())
    }
}

/// A point of one of `triangles`, of which there is at least one.
fn point_of(triangles: &[[Vec3; 3]], [pick, u, v, _]: [f32; 4]) -> Vec3 {
    let index = (pick * triangles.len() as f32) as usize;
    let [a, b, c] = triangles[index.min(triangles.len() - 1)];
    let root = u.sqrt();
    a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
}

/// A vector from `point` to a random point of the lamp's bounding sphere, or far along its direction; none
/// if the lamp is all around.
fn towards(lamp: &Lamp, point: Vec3, sampler: &mut Sampler) -> Option<Vec3> {
    match lamp.origin {
        PoolOrigin::Anywhere => None,
        PoolOrigin::Direction(direction) => Some(FAR * direction),
        PoolOrigin::Sphere(sphere) => {
            let [x, y, z, _] = sampler.next4();
            let within = (2.0 * Vec3::new(x, y, z) - 1.0).clamp_length_max(1.0);
            Some(sphere.centre + sphere.radius * within - point)
        }
    }
}
