//! Where light comes from: emitting triangles, lights without a surface and the environment, drawn
//! by what they may bring to the point that asks.
//!
//! First a cluster of lights is drawn (`cluster`), or a light that is far away, then a light of it by
//! its strength, and on a triangle a point uniformly, which gives over solid angle the density
//! `p d^2 / (A cos)`. Directions to the environment are drawn by [`crate::environment`].

mod cluster;

use crate::accel;
use crate::environment::EnvironmentSampler;
use cluster::{Beacon, Bounds, CLUSTERS_MAX, Cluster};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Light, LightKind, Rgb};

/// Bounds know nothing of what stands in between; so this share of the probability goes to all
/// lights that may bring something, by their power.
const BY_POWER: f32 = 0.2;
/// The choice that the lights infinitely far away are, after all clusters.
const FAR: usize = CLUSTERS_MAX;
/// The choice that the environment is.
const SKY: usize = FAR + 1;
const CHOICES: usize = SKY + 1;

/// All lights of a scene.
#[derive(Debug)]
pub struct Emitters {
    triangles: Vec<EmittingTriangle>,
    punctual: Vec<LightKind>,
    /// The source of the first punctual light; the others follow.
    first_punctual: u32,
    environment: Option<EnvironmentSampler>,
    /// What is drawn first: a cluster, the lights at [`FAR`] or at [`SKY`]. Some are empty.
    choices: [Choice; CHOICES],
    /// The only choice there is, if so.
    sole: Option<usize>,
    /// What clusters may bring.
    bounds: Bounds,
    /// Luminance of the irradiance that the other choices bring, W m^-2.
    irradiances: [f32; CHOICES],
    /// What each choice brings to the scene, W.
    powers: [f32; CHOICES],
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
    /// Its choice.
    choice: usize,
    /// Probability of the triangle, given its choice, over its area, m^-2.
    density: f32,
}

