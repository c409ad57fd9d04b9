//! Stored paths: traced once, evaluated under any appearance.
//!
//! Geometry, lights and camera stay the same while materials are searched for, so the paths that a rendering found stay
//! paths of the scene. Only the values of BRDFs along them change: with `x1 .. xk` the vertices of a path,
//!
//! ```text
//! L = sum over k of  (product over i < k of  f_i cos_i / (pdf_i survival_i)) * (direct_k or emission_k)
//! ```
//!
//! in which everything but the BRDFs `f_i` is a number that is known once the path is traced. [`StoredPaths`] keeps
//! these numbers; a replay runs the same tape as [`Tracer::jacobian`] on them, without a ray. Albedos are edited under
//! global illumination in the same way [Hasan and Ramamoorthi 2013].
//!
//! A path is a sequence of words of 32 bits: for each event a word that names it, with the group or the source of
//! light, then its numbers. A vertex with its light sample and its direction takes 52 bytes, 12 more where
//! light comes from the environment, 8 more where the surface has texture coordinates.

use super::tape::{self, Arriving, Tape};
use super::{CHUNK, Jacobian, Plan, plan};
use crate::appearance::{Appearance, LightSource};
use crate::bsdf::BsdfSample;
use crate::camera_sample::camera_ray;
use crate::path::{DirectLight, Emission, PathObserver, Transport, Vertex, Way};
use crate::query::{Parameter, Query};
use crate::radiance_cache::{CacheLookup, Cached, RadianceCache};
use crate::settings::Settings;
use crate::tracer::Tracer;
use crate::virtual_lamps::{MirrorsPassed, Passed};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use unrender_scene::{Camera, Material, Rgb};

/// The least cosine of a direction that is kept: rounding must not take one below the surface, where BRDFs are not
/// finite. It is the size of that rounding; half or double of it changes no result.
const COS_MIN: f32 = f32::EPSILON;

/// The paths of some pixels.
#[derive(Clone, Debug)]
pub struct StoredPaths {
    /// The materials that directions were drawn from.
    sampled_as: Vec<Material>,
    /// The number of paths of each pixel.
    spp: u32,
    /// The number of pixels.
    pixels: usize,
    /// The events of up to [`CHUNK`] pixels each.
    chunks: Vec<Vec<u32>>,
}

/// An event of a path. Its number and a group, or the index of a light, share a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    /// The paths of a pixel end.
    Pixel,
    /// A path begins.
    Path,
    /// The path arrives at a vertex of a group: `wo`.
    Vertex,
    /// The same where the surface has texture coordinates: `wo`, `uv`.
    TexturedVertex,
    /// It has bumps that shade themselves: the normal of the mesh below.
    Bumps,
    /// A light sample of a source contributes: where it comes from, and what arrives.
    Light,
    /// It comes by way of a mirror of a group: the cosine there.
    Mirrors,
    /// The path goes on: `wi`, and the factor on the BRDF.
    Bounce,
    /// It goes on as from a perfect mirror: the factor on the reflectance.
    Reflection,
    /// Glass on the way: its colour.
    Glass,
    /// The path hits what a source emits: what arrives.
    Emission,
    /// The path ends in the cache, at a pixel of it.
    Cached,
}

impl Event {
    const ALL: [Self; 12] = [
        Self::Pixel,
        Self::Path,
        Self::Vertex,
        Self::TexturedVertex,
        Self::Bumps,
        Self::Light,
        Self::Mirrors,
        Self::Bounce,
        Self::Reflection,
        Self::Glass,
        Self::Emission,
        Self::Cached,
    ];
    /// The bits of a word that hold the event.
    const BITS: u32 = 4;
}

