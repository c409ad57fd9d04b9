//! Probes: the incident light at the surfaces behind given pixels, traced once, for any
//! reflectance.
//!
//! At a surface point the radiance towards `wo` is linear in the reflectances,
//!
//! ```text
//! L(wo) = E + rho_d D + rho_s S
//! D = 1/pi integral L(wi) cos_i dwi,     S = integral w(wo, wi) L(wi) cos_i dwi
//! ```
//!
//! and for a perfect mirror `S = M`, the radiance from the mirror direction. A probe holds `E`,
//! `D`, `M` and a set of incident samples `(wi, L cos_i / density)`; `S` for any roughness and anisotropy
//! direction is a sum over them.
//!
//! The samples come from a mixture: the cosine, half-vector lobes of given roughnesses, light
//! samples, and lobes about the mirror images of lamps ([`crate::guiding`]). Each is weighted by one
//! over the sum of all densities times their numbers, the multi-sample balance heuristic [Veach
//! 1997, section 9.2]. So the sum is unbiased for every lobe, and its variance is low for lobes like
//! those of the mixture.

use crate::accel::Ray;
use crate::appearance::Appearance;
use crate::bsdf::coat::Coat;
use crate::bsdf::lobe::GlossyLobe;
use crate::bsdf::{lambert, mirror};
use crate::camera_sample::camera_ray;
use crate::guiding::VmfMixture;
use crate::path::{MAX_BOUNCES, RayHit, Start, Transport, VisibleLight};
use crate::query::Query;
use crate::radiance_cache::CacheLookup;
use crate::sampler::Sampler;
use crate::surface::Surface;
use crate::tracer::Tracer;
use crate::veil::Passage;
use crate::virtual_lamps::MirrorTrail;
use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_PI;
use unrender_scene::{Camera, Material, Rgb};

/// The sampling of the probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeSettings {
    /// Camera rays per pixel; each becomes one probe.
    pub probes_per_pixel: u32,
    /// Directions by the cosine, as many light samples, and as many towards images of lamps in glossy
    /// planes, per probe.
    pub cosine: u32,
    /// Directions for each of `lobes`, per probe.
    pub per_lobe: u32,
    /// Half-vector lobes to draw directions from.
    pub lobes: Vec<ProposalLobe>,
    /// Paths in the mirror direction, per probe. A single one is very noisy where no cache ends it.
    pub mirror: u32,
    /// Whether to keep the incident samples, or only their sum `D`.
    pub keep_incident: bool,
    /// Whether camera rays continue at perfect mirrors, so that the probe lies on the reflected
    /// surface.
    pub through_mirrors: bool,
    /// The seed of the random numbers; the same seed gives the same bits.
    pub seed: u64,
    /// Most reflections along a path.
    pub max_bounces: u32,
}

impl Default for ProbeSettings {
    fn default() -> Self {
        Self {
            probes_per_pixel: 1,
            cosine: 16,
            per_lobe: 0,
            lobes: Vec::new(),
            mirror: 0,
            keep_incident: false,
            through_mirrors: false,
            seed: 0,
            max_bounces: MAX_BOUNCES,
        }
    }
}

/// A lobe to draw directions from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProposalLobe {
    /// Roughness along the anisotropy direction.
    pub alpha_x: f32,
    /// Roughness across it.
    pub alpha_y: f32,
    /// The angle of the anisotropy direction from the tangent, radians.
    pub theta_rad: f32,
}

impl ProposalLobe {
    /// The lobe of `material`.
    pub fn of(material: &Material) -> Self {
        let Material { alpha_x, alpha_y, theta_rad, .. } = *material;
        Self { alpha_x, alpha_y, theta_rad }
    }

    /// One lobe for each of `alphas`, as wide in all directions.
    pub fn round(alphas: &[f32]) -> Vec<Self> {
        let lobe = |&alpha: &f32| Self { alpha_x: alpha, alpha_y: alpha, theta_rad: 0.0 };
        alphas.iter().map(lobe).collect()
    }
}