/// Lights that are drawn together.
#[derive(Debug, Default)]
struct Choice {
    /// The lights: indices among the triangles, the punctual lights and the environment, in this
    /// order.
    lights: Vec<usize>,
    /// Running sums of their probabilities, given the choice; ends with one.
    cumulative: Vec<f32>,
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
        let mut index_of = vec![NONE; triangles.len()];
        for (index, corners) in triangles.iter().enumerate() {
            let (source, radiance) = emission(index);
            if area(corners) * luminance(radiance) > 0.0 {
                index_of[index] = emitting.len() as u32;
                emitting.push(EmittingTriangle::new(source, *corners, radiance));
            }
        }
        let mut emitters = Self {
            triangles: emitting,
            punctual: lights.iter().map(|l| l.kind).collect(),
            first_punctual,
            environment: environment.and_then(EnvironmentSampler::new),
            choices: Default::default(),
            sole: None,
            bounds: Bounds::default(),
            irradiances: [0.0; CHOICES],
            powers: [0.0; CHOICES],
            index_of,
        };
        emitters.choose(0.5 * (bounds[1] - bounds[0]).length());
        for (index, choice) in emitters.choices.iter().enumerate() {
            for (place, &light) in choice.lights.iter().enumerate() {
                if let Some(triangle) = emitters.triangles.get_mut(light) {
                    triangle.choice = index;
                    triangle.density = choice.probability(place) / area(&triangle.corners);
                }
            }
        }
        emitters
    }

    /// Makes out what is to be drawn first; `radius` is that of the scene.
    fn choose(&mut self, radius: f32) {
        let first = self.triangles.len();
        let triangles = self.triangles.iter().enumerate();
        let mut beacons: Vec<_> = triangles.map(|(index, t)| t.beacon(index)).collect();
        let mut far = Vec::new();
        for (index, kind) in self.punctual.iter().enumerate() {
            let strength = luminance(kind.strength());
            match Beacon::at_point(first + index, kind) {
                _ if strength <= 0.0 => {}
                Some(beacon) => beacons.push(beacon),
                None => far.push((first + index, strength)),
            }
        }
        let clusters = Cluster::all(beacons, radius);
        self.bounds = Bounds::new(&clusters);
        let near = clusters.iter().map(|cluster| {
            cluster.members.iter().map(|m| (m.index, m.strength)).collect::<Vec<_>>()
        });
        let sky = self.environment.as_ref().map(|_| (first + self.punctual.len(), 1.0));
        let mut choices: Vec<_> = near.collect();
        choices.resize(FAR, Vec::new());
        choices.extend([far, sky.into_iter().collect()]);
        for (index, lights) in choices.into_iter().enumerate() {
            let power = |light: &(usize, f32)| self.power(light.0, radius * radius);
            self.powers[index] = lights.iter().map(power).sum();
            self.irradiances[index] = match &self.environment {
                Some(environment) if index == SKY => 0.5 * environment.flux(),
                _ if index == FAR => lights.iter().map(|light| light.1).sum(),
                _ => 0.0,
            };
            self.choices[index] = Choice::new(&lights);
        }
        let mut filled = (0..CHOICES).filter(|&i| !self.choices[i].lights.is_empty());
        self.sole = filled.next().filter(|_| filled.next().is_none());
    }

    /// The power of a triangle or of a light without a surface, W.
    fn power(&self, light: usize, scene_radius2: f32) -> f32 {
        if let Some(triangle) = self.triangles.get(light) {
            return PI * area(&triangle.corners) * luminance(triangle.radiance);
        }
        match self.punctual.get(light - self.triangles.len()) {
            Some(kind) => power(kind, scene_radius2),
            // As with directional lights.
            None => self.environment.as_ref().map_or(0.0, |e| PI * scene_radius2 * e.flux()),
        }
    }

    /// Whether there is more than one cluster of lights.
    pub fn are_several(&self) -> bool {
        self.sole.is_none() && !self.choices.iter().all(|choice| choice.lights.is_empty())
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

    /// The density over solid angle with which [`Emitters::sample`] at `point` draws `wi` to the
    /// environment.
    pub fn environment_pdf(&self, point: Vec3, wi: Vec3) -> f32 {
        let Some(environment) = &self.environment else { return 0.0 };
        self.odds_of(SKY, point) * environment.pdf(wi)
    }

    /// The radiance that a triangle emits from its front.
    pub fn radiance(&self, triangle: u32) -> Rgb {
        match self.index_of[triangle as usize] {
            NONE => Rgb::ZERO,
            index => self.triangles[index as usize].radiance,
        }
    }

    /// The density over solid angle with which [`Emitters::sample`] at `point` draws a ray that
    /// meets the front of `triangle` at `distance` under the cosine `cos` to its normal.
    pub fn pdf(&self, point: Vec3, triangle: u32, distance: f32, cos: f32) -> f32 {
        match self.index_of[triangle as usize] {
            NONE => 0.0,
            index => {
                let triangle = &self.triangles[index as usize];
                let odds = self.odds_of(triangle.choice, point);
                odds * triangle.density * distance * distance / cos.max(1e-6)
            }
        }
    }

    /// The probability of one choice at `point`.
    #[inline]
    fn odds_of(&self, choice: usize, point: Vec3) -> f32 {
        match self.sole {
            Some(sole) => f32::from(u8::from(sole == choice)),
            None => self.odds(point)[choice],
        }
    }

    /// The probability of each choice at `point`, where there are several; all zero where no light
    /// comes.
    fn odds(&self, point: Vec3) -> [f32; CHOICES] {
        let mut odds = self.irradiances;
        odds[..CLUSTERS_MAX].copy_from_slice(&self.bounds.importances(point));
        let (mut sum, mut power) = (0.0, 0.0);
        for (importance, of_choice) in odds.iter().zip(&self.powers) {
            sum += importance;
            power += if *importance > 0.0 { *of_choice } else { 0.0 };
        }
        let by_bound = (1.0 - BY_POWER) / sum.max(f32::MIN_POSITIVE);
        let by_power = BY_POWER / power.max(f32::MIN_POSITIVE);
        for (importance, of_choice) in odds.iter_mut().zip(&self.powers) {
            let probability = *importance * by_bound + of_choice * by_power;
            *importance = if *importance > 0.0 { probability } else { 0.0 };
        }
        odds
    }

    /// Draws a choice for `point` by a number in [0, 1): its probability, and a number for what is drawn
    /// next.
    #[inline]
    fn draw(&self, point: Vec3, u: f32) -> Option<(&Choice, f32, f32)> {
        if let Some(sole) = self.sole {
            return Some((&self.choices[sole], 1.0, u));
        }
        // The last one that is possible, should the rounded sum of all be less than one.
        let mut drawn = None;
        let mut before = 0.0;
        for (choice, probability) in self.choices.iter().zip(self.odds(point)) {
            if probability > 0.0 {
                drawn = Some((choice, probability, (u - before) / probability));
                before += probability;
                if u < before {
                    break;
                }
            }
        }
        drawn
    }

    /// Draws light for the surface point `point` from three numbers in [0, 1).
    pub fn sample(&self, point: Vec3, u: [f32; 3]) -> Option<LightSample> {
        let (choice, probability, within) = self.draw(point, u[0])?;
        let place = choice.cumulative.partition_point(|&c| c <= within);
        let place = place.min(choice.lights.len() - 1);
        let light = choice.lights[place];
        if let Some(triangle) = self.triangles.get(light) {
            return triangle.sample(point, probability, [u[1], u[2]]);
        }
        let index = light - self.triangles.len();
        let Some(kind) = self.punctual.get(index) else {
            return self.sample_environment(probability, [u[1], u[2]]);
        };
        let (wi, distance, irradiance) = kind.illuminate(point);
        if irradiance.max_element() <= 0.0 {
            return None;
        }
        let source = self.first_punctual + index as u32;
        let weight = irradiance / (probability * choice.probability(place));
        Some(LightSample { source, wi, distance, weight, pdf: None })
    }

    fn sample_environment(&self, probability: f32, u: [f32; 2]) -> Option<LightSample> {
        let environment = self.environment.as_ref()?;
        let (wi, pdf) = environment.sample(u);
        let pdf = probability * pdf;
        let radiance = environment.radiance(wi);
        if pdf <= 0.0 || radiance.max_element() <= 0.0 {
            return None;
        }
        let (source, distance) = (self.environment_source(), f32::INFINITY);
        Some(LightSample { source, wi, distance, weight: radiance / pdf, pdf: Some(pdf) })
    }
}

