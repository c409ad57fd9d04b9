//! Light transport: unidirectional path tracing with next-event estimation [Kajiya 1986] and
//! multiple importance sampling by the balance heuristic [Veach and Guibas 1995].
//!
//! At every surface the outgoing radiance obeys the rendering equation
//!
//! ```text
//! L(wo) = E(wo) + integral f(wo, wi) L(wi) cos_i dwi
//! ```
//!
//! The integral is estimated by one light sample and one direction drawn from the BRDF, along which
//! the path continues. Light that both strategies can find is weighted by their densities. Perfect
//! mirrors take no light samples; where lamps are seen in planar ones, a second light sample goes by
//! way of those (`crate::virtual_lamps`). Paths end by Russian roulette, at [`MAX_BOUNCES`], or at a
//! surface whose radiance the image-based cache knows ([`crate::radiance_cache`]).
//!
//! Glass is no vertex of a path but part of the way between two (`way`).
//!
//! One function traces all paths, `Transport::trace`. It reports the events of a path to a
//! `PathObserver`: `RadianceSum` adds up the radiance, and the tape of [`crate::jacobian`]
//! differentiates it.

mod direct;
mod way;

pub(crate) use direct::DirectLight;
pub use direct::VisibleLight;
pub(crate) use way::Way;

use crate::accel::Ray;
use crate::appearance::{Appearance, LightSource, SourceLayout};
use crate::bsdf::{Bsdf, BsdfSample, Specular};
use crate::guiding::{self, FourPairs, VmfMixture};
use crate::radiance_cache::{CacheLookup, Cached};
use crate::sampler::Sampler;
use crate::surface::{Frame, Surface};
use crate::tracer::Tracer;
use crate::virtual_lamps::{MirrorTrail, VirtualLamps};
use glam::Vec3;
use unrender_scene::{BrdfModel, Material, Rgb};

/// The longest path. In a closed room of reflectance 0.95 the light beyond is e^-25 of the total,
/// below single precision; with half of it e^-13, with double of it a bug would take twice as long
/// to end.
pub const MAX_BOUNCES: u32 = 500;
/// Russian roulette starts at this bounce. Earlier it ends paths that carry most of the light;
/// later dim paths cost time.
const ROULETTE_FROM: u32 = 3;
/// Russian roulette ends paths that carry less than this, so that survivors are no brighter than
/// most paths. In a closed room, at equal time, the variance is 0.7 of that with the threshold 1.
///
/// What a path carries is the throughput that it would have without guides. A guided direction has
/// a small throughput *because* much light is expected there; roulette on the throughput itself
/// ends it, and the few survivors weigh a thousand times as much [Vorba and Krivanek 2016].
const ROULETTE_CARRIED: f32 = 0.2;
/// One of many paths that go on from the directions of one point counts as if it carried this, from its start on: what follows
/// is averaged over all of them. In a public staircase the variance times the time is 0.62 to 0.72 of that with roulette as
/// from the camera, in a furnished room 0.99, in a room of metal 0.95; at half of it 0.85 in the staircase, at double not
/// tried there.
const CARRIED_OF_MANY: f32 = 0.4;
/// The largest probability of surviving a bounce. It bounds the mean length of paths at reflectance
/// one, 50 bounces; at 0.96 it would end bright paths, at 0.99 they would be twice as long.
const SURVIVAL_MAX: f32 = 0.98;
/// The least, for a path that carries anything. Random numbers are multiples of 2^-24, and zero once in 2^24: without
/// it a path may survive at a probability of 1e-22, as after surfaces that reflect nothing in one channel each, and its
/// derivatives are divided by that. At half of it they weigh twice as much, at double paths without light take a
/// hundredth of the time.
const SURVIVAL_MIN: f32 = 1.0 / 256.0;

/// The probability that a path which carries so much survives.
#[inline]
fn survival_probability(carried: Rgb) -> f32 {
    let carried = carried.max_element();
    if carried > 0.0 { (carried / ROULETTE_CARRIED).clamp(SURVIVAL_MIN, SURVIVAL_MAX) } else { 0.0 }
}

/// The BRDF at a surface and its frame.
pub struct LocalBsdf {
    /// The BRDF.
    pub bsdf: Bsdf<'static>,
    /// The anisotropy frame, in which its directions are given.
    pub frame: Frame,
}