/// One surface point behind a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// The pixel's index.
    pub pixel: u32,
    /// The group of the surface.
    pub group: u32,
    /// The throughput from the surface to the camera: below one where the path has mirrors.
    pub throughput: Rgb,
    /// Unit vector towards the camera (or the mirror before it), in the tangent frame.
    pub wo: Vec3,
    /// The surface point in world space, metres.
    pub point: Vec3,
    /// `E`: the radiance that the surface emits.
    pub emitted: Rgb,
    /// `D`: the radiance of a white diffuse surface.
    pub diffuse: Rgb,
    /// The part of `D` that comes straight from lights, or by way of planar mirrors: shadows have edges in it alone.
    pub straight: Rgb,
    /// `M`: the radiance of a perfect mirror; zero if not asked for.
    pub mirror: Rgb,
    /// The surface in the mirror direction, if asked for and present.
    pub mirrored: Option<Mirrored>,
    /// The index of its first sample in [`Probes::incident`].
    pub first: u32,
    /// The number of its samples.
    pub count: u32,
}

/// The surface that a perfect mirror would reflect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mirrored {
    /// The object's index in the scene.
    pub object: u32,
    /// The point on it, world space, metres.
    pub point: Vec3,
}

/// An incident light sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Incident {
    /// Unit vector towards the light's origin, in the tangent frame.
    pub wi: Vec3,
    /// `L cos_i` over the density: the sample's share of the irradiance, W m^-2.
    pub irradiance: Rgb,
}

/// The probes of some pixels, in the order of the pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Probes {
    /// One per camera ray that hit a surface.
    pub probes: Vec<Probe>,
    /// The incident samples of all probes, concatenated.
    pub incident: Vec<Incident>,
}

impl Probes {
    /// The incident samples of `probe`.
    pub fn incident_of(&self, probe: &Probe) -> &[Incident] {
        &self.incident[probe.first as usize..(probe.first + probe.count) as usize]
    }

    /// Appends the probes of other pixels.
    pub fn append(&mut self, other: Self) {
        let shift = self.incident.len() as u32;
        self.probes.extend(other.probes.into_iter().map(|p| Probe { first: p.first + shift, ..p }));
        self.incident.extend(other.incident);
    }
}

/// Pixels per parallel task. A probe traces hundreds of rays, so tasks are smaller than in
/// pictures.
const CHUNK: usize = 64;

impl Tracer {
    /// The probes at the surfaces behind the pixels of `query` (indices into a picture of `size`).
    pub fn probe(
        &self,
        camera: &Camera,
        size: (usize, usize),
        query: &Query<'_, u32, ProbeSettings, CacheLookup<'_>>,
    ) -> Probes {
        let Query { appearance, pixels, settings, seen: cache, .. } = *query;
        let gatherer = Gatherer::new(self, appearance, settings, cache);
        let chunks: Vec<Probes> = pixels
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut probes = Probes::default();
                for &pixel in chunk {
                    for index in 0..settings.probes_per_pixel {
                        gatherer.probe(camera, size, pixel, index, &mut probes);
                    }
                }
                probes
            })
            .collect();
        concatenate(chunks)
    }
}

fn concatenate(chunks: Vec<Probes>) -> Probes {
    let mut all = Probes {
        probes: Vec::with_capacity(chunks.iter().map(|p| p.probes.len()).sum()),
        incident: Vec::with_capacity(chunks.iter().map(|p| p.incident.len()).sum()),
    };
    chunks.into_iter().for_each(|chunk| all.append(chunk));
    all
}

/// The sampling techniques of a probe; each has its own stream of random numbers.
const CAMERA: u64 = 0;
const MIRROR: u64 = 1;
const LIGHT: u64 = 2;
const COSINE: u64 = 3;
const IMAGE: u64 = 4;
const FIRST_LOBE: u64 = 5;
const STREAMS: u64 = 16;
/// Most mirrors in a row that a camera ray follows; beyond, their product of reflectances is small.
const MIRRORS_MAX: usize = 16;

