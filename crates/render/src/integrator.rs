//! Rendering pictures: which samples every pixel takes, by which integrator.
//!
//! [`Tracer::render`] takes the same number of samples in all pixels. [`Tracer::accumulate`] adds
//! any [`SampleAllocation`] to an accumulator, so that pictures can be rendered in shards or
//! adaptively ([`crate::adaptive`]). Two integrators estimate the samples: [`Integrator::Path`]
//! traces independent paths ([`crate::path`]), [`Integrator::PathReuse`] reuses the paths of
//! neighbouring pixels (`crate::path_reuse`).

use crate::adaptive::{self, AdaptiveSampling, SampleAllocation};
use crate::appearance::Appearance;
use crate::camera_sample::camera_ray;
use crate::film::{Accumulator, Film, PixelAccumulator};
use crate::path::Transport;
use crate::path_reuse::PathReuse;
use crate::settings::{Integrator, Settings};
use crate::tracer::Tracer;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_scene::{Camera, Rgb};

/// Pixels per parallel task, after which it reports progress.
pub(crate) const CHUNK: usize = 256;

impl Tracer {
    /// Renders what `camera` sees in `width` x `height` pixels. `progress` is called with the
    /// completed fraction, 0 to 1, from any thread.
    ///
    /// ```
    /// use glam::Vec3;
    /// use unrender_render::{Settings, Tracer};
    /// use unrender_scene::{
    ///     Camera, Environment, Group, Material, Mesh, Object, Rgb, RgbImage, Scene,
    /// };
    ///
    /// // A ball of reflectance 0.5 in light of radiance one from everywhere.
    /// let mut scene = Scene::default();
    /// let material = Material::diffuse(Rgb::splat(0.5));
    /// scene.groups.push(Group { name: "ball".into(), material, emission: Rgb::ZERO });
    /// let mesh = Mesh::sphere(Vec3::ZERO, 1.0);
    /// scene.objects.push(Object { name: "ball".into(), group: 0, mesh });
    /// scene.environment = Some(Environment::new(RgbImage::new(1, 1, vec![Rgb::ONE]), 0.0)?);
    /// let camera = Camera::look_at("camera", 4.0 * Vec3::Z, Vec3::ZERO, Vec3::Y, 0.2);
    /// let tracer = Tracer::new(&scene);
    /// let settings = Settings { spp: 64, ..Settings::default() };
    /// let film = tracer.render(&scene.materials(), &camera, (8, 8), &settings, &|_| {});
    /// assert!((film.mean.at(4, 4).x - 0.5).abs() < 0.02);
    /// # Ok::<(), unrender_scene::EnvironmentError>(())
    /// ```
    pub fn render<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        (width, height): (usize, usize),
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Film {
        let mut accumulator = Accumulator::new(width, height);
        let samples = SampleAllocation::Uniform(settings.samples());
        self.accumulate(appearance, camera, settings, &samples, &mut accumulator, progress);
        accumulator.film()
    }

    /// Renders some pixels of the picture, given by index: mean and variance of each. They are path
    /// traced, whatever `settings.integrator` says.
    pub fn render_pixels<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<(Rgb, Rgb)> {
        let tracing = PathTracing::new(self, appearance.into(), camera, size, settings);
        pixels.par_chunks(CHUNK).flat_map_iter(|chunk| tracing.estimates(chunk)).collect()
    }

    /// The efficiency of path reuse in the picture of `size`: the number of independent samples
    /// that have the variance of one sample with reuse; may be infinite. None where reuse costs
    /// more than it saves, and [`Integrator::PathReuse`] traces independent paths.
    pub fn path_reuse_efficiency<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        settings: &Settings,
    ) -> Option<f64> {
        PathTracing::new(self, appearance.into(), camera, size, settings).with_reuse().efficiency()
    }

    /// Adds the samples of the allocation to `accumulator`, which has the size of the picture;
    /// `settings.spp` has no effect. [`Tracer::render`] takes the samples of `settings` of all pixels: an
    /// accumulator of those, in however many calls, gives the same bits. `progress` is called with
    /// the completed fraction, 0 to 1, from any thread.
    pub fn accumulate<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        samples: &SampleAllocation<'_>,
        accumulator: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let size = accumulator.size();
        let tracing = PathTracing::new(self, appearance.into(), camera, size, settings);
        if settings.integrator == Integrator::PathReuse {
            let reuse = tracing.with_reuse();
            if reuse.efficiency().is_some() {
                return reuse.accumulate(samples, accumulator, progress);
            }
        }
        tracing.accumulate(samples, accumulator, progress);
    }

    /// The adaptive sampling of a picture of `size`, from a pilot rendering. Depends on the seed
    /// and not on `settings.spp`.
    pub fn adaptive_sampling<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        (width, height): (usize, usize),
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> AdaptiveSampling {
        let settings = Settings { seed: adaptive::pilot_seed(settings.seed), ..*settings };
        let samples = SampleAllocation::Uniform(0..adaptive::PILOT);
        let mut pilot = Accumulator::new(width, height);
        self.accumulate(appearance, camera, &settings, &samples, &mut pilot, progress);
        AdaptiveSampling::from_pilot(&pilot)
    }
}

/// The path tracing integrator of a picture.
struct PathTracing<'a> {
    transport: Transport<'a>,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

impl<'a> PathTracing<'a> {
    fn new(
        tracer: &'a Tracer,
        appearance: Appearance<'a>,
        camera: &'a Camera,
        size: (usize, usize),
        settings: &'a Settings,
    ) -> Self {
        let transport = Transport::new(tracer, appearance, settings.max_bounces);
        Self { transport, camera, size, settings }
    }

    /// The integrator with path reuse of the same picture.
    fn with_reuse(&self) -> PathReuse<'_> {
        let Self { transport, camera, size, settings } = self;
        PathReuse { transport, camera, size: *size, samples: settings.pixels(size.0) }
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        accumulator: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let pixels = accumulator.image_mut().pixels_mut();
        let count = pixels.len();
        let done = AtomicUsize::new(0);
        pixels.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, pixels)| {
            for (offset, accumulator) in pixels.iter_mut().enumerate() {
                let pixel = chunk * CHUNK + offset;
                self.add(pixel as u32, samples.of(pixel), accumulator);
            }
            let so_far = done.fetch_add(pixels.len(), Ordering::Relaxed) + pixels.len();
            progress(so_far as f64 / count as f64);
        });
    }

    /// Mean and variance of some pixels.
    fn estimates(&self, pixels: &[u32]) -> Vec<(Rgb, Rgb)> {
        let one = |&pixel: &u32| {
            let mut accumulator = PixelAccumulator::default();
            self.add(pixel, self.settings.samples(), &mut accumulator);
            (accumulator.mean(), accumulator.variance())
        };
        pixels.iter().map(one).collect()
    }

    /// Adds the samples of the numbers `samples` to a pixel.
    fn add(&self, pixel: u32, samples: Range<u32>, accumulator: &mut PixelAccumulator) {
        for index in samples {
            let mut sampler = self.settings.pixels(self.size.0).sampler(pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            accumulator.push(self.transport.radiance(&ray, &mut sampler));
        }
    }
}
