//! Light sampling: emitting triangles, punctual lights and the environment, drawn by an estimate of
//! what they contribute at the shaded point.
//!
//! The first step draws a *pool* of lights: a cluster of lights at finite distance (`bounds`), all
//! directional lights, or the environment. Its probability is a mixture of the bound of the pool's
//! irradiance at the point and of its power. The second step draws a light of the pool by its
//! strength, and on a triangle a point uniformly over the area `A`, which over solid angle has the
//! density `p d^2 / (A cos)`. Directions to the environment are drawn by [`crate::environment`].

mod bounds;
mod origins;

pub(crate) use origins::{LampSphere, PoolOrigin};

use crate::accel;
use crate::appearance::{LightSource, SourceLayout};
use crate::environment::EnvironmentSampler;
use crate::lanes::{self, total};
use bounds::{CLUSTERS_MAX, ClusterBounds, LightBounds, LightCluster};
use glam::{Vec3, Vec4};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::num::NonZeroU32;
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Light, LightKind, Rgb};

/// The share of the probability that pools get by power instead of by their bounds. Bounds ignore
/// visibility: without this share a nearby lamp behind a wall would take nearly all samples. With
/// half of it such samples are twice as noisy, with double of it those by bounds are.
const BY_POWER: f32 = 0.2;
/// The pool of the directional lights, after all clusters.
const DIRECTIONAL: usize = CLUSTERS_MAX;
/// The pool of the environment.
pub(crate) const ENVIRONMENT: usize = DIRECTIONAL + 1;
/// The number of pools; some are empty.
pub(crate) const POOLS: usize = ENVIRONMENT + 1;
/// The number of fours of pools.
const FOURS: usize = POOLS.div_ceil(4);

/// A number for each pool, in fours.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PoolWeights([Vec4; FOURS]);

/// All lights of a scene.
#[derive(Debug)]
pub struct Emitters {
    triangles: Vec<EmittingTriangle>,
    /// What they emit: each different emission once.
    emissions: Vec<TriangleEmission>,
    punctual: Vec<LightKind>,
    environment: Option<EnvironmentSampler>,
    layout: SourceLayout,
    /// The pools: clusters, [`DIRECTIONAL`], [`ENVIRONMENT`]. Some are empty.
    pools: [Pool; POOLS],
    /// The only pool that is not empty, if so.
    sole: Option<usize>,
    /// Bounds of the irradiance from clusters.
    bounds: ClusterBounds,
    /// Luminance of the irradiance from the other pools, W m^-2.
    irradiances: PoolWeights,
    /// The power of each pool, W.
    powers: PoolWeights,
    /// For each triangle of the scene: its place in `triangles`, if it emits.
    emitting: Vec<Option<EmittingIndex>>,
}

/// One light that can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Emitter {
    /// By its index among the emitting triangles.
    Triangle(u32),
    /// By its index among the scene's lights.
    Punctual(u32),
    Environment,
}

/// An index into [`Emitters::triangles`], stored plus one so that an option of it has four bytes.
#[derive(Clone, Copy, Debug)]
struct EmittingIndex(NonZeroU32);

impl EmittingIndex {
    fn new(index: usize) -> Option<Self> {
        NonZeroU32::new(index as u32 + 1).map(Self)
    }

    #[inline]
    fn get(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// A lamp may have thousands of triangles, of which each sample meets another one: one lies in one line
/// of the processor's cache.
#[derive(Debug)]
#[repr(align(64))]
struct EmittingTriangle {
    corner: Vec3,
    /// From the corner to the other two.
    edges: [Vec3; 2],
    /// Unit normal of the front.
    normal: Vec3,
    /// The index of its emission.
    emission: u32,
    pool: u32,
    /// Probability of the triangle, given its pool, over its area, m^-2.
    density: f32,
}

/// Lights of which one is drawn by its strength.
#[derive(Debug, Default)]
struct Pool {
    lights: Vec<Weighted>,
    /// For each of as many equal parts of [0, 1) as there are lights: the place of the light at its
    /// beginning [Chen and Asau 1974], from where the right one is a step or two away.
    guide: Vec<u32>,
}

/// A light of a pool.
#[derive(Clone, Copy, Debug)]
struct Weighted {
    light: Emitter,
    /// The cumulative distribution up to this light; that of the last one is one.
    until: f32,
}

/// Light that arrives at a point unless it is occluded.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// What emits it.
    pub source: LightSource,
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// Length of the shadow ray.
    pub distance: f32,
    /// Of a triangle or the environment: radiance over `pdf`. Of a punctual light: irradiance at a
    /// surface that faces it, over the light's probability.
    pub weight: Rgb,
    /// Density over solid angle; none for punctual lights, which no other ray can hit.
    pub pdf: Option<f32>,
}

/// What a triangle emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleEmission {
    /// The triangle's group.
    pub group: u32,
    /// Radiance from the front, W sr^-1 m^-2 per channel.
    pub radiance: Rgb,
}

