//! Light transport: unidirectional path tracing with next-event estimation and multiple importance
//! sampling by the balance heuristic [Kajiya 1986; Veach 1997].
//!
//! At every surface the radiance that leaves towards `wo` is what it emits plus
//! `integral f(wo, wi) L(wi) cos_i dwi`. The integral is estimated by one light sample and one
//! direction drawn from the reflectance; the direction's ray goes on as the path. Light that both
//! could have found is shared out by their densities. Perfect mirrors take no light samples.
//!
//! A path is walked in one place, `Transport::walk`, and tells a `Ledger` what it meets:
//! [`Transport::reflected`] adds up the light, the Jacobian (module [`crate::jacobian`]) also how
//! it changes.

use crate::accel::{self, Between, Bundle, Ray};
use crate::bsdf::{Bsdf, BsdfSample, Specular};
use crate::caustic::{self, Images, Shiny};
use crate::emitters::LightSample;
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
/// Little is less than this: those that go on are then no brighter than most, which would be noise.
/// (In a closed room, at equal time, the variance is 0.7 of what it is with 1.)
const LITTLE: f32 = 0.2;
/// A path survives a bounce with this probability at most, so that none lives for ever.
const SURVIVAL_MAX: f32 = 0.98;

/// A surface on a path, with all that scatters light there.
#[derive(Clone, Copy)]
pub(crate) struct Vertex<'a> {
    pub(crate) surface: &'a Surface,
    /// The reflectance that directions are drawn from.
    pub(crate) bsdf: &'a Bsdf<'a>,
    /// Its brushed frame, in which `wo` and all other directions of the vertex are given.
    pub(crate) frame: &'a Frame,
    /// Unit vector back along the path.
    pub(crate) wo: Vec3,
}

/// What a path meets is told to a ledger, in the path's order. `throughput` is the share of the
/// light from there that the camera sees, by the appearance that directions are drawn from.
pub(crate) trait Ledger {
    /// The path stands at a surface that reflects.
    fn arrive(&mut self, at: &Vertex<'_>);

    /// `light` arrives there unhindered from `wi`; `f_cos` is the reflectance times the cosine,
    /// `share` what light samples have to account for of light that both strategies find.
    fn direct(
        &mut self,
        throughput: Rgb,
        at: &Vertex<'_>,
        wi: Vec3,
        f_cos: Rgb,
        light: &LightSample,
        share: f32,
    );

    /// The path goes on in the direction of `sample`, which it did with the probability `survival`.
    fn bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32);

    /// The ray meets the source `source` (a surface or the environment), which emits `radiance` in the scene as it is; `share` is
    /// what rays have to account for.
    fn emission(&mut self, throughput: Rgb, source: u32, radiance: Rgb, share: f32);

    /// The path ends at a surface of known radiance.
    fn known(&mut self, throughput: Rgb, radiance: Rgb);
}

/// The ledger that adds up radiance.
pub(crate) struct Sum<'a> {
    appearance: Appearance<'a>,
    pub(crate) radiance: Rgb,
}

impl<'a> Sum<'a> {
    pub(crate) fn new(appearance: Appearance<'a>) -> Self {
        Self { appearance, radiance: Rgb::ZERO }
    }
}

impl Ledger for Sum<'_> {
    #[inline]
    fn arrive(&mut self, _: &Vertex<'_>) {}

    #[inline]
    fn direct(
        &mut self,
        throughput: Rgb,
        _: &Vertex<'_>,
        _: Vec3,
        f_cos: Rgb,
        light: &LightSample,
        share: f32,
    ) {
        let factor = self.appearance.light(light.source);
        self.radiance += throughput * (f_cos * light.weight * factor * share);
    }

    #[inline]
    fn bounce(&mut self, _: &Vertex<'_>, _: &BsdfSample, _: f32) {}

    #[inline]
    fn emission(&mut self, throughput: Rgb, source: u32, radiance: Rgb, share: f32) {
        self.radiance += throughput * (radiance * self.appearance.light(source)) * share;
    }

    #[inline]
    fn known(&mut self, throughput: Rgb, radiance: Rgb) {
        self.radiance += throughput * radiance;
    }
}

/// What a path meets: a surface, or the environment.
pub(crate) struct Met {
    pub(crate) surface: Option<Surface>,
    /// What emits there, and its radiance in the scene as it is.
    pub(crate) source: u32,
    pub(crate) emission: Rgb,
    /// The density over solid angle with which light samples find it; zero if it is no light.
    pub(crate) light_pdf: f32,
}

impl Met {
    /// Tells `ledger` of the light that was met in a direction drawn with the density `pdf`, where
    /// `lights` light samples were taken.
    #[inline]
    pub(crate) fn tell(&self, throughput: Rgb, pdf: f32, lights: u32, ledger: &mut impl Ledger) {
        if self.emission != Rgb::ZERO {
            let found = pdf / (pdf + lights as f32 * self.light_pdf);
            let share = if pdf.is_finite() { found } else { 1.0 };
            ledger.emission(throughput, self.source, self.emission, share);
        }
    }
}

/// The light transport of one scene under one appearance.
#[derive(Clone)]
pub struct Transport<'a> {
    tracer: &'a Tracer,
    appearance: Appearance<'a>,
    max_bounces: u32,
    seen: Option<Lookup<'a>>,
    shiny: Vec<Shiny>,
}

