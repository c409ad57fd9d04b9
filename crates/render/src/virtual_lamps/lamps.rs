//! The lamps that are sampled in mirrors, and their images, which may light a point.

use super::chain::{Chain, MIRRORS_MAX};
use crate::emitters::{Emitters, LampSphere, POOLS, PoolOrigin, PoolWeights};
use glam::Vec3;

/// A lamp: one or several pools of lights at about one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    pub(super) origin: PoolOrigin,
    /// One for its pools, zero for the others.
    pub(super) pools: PoolWeights,
    /// As [`Emitters::strength`], of all pools together.
    strength: f32,
}

impl Lamp {
    /// All lamps of a scene. The pools of a bulb, whose parts face all directions, are one lamp.
    pub(super) fn all(emitters: &Emitters) -> Vec<Self> {
        let mut lamps: Vec<Self> = Vec::new();
        for pool in 0..POOLS {
            let Some(origin) = emitters.origin(pool) else { continue };
            let lamp =
                Self { origin, pools: PoolWeights::one(pool), strength: emitters.strength(pool) };
            match lamps.iter_mut().find_map(|other| Some((other.joined(&lamp)?, other))) {
                Some((joined, other)) => *other = joined,
                None => lamps.push(lamp),
            }
        }
        lamps
    }

    /// Both together, if that is at most twice as large as the larger one.
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
            pools: self.pools.plus(&other.pools),
            strength: self.strength + other.strength,
        })
    }

    /// Whether the pool belongs to it.
    pub(super) fn has(&self, pool: usize) -> bool {
        self.pools.of(pool) > 0.0
    }
}

/// A lamp as a chain of mirrors shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct VirtualLamp {
    /// The index of the chain.
    pub(super) chain: usize,
    pub(super) lamp: Lamp,
    /// Its centre, or the direction towards it, as seen before each mirror, in the order of the path.
    pub(super) images: [Vec3; MIRRORS_MAX],
    /// The axis of emission as seen before the first mirror.
    pub(super) axis: Vec3,
    /// The lamp's strength times the mirrors' reflectance, and the share of the last one that shows it.
    pub(super) strength: f32,
}

impl VirtualLamp {
    /// `lamp` by the chain of the index `index`, of which `share` shows it; none if it lies in the plane of a
    /// mirror.
    pub(super) fn new(index: usize, chain: &Chain, lamp: &Lamp, share: f32) -> Option<Self> {
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
        let strength = lamp.strength * chain.reflectance * share;
        Some(Self { chain: index, lamp: *lamp, images, axis, strength })
    }
}
