//! Triangles that emit.

use super::bounds::LightBounds;
use super::pool::Emitter;
use super::{LightSample, TriangleEmission};
use crate::accel;
use crate::appearance::LightSource;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use std::num::NonZeroU32;
use unrender_scene::Rgb;
use unrender_scene::color::luminance;

/// An index into `Emitters::triangles`, stored plus one so that an option of it has four bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmittingIndex(NonZeroU32);

impl EmittingIndex {
    pub(super) fn at(index: usize) -> Self {
        Self(NonZeroU32::MIN.saturating_add(index as u32))
    }

    #[inline]
    pub(super) fn get(self) -> usize {
        self.0.get() as usize - 1
    }
}

/// A triangle that emits, in one cache line: a lamp may have thousands of them, and each sample reads another one.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct EmittingTriangle {
    corner: Vec3,
    /// From the corner to the other two.
    edges: [Vec3; 2],
    /// Unit normal of the front.
    normal: Vec3,
    /// How far before it shadow rays to it end, metres.
    clearance: f32,
    /// The index of its emission.
    pub(super) emission: u32,
    pub(super) pool: u32,
    /// Probability of the triangle, given its pool, over its area, m^-2.
    pub(super) density: f32,
}

impl EmittingTriangle {
    /// Its pool and density are set once all lights are known.
    pub(super) fn new(emission: u32, corners: [Vec3; 3]) -> Self {
        let [corner, b, c] = corners;
        let edges = [b - corner, c - corner];
        let (normal, clearance) = (accel::front_normal(corners), accel::clearance(corners));
        Self { corner, edges, normal, clearance, emission, pool: 0, density: 0.0 }
    }

    /// Square metres.
    pub(super) fn area(&self) -> f32 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    pub(super) fn bounds(&self, light: Emitter, radiance: Rgb) -> LightBounds {
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
    pub(super) fn sample(
        &self,
        emission: &TriangleEmission,
        point: Vec3,
        probability: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let root = u[0].sqrt();
        let (b, c) = (root * (1.0 - u[1]), root * u[1]);
        let on_light = self.corner + self.edges[0] * b + self.edges[1] * c;
        let to_light = on_light + self.clearance * self.normal - point;
        let distance2 = to_light.length_squared();
        let (distance, inverse) = (distance2.sqrt(), 1.0 / distance2.sqrt());
        let wi = to_light * inverse;
        let cos = -wi.dot(self.normal);
        // At the point itself neither is finite.
        if !(cos > 0.0 && inverse.is_finite()) {
            return None;
        }
        let pdf = probability * self.density * distance2 / cos.max(1e-6);
        let source = LightSource::Group(emission.group);
        let weight = emission.radiance * (1.0 / pdf);
        Some(LightSample { source, wi, distance, weight, pdf: Some(pdf) })
    }
}