/// What the vertices of a group have in common.
#[derive(Clone, Copy)]
struct GroupBsdf {
    /// The BRDF but for a texture.
    bsdf: Bsdf<'static>,
    is_textured: bool,
    /// Sine and cosine of the angle of anisotropy, if it is not zero.
    rotation: Option<(f32, f32)>,
}

impl GroupBsdf {
    fn new(material: &Material, model: BrdfModel) -> Self {
        Self {
            bsdf: Bsdf::new(material, material.rho_d, model),
            is_textured: material.texture.is_some(),
            rotation: (material.theta_rad != 0.0).then(|| material.theta_rad.sin_cos()),
        }
    }
}

/// A vertex of a path: a surface and its BRDF.
#[derive(Clone, Copy)]
pub(crate) struct Vertex<'a> {
    pub(crate) surface: &'a Surface,
    /// The BRDF that directions are drawn from.
    pub(crate) bsdf: &'a Bsdf<'a>,
    /// Its anisotropy frame, in which `wo` and all other directions at the vertex are given.
    pub(crate) frame: &'a Frame,
    /// Unit vector back along the path.
    pub(crate) wo: Vec3,
}

/// Emission in a direction, in the scene as it is ([`Appearance::lights`] not applied).
pub(crate) struct Emission {
    pub(crate) source: LightSource,
    pub(crate) radiance: Rgb,
}

/// Receives the events of a path, in the order of the path. `throughput` is the product of BRDFs
/// and cosines over densities from the camera up to the event, under the appearance that directions
/// are drawn from.
pub(crate) trait PathObserver {
    /// The path arrives at a vertex that reflects.
    fn record_vertex(&mut self, at: &Vertex<'_>);

    /// A light sample contributes at the vertex.
    fn record_direct(&mut self, throughput: Rgb, at: &Vertex<'_>, light: &DirectLight<'_>);

    /// The path continues in the direction of `sample`, having survived Russian roulette with the
    /// probability `survival`.
    fn record_bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32);

    /// The way from there, or from the camera, went through glass, which colours all that follows.
    fn record_glass(&mut self, way: &Way);

    /// The path's ray hits something that emits. `mis` is the weight of multiple importance
    /// sampling.
    fn record_emission(&mut self, throughput: Rgb, emission: &Emission, mis: f32);

    /// The path ends at a surface whose reflected radiance is in the cache.
    fn record_cache_hit(&mut self, throughput: Rgb, cached: &Cached);
}

/// The observer that adds up radiance.
pub(crate) struct RadianceSum<'a> {
    pub(crate) appearance: Appearance<'a>,
    layout: &'a SourceLayout,
    pub(crate) radiance: Rgb,
}

impl<'a> RadianceSum<'a> {
    pub(crate) fn new(transport: &Transport<'a>) -> Self {
        let layout = transport.tracer.emitters.layout();
        Self { appearance: transport.appearance, layout, radiance: Rgb::ZERO }
    }

    #[inline]
    fn brightness(&self, source: LightSource) -> Rgb {
        self.appearance.brightness(self.layout, source)
    }
}

