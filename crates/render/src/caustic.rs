//! Where a diffuse surface should look for the light that a shiny plane throws at it.
//!
//! A floor with a gloss throws a patch of light at the wall. Directions drawn by the cosine find the
//! few square metres of floor where lamp and wall see each other in it once in a hundred times, and
//! then it is bright: most of the noise of a picture, and of all that is fitted to it. For a plane
//! the place is known: it lies towards the lamp's mirror image. A share of the directions of a
//! diffuse surface is drawn about that, by a spherical Gaussian as wide as the gloss and the lamp
//! make the patch. It is one more strategy in the mixture that directions are drawn from, so it
//! biases nothing.
//!
//! Width: with the half vector tilted by `epsilon (1 + a/b) / 2` when the direction is off by
//! `epsilon` (`a` from here to the plane, `b` on to the lamp) and Ward's slopes of the deviation
//! `alpha/sqrt 2`, the patch has the deviation `sqrt 2 alpha / (1 + a/b)`, and the lamp's own.

use crate::surface::{Frame, Surface};
use crate::tracer::Appearance;
use glam::Vec3;
use std::f32::consts::TAU;
use unrender_scene::{LightKind, Scene};

/// The share of a diffuse surface's directions that is drawn towards mirror images.
const SHARE: f32 = 0.4;
/// Mirror images that one surface looks for at most.
const IMAGES_MAX: usize = 4;
/// Patches narrower than this (radians) are left to the mirror itself.
const DEVIATION_MIN: f32 = 2e-3;
/// Wider ones are found by the cosine well enough.
const DEVIATION_MAX: f32 = 0.5;
/// A patch reaches this many deviations beyond its centre.
const REACH: f32 = 3.0;

/// The planes and lamps of a scene.
#[derive(Debug, Default)]
pub(crate) struct Caustics {
    planes: Vec<Plane>,
    lamps: Vec<Lamp>,
}

/// A flat object.
#[derive(Clone, Copy, Debug)]
struct Plane {
    group: u32,
    point: Vec3,
    normal: Vec3,
    bounds: [Vec3; 2],
}

/// An area light as a ball, or a light at a point.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    centre: Vec3,
    radius: f32,
}

/// A plane that shines under one appearance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shiny {
    plane: Plane,
    alpha: f32,
}

/// One spherical Gaussian on the sphere of directions (von Mises-Fisher):
/// `pdf = kappa exp(kappa (cos - 1)) / (2 pi (1 - exp(-2 kappa)))`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Image {
    axis: Vec3,
    kappa: f32,
    norm: f32,
}

/// The mirror images that one surface looks for: nothing, or a few Gaussians of equal weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Images {
    images: [Image; IMAGES_MAX],
    count: usize,
}

impl Caustics {
    pub(crate) fn new(scene: &Scene) -> Self {
        let planes = scene.objects.iter().filter_map(|object| {
            let mesh = &object.mesh;
            let corners = || (0..mesh.triangles.len()).map(|i| mesh.corners(i));
            let normal_of = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize_or_zero();
            let first = corners().next()?;
            let normal = normal_of(first);
            let flat = |t: [Vec3; 3]| normal_of(t).dot(normal).abs() > 0.9999;
            let smooth = mesh.normals.iter().all(|n| n.dot(normal).abs() > 0.9999);
            let reach = |p: Vec3| (p - first[0]).dot(normal).abs();
            let (low, high) = bounds(corners().flatten());
            let thin = corners().flatten().all(|p| reach(p) <= 1e-4 * (high - low).length());
            let plane =
                Plane { group: object.group as u32, point: first[0], normal, bounds: [low, high] };
            (corners().all(flat) && smooth && thin).then_some(plane)
        });
        let area = scene.objects.iter().filter(|o| scene.groups[o.group].is_emitter()).map(|o| {
            let (low, high) = bounds(o.mesh.positions.iter().copied());
            Lamp { centre: 0.5 * (low + high), radius: 0.5 * (high - low).length() }
        });
        let points = scene.lights.iter().filter_map(|light| match light.kind {
            LightKind::Point { position, .. } | LightKind::Spot { position, .. } => {
                Some(Lamp { centre: position, radius: 0.0 })
            }
            LightKind::Directional { .. } => None,
        });
        Self { planes: planes.collect(), lamps: area.chain(points).collect() }
    }

