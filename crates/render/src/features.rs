//! Features: what the camera sees at first hit, without noise of light, averaged over each pixel.
//!
//! The rays are those of the picture's samples, by the same random numbers, so that features have the same
//! share of every surface in a pixel as the picture has. Perfect mirrors are followed: their features are
//! those of what they show. Directly visible emission is known too, and need not be denoised. Where an edge crosses a
//! pixel, more rays measure its shares better than the samples do ([`Tracer::finer_features`]).

use crate::accel::Ray;
use crate::appearance::Appearance;
use crate::camera_sample::{PixelSamples, camera_ray};
use crate::film::{Accumulator, PixelAccumulator};
use crate::path::{LocalBsdf, RayHit, Transport};
use crate::settings::Settings;
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use unrender_scene::{Camera, Image, Rgb};

/// Most perfect mirrors in a row that are followed. Behind them Russian roulette decides whether paths go on
/// ([`crate::path`]), and emission is not seen by all samples: with double of it emission would be noisy, with half
/// of it mirrors in mirrors have no features.
const MIRRORS_MAX: u32 = 3;
/// Rays of a pixel that an edge crosses, for each sample of the picture. With half of them lamps have
/// edges 1.5 times as noisy, with double of them a picture full of edges takes as long as its samples.
const FINER: u32 = 8;
/// Samples of a pixel that no edge crosses differ in emission and in reflectance by this share at most; the
/// mean of some dozens of them is then known to a part in a hundred. With half of it smooth textures cost
/// rays, with double of it faint edges have none.
const SAME: f32 = 0.05;

/// The means of some quantities over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelFeatures {
    /// Radiance that is visible directly or through perfect mirrors: that of lamps and of the environment,
    /// W sr^-1 m^-2 per channel.
    pub emission: Rgb,
    /// Diffuse and specular reflectance together, times that of the mirrors before it, per channel; zero where no
    /// surface is visible.
    pub reflectance: Rgb,
    /// Shading normal on the viewer's side, world space; zero where no surface is visible. The mean of unit
    /// vectors.
    pub normal: Vec3,
    /// Inverse of the distance along the path, 1/metres; zero where no surface is visible. Like a depth, but
    /// linear over the pixels of a plane, as far as distance equals depth.
    pub nearness: f32,
    /// Whether samples differ in emission or reflectance: an edge or a texture is in the pixel.
    pub is_mixed: bool,
}

/// The features of all pixels.
pub type FeatureBuffers = Image<PixelFeatures>;

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Default)]
struct Sums {
    emission: DVec3,
    reflectance: DVec3,
    normal: DVec3,
    nearness: f64,
    /// Emission and reflectance of the last sample.
    last: Option<[Rgb; 2]>,
    is_mixed: bool,
}

impl Sums {
    /// Adds the emission and the reflectance of one sample.
    fn push(&mut self, emission: Rgb, reflectance: Rgb) {
        let same = |a: Rgb, b: Rgb| (a - b).abs().max_element() <= SAME * a.max(b).max_element();
        let is_like = |[e, r]: [Rgb; 2]| same(e, emission) && same(r, reflectance);
        self.is_mixed |= self.last.is_some_and(|last| !is_like(last));
        self.last = Some([emission, reflectance]);
        self.emission += emission.as_dvec3();
        self.reflectance += reflectance.as_dvec3();
    }

    fn mean(&self, count: u32) -> PixelFeatures {
        let n = f64::from(count.max(1));
        PixelFeatures {
            emission: (self.emission / n).as_vec3(),
            reflectance: (self.reflectance / n).as_vec3(),
            normal: (self.normal / n).as_vec3(),
            nearness: (self.nearness / n) as f32,
            is_mixed: self.is_mixed,
        }
    }
}

