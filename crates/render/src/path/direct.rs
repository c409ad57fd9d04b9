//! Direct light: light samples at a vertex, straight and by way of planar mirrors, their densities, and
//! the weights of multiple importance sampling between them and directions drawn from the BRDF.

use super::{PathObserver, RayHit, Transport, Vertex};
use crate::accel::{Bundle, Occluders, Ray};
use crate::emitters::LightSample;
use crate::surface::Surface;
use crate::veil::{Passage, Through, Veil};
use crate::virtual_lamps::{MirrorTrail, MirrorsPassed, Passed, VirtualSample};
use glam::Vec3;
use unrender_scene::Rgb;

/// Shadow rays end at this share of the distance to the light, so that they do not hit the light
/// itself: about 170 units in the last place. With half of it large lamps may occlude themselves,
/// with double of it thin objects directly before a lamp are missed.
pub(super) const SHADOW_LENGTH: f32 = 1.0 - 1e-5;

/// Light from a light sample that is not occluded.
pub(crate) struct DirectLight<'a> {
    /// Unit vector towards the light, or towards the first mirror on the way, in the frame of the
    /// vertex.
    pub(crate) wi: Vec3,
    /// The BRDF times the cosine.
    pub(crate) f_cos: Rgb,
    pub(crate) sample: &'a LightSample,
    /// The mirrors on the way.
    pub(crate) passed: MirrorsPassed,
    /// The product of their reflectances, and what glass between them lets through.
    pub(crate) transmittance: Rgb,
    /// The weight of multiple importance sampling.
    pub(crate) mis: f32,
}

/// A light sample that is not occluded, for any BRDF.
pub struct VisibleLight {
    /// Unit vector towards the light, or towards the first mirror on the way, world space.
    pub wi: Vec3,
    /// Radiance over density, or of a punctual light irradiance over probability.
    pub weight: Rgb,
    /// The density over solid angle; none for punctual lights.
    pub pdf: Option<f32>,
    /// The probability with which a direction drawn as `wi` finds the same light: one, or the product of
    /// those with which the mirrors on the way reflect as mirrors, or with which it passes the panes.
    pub by_direction: f32,
}

/// A way by mirrors that nothing occludes.
struct OpenWay {
    passed: MirrorsPassed,
    transmittance: Rgb,
    /// The product of the probabilities with which the mirrors reflect as mirrors.
    probability: f32,
}

