//! Pictures: many paths a pixel, their mean and how sure it is.

use crate::accel::Ray;
use crate::adaptive::Samples;
use crate::path::{MAX_BOUNCES, Transport};
use crate::sampler::Sampler;
use crate::sharing::Sharing;
use crate::tally::{Moments, Tally};
use crate::tracer::{Appearance, Tracer};
use rayon::prelude::*;
use std::ops::Range;
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
    /// Whether neighbouring pixels may share what their paths find (module [`crate::sharing`]), as
    /// they then do where it pays: less noise, but alike in pixels that share. For whole pictures
    /// only.
    pub shared: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { spp: 64, seed: 0, max_bounces: MAX_BOUNCES, shared: false }
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
        let mut tally = Tally::new(width, height);
        let samples = Samples::Even(0..settings.spp);
        self.accumulate(appearance, camera, settings, &samples, &mut tally, progress);
        tally.film()
    }

    /// Renders some pixels of the picture, given by index: mean and variance of each. They share
    /// nothing, whatever `settings` say.
    pub fn render_pixels<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<(Rgb, Rgb)> {
        let painter = Painter::new(self, appearance.into(), camera, size, settings);
        pixels.par_chunks(CHUNK).flat_map_iter(|chunk| painter.estimates(chunk)).collect()
    }

    /// How many paths that share nothing a path that shares what it finds is worth in the picture of
    /// `size`, as far as its noise goes; may be infinite. None where sharing does not pay, and where
    /// [`Settings::shared`] has no effect.
    pub fn worth_of_sharing<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        settings: &Settings,
    ) -> Option<f64> {
        Painter::new(self, appearance.into(), camera, size, settings).sharing().worth()
    }

    /// Adds the paths that `samples` asks for to `tally`, whose size is the picture's;
    /// `settings.spp` does not count. The paths of [`Tracer::render`] are
    /// the numbers 0..spp of all pixels: a tally of those, however many calls it was made in, has
    /// the same bits as its picture. `progress` hears the share done, 0 to 1, from any thread.
    pub fn accumulate<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        samples: &Samples<'_>,
        tally: &mut Tally,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let painter = Painter::new(self, appearance.into(), camera, tally.size(), settings);
        if settings.shared {
            let sharing = painter.sharing();
            if sharing.worth().is_some() {
                sharing.accumulate(samples, tally, progress);
                return;
            }
        }
        let pixels = tally.moments.pixels_mut();
        let count = pixels.len();
        let done = AtomicUsize::new(0);
        pixels.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, pixels)| {
            for (offset, moments) in pixels.iter_mut().enumerate() {
                let pixel = chunk * CHUNK + offset;
                painter.add(pixel as u32, samples.of(pixel), moments);
            }
            let so_far = done.fetch_add(pixels.len(), Ordering::Relaxed) + pixels.len();
            progress(so_far as f64 / count as f64);
        });
    }
}

/// What the pixels of a picture share.
struct Painter<'a> {
    transport: Transport<'a>,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

impl<'a> Painter<'a> {
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

    /// The same with pixels that share.
    fn sharing(&self) -> Sharing<'_> {
        let Self { transport, camera, size, settings } = self;
        Sharing { transport, camera, size: *size, seed: settings.seed }
    }

    /// Mean and variance of some pixels.
    fn estimates(&self, pixels: &[u32]) -> Vec<(Rgb, Rgb)> {
        let one = |&pixel: &u32| {
            let mut moments = Moments::default();
            self.add(pixel, 0..self.settings.spp, &mut moments);
            (moments.mean(), moments.variance())
        };
        pixels.iter().map(one).collect()
    }

    /// Adds the paths of the numbers `samples` to what a pixel has brought.
    fn add(&self, pixel: u32, samples: Range<u32>, moments: &mut Moments) {
        for index in samples {
            let mut sampler = picture_sampler(self.settings.seed, pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            moments.push(self.transport.radiance(&ray, &mut sampler, 0));
        }
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
