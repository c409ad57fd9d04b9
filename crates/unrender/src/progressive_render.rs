//! Renderings in passes: one picture, or a composite's scenes before and after.

use unrender_formats::picture::LightLayer;
use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};
use unrender_render::denoise::Denoised;
use unrender_render::{Accumulator, Integrator, Settings, Tracer};
use unrender_restage::pair::{self, Pairing};
use unrender_scene::{Camera, ENVIRONMENT, Material, Scene};

/// A rendering: a picture, or several sums of one at once.
pub(crate) trait ProgressiveRender {
    /// The name of each sum; the first is the picture whose noise counts.
    fn layers(&self) -> Vec<String>;

    /// Adds the paths of `samples` to `layers`.
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
    sums: Sums,
}

/// The sums of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Sums {
    /// The picture.
    Whole,
    /// The picture and its second half, independent of the first, for denoising.
    Halves,
    /// The picture and the contribution of each of these lights.
    Lights(Vec<String>),
}

impl<'a> PictureRender<'a> {
    pub(crate) fn new(scene: &Scene, camera: &'a Camera, settings: Settings) -> Self {
        let (tracer, materials) = (Tracer::new(scene), scene.materials());
        Self { tracer, materials, camera, settings, sums: Sums::Whole }
    }

    /// The same picture in two halves of independent paths, if `denoise`.
    pub(crate) fn halved(mut self, denoise: bool) -> Self {
        if denoise {
            self.sums = Sums::Halves;
            self.settings.integrator = Integrator::Path;
        }
        self
    }

    /// The same picture with the contribution of each light of its `scene`.
    pub(crate) fn by_light(mut self, scene: &Scene) -> Self {
        let around = scene.environment_parts();
        let name = |place: usize| match place.checked_sub(around.start) {
            Some(part) if around.len() > 1 => format!("{ENVIRONMENT} {part}"),
            _ => {
                let source = scene.sources().find(|source| source.index == place);
                source.map_or_else(|| place.to_string(), |source| source.name.to_owned())
            }
        };
        let mut names: Vec<String> = Vec::new();
        for name in self.tracer.light_sources().into_iter().map(name) {
            let numbered = (2..).map(|number| format!("{name} {number}"));
            let free = std::iter::once(name.clone()).chain(numbered).find(|n| !names.contains(n));
            names.extend(free);
        }
        self.sums = Sums::Lights(names);
        self.settings.integrator = Integrator::Path;
        self
    }

    /// The contribution of each light, if that was accumulated in `layers`.
    pub(crate) fn light_layers(&self, layers: &[Accumulator]) -> Option<Vec<LightLayer>> {
        let Sums::Lights(names) = &self.sums else { return None };
        let each = names.iter().zip(&layers[1..]);
        let layer = |(name, sum): (&String, &Accumulator)| LightLayer {
            name: name.clone(),
            radiance: sum.mean(),
        };
        Some(each.map(layer).collect())
    }

    /// The denoised picture from its accumulated `layers`, if it is to be denoised.
    pub(crate) fn denoised(&self, layers: &[Accumulator]) -> Option<Denoised> {
        let (Sums::Halves, [picture, second]) = (&self.sums, layers) else { return None };
        let first = picture.without(second);
        let Self { tracer, materials, camera, settings, .. } = self;
        Some(tracer.denoise(materials, camera, settings, [&first, second]))
    }

    /// Adds the paths of both halves to the picture, and those of the second one to `second` as
    /// well.
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
    fn layers(&self) -> Vec<String> {
        let behind = match &self.sums {
            Sums::Whole => Vec::new(),
            Sums::Halves => vec!["second half".to_owned()],
            Sums::Lights(names) => names.iter().map(|name| format!("light {name}")).collect(),
        };
        std::iter::once("picture".to_owned()).chain(behind).collect()
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let Self { tracer, materials, camera, settings, sums } = self;
        match (sums, layers) {
            (Sums::Halves, [picture, second]) => {
                self.accumulate_halves(samples, picture, second, progress);
            }
            (Sums::Lights(_), layers) => {
                tracer.accumulate_layers(materials, camera, settings, samples, layers, progress);
            }
            (_, layers) => {
                tracer.accumulate(materials, camera, settings, samples, &mut layers[0], progress);
            }
        }
    }

    fn adaptive_sampling(&self, size: (usize, usize)) -> AdaptiveSampling {
        self.tracer.adaptive_sampling(&self.materials, self.camera, size, &self.settings, &|_| ())
    }
}

impl ProgressiveRender for Pairing<'_> {
    fn layers(&self) -> Vec<String> {
        pair::LAYERS.map(str::to_owned).to_vec()
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