impl PathObserver for RadianceSum<'_> {
    #[inline]
    fn record_vertex(&mut self, _: &Vertex<'_>) {}

    #[inline]
    fn record_direct(&mut self, throughput: Rgb, _: &Vertex<'_>, light: &DirectLight<'_>) {
        let factor = self.brightness(light.sample.source);
        let arriving = light.sample.weight * light.transmittance * factor;
        self.radiance += throughput * (light.f_cos * arriving * light.mis);
    }

    #[inline]
    fn record_bounce(&mut self, _: &Vertex<'_>, _: &BsdfSample, _: f32) {}

    #[inline]
    fn record_glass(&mut self, _: &Way) {}

    #[inline]
    fn record_emission(&mut self, throughput: Rgb, emission: &Emission, mis: f32) {
        let factor = self.brightness(emission.source);
        self.radiance += throughput * (emission.radiance * factor) * mis;
    }

    #[inline]
    fn record_cache_hit(&mut self, throughput: Rgb, cached: &Cached) {
        self.radiance += throughput * cached.radiance;
    }
}

/// How a path begins.
pub(crate) struct Start {
    throughput: Rgb,
    /// What counts as its throughput for Russian roulette.
    carried: Rgb,
    /// The number of reflections before, and the one from which on there is roulette.
    bounce: u32,
    roulette_from: u32,
}

impl Start {
    /// After so many reflections.
    pub(crate) fn after(bounce: u32) -> Self {
        Self { throughput: Rgb::ONE, carried: Rgb::ONE, bounce, roulette_from: ROULETTE_FROM }
    }

    /// The same of one of many paths from the directions of one point.
    pub(crate) fn of_many(bounce: u32) -> Self {
        let carried = Rgb::splat(CARRIED_OF_MANY);
        Self { carried, roulette_from: bounce, ..Self::after(bounce) }
    }
}

/// What a ray hits: a surface, or the environment.
pub(crate) struct RayHit {
    pub(crate) surface: Option<Surface>,
    pub(crate) emission: Emission,
    /// The way there.
    pub(crate) way: Way,
}

/// The light transport of one scene under one appearance.
#[derive(Clone)]
pub struct Transport<'a> {
    pub(crate) tracer: &'a Tracer,
    appearance: Appearance<'a>,
    /// The BRDF of each group.
    groups: Vec<GroupBsdf>,
    max_bounces: u32,
    cache: Option<CacheLookup<'a>>,
    /// The pairs of a glossy plane and a lamp that guide sampling.
    glossy_pairs: Vec<FourPairs>,
    /// The lamps in planar mirrors.
    pub(crate) virtual_lamps: VirtualLamps,
}

impl<'a> Transport<'a> {
    /// Transport with at most `max_bounces` reflections along a path; one means direct light only.
    ///
    /// # Panics
    /// Later, if the appearance has fewer materials than the scene has groups.
    pub fn new(tracer: &'a Tracer, appearance: Appearance<'a>, max_bounces: u32) -> Self {
        let glossy_pairs = FourPairs::all(&tracer.guide.pairs(&appearance));
        let virtual_lamps = tracer.virtual_lamps(&appearance);
        let groups = appearance.materials.iter().map(|m| GroupBsdf::new(m, tracer.model)).collect();
        Self { tracer, appearance, groups, max_bounces, cache: None, glossy_pairs, virtual_lamps }
    }

    /// The same transport with paths that end at surfaces whose radiance is in `cache`, except at
    /// the first vertex, which the camera itself sees.
    pub fn with_cache(self, cache: Option<CacheLookup<'a>>) -> Self {
        Self { cache, ..self }
    }

    /// A ray that leaves `surface` along `wi` without hitting it again.
    pub fn leave(surface: &Surface, wi: Vec3) -> Ray {
        Ray::new(surface.start(), wi)
    }

    /// The radiance that `surface` emits towards the side from which it was hit: from its front
    /// only.
    pub fn emitted(&self, surface: &Surface) -> Rgb {
        self.scaled(&self.emission(surface))
    }

    /// The emission of `surface` in the scene as it is.
    pub(crate) fn emission(&self, surface: &Surface) -> Emission {
        let front = surface.front;
        let radiance =
            if front { self.tracer.emitters.radiance(surface.triangle) } else { Rgb::ZERO };
        Emission { source: LightSource::Group(surface.group), radiance }
    }

    /// The radiance that arrives from the environment along `wi` (world space); zero without one.
    pub fn environment(&self, wi: Vec3) -> Rgb {
        self.scaled(&self.background(wi))
    }

    /// The emission of the environment along `wi` in the scene as it is.
    pub(crate) fn background(&self, wi: Vec3) -> Emission {
        let radiance = self.tracer.emitters.environment(wi);
        Emission { source: LightSource::Environment(wi), radiance }
    }

    /// The radiance of an emission under the appearance.
    pub(crate) fn scaled(&self, emission: &Emission) -> Rgb {
        emission.radiance * self.brightness(emission.source)
    }

    /// The factor of the appearance on the emission of `source`.
    pub(crate) fn brightness(&self, source: LightSource) -> Rgb {
        self.appearance.brightness(self.tracer.emitters.layout(), source)
    }