    /// The planes that shine under `appearance`.
    pub(crate) fn shiny(&self, appearance: &Appearance<'_>) -> Vec<Shiny> {
        let shines = |plane: &Plane| {
            let material = appearance.materials.get(plane.group as usize)?;
            let alpha = (material.alpha_x * material.alpha_y).sqrt();
            (material.rho_s.max_element() > 0.0).then_some(Shiny { plane: *plane, alpha })
        };
        self.planes.iter().filter_map(shines).collect()
    }

    /// The mirror images in `shiny` planes that light may reach `surface` from, in `frame`.
    pub(crate) fn images(&self, shiny: &[Shiny], surface: &Surface, frame: &Frame) -> Images {
        let mut images = Images::NONE;
        for plane in shiny {
            for lamp in &self.lamps {
                if images.count == IMAGES_MAX {
                    return images;
                }
                if let Some((direction, deviation)) = plane.image(lamp, surface) {
                    let axis = frame.local_from_world(direction);
                    images.images[images.count] = Image::new(axis, deviation);
                    images.count += 1;
                }
            }
        }
        images
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points.fold(nothing, |(low, high), p| (low.min(p), high.max(p)))
}

impl Shiny {
    /// The direction to the mirror image of `lamp` and the deviation of the patch about it, radians.
    fn image(&self, lamp: &Lamp, surface: &Surface) -> Option<(Vec3, f32)> {
        let Plane { point, normal, bounds, .. } = self.plane;
        let here = (surface.point - point).dot(normal);
        let there = (lamp.centre - point).dot(normal);
        // Both on one side, and neither in the plane.
        if here * there <= 0.0 || here.abs() < 1e-4 * there.abs() {
            return None;
        }
        let mirrored = lamp.centre - 2.0 * there * normal;
        let to_image = mirrored - surface.point;
        let distance = to_image.length();
        let direction = to_image / distance;
        if !surface.is_above(direction) {
            return None;
        }
        let share = here / (here + there);
        let of_gloss = std::f32::consts::SQRT_2 * self.alpha * (1.0 - share);
        let of_lamp = 0.5 * lamp.radius / distance;
        let deviation = of_gloss.hypot(of_lamp);
        let met = surface.point + share * to_image;
        let outside = met - met.clamp(bounds[0], bounds[1]);
        let reach = REACH * deviation * share * distance;
        let useful = (DEVIATION_MIN..DEVIATION_MAX).contains(&deviation);
        (useful && outside.length() <= reach).then_some((direction, deviation))
    }
}

impl Image {
    fn new(axis: Vec3, deviation: f32) -> Self {
        let kappa = 1.0 / (deviation * deviation);
        Self { axis, kappa, norm: kappa / (TAU * (1.0 - (-2.0 * kappa).exp())) }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        // 1 - cos from the difference of the vectors, which keeps its digits near the axis.
        self.norm * (-0.5 * self.kappa * (wi - self.axis).length_squared()).exp()
    }

    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let below = (-2.0 * self.kappa).exp();
        // 1 - cos theta, distributed as exp(-kappa (1 - cos)).
        let versine = -(1.0 - u[0] * (1.0 - below)).ln() / self.kappa;
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (y, x) = (TAU * u[1]).sin_cos();
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        self.axis * (1.0 - versine) + (tangent * x + bitangent * y) * sin
    }
}

impl Images {
    /// No mirror image anywhere.
    pub const NONE: Self =
        Self { images: [Image { axis: Vec3::Z, kappa: 0.0, norm: 0.0 }; IMAGES_MAX], count: 0 };

    /// The share of directions to draw towards images.
    pub(crate) fn share(&self) -> f32 {
        if self.count == 0 { 0.0 } else { SHARE }
    }

    fn all(&self) -> &[Image] {
        &self.images[..self.count]
    }

    /// The density of [`Images::sample`] over solid angle; zero without images.
    pub(crate) fn pdf(&self, wi: Vec3) -> f32 {
        let sum: f32 = self.all().iter().map(|image| image.pdf(wi)).sum();
        sum / self.count.max(1) as f32
    }

    /// Draws a direction; `pick` in [0, 1) chooses the image, of which there is at least one. It may
    /// fall below the surface.
    pub(crate) fn sample(&self, pick: f32, u: [f32; 2]) -> Vec3 {
        let image = ((pick * self.count as f32) as usize).min(self.count - 1);
        self.images[image].sample(u).normalize()
    }
}
