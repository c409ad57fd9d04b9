//! Light transport: unidirectional path tracing with next-event estimation and multiple importance
//! sampling by the balance heuristic [Kajiya 1986; Veach 1997].
//!
//! At every surface the radiance that leaves towards `wo` is what it emits plus
//! `integral f(wo, wi) L(wi) cos_i dwi`. The integral is estimated by one light sample and one
//! direction drawn from the reflectance; the direction's ray goes on as the path. Light that both
//! could have found is shared out by their densities. Perfect mirrors take no light samples.

use crate::accel::{self, Ray};
use crate::bsdf::Bsdf;
use crate::sampler::Sampler;
use crate::seen::Lookup;
use crate::surface::{Frame, Surface};
use crate::tracer::{Appearance, Tracer};
use glam::Vec3;
use unrender_scene::Rgb;

/// Paths longer than this end; in a closed room that reflects 95 % they carry e^-25 of the light.
pub const MAX_BOUNCES: u32 = 500;
/// From this bounce on, paths that carry little light end at random.
const ROULETTE_FROM: u32 = 3;
/// A path survives a bounce with this probability at most, so that none lives for ever.
const SURVIVAL_MAX: f32 = 0.98;

/// The light transport of one scene under one appearance.
#[derive(Clone, Copy)]
pub struct Transport<'a> {
    tracer: &'a Tracer,
    appearance: Appearance<'a>,
    max_bounces: u32,
    seen: Option<Lookup<'a>>,
}

impl<'a> Transport<'a> {
    /// Transport with at most `max_bounces` reflections along a path; one means direct light only.
    ///
    /// # Panics
    /// Later, if the appearance has fewer materials than groups.
    pub fn new(tracer: &'a Tracer, appearance: Appearance<'a>, max_bounces: u32) -> Self {
        Self { tracer, appearance, max_bounces, seen: None }
    }

    /// The same transport, but paths end where `seen` knows the radiance.
    pub fn ending_at(self, seen: Option<Lookup<'a>>) -> Self {
        Self { seen, ..self }
    }

    /// The nearest surface along the ray.
    pub fn surface(&self, ray: &Ray) -> Option<Surface> {
        self.tracer.surface(ray)
    }

    /// A ray that leaves `surface` along `wi` without meeting it again.
    pub fn leave(surface: &Surface, wi: Vec3) -> Ray {
        Ray::new(accel::offset(surface.point, surface.geometric_normal), wi)
    }

    /// The radiance that `surface` emits to its viewer: from the front only.
    pub fn emitted(&self, surface: &Surface) -> Rgb {
        if !surface.front {
            return Rgb::ZERO;
        }
        self.tracer.emitters.radiance(surface.triangle) * self.appearance.light(surface.group)
    }

    /// The reflectance at `surface` and the brushed frame that it lives in.
    pub fn bsdf(&self, surface: &Surface) -> (Bsdf, Frame) {
        let material = &self.appearance.materials[surface.group as usize];
        let bsdf = Bsdf::new(material, material.rho_d_at(surface.uv), self.tracer.model);
        (bsdf, surface.frame.brushed(material.theta_rad))
    }

    /// All radiance that arrives along the ray. Counts the first surface's reflection as the
    /// reflection number `bounce`, from zero.
    pub fn radiance(&self, ray: &Ray, sampler: &mut Sampler, bounce: u32) -> Rgb {
        let Some(surface) = self.surface(ray) else { return Rgb::ZERO };
        self.emitted(&surface) + self.reflected(surface, -ray.direction, sampler, bounce)
    }