impl Tracer {
    /// Traces the paths of the pixels of `query` (indices into a picture of `size`), drawn from the materials of its
    /// appearance, and keeps them, for derivatives by its parameters. The paths are those of [`Tracer::jacobian`] under
    /// the same seed, and without parameters those of [`Tracer::render_pixels`].
    ///
    /// ```
    /// use unrender_render::{Query, Settings, Tracer};
    /// # use unrender_scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};
    /// # let mut scene = Scene::default();
    /// # let mesh = Mesh::flat(&[glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y], &[], &[[0, 1, 2]]);
    /// # let material = Material::diffuse(Rgb::splat(0.5));
    /// # scene.groups.push(Group { name: "a".into(), material, emission: Rgb::ONE });
    /// # scene.objects.push(Object { name: "a".into(), group: 0, mesh });
    /// # let [eye, target] = [glam::Vec3::splat(2.0), glam::Vec3::ZERO];
    /// # let camera = Camera::look_at("camera", eye, target, glam::Vec3::Y, 0.8);
    /// let tracer = Tracer::new(&scene);
    /// let materials = scene.materials();
    /// let settings = Settings { spp: 4, ..Settings::default() };
    /// let paths = tracer.store(&camera, (8, 8), &Query::new(&materials, &[27, 28], &settings));
    /// let radiance = paths.replay(&tracer, &materials, &[], None).radiance;
    /// assert_eq!(radiance.len(), 2);
    /// ```
    ///
    /// # Panics
    /// If the appearance has fewer materials than the scene has groups.
    pub fn store(
        &self,
        camera: &Camera,
        size: (usize, usize),
        query: &Query<'_, u32, Settings, CacheLookup<'_>>,
    ) -> StoredPaths {
        let Query { appearance, pixels, parameters, settings, seen: cache } = *query;
        let drawn = plan::drawn(appearance.materials, parameters);
        let sampled_as = Appearance { materials: &drawn, ..appearance };
        let transport = Transport::new(self, sampled_as, settings.max_bounces).with_cache(cache);
        let chunk = |pixels: &[u32]| {
            let mut recorder = Recorder { words: Vec::new() };
            for pixel in pixels {
                for index in settings.samples() {
                    let mut sampler = settings.pixels(size.0).sampler(*pixel, index);
                    let ray = camera_ray(camera, size, *pixel, &mut sampler);
                    recorder.event(Event::Path, 0);
                    transport.trace_ray(&ray, &mut sampler, &mut recorder);
                }
                recorder.event(Event::Pixel, 0);
            }
            recorder.words.shrink_to_fit();
            recorder.words
        };
        StoredPaths {
            sampled_as: drawn.clone(),
            spp: settings.spp,
            pixels: pixels.len(),
            chunks: pixels.par_chunks(CHUNK).map(chunk).collect(),
        }
    }
}

impl StoredPaths {
    /// The memory that the paths take, bytes.
    pub fn bytes(&self) -> usize {
        self.chunks.iter().map(|words| size_of_val(words.as_slice())).sum()
    }

