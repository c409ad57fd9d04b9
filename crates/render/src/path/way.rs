//! The way of a ray through glass to the first surface of a group.
//!
//! At each face of glass the ray is reflected or goes on, at random, with the probability of what light does: so what it
//! brings back has the weight one, but for what glass colours and absorbs ([`unrender_scene::glass`]). Faces are smooth.
//! A ray that passed panes alone went straight: light samples find the same light
//! ([`Transport::passage`]), and both are weighted against each other. Light that was bent or reflected on the way, as of
//! a caustic, is found by drawn directions alone.

use super::{RayHit, Transport};
use crate::accel::{Hit, Ray};
use crate::surface::Surface;
use crate::veil::{Passage, Through, Veil, absorbed};
use glam::Vec3;
use unrender_scene::{Glass, Rgb};

/// Most faces of glass on a way; what is reflected to and fro longer is less than 1e-5 of the light. At half of it stacks
/// of tumblers darken, at double of it nothing changes.
const FACES_MAX: usize = 64;

/// Where a ray arrives behind glass.
#[derive(Clone, Copy)]
pub(crate) struct Way {
    /// Unit vector along which it arrives.
    pub(crate) direction: Vec3,
    /// What it passed; of a way that is not straight the probability is one.
    pub(crate) passage: Passage,
    /// Whether it went straight.
    pub(crate) is_straight: bool,
    /// Whether nothing happened on it.
    pub(crate) is_open: bool,
}

impl Way {
    /// That of a ray along `direction` without glass.
    #[inline]
    fn open(direction: Vec3) -> Self {
        Self { direction, passage: Passage::OPEN, is_straight: true, is_open: true }
    }
}

impl Transport<'_> {
    /// What `ray` hits, by a way through glass that the numbers of `choose` in [0, 1) choose.
    #[inline]
    pub(crate) fn follow(&self, ray: &Ray, choose: impl FnMut() -> f32) -> RayHit {
        match self.tracer.veil.as_ref().filter(|veil| veil.has_glass()) {
            None => self.arrived(self.tracer.surface(ray), Way::open(ray.direction)),
            Some(veil) => self.follow_through(veil, *ray, choose),
        }
    }

    /// The surface of a group that `ray` shows: behind glass the one that most of its light comes from.
    pub fn shown(&self, ray: &Ray) -> Option<Surface> {
        // The largest of the numbers takes what has a chance of being reflected onwards.
        self.follow(ray, || 1.0).surface
    }

    #[inline]
    fn arrived(&self, surface: Option<Surface>, way: Way) -> RayHit {
        let emission = match &surface {
            Some(surface) => self.emission(surface),
            None => self.background(way.direction),
        };
        RayHit { surface, emission, way }
    }

    // Few scenes have glass.
    #[inline(never)]
    fn follow_through(&self, veil: &Veil, mut ray: Ray, mut choose: impl FnMut() -> f32) -> RayHit {
        let shapes = &self.tracer.shapes;
        let mut way = Way::open(ray.direction);
        for _ in 0..FACES_MAX {
            let hit = veil.next(shapes, &ray, self.tracer.accel.closest(&ray));
            let glass = hit.and_then(|hit| Some((hit, shapes.glass(hit.triangle)?)));
            let Some((hit, glass)) = glass else {
                let surface = hit.map(|hit| shapes.surface_at(&ray, hit));
                way.direction = ray.direction;
                if !way.is_straight {
                    way.passage.probability = 1.0;
                }
                way.is_open = way.is_straight && way.passage == Passage::OPEN;
                return self.arrived(surface, way);
            };
            ray = self.pass(&ray, &hit, glass, choose(), &mut way);
        }
        // What is left is black.
        way.passage.filter = Rgb::ZERO;
        way.is_open = false;
        RayHit { surface: None, emission: self.background(ray.direction), way }
    }

    /// The ray after the face of `glass` that `ray` hits, which the number `pick` in [0, 1) chooses.
    fn pass(&self, ray: &Ray, hit: &Hit, glass: &Glass, pick: f32, way: &mut Way) -> Ray {
        let shapes = &self.tracer.shapes;
        let surface = shapes.surface_at(ray, *hit);
        let is_inside = !surface.front && !glass.is_thin;
        if is_inside {
            way.passage.filter *= absorbed(glass, hit.t);
        }
        let facing = [surface.frame.normal, surface.geometric_normal];
        let normal = facing[usize::from(ray.direction.dot(facing[0]) >= 0.0)];
        let cos = -ray.direction.dot(normal);
        // Light is reflected alike from both sides of a face.
        let bend = if glass.is_thin {
            1.0
        } else if is_inside {
            glass.ior
        } else {
            1.0 / glass.ior
        };
        let cos_behind = (1.0 - bend * bend * (1.0 - cos * cos)).max(0.0).sqrt();
        let reflected = match (is_inside, cos_behind > 0.0) {
            (_, false) => 1.0,
            (true, true) => glass.reflected(cos_behind),
            (false, true) => glass.reflected(cos),
        };
        if pick < reflected {
            way.is_straight = false;
            let away = |normal: Vec3| ray.direction - 2.0 * ray.direction.dot(normal) * normal;
            let mut direction = away(normal);
            if direction.dot(surface.geometric_normal) <= 0.0 {
                direction = away(surface.geometric_normal);
            }
            return Ray::new(surface.start(), direction.normalize());
        }
        way.passage.filter *= glass.tint;
        way.passage.probability *= 1.0 - reflected;
        if glass.is_thin {
            return Ray { t_max: f32::INFINITY, ..shapes.behind(ray, hit) };
        }
        way.is_straight = false;
        let direction = bend * ray.direction + (bend * cos - cos_behind) * normal;
        let is_through = direction.dot(surface.geometric_normal) < 0.0;
        let direction = if is_through { direction.normalize() } else { ray.direction };
        Ray { direction, t_max: f32::INFINITY, ..shapes.behind(ray, hit) }
    }

    /// What passes from `origin` along `wi` over `distance`; none if something occludes it.
    #[inline]
    pub(crate) fn passage(
        &self,
        origin: Vec3,
        wi: Vec3,
        distance: f32,
        through: Through,
    ) -> Option<Passage> {
        let ray = Ray { origin, direction: wi, t_max: distance * super::direct::SHADOW_LENGTH };
        if self.tracer.accel.occluded(&ray) {
            return None;
        }
        match &self.tracer.veil {
            None => Some(Passage::OPEN),
            Some(veil) => veil.passage(&self.tracer.shapes, &ray, through),
        }
    }
}