    /// The BRDF at `surface`.
    // Without this the compiler does not inline it where there are several callers, and pictures
    // take 2 % longer.
    #[inline(always)]
    pub fn bsdf(&self, surface: &Surface) -> LocalBsdf {
        let GroupBsdf { mut bsdf, is_textured, rotation } = self.groups[surface.group as usize];
        if is_textured {
            let material = &self.appearance.materials[surface.group as usize];
            bsdf = bsdf.over(material.rho_d_at(surface.uv));
        }
        let has_lobe = bsdf.specular != Specular::None;
        let frame = if has_lobe { surface.lobe_frame() } else { surface.frame };
        let frame = rotation.map_or(frame, |rotation| frame.turned(rotation));
        if surface.shades_itself {
            bsdf = bsdf.bumped(frame.local_from_world(surface.mesh_normal));
        }
        LocalBsdf { bsdf, frame }
    }

    /// The radiance that arrives along the ray.
    pub fn radiance(&self, ray: &Ray, sampler: &mut Sampler) -> Rgb {
        let mut sum = RadianceSum::new(self);
        self.trace_ray(ray, sampler, &mut sum);
        sum.radiance
    }

    /// The radiance that `surface` reflects into `wo` (world space), without its emission. `trail` is
    /// that of a vertex which takes virtual samples and has drawn this direction; none if there is no such
    /// vertex.
    pub(crate) fn reflected(
        &self,
        surface: Surface,
        wo: Vec3,
        sampler: &mut Sampler,
        start: Start,
        trail: Option<MirrorTrail>,
    ) -> Rgb {
        let mut sum = RadianceSum::new(self);
        self.trace_on((surface, wo), start, sampler, trail, &mut sum);
        sum.radiance
    }

    /// Traces the path that begins with `ray`, and reports its events to `observer`: first what the ray hits, if that
    /// emits.
    #[inline]
    pub(crate) fn trace_ray(
        &self,
        ray: &Ray,
        sampler: &mut Sampler,
        observer: &mut impl PathObserver,
    ) {
        let RayHit { surface, emission, way } = self.follow(ray, || sampler.next4()[0]);
        let filter = way.passage.filter;
        if !way.is_open {
            observer.record_glass(&way);
        }
        if emission.radiance != Rgb::ZERO {
            observer.record_emission(filter, &emission, 1.0);
        }
        if let Some(surface) = surface {
            let start = Start { throughput: filter, carried: filter, ..Start::after(0) };
            self.trace_on((surface, -way.direction), start, sampler, None, observer);
        }
    }

    /// Traces a path that leaves `surface` into `wo` (world space), and reports its events to `observer`.
    #[inline]
    fn trace_on(
        &self,
        (mut surface, mut wo): (Surface, Vec3),
        start: Start,
        sampler: &mut Sampler,
        mut trail: Option<MirrorTrail>,
        observer: &mut impl PathObserver,
    ) {
        let Start { mut throughput, mut carried, bounce, roulette_from } = start;
        for bounce in bounce..self.max_bounces {
            if let Some(cached) = self.cached(&surface, bounce) {
                observer.record_cache_hit(throughput, &cached);
                break;
            }
            let LocalBsdf { bsdf, frame } = self.bsdf(&surface);
            if bsdf.is_black() {
                break;
            }
            // Computed side by side by the processor.
            let (numbers, [lobe, u, v, survival]) = (sampler.next4(), sampler.next4());
            let guide;
            let bsdf = if self.is_guided(&bsdf) {
                guide = guiding::mixture(&surface, &frame, &self.glossy_pairs, bounce);
                bsdf.guided_by(&guide)
            } else {
                bsdf
            };
            let wo_local = frame.local_from_viewer(wo);
            let at = Vertex { surface: &surface, bsdf: &bsdf, frame: &frame, wo: wo_local };
            observer.record_vertex(&at);

            // Next-event estimation.
            if !bsdf.is_pure_mirror() {
                self.sample_lights(throughput, &at, numbers, (1, bounce), observer);
            }

            // The next direction.
            let Some(sample) = bsdf.sample(wo_local, [lobe, u, v]) else { break };
            let wi = frame.world_from_local(sample.wi);
            if !surface.is_above(wi) {
                break;
            }
            throughput *= sample.weight;
            carried *= sample.unguided;

            // Russian roulette.
            let mut probability = 1.0;
            if bounce >= roulette_from {
                probability = survival_probability(carried);
                if survival >= probability {
                    break;
                }
                throughput /= probability;
                carried /= probability;
            }
            observer.record_bounce(&at, &sample, probability);

            let hit = self.hit(&surface, wi, sampler);
            trail = self.trail(trail, &surface, &bsdf, sample.pdf, 1);
            trail = trail.filter(|_| hit.way.is_open);
            if !hit.way.is_open {
                let filter = hit.way.passage.filter;
                throughput *= filter;
                carried *= filter;
                observer.record_glass(&hit.way);
            }
            if hit.emission.radiance != Rgb::ZERO {
                let mis = self.share_of_direction(&surface, &hit, (sample.pdf, 1), trail);
                observer.record_emission(throughput, &hit.emission, mis);
            }
            let Some(next) = hit.surface else { break };
            (surface, wo) = (next, -hit.way.direction);
        }
    }