/// Gathers probes.
struct Gatherer<'a> {
    transport: Transport<'a>,
    materials: &'a [Material],
    settings: &'a ProbeSettings,
    lobes: Vec<RotatedLobe>,
}

/// A lobe in a frame that is rotated about the normal.
#[derive(Clone, Copy)]
struct RotatedLobe {
    lobe: GlossyLobe,
    cos: f32,
    sin: f32,
}

/// The surface of a probe.
struct FirstSurface {
    surface: Surface,
    /// Unit vector back along the ray, world space.
    wo: Vec3,
    /// Of the mirrors on the way.
    throughput: Rgb,
    /// The number of mirrors on the way.
    bounces: u32,
}

/// What the mirror direction of a probe shows.
struct MirrorView {
    radiance: Rgb,
    surface: Option<Mirrored>,
}

impl<'a> Gatherer<'a> {
    fn new(
        tracer: &'a Tracer,
        appearance: Appearance<'a>,
        settings: &'a ProbeSettings,
        cache: Option<CacheLookup<'a>>,
    ) -> Self {
        assert!(settings.lobes.len() as u64 <= STREAMS - FIRST_LOBE, "too many proposal lobes");
        let lobes = settings.lobes.iter().map(|lobe| {
            let (sin, cos) = lobe.theta_rad.sin_cos();
            let lobe = GlossyLobe::new(tracer.model, lobe.alpha_x, lobe.alpha_y);
            RotatedLobe { lobe, cos, sin }
        });
        Self {
            transport: Transport::new(tracer, appearance, settings.max_bounces).with_cache(cache),
            materials: appearance.materials,
            settings,
            lobes: lobes.collect(),
        }
    }

    fn sampler(&self, pixel: u32, technique: u64, index: u32) -> Sampler {
        Sampler::new(self.settings.seed, u64::from(pixel) * STREAMS + technique, index)
    }

    /// Gathers the probe of one camera ray and appends it to `out`.
    fn probe(
        &self,
        camera: &Camera,
        size: (usize, usize),
        pixel: u32,
        index: u32,
        out: &mut Probes,
    ) {
        let ray = camera_ray(camera, size, pixel, &mut self.sampler(pixel, CAMERA, index));
        let Some(first) = self.first_surface(ray) else { return };
        let FirstSurface { surface, wo, throughput, bounces } = first;
        let wo_local = surface.frame.local_from_viewer(wo);
        let first = out.incident.len();
        let images = self.transport.images(&surface);
        let [received, straight] = [Rgb::ZERO; 2];
        let wo = wo_local;
        let mut gathering =
            Gathering { gatherer: self, surface, wo, bounces, images, received, straight, out };
        // Mirrors on the way may have used up all bounces.
        let reflects = bounces < self.settings.max_bounces;
        if reflects && wo_local.z > 0.0 {
            gathering.lights(pixel, index);
            gathering.directions(pixel, index);
        }
        let mirror = if reflects { gathering.mirror(pixel, index) } else { None };
        let [received, straight] = [gathering.received, gathering.straight];
        if !self.settings.keep_incident {
            out.incident.truncate(first);
        }
        out.probes.push(Probe {
            pixel,
            group: surface.group,
            throughput,
            wo: wo_local,
            point: surface.point,
            emitted: self.transport.emitted(&surface),
            diffuse: received * FRAC_1_PI,
            straight: straight * FRAC_1_PI,
            mirror: mirror.as_ref().map_or(Rgb::ZERO, |m| m.radiance),
            mirrored: mirror.and_then(|m| m.surface),
            first: first as u32,
            count: (out.incident.len() - first) as u32,
        });
    }