    /// The radiance that `surface` reflects into `wo` (world space), emission left out.
    pub fn reflected(
        &self,
        mut surface: Surface,
        mut wo: Vec3,
        sampler: &mut Sampler,
        bounce: u32,
    ) -> Rgb {
        let mut radiance = Rgb::ZERO;
        let mut throughput = Rgb::ONE;
        for bounce in bounce..self.max_bounces {
            if let Some(known) = self.seen.and_then(|seen| seen.radiance(&surface)) {
                return radiance + throughput * known;
            }
            let (bsdf, frame) = self.bsdf(&surface);
            if bsdf.is_black() {
                break;
            }
            let wo_local = frame.local_from_world(wo);

            // Light that comes straight from an emitter.
            let [pick, u, v, _] = sampler.next4();
            if !bsdf.is_pure_mirror() {
                radiance +=
                    throughput * self.direct(&surface, &bsdf, &frame, wo_local, [pick, u, v]);
            }

            // Light from the direction in which the path goes on.
            let [lobe, u, v, survival] = sampler.next4();
            let Some(sample) = bsdf.sample(wo_local, [lobe, u, v]) else { break };
            let wi = frame.world_from_local(sample.wi);
            if !surface.is_above(wi) {
                break;
            }
            throughput *= sample.weight;

            // Possibly end the path.
            if bounce >= ROULETTE_FROM {
                let probability = throughput.max_element().min(SURVIVAL_MAX);
                if survival >= probability {
                    break;
                }
                throughput /= probability;
            }

            let Some(next) = self.surface(&Self::leave(&surface, wi)) else { break };
            let emitted = self.emitted(&next);
            if emitted != Rgb::ZERO {
                let share = if sample.pdf.is_finite() {
                    sample.pdf / (sample.pdf + self.light_pdf(&surface, &next, wi))
                } else {
                    1.0
                };
                radiance += throughput * emitted * share;
            }
            (surface, wo) = (next, -wi);
        }
        radiance
    }

    /// The density over solid angle with which light samples at `from` find `emitter` along `wi`.
    pub fn light_pdf(&self, from: &Surface, emitter: &Surface, wi: Vec3) -> f32 {
        let distance = (emitter.point - from.point).length();
        let cos = -wi.dot(self.tracer.accel.front_normal(emitter.triangle));
        self.tracer.emitters.pdf(emitter.triangle, distance, cos)
    }

    /// One light sample, weighted against what the reflectance's own sampling finds.
    fn direct(&self, at: &Surface, bsdf: &Bsdf, frame: &Frame, wo: Vec3, u: [f32; 3]) -> Rgb {
        let origin = accel::offset(at.point, at.geometric_normal);
        let Some(light) = self.tracer.emitters.sample(origin, u) else { return Rgb::ZERO };
        if !at.is_above(light.wi) {
            return Rgb::ZERO;
        }
        let wi = frame.local_from_world(light.wi);
        let f = bsdf.value(wo, wi) * wi.z;
        if f.max_element() <= 0.0 || !self.is_free(origin, light.wi, light.distance) {
            return Rgb::ZERO;
        }
        let share = light.pdf.map_or(1.0, |pdf| pdf / (pdf + bsdf.pdf(wo, wi)));
        f * light.weight * self.appearance.light(light.source) * share
    }

    /// Whether nothing stands between `origin` and a light at `distance` along `wi`.
    fn is_free(&self, origin: Vec3, wi: Vec3, distance: f32) -> bool {
        let t_max = distance * (1.0 - 1e-5);
        !self.tracer.accel.occluded(&Ray { origin, direction: wi, t_max })
    }

    /// A light sample at a surface for any reflectance: the direction, its weight (radiance over
    /// density, or irradiance over probability), and its density if other rays can find the light.
    pub fn visible_light(&self, at: &Surface, u: [f32; 3]) -> Option<(Vec3, Rgb, Option<f32>)> {
        let origin = accel::offset(at.point, at.geometric_normal);
        let light = self.tracer.emitters.sample(origin, u)?;
        let seen = at.is_above(light.wi) && self.is_free(origin, light.wi, light.distance);
        let weight = light.weight * self.appearance.light(light.source);
        seen.then_some((light.wi, weight, light.pdf))
    }
}