impl Tracer {
    /// The features of the samples in `accumulator`, which are the first ones of each pixel that
    /// [`Tracer::accumulate`] adds with the same `camera` and `settings` and [`crate::Integrator::Path`];
    /// `settings.spp` has no effect. One ray a sample, more behind mirrors.
    pub fn features<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        accumulator: &Accumulator,
    ) -> FeatureBuffers {
        let rays = FeatureRays::new(self, appearance.into(), camera, settings, accumulator.size());
        let of_pixel =
            |(pixel, samples): (usize, &PixelAccumulator)| rays.mean(pixel, samples.count);
        let pixels = accumulator.image().pixels().par_iter().enumerate().map(of_pixel).collect();
        Image::new(rays.size.0, rays.size.1, pixels)
    }

    /// The features of a picture whose two halves have the features `halves` and as many samples as are in
    /// `accumulator`: those of the first half, or of more rays where samples differ.
    pub fn finer_features<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        accumulator: &Accumulator,
        halves: [&FeatureBuffers; 2],
    ) -> FeatureBuffers {
        let rays = FeatureRays::new(self, appearance.into(), camera, settings, accumulator.size());
        let of_pixel = |(pixel, samples): (usize, &PixelAccumulator)| {
            let [a, b] = halves.map(|half| half.pixels()[pixel]);
            let is_mixed = a.is_mixed || b.is_mixed;
            if is_mixed { rays.mean(pixel, samples.count.saturating_mul(FINER)) } else { a }
        };
        let pixels = accumulator.image().pixels().par_iter().enumerate().map(of_pixel).collect();
        Image::new(rays.size.0, rays.size.1, pixels)
    }
}

/// The rays of the features of a picture.
pub(crate) struct FeatureRays<'a> {
    pub(crate) transport: Transport<'a>,
    pub(crate) camera: &'a Camera,
    samples: PixelSamples,
    pub(crate) size: (usize, usize),
}

impl<'a> FeatureRays<'a> {
    pub(crate) fn new(
        tracer: &'a Tracer,
        appearance: Appearance<'a>,
        camera: &'a Camera,
        settings: &Settings,
        size: (usize, usize),
    ) -> Self {
        let transport = Transport::new(tracer, appearance, settings.max_bounces);
        Self { transport, camera, samples: settings.pixels(size.0), size }
    }

    /// The rays of the first `count` samples of a pixel.
    pub(crate) fn of(&self, pixel: usize, count: u32) -> impl Iterator<Item = Ray> + '_ {
        (0..count).map(move |index| {
            let mut sampler = self.samples.sampler(pixel as u32, index);
            camera_ray(self.camera, self.size, pixel as u32, &mut sampler)
        })
    }

    /// The features of the first `count` samples of a pixel.
    fn mean(&self, pixel: usize, count: u32) -> PixelFeatures {
        let mut sums = Sums::default();
        self.of(pixel, count).for_each(|ray| self.transport.add_features(ray, &mut sums));
        sums.mean(count)
    }
}

impl Transport<'_> {
    /// Adds the features of what `ray` hits.
    fn add_features(&self, mut ray: Ray, sums: &mut Sums) {
        let (mut throughput, mut distance, mut emission) = (Rgb::ONE, 0.0, Rgb::ZERO);
        for mirrors in 0..=MIRRORS_MAX {
            // Behind glass the surface that most of the light comes from.
            let RayHit { surface, emission: of_hit, way } = self.follow(&ray, || 1.0);
            throughput *= way.passage.filter;
            emission += throughput * self.scaled(&of_hit);
            let Some(surface) = surface else { return sums.push(emission, Rgb::ZERO) };
            ray.direction = way.direction;
            distance += (surface.point - ray.origin).length();
            let LocalBsdf { bsdf, frame } = self.bsdf(&surface);
            let normal = frame.normal;
            let wi = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
            let is_followed = mirrors < MIRRORS_MAX && self.reflects(mirrors);
            if is_followed && bsdf.is_pure_mirror() && surface.is_above(wi) {
                throughput *= bsdf.coat.mirror(bsdf.rho_s, -ray.direction.dot(normal));
                ray = Self::leave(&surface, wi);
                continue;
            }
            sums.normal += normal.as_dvec3();
            sums.nearness += 1.0 / f64::from(distance).max(1e-6);
            return sums.push(emission, throughput * (bsdf.rho_d + bsdf.rho_s));
        }
    }
}