impl<'a> Transport<'a> {
    /// Transport with at most `max_bounces` reflections along a path; one means direct light only.
    ///
    /// # Panics
    /// Later, if the appearance has fewer materials than groups.
    pub fn new(tracer: &'a Tracer, appearance: Appearance<'a>, max_bounces: u32) -> Self {
        let shiny = tracer.caustics.shiny(&appearance);
        Self { tracer, appearance, max_bounces, seen: None, shiny }
    }

    /// The same transport, but paths end where `seen` knows the radiance; never at the surface of
    /// the reflection number zero, which the camera itself looks at.
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
        self.emission(surface) * self.appearance.light(surface.group)
    }

    /// What `surface` emits in the scene as it is.
    pub(crate) fn emission(&self, surface: &Surface) -> Rgb {
        if surface.front { self.tracer.emitters.radiance(surface.triangle) } else { Rgb::ZERO }
    }

    /// The radiance that arrives along `wi` (world space) from the environment; zero without one.
    pub fn environment(&self, wi: Vec3) -> Rgb {
        let (source, radiance) = self.background(wi);
        radiance * self.appearance.light(source)
    }

    /// The source behind all surfaces and what comes from it along `wi` in the scene as it is.
    pub(crate) fn background(&self, wi: Vec3) -> (u32, Rgb) {
        let emitters = &self.tracer.emitters;
        (emitters.environment_source(), emitters.environment(wi))
    }

    /// The reflectance at `surface` and the brushed frame that it lives in.
    // Out of line, as the compiler would have it with several callers, pictures take 2 % longer.
    #[inline(always)]
    pub fn bsdf(&self, surface: &Surface) -> (Bsdf<'static>, Frame) {
        let material = &self.appearance.materials[surface.group as usize];
        let bsdf = Bsdf::new(material, material.rho_d_at(surface.uv), self.tracer.model);
        (bsdf, surface.frame.brushed(material.theta_rad))
    }

    /// All radiance that arrives along the ray. Counts the first surface's reflection as the
    /// reflection number `bounce`, from zero.
    pub fn radiance(&self, ray: &Ray, sampler: &mut Sampler, bounce: u32) -> Rgb {
        let Some(surface) = self.surface(ray) else { return self.environment(ray.direction) };
        self.emitted(&surface) + self.reflected(surface, -ray.direction, sampler, bounce)
    }

    /// The radiance that `surface` reflects into `wo` (world space), emission left out.
    pub fn reflected(&self, surface: Surface, wo: Vec3, sampler: &mut Sampler, bounce: u32) -> Rgb {
        let mut sum = Sum::new(self.appearance);
        self.walk(surface, wo, sampler, bounce, &mut sum);
        sum.radiance
    }

    /// Walks a path on from `surface`, seen from `wo` (world space), and tells `ledger` what it
    /// meets.
    #[inline]
    pub(crate) fn walk(
        &self,
        mut surface: Surface,
        mut wo: Vec3,
        sampler: &mut Sampler,
        bounce: u32,
        ledger: &mut impl Ledger,
    ) {
        let mut throughput = Rgb::ONE;
        for bounce in bounce..self.max_bounces {
            if let Some(known) = self.known(&surface, bounce) {
                ledger.known(throughput, known);
                break;
            }
            let (bsdf, frame) = self.bsdf(&surface);
            if bsdf.is_black() {
                break;
            }
            let images;
            let bsdf = if self.looks_for_images(&bsdf, bounce) {
                images = Images::seen_from(&surface, &frame, &self.shiny, bounce);
                bsdf.looking_at(&images)
            } else {
                bsdf
            };
            let wo_local = frame.local_from_world(wo);
            let at = Vertex { surface: &surface, bsdf: &bsdf, frame: &frame, wo: wo_local };
            ledger.arrive(&at);

            // Light that comes straight from an emitter.
            let [pick, u, v, _] = sampler.next4();
            if !bsdf.is_pure_mirror() {
                self.direct(throughput, &at, [pick, u, v], 1, ledger);
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
            let mut probability = 1.0;
            if bounce >= ROULETTE_FROM {
                probability = (throughput.max_element() / LITTLE).min(SURVIVAL_MAX);
                if survival >= probability {
                    break;
                }
                throughput /= probability;
            }
            ledger.bounce(&at, &sample, probability);

            let met = self.meet(&surface, wi);
            met.tell(throughput, sample.pdf, 1, ledger);
            let Some(next) = met.surface else { break };
            (surface, wo) = (next, -wi);
        }
    }

    /// What a path meets that leaves `from` along `wi`.
    #[inline]
    pub(crate) fn meet(&self, from: &Surface, wi: Vec3) -> Met {
        let surface = self.surface(&Self::leave(from, wi));
        let (source, emission) = match &surface {
            Some(surface) => (surface.group, self.emission(surface)),
            None => self.background(wi),
        };
        let light_pdf = match &surface {
            _ if emission == Rgb::ZERO => 0.0,
            Some(surface) => self.light_pdf(from, surface, wi),
            None => self.environment_pdf(from, wi),
        };
        Met { surface, source, emission, light_pdf }
    }

    /// Whether a reflectance met at the reflection number `bounce` is sampled towards images.
    #[inline]
    fn looks_for_images(&self, bsdf: &Bsdf<'_>, bounce: u32) -> bool {
        !self.shiny.is_empty() && bounce < caustic::BOUNCES && bsdf.rho_d.max_element() > 0.0
    }

    /// Where the reflectance at the surface of the reflection number `bounce` looks for light.
    pub(crate) fn images(
        &self,
        bsdf: &Bsdf<'_>,
        surface: &Surface,
        frame: &Frame,
        bounce: u32,
    ) -> Images {
        if self.looks_for_images(bsdf, bounce) {
            Images::seen_from(surface, frame, &self.shiny, bounce)
        } else {
            Images::NONE
        }
    }

    /// Whether paths may have a reflection number `bounce`, from zero.
    pub(crate) fn reflects(&self, bounce: u32) -> bool {
        bounce < self.max_bounces
    }

    /// Whether light comes from several places, among which light samples choose.
    pub(crate) fn has_several_lights(&self) -> bool {
        self.tracer.emitters.are_several()
    }

    /// Whether nothing of `surface` is a perfect mirror.
    pub(crate) fn is_smooth(&self, surface: &Surface) -> bool {
        self.bsdf(surface).0.specular != Specular::Mirror
    }

    /// What is assumed of the scene.
    pub(crate) fn appearance(&self) -> Appearance<'a> {
        self.appearance
    }

    /// The radiance of `surface` if the cache knows it.
    #[inline]
    fn known(&self, surface: &Surface, bounce: u32) -> Option<Rgb> {
        self.seen.filter(|_| bounce > 0).and_then(|seen| seen.radiance(surface))
    }

    /// The density over solid angle with which light samples at `from` find `emitter` along `wi`.
    pub fn light_pdf(&self, from: &Surface, emitter: &Surface, wi: Vec3) -> f32 {
        let distance = (emitter.point - from.point).length();
        let cos = -wi.dot(self.tracer.front_normal(emitter.triangle));
        let origin = accel::offset(from.point, from.geometric_normal);
        self.tracer.emitters.pdf(origin, emitter.triangle, distance, cos)
    }

    /// The density over solid angle with which light samples at `from` find the environment along
    /// `wi`.
    pub fn environment_pdf(&self, from: &Surface, wi: Vec3) -> f32 {
        let origin = accel::offset(from.point, from.geometric_normal);
        self.tracer.emitters.environment_pdf(origin, wi)
    }

    /// One of `count` light samples, weighted against what the reflectance's own sampling finds.
    #[inline]
    pub(crate) fn direct(
        &self,
        throughput: Rgb,
        at: &Vertex<'_>,
        u: [f32; 3],
        count: u32,
        ledger: &mut impl Ledger,
    ) {
        let origin = accel::offset(at.surface.point, at.surface.geometric_normal);
        let Some(light) = self.tracer.emitters.sample(origin, u) else { return };
        if !at.surface.is_above(light.wi) {
            return;
        }
        let wi = at.frame.local_from_world(light.wi);
        let (f, found) = at.bsdf.value_and_pdf(at.wo, wi);
        let f_cos = f * wi.z;
        if f_cos.max_element() <= 0.0 || !self.is_free(origin, light.wi, light.distance) {
            return;
        }
        let count = count as f32;
        let share = match light.pdf {
            Some(pdf) => pdf / (count * pdf + found),
            None => 1.0 / count,
        };
        ledger.direct(throughput, at, wi, f_cos, &light, share);
    }

    /// Whether nothing stands between `origin` and a light at `distance` along `wi`.
    pub(crate) fn is_free(&self, origin: Vec3, wi: Vec3, distance: f32) -> bool {
        let t_max = distance * (1.0 - 1e-5);
        !self.tracer.accel.occluded(&Ray { origin, direction: wi, t_max })
    }

    /// What may stand between `apex` and the points of `bundle`.
    pub(crate) fn between(&self, apex: Vec3, bundle: &Bundle) -> Between {
        self.tracer.accel.between(apex, bundle)
    }

    /// [`Transport::is_free`] where it is known what may stand `between`.
    pub(crate) fn is_free_among(
        &self,
        between: &Between,
        origin: Vec3,
        wi: Vec3,
        distance: f32,
    ) -> bool {
        let t_max = distance * (1.0 - 1e-5);
        !self.tracer.accel.occluded_among(between, &Ray { origin, direction: wi, t_max })
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