impl Transport<'_> {
    /// The density over solid angle with which light samples at `from` draw what `hit` emits; zero if nothing does, or
    /// not on a straight way.
    pub(crate) fn light_pdf(&self, from: &Surface, hit: &RayHit) -> f32 {
        let wi = hit.way.direction;
        match &hit.surface {
            _ if hit.emission.radiance == Rgb::ZERO || !hit.way.is_straight => 0.0,
            Some(surface) => self.triangle_pdf(from, surface, wi),
            None => self.environment_pdf(from, wi),
        }
    }

    /// The density over solid angle with which light samples at `from` draw `emitter` along `wi`.
    pub(crate) fn triangle_pdf(&self, from: &Surface, emitter: &Surface, wi: Vec3) -> f32 {
        let distance = (emitter.point - from.point).length();
        let cos = -wi.dot(self.tracer.front_normal(emitter.triangle));
        let origin = from.start();
        self.tracer.emitters.pdf(origin, emitter.triangle, distance, cos)
    }

    /// The density over solid angle with which light samples at `from` draw the environment along
    /// `wi`.
    pub(crate) fn environment_pdf(&self, from: &Surface, wi: Vec3) -> f32 {
        let origin = from.start();
        self.tracer.emitters.environment_pdf(origin, wi)
    }

    /// The weight of multiple importance sampling of what `hit` emits towards `from`, in a direction that was drawn with
    /// the density `pdf`, beside `lights` light samples. Behind a perfect mirror, where the density is infinite, `trail`
    /// says which other samples may find it.
    #[inline]
    pub(crate) fn share_of_direction(
        &self,
        from: &Surface,
        hit: &RayHit,
        (pdf, lights): (f32, u32),
        trail: Option<MirrorTrail>,
    ) -> f32 {
        if pdf.is_finite() {
            let pdf = pdf * hit.way.passage.probability;
            return pdf / (pdf + lights as f32 * self.light_pdf(from, hit));
        }
        let emitters = &self.tracer.emitters;
        let (surface, wi) = (hit.surface.as_ref(), hit.way.direction);
        trail.map_or(1.0, |trail| self.virtual_lamps.share_of_path(emitters, &trail, surface, wi))
    }

    /// Takes one of `count` light samples at the vertex number `bounce` of a path, and one by way of planar
    /// mirrors if there are any, from four numbers in [0, 1). Both are weighted by the balance heuristic against one sample of the
    /// BRDF, and reported to `observer` if they contribute.
    #[inline]
    pub(crate) fn sample_lights(
        &self,
        throughput: Rgb,
        at: &Vertex<'_>,
        [pick, u, v, again]: [f32; 4],
        (count, bounce): (u32, u32),
        observer: &mut impl PathObserver,
    ) {
        let origin = at.surface.start();
        let emitters = &self.tracer.emitters;
        if self.virtual_lamps.is_empty() {
            let light = emitters.sample(origin, [pick, u, v]);
            self.add_light(throughput, at, (origin, light), count, observer);
        } else {
            let importances = emitters.importances(origin);
            let light = emitters.sample_where(importances, origin, [pick, u, v]);
            self.add_light(throughput, at, (origin, light), count, observer);
            // The same strata, shifted by one half, so that the two errors differ.
            let [u, v] = [u, v].map(|u| if u < 0.5 { u + 0.5 } else { u - 0.5 });
            let point = (origin, importances.sum());
            let sample = self.virtual_lamps.sample(emitters, point, [again, u, v]);
            self.add_virtual_light(throughput, at, (origin, sample), (count, bounce), observer);
        }
    }

    /// Reports `light`, one of `count` light samples at a vertex whose rays leave from `origin`.
    #[inline]
    fn add_light(
        &self,
        throughput: Rgb,
        at: &Vertex<'_>,
        (origin, light): (Vec3, Option<LightSample>),
        count: u32,
        observer: &mut impl PathObserver,
    ) {
        let Some(light) = light else { return };
        if !at.surface.is_above(light.wi) {
            return;
        }
        let wi = at.frame.local_from_world(light.wi);
        let (f, bsdf_pdf) = at.bsdf.value_and_pdf(at.wo, wi);
        let f_cos = f * wi.z;
        if f_cos.max_element() <= 0.0 {
            return;
        }
        let Some(passage) = self.passage(origin, light.wi, light.distance, through(&light)) else {
            return;
        };
        let Some(light) = self.tracer.emitters.looked_up(light) else { return };
        let light = behind_glass(light, &passage);
        let mis = balance(light.pdf, count, bsdf_pdf * passage.probability);
        let (passed, transmittance) = (MirrorsPassed::default(), Rgb::ONE);
        let sample = &light;
        let light = DirectLight { wi, f_cos, sample, passed, transmittance, mis };
        observer.record_direct(throughput, at, &light);
    }

    /// The same for a sample by way of mirrors.
    // Few scenes have planar mirrors.
    #[inline(never)]
    fn add_virtual_light(
        &self,
        throughput: Rgb,
        at: &Vertex<'_>,
        (origin, sample): (Vec3, Option<VirtualSample>),
        (count, bounce): (u32, u32),
        observer: &mut impl PathObserver,
    ) {
        let Some(sample) = sample else { return };
        // The mirrors are vertices as well.
        if !at.surface.is_above(sample.wi) || !self.reflects(bounce + sample.count as u32) {
            return;
        }
        let wi = at.frame.local_from_world(sample.wi);
        let (f, bsdf_pdf) = at.bsdf.value_and_pdf(at.wo, wi);
        let f_cos = f * wi.z;
        if f_cos.max_element() <= 0.0 {
            return;
        }
        let Some(OpenWay { passed, transmittance, probability }) = self.open_way(origin, &sample)
        else {
            return;
        };
        let Some(light) = self.tracer.emitters.looked_up(sample.light) else { return };
        let sample = &light;
        let mis = balance(sample.pdf, count, bsdf_pdf * probability);
        let light = DirectLight { wi, f_cos, sample, passed, transmittance, mis };
        observer.record_direct(throughput, at, &light);
    }

    /// The way of `sample` from `origin`, if its mirrors are there and nothing occludes it.
    fn open_way(&self, origin: Vec3, sample: &VirtualSample) -> Option<OpenWay> {
        let mut way =
            OpenWay { passed: MirrorsPassed::default(), transmittance: Rgb::ONE, probability: 1.0 };
        let mut ray = Ray::new(origin, sample.wi);
        for (index, place) in sample.places[..sample.count].iter().enumerate() {
            let hit = self.tracer.closest(&ray)?;
            if self.tracer.flat_faces.of(hit.triangle) != Some(*place) {
                return None;
            }
            let to_mirror = self.passage(ray.origin, ray.direction, hit.t, through(&sample.light));
            way.transmittance *= counted(to_mirror?, &sample.light)?;
            let surface = self.tracer.shapes.surface_at(&ray, hit);
            let bsdf = self.bsdf(&surface).bsdf;
            let cos = -ray.direction.dot(surface.frame.normal);
            way.passed.push(Passed { group: surface.group, cos });
            way.transmittance *= bsdf.coat.mirror(bsdf.rho_s, cos);
            way.probability *= bsdf.specular_share();
            let next = sample.crossings.get(index + 1).filter(|_| index + 1 < sample.count);
            let wi = next.map_or(sample.light.wi, |next| (next - surface.point).normalize());
            if !surface.is_above(wi) {
                return None;
            }
            ray = Self::leave(&surface, wi);
        }
        // From where the ray leaves the mirror, which is a little before it: the whole distance would reach into the
        // lamp.
        let (direction, distance) = match sample.end {
            Some(end) => ((end - ray.origin).normalize(), ray.origin.distance(end)),
            None => (ray.direction, f32::INFINITY),
        };
        let to_light = self.passage(ray.origin, direction, distance, through(&sample.light))?;
        way.transmittance *= counted(to_light, &sample.light)?;
        Some(way)
    }

    /// The triangles that may occlude the segments between `apex` and the points of `bundle`.
    pub(crate) fn occluders(&self, apex: Vec3, bundle: &Bundle) -> Occluders {
        self.tracer.accel.occluders(apex, bundle)
    }

    /// Whether nothing occludes what is at `distance` along `wi` from `origin`, where the opaque `occluders` are known and
    /// there is no glass.
    pub(crate) fn is_visible_among(
        &self,
        occluders: &Occluders,
        origin: Vec3,
        wi: Vec3,
        distance: f32,
    ) -> bool {
        let ray = Ray { origin, direction: wi, t_max: distance * SHADOW_LENGTH };
        let is_open =
            |veil: &Veil| veil.passage(&self.tracer.shapes, &ray, Through::Panes).is_some();
        !self.tracer.accel.occluded_among(occluders, &ray)
            && self.tracer.veil.as_ref().is_none_or(is_open)
    }

    /// A light sample at a surface for any BRDF; none if it is occluded.
    pub fn visible_light(&self, at: &Surface, u: [f32; 3]) -> Option<VisibleLight> {
        let origin = at.start();
        let light = self.tracer.emitters.sample(origin, u)?;
        let is_above = at.is_above(light.wi);
        let passage = || self.passage(origin, light.wi, light.distance, through(&light));
        let passage = is_above.then(passage).flatten()?;
        let light = behind_glass(self.tracer.emitters.looked_up(light)?, &passage);
        let weight = light.weight * self.brightness(light.source);
        let LightSample { wi, pdf, .. } = light;
        Some(VisibleLight { wi, weight, pdf, by_direction: passage.probability })
    }

    /// A light sample by way of planar mirrors at a surface, the vertex number `bounce` of a path, for any
    /// BRDF; none if there is none, or it is occluded.
    pub fn virtual_light(&self, at: &Surface, u: [f32; 3], bounce: u32) -> Option<VisibleLight> {
        if self.virtual_lamps.is_empty() {
            return None;
        }
        let origin = at.start();
        let emitters = &self.tracer.emitters;
        let point = (origin, emitters.importances(origin).sum());
        let sample = self.virtual_lamps.sample(emitters, point, u)?;
        let reflects = at.is_above(sample.wi) && self.reflects(bounce + sample.count as u32);
        let way = reflects.then(|| self.open_way(origin, &sample)).flatten()?;
        let VirtualSample { wi, light, .. } = sample;
        let light = emitters.looked_up(light)?;
        let weight = light.weight * self.brightness(light.source) * way.transmittance;
        Some(VisibleLight { wi, weight, pdf: light.pdf, by_direction: way.probability })
    }
}

/// The glass that light samples of `light` pass: the bent rays that find lamps through solid glass do not find lights
/// without an extent.
#[inline]
fn through(light: &LightSample) -> Through {
    if light.pdf.is_some() { Through::Panes } else { Through::All }
}

/// `light` behind glass.
#[inline]
fn behind_glass(light: LightSample, passage: &Passage) -> LightSample {
    LightSample { weight: light.weight * passage.transmittance(), ..light }
}

/// What passes on the way of a virtual sample of `light`. Lamps count without any glass on the way alone: with some,
/// drawn directions find them ([`Transport::share_of_direction`]).
fn counted(passage: Passage, light: &LightSample) -> Option<Rgb> {
    let counts = light.pdf.is_none() || passage == Passage::OPEN;
    counts.then(|| passage.transmittance())
}

/// The weight by the balance heuristic of one of `count` samples of the density `pdf`, none for light that no direction
/// finds, beside one direction drawn with the density `by_direction`.
#[inline]
fn balance(pdf: Option<f32>, count: u32, by_direction: f32) -> f32 {
    let count = count as f32;
    pdf.map_or(1.0 / count, |pdf| pdf / (count * pdf + by_direction))
}