impl Emitters {
    /// The lights of a scene of `groups` groups: those of `triangles` that `emission` says to emit,
    /// `lights`, and `environment`. `bounds` is the bounding box of the scene.
    pub fn new(
        triangles: &[[Vec3; 3]],
        emission: impl Fn(usize) -> TriangleEmission,
        groups: u32,
        lights: &[Light],
        bounds: [Vec3; 2],
        environment: Option<&Environment>,
    ) -> Self {
        let mut of_triangle = vec![None; triangles.len()];
        let mut emitting = Vec::new();
        let mut emissions: Vec<TriangleEmission> = Vec::new();
        for (index, corners) in triangles.iter().enumerate() {
            let emission = emission(index);
            if area(corners) * luminance(emission.radiance) > 0.0 {
                of_triangle[index] = EmittingIndex::new(emitting.len());
                // The triangles of a group follow each other.
                if emissions.last() != Some(&emission) {
                    emissions.push(emission);
                }
                emitting.push(EmittingTriangle::new(emissions.len() as u32 - 1, *corners));
            }
        }
        let mut emitters = Self {
            triangles: emitting,
            emissions,
            punctual: lights.iter().map(|l| l.kind).collect(),
            environment: environment.and_then(EnvironmentSampler::new),
            layout: SourceLayout::new(groups, lights.len() as u32, environment),
            pools: Default::default(),
            sole: None,
            bounds: ClusterBounds::default(),
            irradiances: PoolWeights::default(),
            powers: PoolWeights::default(),
            emitting: of_triangle,
        };
        emitters.fill_pools(0.5 * (bounds[1] - bounds[0]).length());
        for (index, pool) in emitters.pools.iter().enumerate() {
            for (place, light) in pool.lights.iter().enumerate() {
                if let Emitter::Triangle(triangle) = light.light {
                    let triangle = &mut emitters.triangles[triangle as usize];
                    triangle.pool = index as u32;
                    triangle.density = pool.probability(place) / triangle.area();
                }
            }
        }
        emitters
    }

    /// Distributes the lights over the pools; `radius` is that of the scene.
    fn fill_pools(&mut self, radius: f32) {
        let triangles = self.triangles.iter().zip(0..);
        let bounds = |(triangle, index): (&EmittingTriangle, u32)| {
            triangle.bounds(Emitter::Triangle(index), self.emission(triangle).radiance)
        };
        let mut near: Vec<_> = triangles.map(bounds).collect();
        let mut directional = Vec::new();
        for (kind, index) in self.punctual.iter().zip(0..) {
            let (light, strength) = (Emitter::Punctual(index), luminance(kind.strength()));
            match LightBounds::of_punctual(light, kind) {
                _ if strength <= 0.0 => {}
                Some(bounds) => near.push(bounds),
                None => directional.push((light, strength)),
            }
        }
        let clusters = LightCluster::all(near, radius);
        self.bounds = ClusterBounds::new(&clusters);
        let members = |cluster: &LightCluster| -> Vec<_> {
            cluster.members.iter().map(|m| (m.light, m.strength)).collect()
        };
        let mut pools: Vec<_> = clusters.iter().map(members).collect();
        pools.resize(DIRECTIONAL, Vec::new());
        let environment = self.environment.iter().map(|_| (Emitter::Environment, 1.0));
        pools.extend([directional, environment.collect()]);
        for (index, lights) in pools.into_iter().enumerate() {
            let power = |light: &(Emitter, f32)| self.power(light.0, radius * radius);
            self.powers.set(index, lights.iter().map(power).sum());
            let irradiance = match &self.environment {
                Some(environment) if index == ENVIRONMENT => 0.5 * environment.flux(),
                _ if index == DIRECTIONAL => lights.iter().map(|light| light.1).sum(),
                _ => 0.0,
            };
            self.irradiances.set(index, irradiance);
            self.pools[index] = Pool::new(&lights);
        }
        let mut filled = (0..POOLS).filter(|&i| !self.pools[i].lights.is_empty());
        self.sole = filled.next().filter(|_| filled.next().is_none());
    }

