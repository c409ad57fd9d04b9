//! Renderings in passes: one picture, or a composite's scenes before and after.

use crate::output::Encoding;
use crate::passes;
use unrender_formats::picture::{LightLayer, Pass, Passes, Values};
use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};
use unrender_render::denoise::Denoised;
use unrender_render::{Accumulator, Integrator, Settings, Tracer};
use unrender_restage::pair::{self, Pairing};
use unrender_scene::{Camera, Material, Scene};

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
    /// The same and the direct light.
    Passes(Vec<String>),
}

/// The name of the sum of the direct light.
pub(crate) const DIRECT: &str = "direct light";

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
        let names = passes::light_names(scene, &self.tracer);
        self.sums = Sums::Lights(names);
        self.settings.integrator = Integrator::Path;
        self
    }

    /// The same picture with the contribution of each light of its `scene`, and what compositing programs want beside.
    pub(crate) fn with_passes(self, scene: &Scene) -> Self {
        let mut render = self.by_light(scene);
        if let Sums::Lights(names) = render.sums {
            render.sums = Sums::Passes(names);
        }
        render
    }

    /// The passes of the picture of `scene`, if they were accumulated in `layers`.
    pub(crate) fn passes(
        &self,
        scene: &Scene,
        layers: &[Accumulator],
        encoding: Encoding,
    ) -> Option<Passes> {
        let (Sums::Passes(_), [picture, .., direct]) = (&self.sums, layers) else { return None };
        let Self { tracer, materials, camera, settings, .. } = self;
        let hits = tracer.first_hits(materials, camera, settings, picture);
        let sums = passes::Sums { picture, direct, lights: self.light_layers(layers)? };
        Some(passes::of(scene, sums, hits, encoding))
    }

    /// The contribution of each light, if that was accumulated in `layers`.
    pub(crate) fn light_layers(&self, layers: &[Accumulator]) -> Option<Vec<LightLayer>> {
        let (Sums::Lights(names) | Sums::Passes(names)) = &self.sums else { return None };
        Some(passes::lights(names, &layers[1..]))
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
        let each = |names: &[String]| names.iter().map(|name| format!("light {name}")).collect();
        let behind: Vec<String> = match &self.sums {
            Sums::Whole => Vec::new(),
            Sums::Halves => vec!["second half".to_owned()],
            Sums::Lights(names) | Sums::Passes(names) => each(names),
        };
        let direct = matches!(self.sums, Sums::Passes(_)).then(|| DIRECT.to_owned());
        std::iter::once("picture".to_owned()).chain(behind).chain(direct).collect()
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
            (Sums::Lights(_) | Sums::Passes(_), layers) => {
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

/// A composite's scenes before and after, and if passes are wanted, the names of the lights after.
pub(crate) struct CompositeRender<'a> {
    pub(crate) pairing: Pairing<'a>,
    lights: Option<Vec<String>>,
}

impl<'a> CompositeRender<'a> {
    pub(crate) fn new(pairing: Pairing<'a>, after: &Scene, with_passes: bool) -> Self {
        let lights = with_passes.then(|| passes::light_names(after, pairing.tracer()));
        let pairing = if with_passes { pairing.with_passes() } else { pairing };
        Self { pairing, lights }
    }

    /// The passes of the picture of `after`, if they were accumulated in `layers`.
    pub(crate) fn passes(&self, after: &Scene, layers: &[Accumulator]) -> Option<Passes> {
        let (Some(names), [picture, .., direct]) = (&self.lights, layers) else { return None };
        let lights = passes::lights(names, &layers[pair::LAYERS.len()..]);
        let sums = passes::Sums { picture, direct, lights };
        let hits = self.pairing.first_hits(picture);
        let mut all = passes::of(after, sums, hits, Encoding::default());
        let paired = pair::paired(layers);
        let [shadow, reflection] = [pair::shadow(&paired), pair::reflection(&paired)];
        for (name, picture) in [("Shadow", shadow), ("Reflection", reflection)] {
            all.others.push(Pass { name, values: Values::Colour(picture) });
        }
        Some(all)
    }
}

impl ProgressiveRender for CompositeRender<'_> {
    fn layers(&self) -> Vec<String> {
        let own = pair::LAYERS.map(str::to_owned).into_iter();
        let lights = self.lights.iter().flatten().map(|name| format!("light {name}"));
        let direct = self.lights.iter().map(|_| DIRECT.to_owned());
        own.chain(lights).chain(direct).collect()
    }

    fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        self.pairing.accumulate(samples, layers, progress);
    }

    fn adaptive_sampling(&self, size: (usize, usize)) -> AdaptiveSampling {
        self.pairing.adaptive_sampling(size)
    }
}
