//! Where light comes from: emitting triangles, lights without a surface and the environment, drawn
//! by their power.
//!
//! A triangle is drawn with a probability proportional to its power, then a point on it uniformly,
//! which gives over solid angle the density `p d^2 / (A cos)`. Directions to the environment are
//! drawn by [`crate::environment`].

use crate::accel;
use crate::environment::EnvironmentSampler;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Light, LightKind, Rgb};

/// All lights of a scene.
#[derive(Debug)]
pub struct Emitters {
    triangles: Vec<EmittingTriangle>,
    punctual: Vec<LightKind>,
    /// The source of the first punctual light; the others follow.
    first_punctual: u32,
    environment: Option<EnvironmentSampler>,
    /// The probability of the environment.
    environment_share: f32,
    /// Running sum of the powers: the triangles', the lights', the environment's; ends with one.
    cumulative: Vec<f32>,
    /// For each triangle of the scene: its index in `triangles`, or `NONE`. Empty without any.
    index_of: Vec<u32>,
}

const NONE: u32 = u32::MAX;

#[derive(Debug)]
struct EmittingTriangle {
    source: u32,
    corners: [Vec3; 3],
    normal: Vec3,
    radiance: Rgb,
    /// Probability of the triangle over its area, m^-2.
    density: f32,
}

/// Light that would arrive at a point if nothing stood between.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Which source it is: the group that emits, or the number of groups plus the light's index,
    /// or plus the number of lights for the environment.
    pub source: u32,
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// How far a shadow ray must be free.
    pub distance: f32,
    /// Radiance over `pdf` for a triangle or the environment, irradiance at a surface that faces the light over the
    /// probability for the others.
    pub weight: Rgb,
    /// Density over solid angle; none for lights that no other ray can meet.
    pub pdf: Option<f32>,
}

impl Emitters {
    /// The emitters among `triangles`, whose source and radiance `emission` knows, and `lights`
    /// with the source of the first; `bounds` is the box around the scene, which `environment`
    /// surrounds.
    pub fn new(
        triangles: &[[Vec3; 3]],
        emission: impl Fn(usize) -> (u32, Rgb),
        (lights, first_punctual): (&[Light], u32),
        bounds: [Vec3; 2],
        environment: Option<&Environment>,
    ) -> Self {
        let mut emitting = Vec::new();
        let mut powers = Vec::new();
        let mut index_of = vec![NONE; triangles.len()];
        for (index, corners) in triangles.iter().enumerate() {
            let (source, radiance) = emission(index);
            let power = PI * area(corners) * luminance(radiance);
            if power > 0.0 {
                index_of[index] = emitting.len() as u32;
                let normal = accel::front_normal(*corners);
                emitting.push(EmittingTriangle {
                    source,
                    corners: *corners,
                    normal,
                    radiance,
                    density: 0.0,
                });
                powers.push(power);
            }
        }
        let punctual: Vec<_> = lights.iter().map(|l| l.kind).collect();
        let radius2 = 0.25 * (bounds[1] - bounds[0]).length_squared();
        powers.extend(punctual.iter().map(|kind| power(kind, radius2)));
        let environment = environment.and_then(EnvironmentSampler::new);
        // What it brings to the scene, as with directional lights.
        let of_environment = environment.as_ref().map(|e| PI * radius2 * e.flux());
        powers.extend(of_environment);
        let total: f64 = powers.iter().map(|p| f64::from(*p)).sum();
        let share = |p: f32| (f64::from(p) / total) as f32;
        for (triangle, p) in emitting.iter_mut().zip(&powers) {
            triangle.density = share(*p) / area(&triangle.corners);
        }
        let mut sum = 0.0;
        let cumulative = powers
            .iter()
            .map(|p| {
                sum += f64::from(*p) / total;
                sum as f32
            })
            .collect();
        let environment_share = of_environment.map_or(0.0, share);
        Self {
            triangles: emitting,
            punctual,
            first_punctual,
            environment,
            environment_share,
            cumulative,
            index_of,
        }
    }

    /// The number of sources: all groups, whether they emit or not, the lights without a surface,
    /// and the environment, whether there is one or not.
    pub fn source_count(&self) -> usize {
        self.environment_source() as usize + 1
    }

    /// The source that the environment is: the last one.
    pub fn environment_source(&self) -> u32 {
        self.first_punctual + self.punctual.len() as u32
    }