    /// The power of a light, W; of one at infinity, the power that enters the scene.
    fn power(&self, light: Emitter, scene_radius2: f32) -> f32 {
        match light {
            Emitter::Triangle(index) => {
                let triangle = &self.triangles[index as usize];
                PI * triangle.area() * luminance(self.emission(triangle).radiance)
            }
            Emitter::Punctual(index) => power(&self.punctual[index as usize], scene_radius2),
            Emitter::Environment => {
                self.environment.as_ref().map_or(0.0, |e| PI * scene_radius2 * e.flux())
            }
        }
    }

    /// Whether lights are in more than one pool.
    pub fn are_several(&self) -> bool {
        self.sole.is_none() && !self.pools.iter().all(|pool| pool.lights.is_empty())
    }

    /// The order of the light sources.
    #[inline]
    pub fn layout(&self) -> &SourceLayout {
        &self.layout
    }

    /// Whether surfaces of the group with this index emit.
    pub(crate) fn emits_from_group(&self, group: u32) -> bool {
        self.emissions.iter().any(|emission| emission.group == group)
    }

    /// Whether light comes from the environment.
    pub(crate) fn has_environment(&self) -> bool {
        self.environment.is_some()
    }

    /// The radiance of the environment along the unit vector `wi`; zero without an environment.
    #[inline]
    pub fn environment(&self, wi: Vec3) -> Rgb {
        self.environment.as_ref().map_or(Rgb::ZERO, |environment| environment.radiance(wi))
    }

    /// The density over solid angle with which [`Emitters::sample`] at `point` draws `wi` to the
    /// environment.
    pub fn environment_pdf(&self, point: Vec3, wi: Vec3) -> f32 {
        self.environment_pdf_of(self.probability(ENVIRONMENT, point), wi)
    }

    /// The density over solid angle of `wi` to the environment, if that is drawn with `probability`.
    pub(crate) fn environment_pdf_of(&self, probability: f32, wi: Vec3) -> f32 {
        self.environment.as_ref().map_or(0.0, |environment| probability * environment.pdf(wi))
    }

    /// The radiance that a triangle emits from its front.
    pub fn radiance(&self, triangle: u32) -> Rgb {
        match self.emitting[triangle as usize] {
            None => Rgb::ZERO,
            Some(index) => self.emission(&self.triangles[index.get()]).radiance,
        }
    }

    #[inline]
    fn emission(&self, triangle: &EmittingTriangle) -> &TriangleEmission {
        &self.emissions[triangle.emission as usize]
    }

    /// The density over solid angle with which [`Emitters::sample`] at `point` draws the direction
    /// in which the front of `triangle` lies at `distance`, under the cosine `cos` to its normal.
    pub fn pdf(&self, point: Vec3, triangle: u32, distance: f32, cos: f32) -> f32 {
        self.pool_of(triangle)
            .map_or(0.0, |pool| self.pdf_of(self.probability(pool, point), triangle, distance, cos))
    }

    /// The density over solid angle of the direction in which the front of `triangle` lies at
    /// `distance`, under the cosine `cos` to its normal, if its pool is drawn with `probability`.
    pub(crate) fn pdf_of(&self, probability: f32, triangle: u32, distance: f32, cos: f32) -> f32 {
        self.emitting[triangle as usize].map_or(0.0, |index| {
            let density = self.triangles[index.get()].density;
            probability * density * distance * distance / cos.max(1e-6)
        })
    }

    /// The probability of one pool at `point`.
    #[inline]
    fn probability(&self, pool: usize, point: Vec3) -> f32 {
        match self.sole {
            Some(sole) => f32::from(u8::from(sole == pool)),
            None => self.probabilities(self.importances(point)).of(pool),
        }
    }

    /// Bounds of the irradiance of all pools at `point`, W m^-2.
    #[inline]
    pub(crate) fn importances(&self, point: Vec3) -> PoolWeights {
        let mut result = self.irradiances;
        for four in 0..self.bounds.fours() {
            result.0[four] = self.bounds.importances(four, point);
        }
        result
    }

    /// The pool of a triangle, if it emits.
    pub(crate) fn pool_of(&self, triangle: u32) -> Option<usize> {
        self.emitting[triangle as usize].map(|index| self.triangles[index.get()].pool as usize)
    }