    /// The first surface along a camera ray, or with [`ProbeSettings::through_mirrors`] the first
    /// that is no perfect mirror.
    fn first_surface(&self, mut ray: Ray) -> Option<FirstSurface> {
        let mut throughput = Rgb::ONE;
        for bounces in 0..MIRRORS_MAX {
            let surface = self.transport.tracer.surface(&ray)?;
            let wo = -ray.direction;
            let material = &self.materials[surface.group as usize];
            if !(self.settings.through_mirrors && material.is_pure_mirror()) {
                return Some(FirstSurface { surface, wo, throughput, bounces: bounces as u32 });
            }
            let frame = surface.lobe_frame();
            let local = frame.local_from_viewer(wo);
            let wi = frame.world_from_local(mirror::reflect(local));
            if !surface.is_above(wi) {
                return None;
            }
            throughput *= Coat::new(material).mirror(material.rho_s, local.z);
            ray = Transport::leave(&surface, wi);
        }
        None
    }
}

/// The vector in a frame that is rotated about z by the angle with the given cosine and sine.
#[inline]
fn rotated(v: Vec3, cos: f32, sin: f32) -> Vec3 {
    Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
}

/// The gathering of one probe.
struct Gathering<'a, 'b> {
    gatherer: &'b Gatherer<'a>,
    surface: Surface,
    wo: Vec3,
    bounces: u32,
    /// The lobes about the images of lamps, if there are any.
    images: VmfMixture,
    /// What a white base received so far, and the part that came straight from lights.
    received: Rgb,
    straight: Rgb,
    out: &'b mut Probes,
}

impl Gathering<'_, '_> {
    /// The sum of the densities of all directional techniques, each times its number of samples.
    fn density(&self, wi: Vec3) -> f32 {
        let settings = self.gatherer.settings;
        let mut density = settings.cosine as f32 * (lambert::pdf(wi) + self.images.pdf(wi));
        for RotatedLobe { lobe, cos, sin } in &self.gatherer.lobes {
            let pdf = lobe.pdf(rotated(self.wo, *cos, *sin), rotated(wi, *cos, *sin));
            density += settings.per_lobe as f32 * pdf;
        }
        density
    }

    /// Takes the light samples.
    fn lights(&mut self, pixel: u32, index: u32) {
        let count = self.gatherer.settings.cosine;
        for k in 0..count {
            let mut sampler = self.gatherer.sampler(pixel, LIGHT, index * count + k);
            let [pick, u, v, again] = sampler.next4();
            let transport = &self.gatherer.transport;
            let straight = transport.visible_light(&self.surface, [pick, u, v]);
            let mirrored = transport.virtual_light(&self.surface, [again, u, v], self.bounces);
            for VisibleLight { wi, weight, pdf, by_direction } in
                straight.into_iter().chain(mirrored)
            {
                let wi = self.surface.frame.local_from_world(wi);
                let factor = match pdf {
                    Some(pdf) => pdf / (count as f32 * pdf + self.density(wi) * by_direction),
                    None => 1.0 / count as f32,
                };
                let received = self.keep(wi, weight * factor);
                self.straight += received;
            }
        }
    }

    /// Traces the directions by the cosine and by the lobes.
    fn directions(&mut self, pixel: u32, index: u32) {
        let settings = self.gatherer.settings;
        for k in 0..settings.cosine {
            let mut sampler = self.gatherer.sampler(pixel, COSINE, index * settings.cosine + k);
            let [u, v, ..] = sampler.next4();
            self.follow(lambert::sample([u, v]), sampler);
        }
        // As many as by the cosine, since it is not known which find more light.
        let images = if self.images.share() > 0.0 { settings.cosine } else { 0 };
        for k in 0..images {
            let mut sampler = self.gatherer.sampler(pixel, IMAGE, index * settings.cosine + k);
            let [pick, u, v, _] = sampler.next4();
            self.follow(self.images.sample(pick, [u, v]), sampler);
        }
        for lobe in 0..settings.lobes.len() {
            let technique = FIRST_LOBE + lobe as u64;
            for k in 0..settings.per_lobe {
                let number = index * settings.per_lobe + k;
                let mut sampler = self.gatherer.sampler(pixel, technique, number);
                let [u, v, ..] = sampler.next4();
                let RotatedLobe { lobe, cos, sin } = self.gatherer.lobes[lobe];
                let wi = lobe.sample(rotated(self.wo, cos, sin), [u, v]);
                self.follow(rotated(wi, cos, -sin), sampler);
            }
        }
    }