    /// The radiance of each pixel under `appearance`, in W sr^-1 m^-2, and its derivatives by `parameters`, on the
    /// stored paths of the scene of `tracer`. Paths that end in a cache bring the radiance that `cache` has there
    /// now, of as many pixels. As [`Tracer::radiance_reweighted`] this is unbiased if the materials that directions
    /// were drawn from reflect wherever those of `appearance` do.
    ///
    /// # Panics
    /// If the appearance has fewer materials than the scene has groups, or `cache` fewer pixels than the one that
    /// the paths were traced with.
    pub fn replay<'a>(
        &self,
        tracer: &Tracer,
        appearance: impl Into<Appearance<'a>>,
        parameters: &[Parameter],
        cache: Option<&RadianceCache>,
    ) -> Jacobian {
        let cache = cache.map(|cache| cache.radiance.pixels());
        let sampled_as = Appearance::from(&self.sampled_as);
        let plan = Plan::new(tracer, appearance.into(), sampled_as, parameters);
        let mut radiance = vec![Rgb::ZERO; self.pixels];
        let mut derivatives = vec![Rgb::ZERO; self.pixels * parameters.len()];
        if parameters.is_empty() {
            let outputs = radiance.par_chunks_mut(CHUNK);
            self.chunks.par_iter().zip(outputs).for_each(|(words, radiance)| {
                self.replay_chunk(words, (&plan, cache), radiance, &mut []);
            });
        } else {
            let rows = derivatives.par_chunks_mut(CHUNK * parameters.len());
            let outputs = radiance.par_chunks_mut(CHUNK).zip(rows);
            self.chunks.par_iter().zip(outputs).for_each(|(words, (radiance, rows))| {
                self.replay_chunk(words, (&plan, cache), radiance, rows);
            });
        }
        Jacobian { radiance, derivatives }
    }

    /// The pixels of one chunk.
    fn replay_chunk(
        &self,
        words: &[u32],
        (plan, cache): (&Plan<'_>, Option<&[Rgb]>),
        radiance: &mut [Rgb],
        rows: &mut [Rgb],
    ) {
        let mut tape = Tape::new(plan);
        let mut reader = Reader { words };
        let scale = 1.0 / f64::from(self.spp.max(1));
        let parameters = plan.slots.len();
        for (index, radiance) in radiance.iter_mut().enumerate() {
            *radiance = (reader.pixel(&mut tape, cache) * scale).as_vec3();
            let row = &mut rows[index * parameters..][..parameters];
            for (derivative, slot) in row.iter_mut().zip(&plan.slots) {
                let sum = slot.map_or(DVec3::ZERO, |slot| tape.sums[slot as usize]);
                *derivative = (sum * scale).as_vec3();
            }
            tape.sums.fill(DVec3::ZERO);
        }
    }
}

/// Writes the events of paths.
struct Recorder {
    words: Vec<u32>,
}

impl Recorder {
    #[inline]
    fn event(&mut self, event: Event, index: u32) {
        self.words.push(index << Event::BITS | event as u32);
    }

    #[inline]
    fn number(&mut self, number: f32) {
        self.words.push(number.to_bits());
    }

    fn numbers(&mut self, numbers: Vec3) {
        numbers.to_array().into_iter().for_each(|number| self.number(number));
    }

    /// A unit vector above the surface, by its stereographic projection from the pole below.
    #[inline]
    fn direction(&mut self, v: Vec3) {
        let scale = 1.0 / (1.0 + v.z);
        self.number(v.x * scale);
        self.number(v.y * scale);
    }

    /// The source of arriving light; two bits of the event's word are its kind.
    fn source(&mut self, event: Event, source: LightSource) {
        let (kind, index) = match source {
            LightSource::Group(group) => (0, group),
            LightSource::Punctual(light) => (1, light),
            LightSource::Environment(_) => (2, 0),
        };
        self.event(event, index << 2 | kind);
        if let LightSource::Environment(wi) = source {
            self.numbers(wi);
        }
    }
}

impl PathObserver for Recorder {
    #[inline]
    fn record_vertex(&mut self, at: &Vertex<'_>) {
        let group = at.surface.group;
        let uv = at.surface.uv;
        self.event(if uv == Vec2::ZERO { Event::Vertex } else { Event::TexturedVertex }, group);
        self.direction(at.wo);
        if uv != Vec2::ZERO {
            self.number(uv.x);
            self.number(uv.y);
        }
        if let Some(mesh) = at.bsdf.mesh() {
            self.event(Event::Bumps, 0);
            self.direction(mesh);
        }
    }

    #[inline]
    fn record_direct(&mut self, _: Rgb, _: &Vertex<'_>, light: &DirectLight<'_>) {
        for mirror in light.passed.all() {
            self.event(Event::Mirrors, mirror.group);
            self.number(mirror.cos);
        }
        self.source(Event::Light, light.sample.source);
        self.direction(light.wi);
        self.numbers(light.sample.weight * light.mis);
    }

