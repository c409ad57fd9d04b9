//! Pictures: many paths a pixel, their mean and how sure it is.

use crate::accel::Ray;
use crate::path::{MAX_BOUNCES, Transport};
use crate::sampler::Sampler;
use crate::tracer::{Appearance, Tracer};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_scene::{Camera, Rgb, RgbImage};

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Paths a pixel.
    pub spp: u32,
    /// Another seed, another noise.
    pub seed: u64,
    /// Reflections along a path at most; one means direct light only.
    pub max_bounces: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { spp: 64, seed: 0, max_bounces: MAX_BOUNCES }
    }
}

/// A picture with the variance of its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub mean: RgbImage,
    /// Variance of `mean`, from the spread of the paths. Paths of a pixel are stratified, so the
    /// true variance is at most this. Zero with a single path.
    pub variance: RgbImage,
}

/// Keeps the numbers of pictures apart from those of probes under the same seed.
pub(crate) const STREAM: u64 = 0x0F11_0000_0000_0000;

/// Pixels that one task renders before it reports progress.
pub(crate) const CHUNK: usize = 256;

impl Tracer {
    /// Renders what `camera` sees in `width` x `height` pixels. `progress` hears the share done, 0
    /// to 1, from any thread.
    pub fn render<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        (width, height): (usize, usize),
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Film {
        let appearance = appearance.into();
        let pixels: Vec<u32> = (0..(width * height) as u32).collect();
        let done = AtomicUsize::new(0);
        let estimates: Vec<(Rgb, Rgb)> = pixels
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| {
                let part = self.render_chunk(appearance, camera, (width, height), chunk, settings);
                let so_far = done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len();
                progress(so_far as f64 / pixels.len() as f64);
                part
            })
            .collect();
        let picture = |f: fn(&(Rgb, Rgb)) -> Rgb| {
            RgbImage::new(width, height, estimates.iter().map(f).collect())
        };
        Film { mean: picture(|e| e.0), variance: picture(|e| e.1) }
    }

    /// Renders some pixels of the picture, given by index: mean and variance of each.
    pub fn render_pixels<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<(Rgb, Rgb)> {
        let appearance = appearance.into();
        pixels
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| self.render_chunk(appearance, camera, size, chunk, settings))
            .collect()
    }

    fn render_chunk(
        &self,
        appearance: Appearance<'_>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<(Rgb, Rgb)> {
        let transport = Transport::new(self, appearance, settings.max_bounces);
        let one = |&pixel: &u32| {
            let mut sum = DVec3::ZERO;
            let mut squares = DVec3::ZERO;
            for index in 0..settings.spp {
                let mut sampler = picture_sampler(settings.seed, pixel, index);
                let ray = camera_ray(camera, size, pixel, &mut sampler);
                let radiance = transport.radiance(&ray, &mut sampler, 0).as_dvec3();
                sum += radiance;
                squares += radiance * radiance;
            }
            let n = f64::from(settings.spp.max(1));
            let mean = sum / n;
            let spread = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0).max(1.0);
            (mean.as_vec3(), spread.as_vec3())
        };
        pixels.iter().map(one).collect()
    }
}

/// The numbers of the path number `index` through a pixel of a picture.
pub fn picture_sampler(seed: u64, pixel: u32, index: u32) -> Sampler {
    Sampler::new(seed ^ STREAM, u64::from(pixel), index)
}

/// A ray through a random point of a pixel: the picture's filter is the pixel itself.
pub fn camera_ray(
    camera: &Camera,
    (width, height): (usize, usize),
    pixel: u32,
    sampler: &mut Sampler,
) -> Ray {
    let [dx, dy, ..] = sampler.next4();
    let x = (pixel as usize % width) as f32 + dx;
    let y = (pixel as usize / width) as f32 + dy;
    Ray::new(camera.origin(), camera.direction(x, y, width, height))
}
