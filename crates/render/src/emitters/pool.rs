//! Pools of lights: a light of a pool is drawn by its strength, a pool by numbers that depend on the point.

use crate::distribution::Distribution;
use crate::lanes::{self, total};
use glam::Vec4;

/// The share of the probability that pools get by power instead of by their bounds. Bounds ignore
/// visibility: without this share a nearby lamp behind a wall would take nearly all samples. With
/// half of it such samples are twice as noisy, with double of it those by bounds are.
const BY_POWER: f32 = 0.2;
/// Most clusters. Bounds ignore visibility, so that more clusters would hardly reduce the variance;
/// with half of them lamps of one ceiling share a cluster, with double of them each sample
/// evaluates twice as many bounds. A multiple of four: they are evaluated in fours.
pub(super) const CLUSTERS_MAX: usize = 16;
/// The pool of the directional lights, after all clusters.
pub(super) const DIRECTIONAL: usize = CLUSTERS_MAX;
/// The pool of the environment.
pub(crate) const ENVIRONMENT: usize = DIRECTIONAL + 1;
/// The number of pools; some are empty.
pub(crate) const POOLS: usize = ENVIRONMENT + 1;
/// The number of fours of pools.
const FOURS: usize = POOLS.div_ceil(4);

/// One light that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Emitter {
    /// By its index among the emitting triangles.
    Triangle(u32),
    /// By its index among the scene's lights.
    Punctual(u32),
    Environment,
}

/// Lights of which one is drawn by its strength.
#[derive(Debug, Default)]
pub(super) struct Pool {
    pub(super) lights: Distribution<Emitter>,
    /// If all are triangles: the index of the first one, after which the others follow in order.
    pub(super) triangles_from: Option<u32>,
}

/// A number for each pool, in fours.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PoolWeights {
    pub(super) fours: [Vec4; FOURS],
    /// The fours beyond this number are empty.
    count: usize,
}

impl Pool {
    /// Of `lights`, each with its strength.
    pub(super) fn new(lights: &[(Emitter, f32)]) -> Self {
        let weighted = lights.iter().map(|(light, strength)| (*light, f64::from(*strength)));
        Self { lights: Distribution::new(weighted), triangles_from: None }
    }
}

impl PoolWeights {
    /// The fours that may not be empty.
    #[inline]
    fn fours(&self) -> &[Vec4] {
        &self.fours[..self.count]
    }

    /// The probabilities of pools that have these importances and the `powers`; all zero where no light arrives.
    #[inline]
    pub(super) fn probabilities(mut self, powers: &Self) -> Self {
        let possible = |importance: Vec4, of_pool: Vec4| {
            Vec4::select(importance.cmpgt(Vec4::ZERO), of_pool, Vec4::ZERO)
        };
        let (mut sum, mut power) = (Vec4::ZERO, Vec4::ZERO);
        for (importance, of_pool) in self.fours().iter().zip(powers.fours) {
            sum += *importance;
            power += possible(*importance, of_pool);
        }
        let by_bound = (1.0 - BY_POWER) / total(sum).max(f32::MIN_POSITIVE);
        let by_power = BY_POWER / total(power).max(f32::MIN_POSITIVE);
        for (importance, of_pool) in self.fours[..self.count].iter_mut().zip(powers.fours) {
            let probability = *importance * by_bound + of_pool * by_power;
            *importance = possible(*importance, probability);
        }
        self
    }

    /// The number of one pool.
    #[inline]
    pub(crate) fn of(&self, pool: usize) -> f32 {
        self.fours[pool / 4][pool % 4]
    }

    /// Sets the number of one pool.
    pub(super) fn set(&mut self, pool: usize, number: f32) {
        self.fours[pool / 4][pool % 4] = number;
        self.count = self.count.max(pool / 4 + 1);
    }

    /// One for `pool`, zero for all others.
    pub(crate) fn one(pool: usize) -> Self {
        let mut weights = Self::default();
        weights.set(pool, 1.0);
        weights
    }

    /// The sum with `other`, pool by pool.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.fours.iter_mut().zip(other.fours).for_each(|(a, b)| *a += b);
        Self { count: self.count.max(other.count), ..self }
    }

    /// The product with `other`, pool by pool.
    #[inline]
    pub(crate) fn times(mut self, other: &Self) -> Self {
        self.fours.iter_mut().zip(other.fours).for_each(|(a, b)| *a *= b);
        Self { count: self.count.min(other.count), ..self }
    }

    /// The sum of all.
    #[inline]
    pub(crate) fn sum(&self) -> f32 {
        total(self.fours().iter().copied().sum())
    }

    /// Draws a pool in proportion to these numbers by one between zero and their sum: the pool, its number,
    /// and one in [0, 1) that is uniform given the pool. None if all are zero.
    #[inline]
    pub(crate) fn draw(&self, u: f32) -> Option<(usize, f32, f32)> {
        lanes::draw(self.fours(), u)
    }
}