    #[inline]
    fn record_bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32) {
        if sample.pdf.is_finite() {
            self.event(Event::Bounce, 0);
            self.direction(sample.wi);
        } else {
            self.event(Event::Reflection, 0);
        }
        self.number(tape::scale(at, sample, survival));
    }

    #[inline]
    fn record_glass(&mut self, way: &Way) {
        let filter = way.passage.filter;
        if filter != Rgb::ONE {
            self.event(Event::Glass, 0);
            self.numbers(filter);
        }
    }

    #[inline]
    fn record_emission(&mut self, _: Rgb, emission: &Emission, mis: f32) {
        self.source(Event::Emission, emission.source);
        self.numbers(emission.radiance * mis);
    }

    #[inline]
    fn record_cache_hit(&mut self, _: Rgb, cached: &Cached) {
        self.event(Event::Cached, cached.pixel);
    }
}

/// Reads the events of paths.
struct Reader<'a> {
    words: &'a [u32],
}

impl Reader<'_> {
    /// The next word; the events end before the words do.
    #[inline]
    fn word(&mut self) -> u32 {
        let (first, rest) = self.words.split_first().expect("every pixel has an end");
        self.words = rest;
        *first
    }

    #[inline]
    fn number(&mut self) -> f32 {
        f32::from_bits(self.word())
    }

    #[inline]
    fn numbers(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    #[inline]
    fn direction(&mut self) -> Vec3 {
        let (x, y) = (self.number(), self.number());
        let square = x * x + y * y;
        let scale = 1.0 / (1.0 + square);
        Vec3::new(2.0 * x * scale, 2.0 * y * scale, ((1.0 - square) * scale).max(COS_MIN))
    }

    #[inline]
    fn source(&mut self, index: u32) -> LightSource {
        match index & 3 {
            0 => LightSource::Group(index >> 2),
            1 => LightSource::Punctual(index >> 2),
            _ => LightSource::Environment(self.numbers()),
        }
    }

    /// Plays the paths of the next pixel, which end in the radiances of `cache`. Returns the sum of their radiances.
    fn pixel(&mut self, tape: &mut Tape<'_>, cache: Option<&[Rgb]>) -> DVec3 {
        let mut radiance = DVec3::ZERO;
        let mut passed = MirrorsPassed::default();
        tape.begin();
        loop {
            let word = self.word();
            let index = word >> Event::BITS;
            match Event::ALL[(word & ((1 << Event::BITS) - 1)) as usize] {
                Event::Pixel => return radiance + tape.finish().as_dvec3(),
                Event::Path => {
                    radiance += tape.finish().as_dvec3();
                    tape.begin();
                }
                Event::Vertex => {
                    let wo = self.direction();
                    tape.vertex(index, Vec2::ZERO, wo);
                }
                Event::TexturedVertex => {
                    let wo = self.direction();
                    let uv = Vec2::new(self.number(), self.number());
                    tape.vertex(index, uv, wo);
                }
                Event::Bumps => tape.bumps(self.direction()),
                Event::Mirrors => passed.push(Passed { group: index, cos: self.number() }),
                Event::Light => {
                    let (source, wi) = (self.source(index), self.direction());
                    tape.light(wi, &Arriving { source, weight: self.numbers(), passed });
                    passed = MirrorsPassed::default();
                }
                Event::Bounce => {
                    let wi = self.direction();
                    tape.bounce(wi, self.number());
                }
                Event::Reflection => tape.reflection(self.number()),
                Event::Glass => tape.glass(self.numbers()),
                Event::Emission => {
                    let source = self.source(index);
                    tape.emission(source, self.numbers());
                }
                Event::Cached => tape.cached(cache.map_or(Rgb::ZERO, |seen| seen[index as usize])),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_come_back_and_stay_above_the_surface() {
        for z in [1.0f32, 0.7, 1e-2, 1e-4, 1e-6, 1e-8, 1e-20] {
            let sin = (1.0 - z * z).sqrt();
            for phi in 0..8 {
                let (y, x) = (phi as f32).sin_cos();
                let direction = Vec3::new(sin * x, sin * y, z);
                let mut recorder = Recorder { words: Vec::new() };
                recorder.direction(direction);
                let found = Reader { words: &recorder.words }.direction();
                assert!((found - direction).length() < 3e-7 && found.z > 0.0, "{found} {z}");
            }
        }
    }
}
