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
mod pool;
mod triangle;

pub(crate) use origins::{LampSphere, PoolOrigin};
pub(crate) use pool::{ENVIRONMENT, POOLS, PoolWeights};

use crate::appearance::{LightSource, SourceLayout};
use crate::environment::EnvironmentSampler;
use bounds::{ClusterBounds, LightBounds, LightCluster};
use glam::Vec3;
use pool::{DIRECTIONAL, Emitter, Pool};
use std::f32::consts::{PI, TAU};
use triangle::{EmittingIndex, EmittingTriangle};
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Light, LightKind, Rgb};

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

/// Light that arrives at a point unless it is occluded.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// What emits it.
    pub source: LightSource,
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// Length of the shadow ray.
    pub distance: f32,
    /// Of a triangle: radiance over `pdf`. Of a punctual light: irradiance at a surface that faces it, over the light's
    /// probability. Of the environment: radiance over `pdf`, and zero until it is known that
    /// nothing occludes it.
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
                of_triangle[index] = Some(EmittingIndex::at(emitting.len()));
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
            punctual: lights.iter().map(|l| l.kind.clone()).collect(),
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
        emitters.sort_triangles();
        for (index, pool) in emitters.pools.iter().enumerate() {
            for (place, light) in pool.lights.iter().enumerate() {
                if let Emitter::Triangle(triangle) = *light {
                    let triangle = &mut emitters.triangles[triangle as usize];
                    triangle.pool = index as u32;
                    triangle.density = pool.lights.probability(place) / triangle.area();
                }
            }
        }
        emitters
    }

    /// Puts the triangles into the order of the pools.
    fn sort_triangles(&mut self) {
        let mut order = Vec::with_capacity(self.triangles.len());
        for pool in &mut self.pools {
            let first = order.len() as u32;
            for light in pool.lights.iter_mut() {
                if let Emitter::Triangle(index) = light {
                    order.push(*index as usize);
                    *index = order.len() as u32 - 1;
                }
            }
            let are_all = order.len() - first as usize == pool.lights.len();
            pool.triangles_from = are_all.then_some(first);
        }
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, index)| places[*index] = place);
        self.triangles = order.iter().map(|index| self.triangles[*index]).collect();
        for index in self.emitting.iter_mut().flatten() {
            *index = EmittingIndex::at(places[index.get()]);
        }
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
            if lights.is_empty() {
                continue;
            }
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
            None => self.importances(point).probabilities(&self.powers).of(pool),
        }
    }

    /// Bounds of the irradiance of all pools at `point`, W m^-2.
    #[inline]
    pub(crate) fn importances(&self, point: Vec3) -> PoolWeights {
        let mut result = self.irradiances;
        for four in 0..self.bounds.fours() {
            result.fours[four] = self.bounds.importances(four, point);
        }
        result
    }

    /// The pool of a triangle, if it emits.
    pub(crate) fn pool_of(&self, triangle: u32) -> Option<usize> {
        self.emitting[triangle as usize].map(|index| self.triangles[index.get()].pool as usize)
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
        let (pool, probability, rest) = importances.probabilities(&self.powers).draw(u[0])?;
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
        let place = pool.lights.place(u[0]);
        let light = match pool.triangles_from {
            Some(first) => Emitter::Triangle(first + place as u32),
            None => *pool.lights.at(place),
        };
        match light {
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
                let weight = irradiance / (probability * pool.lights.probability(place));
                Some(LightSample { source, wi, distance, weight, pdf: None })
            }
            Emitter::Environment => self.sample_environment(probability, [u[1], u[2]]),
        }
    }

    fn sample_environment(&self, probability: f32, u: [f32; 2]) -> Option<LightSample> {
        let environment = self.environment.as_ref()?;
        let (wi, pdf) = environment.sample(u);
        let pdf = probability * pdf;
        let (source, distance) = (LightSource::Environment(wi), f32::INFINITY);
        let weight = Rgb::ZERO;
        (pdf > 0.0).then_some(LightSample { source, wi, distance, weight, pdf: Some(pdf) })
    }

    /// `light`, and if it is from the environment with its radiance; none if that is black. In a room most of these are
    /// occluded, and the panorama is so large that to look up one pixel takes as long as much of the ray.
    #[inline]
    pub(crate) fn looked_up(&self, light: LightSample) -> Option<LightSample> {
        let LightSource::Environment(wi) = light.source else { return Some(light) };
        let weight = self.environment(wi) / light.pdf?;
        (weight.max_element() > 0.0).then_some(LightSample { weight, ..light })
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
        LightKind::Profiled { intensity, profile, .. } => {
            profile.steradians() as f32 * luminance(*intensity)
        }
    }
}

#[cfg(test)]
mod tests;
