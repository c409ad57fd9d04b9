//! The lamps that mirrors can be asked for, and their images: which of them may light a point.

use super::chain::{Chain, MIRRORS_MAX, Mirror};
use crate::emitters::{Emitters, LampSphere, POOLS, PoolOrigin};
use glam::Vec3;

/// A lamp: one or several pools of lights at about one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    pub(super) origin: PoolOrigin,
    /// The pools, as bits.
    pools: u32,
    /// As [`Emitters::strength`], of all pools together.
    strength: f32,
}

impl Lamp {
    /// All lamps of a scene. The pools of a bulb, whose parts face all directions, are one lamp.
    pub(super) fn all(emitters: &Emitters) -> Vec<Self> {
        let mut lamps: Vec<Self> = Vec::new();
        for pool in 0..POOLS {
            let Some(origin) = emitters.origin(pool) else { continue };
            let lamp = Self { origin, pools: 1 << pool, strength: emitters.strength(pool) };
            match lamps.iter_mut().find_map(|other| Some((other.joined(&lamp)?, other))) {
                Some((joined, other)) => *other = joined,
                None => lamps.push(lamp),
            }
        }
        lamps
    }

    /// Both together, if that is hardly larger than the larger one.
    fn joined(&self, other: &Self) -> Option<Self> {
        let (PoolOrigin::Sphere(a), PoolOrigin::Sphere(b)) = (self.origin, other.origin) else {
            return None;
        };
        let distance = a.centre.distance(b.centre);
        let radius = (0.5 * (distance + a.radius + b.radius)).max(a.radius).max(b.radius);
        if radius > 2.0 * a.radius.max(b.radius) {
            return None;
        }
        let towards = (b.centre - a.centre).normalize_or_zero();
        let centre = a.centre + (radius - a.radius) * towards;
        let sphere = LampSphere { centre, radius, axis: Vec3::ZERO, cos_reach: -1.0 };
        Some(Self {
            origin: PoolOrigin::Sphere(sphere),
            pools: self.pools | other.pools,
            strength: self.strength + other.strength,
        })
    }

    /// About the irradiance that arrives at `origin` straight, W m^-2, if nothing occludes it.
    #[inline]
    pub(super) fn irradiance(&self, origin: Vec3) -> f32 {
        match &self.origin {
            PoolOrigin::Sphere(sphere) => {
                self.strength * from_sphere(sphere, sphere.axis, origin - sphere.centre)
            }
            _ => self.strength,
        }
    }

    /// Whether the pool belongs to it.
    pub(super) fn has(&self, pool: usize) -> bool {
        self.pools >> pool & 1 == 1
    }
}

/// A lamp as a chain of mirrors shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct VirtualLamp {
    /// The index of the chain.
    pub(super) chain: usize,
    pub(super) lamp: Lamp,
    /// Its centre, or the direction towards it, as seen before each mirror, in the order of the path.
    images: [Vec3; MIRRORS_MAX],
    /// The axis of emission as seen before the first mirror.
    axis: Vec3,
    /// The lamp's strength times the mirrors' reflectance.
    pub(super) strength: f32,
}

impl VirtualLamp {
    /// `lamp` by the chain of the index `index`; none if it lies in the plane of a mirror.
    pub(super) fn new(index: usize, chain: &Chain, lamp: &Lamp) -> Option<Self> {
        let mut images = [Vec3::ZERO; MIRRORS_MAX];
        let (mut image, mut axis) = match lamp.origin {
            PoolOrigin::Sphere(sphere) => (sphere.centre, sphere.axis),
            PoolOrigin::Direction(direction) => (direction, Vec3::ZERO),
            PoolOrigin::Anywhere => (Vec3::ZERO, Vec3::ZERO),
        };
        for (slot, mirror) in images.iter_mut().zip(chain.mirrors()).rev() {
            image = match lamp.origin {
                PoolOrigin::Sphere(_) if mirror.is_close(image) => return None,
                PoolOrigin::Sphere(_) => mirror.image(image),
                _ => mirror.image_of_direction(image),
            };
            axis = mirror.image_of_direction(axis);
            *slot = image;
        }
        let strength = lamp.strength * chain.reflectance;
        Some(Self { chain: index, lamp: *lamp, images, axis, strength })
    }

    /// About the irradiance that arrives at `origin`, W m^-2; zero if the mirrors of `chain` do not show the
    /// lamp there.
    #[inline]
    pub(super) fn irradiance(&self, chain: &Chain, origin: Vec3) -> f32 {
        match &self.lamp.origin {
            PoolOrigin::Anywhere => self.strength,
            PoolOrigin::Direction(_) => {
                let mut point = origin;
                for (mirror, direction) in chain.mirrors().iter().zip(self.images) {
                    let Some(crossing) = towards(mirror, point, direction) else { return 0.0 };
                    point = crossing;
                }
                self.strength
            }
            PoolOrigin::Sphere(sphere) => self.through_mirrors(sphere, chain, origin),
        }
    }

    #[inline]
    fn through_mirrors(&self, sphere: &LampSphere, chain: &Chain, origin: Vec3) -> f32 {
        let mut point = origin;
        let mut radius = sphere.radius;
        for (mirror, image) in chain.mirrors().iter().zip(self.images) {
            let Some((crossing, share)) = through(mirror, point, image, radius) else { return 0.0 };
            point = crossing;
            // What is left of the way sees the lamp as large as the whole way does.
            radius *= 1.0 - share;
        }
        self.strength * from_sphere(sphere, self.axis, origin - self.images[0])
    }
}

/// A bound of the cosine at a lamp over the squared distance, for a point off its centre by `from_lamp`; `axis`
/// is the lamp's axis of emission, perhaps mirrored.
#[inline]
fn from_sphere(sphere: &LampSphere, axis: Vec3, from_lamp: Vec3) -> f32 {
    let distance2 = from_lamp.length_squared();
    let mut facing = 1.0;
    if axis != Vec3::ZERO {
        let distance = distance2.sqrt();
        let along = from_lamp.dot(axis) + sphere.radius;
        if along <= (distance - sphere.radius) * sphere.cos_reach - 1e-4 * distance {
            return 0.0;
        }
        facing = (along / distance).clamp(FACING_MIN, 1.0);
    }
    facing / distance2.max(sphere.radius * sphere.radius).max(f32::MIN_POSITIVE)
}

/// A lamp that is seen from the side counts as if its cosine were at least this: its other side may
/// face the point. Half or double of it moves a few samples from one lamp to another.
const FACING_MIN: f32 = 0.05;

/// Where the line from `point` to the mirror image `image` of a lamp of `radius` crosses the mirror, and
/// the share of the way up to there; none if the two lie on one side of it, or the lamp cannot be seen
/// through it.
#[inline]
fn through(mirror: &Mirror, point: Vec3, image: Vec3, radius: f32) -> Option<(Vec3, f32)> {
    let (here, there) = (mirror.face.height(point), mirror.face.height(image));
    if here * there >= 0.0 {
        return None;
    }
    let share = here / (here - there);
    let crossing = point + share * (image - point);
    mirror.is_near(crossing, radius * share).then_some((crossing, share))
}

/// Where the line from `point` along `direction` crosses the mirror.
#[inline]
fn towards(mirror: &Mirror, point: Vec3, direction: Vec3) -> Option<Vec3> {
    let along = -mirror.face.height(point) / direction.dot(mirror.face.normal);
    let crossing = point + along * direction;
    (along > 0.0 && along.is_finite() && mirror.is_near(crossing, 0.0)).then_some(crossing)
}
