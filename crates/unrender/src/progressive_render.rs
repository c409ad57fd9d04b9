//! What is rendered in passes: one picture, or a composite's scenes before and after.

use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};
use unrender_render::denoise::Denoised;
use unrender_render::{Accumulator, Integrator, Settings, Tracer};
use unrender_restage::pair::{self, Pairing};
use unrender_scene::{Camera, Material, Scene};

/// What is rendered: a picture, or several sums of one at once.
pub(crate) trait ProgressiveRender {
    /// What each sum is called; the first is the picture whose noise counts.
    fn layers(&self) -> &'static [&'static str];

    /// Adds the paths that `samples` asks for to `layers`.
    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    );

    /// How many paths each pixel should get, by a pilot picture of `size`.
    fn adaptive_sampling(&self, size: (usize, usize)) -> AdaptiveSampling;
}

/// One picture of a scene.
pub(crate) struct PictureRender<'a> {
    tracer: Tracer,
    materials: Vec<Material>,
    camera: &'a Camera,
    settings: Settings,
    /// Whether it is to be denoised, which two independent halves of it are for.
    is_halved: bool,
}

impl<'a> PictureRender<'a> {
    pub(crate) fn new(scene: &Scene, camera: &'a Camera, settings: Settings) -> Self {
        let (tracer, materials) = (Tracer::new(scene), scene.materials());
        Self { tracer, materials, camera, settings, is_halved: false }
    }

    /// The same picture in two halves of independent paths, if `denoise`.
    pub(crate) fn halved(mut self, denoise: bool) -> Self {
        if denoise {
            self.is_halved = true;
            self.settings.integrator = Integrator::Path;
        }
        self
    }

    /// The picture whose `layers` were accumulated, denoised, if it is to be.
    pub(crate) fn denoised(&self, layers: &[Accumulator]) -> Option<Denoised> {
        let [picture, second] = layers else { return None };
        let first = picture.without(second);
        let Self { tracer, materials, camera, settings, .. } = self;
        Some(tracer.denoise(materials, camera, settings, [&first, second]))
    }

    /// Adds the paths of both halves: to the picture, and those of the second one to `second` too.
    fn accumulate_halves(
        &self,
        samples: &SampleAllocation<'_>,
        picture: &mut Accumulator,
        second: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let (width, height) = picture.size();
        let mut added = Accumulator::new(width, height);
        for (half, sum) in [&mut *picture, &mut added].into_iter().enumerate() {
            let progress = |done: f64| progress((half as f64 + done) / 2.0);
            let Self { tracer, materials, camera, settings, .. } = self;
            tracer.accumulate_half(materials, camera, settings, (samples, half), sum, &progress);
        }
        picture.add(&added);
        second.add(&added);
    }
}

impl ProgressiveRender for PictureRender<'_> {
    fn layers(&self) -> &'static [&'static str] {
        if self.is_halved { &["picture", "second half"] } else { &["picture"] }
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        if let [picture, second] = layers {
            return self.accumulate_halves(samples, picture, second, progress);
        }
        let Self { tracer, materials, camera, settings, .. } = self;
        tracer.accumulate(materials, camera, settings, samples, &mut layers[0], progress);
    }

    fn adaptive_sampling(&self, size: (usize, usize)) -> AdaptiveSampling {
        self.tracer.adaptive_sampling(&self.materials, self.camera, size, &self.settings, &|_| ())
    }
}

impl ProgressiveRender for Pairing<'_> {
    fn layers(&self) -> &'static [&'static str] {
        &pair::LAYERS
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        self.accumulate(samples, layers, progress);
    }

    fn adaptive_sampling(&self, size: (usize, usize)) -> AdaptiveSampling {
        self.adaptive_sampling(size)
    }
}