    /// The probabilities of all pools where they have these `importances`; all zero where no light arrives.
    #[inline]
    fn probabilities(&self, importances: PoolWeights) -> PoolWeights {
        let possible = |importance: Vec4, of_pool: Vec4| {
            Vec4::select(importance.cmpgt(Vec4::ZERO), of_pool, Vec4::ZERO)
        };
        let (mut sum, mut power) = (Vec4::ZERO, Vec4::ZERO);
        for (importance, of_pool) in importances.0.iter().zip(self.powers.0) {
            sum += *importance;
            power += possible(*importance, of_pool);
        }
        let by_bound = (1.0 - BY_POWER) / total(sum).max(f32::MIN_POSITIVE);
        let by_power = BY_POWER / total(power).max(f32::MIN_POSITIVE);
        let mut result = importances;
        for (importance, of_pool) in result.0.iter_mut().zip(self.powers.0) {
            let probability = *importance * by_bound + of_pool * by_power;
            *importance = possible(*importance, probability);
        }
        result
    }

    /// Draws light for the surface point `point` from three numbers in [0, 1).
    pub fn sample(&self, point: Vec3, u: [f32; 3]) -> Option<LightSample> {
        match self.sole {
            Some(sole) => self.sample_from(&self.pools[sole], 1.0, point, u),
            None => self.sample_where(self.importances(point), point, u),
        }
    }

    /// The same for a point where the pools have these `importances`.
    #[inline]
    pub(crate) fn sample_where(
        &self,
        importances: PoolWeights,
        point: Vec3,
        u: [f32; 3],
    ) -> Option<LightSample> {
        let (pool, probability, rest) = self.probabilities(importances).draw(u[0])?;
        self.sample_from(&self.pools[pool], probability, point, [rest, u[1], u[2]])
    }

    /// Draws light of the pool with the index `pool`, which was drawn with `probability`, for the
    /// surface point `point` from three numbers in [0, 1).
    pub(crate) fn sample_pool(
        &self,
        pool: usize,
        probability: f32,
        point: Vec3,
        u: [f32; 3],
    ) -> Option<LightSample> {
        self.sample_from(&self.pools[pool], probability, point, u)
    }

    fn sample_from(
        &self,
        pool: &Pool,
        probability: f32,
        point: Vec3,
        u: [f32; 3],
    ) -> Option<LightSample> {
        let place = pool.place(u[0]);
        match pool.lights[place].light {
            Emitter::Triangle(index) => {
                let triangle = &self.triangles[index as usize];
                triangle.sample(self.emission(triangle), point, probability, [u[1], u[2]])
            }
            Emitter::Punctual(index) => {
                let (wi, distance, irradiance) = self.punctual[index as usize].illuminate(point);
                if irradiance.max_element() <= 0.0 {
                    return None;
                }
                let source = LightSource::Punctual(index);
                let weight = irradiance / (probability * pool.probability(place));
                Some(LightSample { source, wi, distance, weight, pdf: None })
            }
            Emitter::Environment => self.sample_environment(probability, [u[1], u[2]]),
        }
    }

    fn sample_environment(&self, probability: f32, u: [f32; 2]) -> Option<LightSample> {
        let environment = self.environment.as_ref()?;
        let (wi, pdf) = environment.sample(u);
        let pdf = probability * pdf;
        let radiance = environment.radiance(wi);
        if pdf <= 0.0 || radiance.max_element() <= 0.0 {
            return None;
        }
        let (source, distance) = (LightSource::Environment(wi), f32::INFINITY);
        Some(LightSample { source, wi, distance, weight: radiance / pdf, pdf: Some(pdf) })
    }
}

impl PoolWeights {
    /// The number of one pool.
    #[inline]
    pub(crate) fn of(&self, pool: usize) -> f32 {
        self.0[pool / 4][pool % 4]
    }

    /// Sets the number of one pool.
    fn set(&mut self, pool: usize, number: f32) {
        self.0[pool / 4][pool % 4] = number;
    }

    /// One for `pool`, zero for all others.
    pub(crate) fn one(pool: usize) -> Self {
        let mut weights = Self::default();
        weights.set(pool, 1.0);
        weights
    }

