//! What is rendered in passes: one picture, or a composite's scenes before and after.

use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};
use unrender_render::{Accumulator, Settings, Tracer};
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
}

impl<'a> PictureRender<'a> {
    pub(crate) fn new(scene: &Scene, camera: &'a Camera, settings: Settings) -> Self {
        Self { tracer: Tracer::new(scene), materials: scene.materials(), camera, settings }
    }
}

impl ProgressiveRender for PictureRender<'_> {
    fn layers(&self) -> &'static [&'static str] {
        &["picture"]
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let Self { tracer, materials, camera, settings } = self;
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