    /// Traces the ray along `wi` and keeps emitted and reflected light as separate samples: only
    /// emission can also come from a light sample.
    fn follow(&mut self, wi: Vec3, mut sampler: Sampler) {
        let world = self.surface.frame.world_from_local(wi);
        if !self.surface.is_above(world) {
            return;
        }
        let transport = &self.gatherer.transport;
        let density = self.density(wi);
        let lights = self.gatherer.settings.cosine as f32;
        let hit = transport.hit(&self.surface, world, &mut sampler);
        let Passage { filter, probability } = hit.way.passage;
        let emitted = filter * transport.scaled(&hit.emission);
        if emitted != Rgb::ZERO {
            let by_light = lights * transport.light_pdf(&self.surface, &hit);
            let density = density * probability + by_light;
            let received = self.keep(wi, emitted * probability / density);
            self.straight += received;
        }
        let Some(next) = hit.surface else { return };
        let samples = self.gatherer.settings.cosine;
        let trail = MirrorTrail::new(&self.surface, density, samples);
        let trail = hit.way.is_open.then_some(trail);
        let (wo, bounce) = (-hit.way.direction, self.bounces + 1);
        let reflected = transport.reflected(next, wo, &mut sampler, Start::of_many(bounce), trail);
        self.keep(wi, filter * reflected / density);
    }

    /// Keeps a sample; returns what a white base receives of it.
    fn keep(&mut self, wi: Vec3, weighted_radiance: Rgb) -> Rgb {
        let irradiance = weighted_radiance * wi.z;
        if !(irradiance.max_element() > 0.0 && irradiance.is_finite()) {
            return Rgb::ZERO;
        }
        self.out.incident.push(Incident { wi, irradiance });
        let Surface { frame, mesh_normal, shades_itself, .. } = &self.surface;
        let lit = || lambert::lit(frame.local_from_world(*mesh_normal), wi);
        let received = if *shades_itself { irradiance * lit() } else { irradiance };
        self.received += received;
        received
    }

    /// Traces the mirror direction; none if not asked for, or if the direction lies below the
    /// surface.
    fn mirror(&self, pixel: u32, index: u32) -> Option<MirrorView> {
        let frame = self.surface.lobe_frame();
        let wo = frame.local_from_viewer(self.surface.to_viewer);
        let wi = frame.world_from_local(mirror::reflect(wo));
        let count = self.gatherer.settings.mirror;
        if count == 0 || !self.surface.is_above(wi) {
            return None;
        }
        let transport = &self.gatherer.transport;
        let (mut emitted, mut reflected) = (Rgb::ZERO, Rgb::ZERO);
        for k in 0..count {
            let mut sampler = self.gatherer.sampler(pixel, MIRROR, index * count + k);
            let RayHit { surface, emission, way } = transport.hit(&self.surface, wi, &mut sampler);
            emitted += way.passage.filter * transport.scaled(&emission);
            let Some(next) = surface else { continue };
            let (wo, bounce) = (-way.direction, self.bounces + 1);
            reflected += way.passage.filter
                * transport.reflected(next, wo, &mut sampler, Start::of_many(bounce), None);
        }
        let radiance = emitted / count as f32 + reflected / count as f32;
        let next = transport.shown(&Transport::leave(&self.surface, wi));
        let surface = next.map(|next| Mirrored { object: next.object, point: next.point });
        Some(MirrorView { radiance, surface })
    }
}