    /// The sum with `other`, pool by pool.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
        self
    }

    /// The product with `other`, pool by pool.
    #[inline]
    pub(crate) fn times(mut self, other: &Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a *= b);
        self
    }

    /// The sum of all.
    #[inline]
    pub(crate) fn sum(&self) -> f32 {
        total(self.0.iter().copied().sum())
    }

    /// Draws a pool in proportion to these numbers by one between zero and their sum: the pool, its number,
    /// and one in [0, 1) that is uniform given the pool. None if all are zero.
    #[inline]
    pub(crate) fn draw(&self, u: f32) -> Option<(usize, f32, f32)> {
        lanes::draw(&self.0, u)
    }
}

impl Pool {
    /// Of `lights`, each with its strength.
    fn new(lights: &[(Emitter, f32)]) -> Self {
        let total: f64 = lights.iter().map(|light| f64::from(light.1)).sum();
        let running = lights.iter().scan(0.0, |sum, &(light, strength)| {
            *sum += f64::from(strength) / total;
            Some(Weighted { light, until: *sum as f32 })
        });
        let lights: Vec<Weighted> = running.collect();
        let parts = lights.len();
        let begin = |part: usize| part as f32 / parts as f32;
        let first = |part| lights.partition_point(|light| light.until <= begin(part)) as u32;
        Self { guide: (0..parts).map(first).collect(), lights }
    }

    /// The place of the light that a number in [0, 1) draws.
    fn place(&self, u: f32) -> usize {
        let last = self.lights.len() - 1;
        let part = (u * self.guide.len() as f32) as usize;
        let mut place = (self.guide[part.min(last)] as usize).min(last);
        // Rounding may have put the number into the part after its own.
        while place > 0 && self.lights[place - 1].until > u {
            place -= 1;
        }
        while place < last && self.lights[place].until <= u {
            place += 1;
        }
        place
    }

    /// The probability of the light at `place`, given the pool.
    fn probability(&self, place: usize) -> f32 {
        let before = if place == 0 { 0.0 } else { self.lights[place - 1].until };
        self.lights[place].until - before
    }
}

impl EmittingTriangle {
    /// Its pool and density are set once all lights are known.
    fn new(emission: u32, corners: [Vec3; 3]) -> Self {
        let [corner, b, c] = corners;
        let (edges, normal) = ([b - corner, c - corner], accel::front_normal(corners));
        Self { corner, edges, normal, emission, pool: 0, density: 0.0 }
    }

    /// Square metres.
    fn area(&self) -> f32 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    fn bounds(&self, light: Emitter, radiance: Rgb) -> LightBounds {
        let [b, c] = self.edges;
        let to_centre = (b + c) / 3.0;
        let offsets = [to_centre, to_centre - b, to_centre - c];
        LightBounds {
            light,
            centre: self.corner + to_centre,
            radius: offsets.map(Vec3::length).into_iter().fold(0.0, f32::max),
            axis: self.normal,
            reach_rad: FRAC_PI_2,
            strength: self.area() * luminance(radiance),
        }
    }

    /// A point of it, given what it emits and the probability of its pool.
    #[inline]
    fn sample(
        &self,
        emission: &TriangleEmission,
        point: Vec3,
        probability: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let root = u[0].sqrt();
        let (b, c) = (root * (1.0 - u[1]), root * u[1]);
        let on_light = self.corner + self.edges[0] * b + self.edges[1] * c;
        let to_light = accel::offset(on_light, self.normal) - point;
        let distance2 = to_light.length_squared();
        let (distance, inverse) = (distance2.sqrt(), 1.0 / distance2.sqrt());
        let wi = to_light * inverse;
        let cos = -wi.dot(self.normal);
        // At the point itself neither is a number.
        if !(cos > 0.0 && inverse.is_finite()) {
            return None;
        }
        let pdf = probability * self.density * distance2 / cos.max(1e-6);
        let source = LightSource::Group(emission.group);
        let weight = emission.radiance * (1.0 / pdf);
        Some(LightSample { source, wi, distance, weight, pdf: Some(pdf) })
    }
}

fn area([a, b, c]: &[Vec3; 3]) -> f32 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// The power of a punctual light, W; of a directional one, the power that enters the scene.
pub(crate) fn power(kind: &LightKind, scene_radius2: f32) -> f32 {
    match kind {
        LightKind::Point { intensity, .. } => 4.0 * PI * luminance(*intensity),
        LightKind::Spot { intensity, inner_rad, outer_rad, .. } => {
            TAU * (1.0 - 0.5 * (inner_rad.cos() + outer_rad.cos())) * luminance(*intensity)
        }
        LightKind::Directional { irradiance, .. } => PI * scene_radius2 * luminance(*irradiance),
    }
}

#[cfg(test)]
mod tests;