    /// The trail after a direction was drawn at `surface` with the density `pdf`, beside `samples`
    /// virtual samples, or after the reflection in a perfect mirror, whose density is infinite; `before` is
    /// the trail up to there. None if virtual samples cannot find what follows.
    #[inline]
    pub(crate) fn trail(
        &self,
        before: Option<MirrorTrail>,
        surface: &Surface,
        bsdf: &Bsdf<'_>,
        pdf: f32,
        samples: u32,
    ) -> Option<MirrorTrail> {
        if self.virtual_lamps.is_empty() {
            None
        } else if pdf.is_finite() {
            Some(MirrorTrail::new(surface, pdf, samples))
        } else {
            before?.reflected(self.tracer.flat_faces.of(surface.triangle), bsdf.specular_share())
        }
    }

    /// What the ray from `from` along `wi` hits.
    #[inline]
    pub(crate) fn hit(&self, from: &Surface, wi: Vec3, sampler: &mut Sampler) -> RayHit {
        self.follow(&Self::leave(from, wi), || sampler.next4()[0])
    }

    /// Whether the sampling of a BRDF is guided.
    #[inline]
    fn is_guided(&self, bsdf: &Bsdf<'_>) -> bool {
        !self.glossy_pairs.is_empty() && bsdf.rho_d.max_element() > 0.0
    }

    /// The lobes about the images of lamps in glossy planes at `surface`, in its frame.
    pub(crate) fn images(&self, surface: &Surface) -> VmfMixture {
        guiding::mixture(surface, &surface.frame, &self.glossy_pairs, 0)
    }

    /// The mixture that guides the sampling of a BRDF at the bounce number `bounce`.
    pub(crate) fn guide(
        &self,
        LocalBsdf { bsdf, frame }: &LocalBsdf,
        surface: &Surface,
        bounce: u32,
    ) -> VmfMixture {
        if self.is_guided(bsdf) {
            guiding::mixture(surface, frame, &self.glossy_pairs, bounce)
        } else {
            VmfMixture::NONE
        }
    }

    /// Whether paths may have a bounce number `bounce`, from zero.
    #[inline]
    pub(crate) fn reflects(&self, bounce: u32) -> bool {
        bounce < self.max_bounces
    }

    /// Whether light samples choose among several pools of lights.
    pub(crate) fn has_several_lights(&self) -> bool {
        self.tracer.emitters.are_several()
    }

    /// Whether what `surface` reflects can be reused for receivers in other directions: no part of its
    /// BRDF is a perfect mirror; nor is it glossy where lamps light it through mirrors, whose virtual
    /// samples would have a weight of their own for each receiver.
    pub(crate) fn is_reusable(&self, surface: &Surface) -> bool {
        match self.bsdf(surface).bsdf.specular {
            Specular::None => true,
            Specular::Glossy(_) => self.virtual_lamps.is_empty(),
            Specular::Mirror => false,
        }
    }

    /// The radiance of `surface` from the cache.
    #[inline]
    fn cached(&self, surface: &Surface, bounce: u32) -> Option<Cached> {
        self.cache.filter(|_| bounce > 0).and_then(|cache| cache.at(surface))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survivors_weigh_no_more_than_random_numbers_can_tell() {
        let survives = |carried: f32| survival_probability(Rgb::new(0.0, carried, 0.0));
        assert_eq!(survives(0.0), 0.0);
        // One draw in 2^24 is zero, and survives at any positive probability.
        let tiny = [1e-38, 1e-22, 1e-9, 1e-4].map(survives);
        assert!(tiny.iter().all(|p| 2f32.powi(-24) / p < 1e-4), "{tiny:?}");
        assert!([1e-22, 1e-3, 0.02, 0.15, 0.3, 7.0].map(survives).is_sorted());
        assert_eq!(survives(1.0), SURVIVAL_MAX);
    }
}