    /// The radiance that comes from the environment along the unit vector `wi`; zero if there is
    /// none.
    #[inline]
    pub fn environment(&self, wi: Vec3) -> Rgb {
        self.environment.as_ref().map_or(Rgb::ZERO, |environment| environment.radiance(wi))
    }

    /// The density over solid angle with which [`Emitters::sample`] draws `wi` to the environment.
    pub fn environment_pdf(&self, wi: Vec3) -> f32 {
        self.environment.as_ref().map_or(0.0, |e| self.environment_share * e.pdf(wi))
    }

    /// The radiance that a triangle emits from its front.
    pub fn radiance(&self, triangle: u32) -> Rgb {
        match self.index_of[triangle as usize] {
            NONE => Rgb::ZERO,
            index => self.triangles[index as usize].radiance,
        }
    }

    /// The density over solid angle with which [`Emitters::sample`] draws a ray that meets the
    /// front of `triangle` at `distance` under the cosine `cos` to its normal.
    pub fn pdf(&self, triangle: u32, distance: f32, cos: f32) -> f32 {
        match self.index_of[triangle as usize] {
            NONE => 0.0,
            index => self.triangles[index as usize].density * distance * distance / cos.max(1e-6),
        }
    }

    /// Draws light for the surface point `point` from three numbers in [0, 1).
    pub fn sample(&self, point: Vec3, u: [f32; 3]) -> Option<LightSample> {
        let chosen = self.cumulative.partition_point(|&c| c <= u[0]);
        let chosen = chosen.min(self.cumulative.len().checked_sub(1)?);
        if let Some(triangle) = self.triangles.get(chosen) {
            return triangle.sample(point, [u[1], u[2]]);
        }
        let before = if chosen == 0 { 0.0 } else { self.cumulative[chosen - 1] };
        let probability = self.cumulative[chosen] - before;
        let index = chosen - self.triangles.len();
        if index == self.punctual.len() {
            return self.sample_environment([u[1], u[2]]);
        }
        let (wi, distance, irradiance) = self.punctual[index].illuminate(point);
        if irradiance.max_element() <= 0.0 || probability <= 0.0 {
            return None;
        }
        let source = self.first_punctual + index as u32;
        Some(LightSample { source, wi, distance, weight: irradiance / probability, pdf: None })
    }

    fn sample_environment(&self, u: [f32; 2]) -> Option<LightSample> {
        let environment = self.environment.as_ref()?;
        let (wi, pdf) = environment.sample(u);
        let pdf = self.environment_share * pdf;
        let radiance = environment.radiance(wi);
        if pdf <= 0.0 || radiance.max_element() <= 0.0 {
            return None;
        }
        let (source, distance) = (self.environment_source(), f32::INFINITY);
        Some(LightSample { source, wi, distance, weight: radiance / pdf, pdf: Some(pdf) })
    }
}

impl EmittingTriangle {
    fn sample(&self, point: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let root = u[0].sqrt();
        let (b, c) = (root * (1.0 - u[1]), root * u[1]);
        let on_light = self.corners[0] * (1.0 - b - c) + self.corners[1] * b + self.corners[2] * c;
        let to_light = accel::offset(on_light, self.normal) - point;
        let distance = to_light.length();
        let wi = to_light / distance;
        let cos = -wi.dot(self.normal);
        if cos <= 0.0 || !wi.is_finite() {
            return None;
        }
        let pdf = self.density * distance * distance / cos.max(1e-6);
        let weight = self.radiance / pdf;
        Some(LightSample { source: self.source, wi, distance, weight, pdf: Some(pdf) })
    }
}

fn area([a, b, c]: &[Vec3; 3]) -> f32 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// The power of a light without a surface, W; what a directional one brings to the scene.
pub(crate) fn power(kind: &LightKind, scene_radius2: f32) -> f32 {
    match kind {
        LightKind::Point { intensity, .. } => 4.0 * PI * luminance(*intensity),
        LightKind::Spot { intensity, inner_rad, outer_rad, .. } => {
            TAU * (1.0 - 0.5 * (inner_rad.cos() + outer_rad.cos())) * luminance(*intensity)
        }
        LightKind::Directional { irradiance, .. } => PI * scene_radius2 * luminance(*irradiance),
    }
}