impl Choice {
    /// Of some lights, each with its strength.
    fn new(lights: &[(usize, f32)]) -> Self {
        let total: f64 = lights.iter().map(|light| f64::from(light.1)).sum();
        let running = lights.iter().scan(0.0, |sum, light| {
            *sum += f64::from(light.1) / total;
            Some(*sum as f32)
        });
        Self { cumulative: running.collect(), lights: lights.iter().map(|light| light.0).collect() }
    }

    /// The probability of the light at a place among these, given that they were chosen.
    fn probability(&self, place: usize) -> f32 {
        let before = if place == 0 { 0.0 } else { self.cumulative[place - 1] };
        self.cumulative[place] - before
    }
}

impl EmittingTriangle {
    /// Before its probability is known.
    fn new(source: u32, corners: [Vec3; 3], radiance: Rgb) -> Self {
        let normal = accel::front_normal(corners);
        Self { source, corners, normal, radiance, choice: 0, density: 0.0 }
    }

    fn beacon(&self, index: usize) -> Beacon {
        let centre = self.corners.iter().sum::<Vec3>() / 3.0;
        let radius = self.corners.iter().map(|c| c.distance(centre)).fold(0.0, f32::max);
        let strength = area(&self.corners) * luminance(self.radiance);
        Beacon { index, centre, radius, axis: self.normal, reach_rad: FRAC_PI_2, strength }
    }

    /// A point of it, given the probability of its choice.
    fn sample(&self, point: Vec3, probability: f32, u: [f32; 2]) -> Option<LightSample> {
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
        let pdf = probability * self.density * distance * distance / cos.max(1e-6);
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

#[cfg(test)]
mod tests;
