//! A scene before and after its edits, rendered with common random numbers.
//!
//! Each sample is traced in both scenes with the same random numbers. Paths that the edits do not
//! affect agree to the bit, and their difference is zero. So the noise of the difference is that of
//! the change and not that of the picture; its variance is the sample variance of the differences.
//!
//! Each sample also identifies the visible surface, through perfect mirrors. Where it is another
//! one after the edits, or has another material, the content of the photograph is replaced.

use crate::stage::Change;
use glam::Vec3;
use rayon::prelude::*;
use rayon::slice::ChunksMut;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_render::accel::Ray;
use unrender_render::adaptive::{self, AdaptiveSampling, SampleAllocation};
use unrender_render::camera_sample::camera_ray;
use unrender_render::denoise::ratios::{Ratio, Smoother, over_or_zero};
use unrender_render::denoise::{Halves, denoise};
use unrender_render::layers::LightSplit;
use unrender_render::path::Transport;
use unrender_render::sampler::Sampler;
use unrender_render::surface::Surface;
use unrender_render::{
    Accumulator, FirstHits, GeometryBuffers, PixelAccumulator, Settings, Tracer,
};
use unrender_scene::{Camera, Image, Material, Rgb, RgbImage, Scene};

/// One pixel before and after the edits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Paired {
    /// Radiance before the edits, W sr^-1 m^-2 per channel.
    pub before: Rgb,
    /// Radiance after.
    pub after: Rgb,
    /// The part of `after - before` of samples that show the same surface.
    pub kept_change: Rgb,
    /// Variance of `kept_change`; where nothing is replaced, that of `after - before`.
    pub change_variance: Rgb,
    /// Variance of `before`.
    pub before_variance: Rgb,
    /// Variance of `after`.
    pub after_variance: Rgb,
    /// The fraction of the pixel that shows another surface than before, 0 to 1.
    pub replaced: f32,
    /// The fraction of the pixel that shows a surface of the old scene that was occluded before.
    pub uncovered: f32,
    /// `after / before`, without most of its noise where [`smoothed`] made it; zero where `before` is zero.
    pub ratio: Rgb,
}

/// The scene before and after.
#[derive(Clone, Copy, Debug)]
pub struct Scenes<'a> {
    /// The scene that the photograph shows.
    pub before: &'a Scene,
    /// The edited scene, validated.
    pub after: &'a Scene,
    /// The relation between the two.
    pub change: &'a Change,
}

/// The accumulators of a pairing: the radiance after and before; the positive and the negative part
/// of the change of samples that show the same surface; counts, in the first channel of samples
/// that show another surface, in the second of those that show an uncovered one; and the radiance after and before of
/// every other sample.
pub const LAYERS: [&str; 7] =
    ["after", "before", "lighter", "darker", "shown", "half after", "half before"];

/// Noise of a change below this share of the light before or after, whichever is more, is not seen. At half of it shadows lose sharpness for nothing, at
/// double of it grain shows on even walls.
const VISIBLE: f32 = 0.02;
/// The fewest samples of half a picture from which its noise is estimated: with half of them two would say how much
/// they scatter.
const DENOISE_MIN: u32 = 4;
/// Pixels per parallel task, after which it reports progress.
const CHUNK: usize = 128;
/// Most perfect mirrors in a row that are followed.
const MIRRORS_MAX: usize = 16;

/// Both scenes, prepared for rendering.
#[derive(Debug)]
pub struct Pairing<'a> {
    scenes: Scenes<'a>,
    with_passes: bool,
    before: (Tracer, Vec<Material>),
    after: (Tracer, Vec<Material>),
    camera: &'a Camera,
    settings: Settings,
}

impl<'a> Pairing<'a> {
    /// Prepares both scenes; `settings.spp` has no effect.
    pub fn new(scenes: Scenes<'a>, camera: &'a Camera, settings: Settings) -> Self {
        let side = |scene: &Scene| (Tracer::new(scene), scene.materials());
        let (before, after) = (side(scenes.before), side(scenes.after));
        Self { scenes, with_passes: false, before, after, camera, settings }
    }

    /// The same with more sums behind those of [`LAYERS`]: after the edits, the contribution of each light
    /// ([`Tracer::light_sources`]), and the direct light.
    #[must_use]
    pub fn with_passes(self) -> Self {
        Self { with_passes: true, ..self }
    }

    /// The edited scene, to trace rays in.
    pub fn tracer(&self) -> &Tracer {
        &self.after.0
    }

    /// What the camera sees first of the edited scene, in the samples of `after`.
    pub fn first_hits(&self, after: &Accumulator) -> FirstHits {
        let (tracer, materials) = &self.after;
        tracer.first_hits(materials, self.camera, &self.settings, after)
    }

    /// The picture after the edits, denoised; none if there are too few samples to estimate noise.
    ///
    /// # Panics
    /// If accumulators are missing.
    pub fn denoised(&self, layers: &[Accumulator]) -> Option<RgbImage> {
        let (whole, half) = (&layers[0], &layers[5]);
        let fewest = half.image().pixels().iter().map(|pixel| pixel.count).min()?;
        if fewest < DENOISE_MIN {
            return None;
        }
        let (tracer, materials) = &self.after;
        let seen = tracer.features(materials, self.camera, &self.settings, whole);
        let samples = [&whole.without(half), half];
        let halves = Halves { samples, features: [&seen, &seen], finer: &seen };
        Some(denoise(&halves).radiance)
    }

    /// The number of sums behind those of [`LAYERS`].
    fn more(&self) -> usize {
        if self.with_passes { self.tracer().light_sources().len() + 1 } else { 0 }
    }

    /// Adds the samples of the allocation to `layers`, which have the size of the picture. The sums
    /// have the same bits, however many calls there are. `progress` is called with the completed
    /// fraction, 0 to 1, from any thread.
    ///
    /// # Panics
    /// If there is not one accumulator for each of [`LAYERS`], and for each of the passes.
    pub fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let [after, before, lighter, darker, shown, half_after, half_before, more @ ..] = layers
        else {
            panic!("a pairing has {} layers", LAYERS.len());
        };
        assert_eq!(more.len(), self.more(), "a pairing has one layer for each of its passes");
        let size = after.size();
        let more = side_by_side(more, (size.0 * size.1).div_ceil(CHUNK));
        let pair = self.pair(size);
        let done = AtomicUsize::new(0);
        let halves = (chunks(half_after), chunks(half_before));
        (
            chunks(after),
            chunks(before),
            chunks(lighter),
            chunks(darker),
            chunks(shown),
            halves,
            more,
        )
            .into_par_iter()
            .enumerate()
            .for_each(
                |(chunk, (after, before, lighter, darker, shown, halves, mut more))| {
                    let mut light = pair.split.as_ref().map(LightSplit::sums).unwrap_or_default();
                    for offset in 0..after.len() {
                        let pixel = chunk * CHUNK + offset;
                        let passes = more.iter_mut().map(|layer| &mut layer[offset]).collect();
                        let mut sums = PairSums {
                            passes,
                            light: &mut light,
                            after: &mut after[offset],
                            before: &mut before[offset],
                            lighter: &mut lighter[offset],
                            darker: &mut darker[offset],
                            shown: &mut shown[offset],
                            half: [&mut halves.0[offset], &mut halves.1[offset]],
                        };
                        pair.add(pixel as u32, samples.of(pixel), &mut sums);
                    }
                    let so_far = done.fetch_add(after.len(), Ordering::Relaxed) + after.len();
                    progress(so_far as f64 / (size.0 * size.1) as f64);
                },
            );
    }

    /// The adaptive sampling of a picture of `size`, from a pilot, by the variance in the
    /// composite: that of the change, or of the radiance where another surface is visible.
    pub fn adaptive_sampling(&self, (width, height): (usize, usize)) -> AdaptiveSampling {
        let settings = Settings { seed: adaptive::pilot_seed(self.settings.seed), ..self.settings };
        let pilot = Self::new(self.scenes, self.camera, settings);
        let mut layers = LAYERS.map(|_| Accumulator::new(width, height));
        pilot.accumulate(&SampleAllocation::Uniform(0..adaptive::PILOT), &mut layers, &|_| ());
        let pixel = |index: usize| {
            let of = |layer: usize| layers[layer].image().pixels()[index];
            // This counts each sample twice, in both parts, but equally in all pixels.
            let mut change = of(2);
            change.add(&of(3));
            if of(4).sum[0] > 0 { of(0) } else { change }
        };
        let pixels = (0..width * height).map(pixel).collect();
        AdaptiveSampling::from_pilot(&Accumulator::from_image(Image::new(width, height, pixels)))
    }

    fn pair(&self, size: (usize, usize)) -> Pair<'_> {
        Pair {
            before: Side::new(&self.before, &self.settings),
            after: Side::new(&self.after, &self.settings),
            split: self.with_passes.then(|| LightSplit::new(self.tracer())),
            origin: &self.scenes.change.origin,
            repainted: repainted(&self.scenes),
            new_surroundings: self.scenes.before.environment != self.scenes.after.environment,
            camera: self.camera,
            size,
            settings: &self.settings,
        }
    }
}

/// The `count` chunks of all layers.
fn side_by_side(layers: &mut [Accumulator], count: usize) -> Vec<Vec<&mut [PixelAccumulator]>> {
    let mut all: Vec<Vec<&mut [PixelAccumulator]>> = Vec::new();
    all.resize_with(count, Vec::new);
    for layer in layers {
        let pixels = layer.image_mut().pixels_mut().chunks_mut(CHUNK);
        all.iter_mut().zip(pixels).for_each(|(all, one)| all.push(one));
    }
    all
}

fn chunks(layer: &mut Accumulator) -> ChunksMut<'_, PixelAccumulator> {
    layer.image_mut().pixels_mut().par_chunks_mut(CHUNK)
}

/// The pixels of `layers`, one accumulator for each of [`LAYERS`].
///
/// # Panics
/// If accumulators are missing.
pub fn paired(layers: &[Accumulator]) -> Image<Paired> {
    let (width, height) = layers[0].size();
    let of_pixel = |index: usize| {
        let of = |layer: usize| layers[layer].image().pixels()[index];
        let (after, before, lighter, darker) = (of(0), of(1), of(2), of(3));
        let shown = of(4).mean();
        let n = (lighter.count as f32 - 1.0).max(1.0);
        Paired {
            before: before.mean(),
            after: after.mean(),
            kept_change: lighter.mean() - darker.mean(),
            // A channel of a sample is lighter or darker, so the product of the parts is zero.
            change_variance: lighter.variance()
                + darker.variance()
                + 2.0 * lighter.mean() * darker.mean() / n,
            before_variance: before.variance(),
            after_variance: after.variance(),
            replaced: shown.x,
            uncovered: shown.y,
            ratio: over_or_zero(after.mean(), before.mean()),
        }
    };
    Image::new(width, height, (0..width * height).map(of_pixel).collect())
}

/// As [`paired`], with smooth ratios where their noise would be seen: `camera` saw the `geometry` of the pixels before the edits.
///
/// # Panics
/// If accumulators are missing, or the geometry has another size.
pub fn smoothed(
    layers: &[Accumulator],
    camera: &Camera,
    geometry: &GeometryBuffers,
) -> Image<Paired> {
    let halves =
        |whole: &Accumulator, half: &Accumulator| [whole.without(half).mean(), half.mean()];
    let (after, before) = (halves(&layers[0], &layers[5]), halves(&layers[1], &layers[6]));
    // The share of the light after in both, whose noise is alike where light comes and where it goes.
    let both = [0, 1].map(|half: usize| {
        let sums = after[half].pixels().iter().zip(before[half].pixels()).map(|(a, b)| *a + *b);
        RgbImage::new(after[half].width(), after[half].height(), sums.collect())
    });
    let share = Ratio { numerator: [&after[0], &after[1]], denominator: [&both[0], &both[1]] };
    let share = Smoother::new(camera, geometry).smooth(&share);
    let mut paired = paired(layers);
    for (of, share) in paired.pixels_mut().iter_mut().zip(share.pixels()) {
        // Smoothing costs edges of shadows, which common random numbers show without noise.
        let is_seen = of.change_variance.map(f32::sqrt).cmpgt(VISIBLE * of.before.max(of.after));
        of.ratio = if is_seen.any() { over_or_zero(*share, Rgb::ONE - *share) } else { of.ratio };
    }
    paired
}

/// Renders both scenes as `camera` sees them in `width` x `height` pixels. `progress` is called
/// with the completed fraction, 0 to 1, from any thread.
pub fn render(
    scenes: &Scenes<'_>,
    camera: &Camera,
    (width, height): (usize, usize),
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Image<Paired> {
    let mut layers = LAYERS.map(|_| Accumulator::new(width, height));
    let pairing = Pairing::new(*scenes, camera, *settings);
    pairing.accumulate(&SampleAllocation::Uniform(0..settings.spp), &mut layers, progress);
    smoothed(&layers, camera, &pairing.before.0.geometry(camera, width, height))
}

/// For each group of the old scene whether its material or emission changes.
fn repainted(scenes: &Scenes<'_>) -> Vec<bool> {
    let pairs = scenes.before.groups.iter().zip(&scenes.after.groups);
    pairs.map(|(b, a)| b.material != a.material || b.emission != a.emission).collect()
}

/// One of the two scenes.
struct Side<'a> {
    transport: Transport<'a>,
    materials: &'a [Material],
}

/// Both scenes during the rendering of a picture.
struct Pair<'a> {
    before: Side<'a>,
    after: Side<'a>,
    /// Of the light after the edits, if its passes are wanted.
    split: Option<LightSplit<'a>>,
    origin: &'a [Option<usize>],
    repainted: Vec<bool>,
    new_surroundings: bool,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

/// The visible surface of a sample.
#[derive(Clone, Copy)]
struct VisibleSurface {
    object: u32,
    group: u32,
    point: Vec3,
}

/// One sample of one scene.
struct PairSample {
    radiance: Rgb,
    visible: Option<VisibleSurface>,
}

/// How the visible surface of a sample changes.
#[derive(Clone, Copy)]
struct Replacement {
    /// Another surface is visible.
    replaced: bool,
    /// It is a surface of the old scene that was occluded.
    uncovered: bool,
}

impl<'a> Side<'a> {
    fn new((tracer, materials): &'a (Tracer, Vec<Material>), settings: &Settings) -> Self {
        let transport = Transport::new(tracer, materials.into(), settings.max_bounces);
        Self { transport, materials }
    }

    /// The surface visible at `surface`: itself, or the reflected one of a perfect mirror.
    fn visible(&self, mut surface: Surface) -> Option<VisibleSurface> {
        for _ in 0..MIRRORS_MAX {
            if !self.materials[surface.group as usize].is_pure_mirror() {
                break;
            }
            let normal = surface.frame.normal;
            let wi = 2.0 * surface.to_viewer.dot(normal) * normal - surface.to_viewer;
            if !surface.is_above(wi) {
                return None;
            }
            surface = self.transport.shown(&Transport::leave(&surface, wi))?;
        }
        let Surface { object, group, point, .. } = surface;
        Some(VisibleSurface { object, group, point })
    }

    /// Traces one sample; its light is separated by `split`, if that is given, into the sums behind it.
    fn sample(
        &self,
        ray: &Ray,
        sampler: &mut Sampler,
        split: Option<(&LightSplit<'_>, &mut [Rgb])>,
    ) -> PairSample {
        let radiance = match split {
            Some((split, light)) => split.radiance(&self.transport, ray, sampler, light),
            None => self.transport.radiance(ray, sampler),
        };
        let visible = self.transport.shown(ray).and_then(|surface| self.visible(surface));
        PairSample { radiance, visible }
    }
}

impl Pair<'_> {
    /// Adds the samples of the numbers `samples` to a pixel.
    fn add(&self, pixel: u32, samples: Range<u32>, sums: &mut PairSums<'_>) {
        for index in samples {
            let mut sampler = self.settings.pixels(self.size.0).sampler(pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            let mut again = sampler;
            let before = self.before.sample(&ray, &mut sampler, None);
            let split = self.split.as_ref().map(|split| (split, &mut *sums.light));
            let after = self.after.sample(&ray, &mut again, split);
            let replacement = self.replacement(before.visible, after.visible);
            sums.push(before.radiance, after.radiance, replacement);
            if index % 2 == 1 {
                sums.half[0].push(after.radiance);
                sums.half[1].push(before.radiance);
            }
        }
    }

    fn replacement(
        &self,
        before: Option<VisibleSurface>,
        after: Option<VisibleSurface>,
    ) -> Replacement {
        let Some(VisibleSurface { object, group, point }) = after else {
            let uncovered = before.is_some();
            return Replacement { replaced: uncovered || self.new_surroundings, uncovered };
        };
        let origin = self.origin[object as usize].filter(|_| !self.repainted[group as usize]);
        let Some(origin) = origin else { return Replacement { replaced: true, uncovered: false } };
        let same = before.is_some_and(|b| b.object as usize == origin && b.point == point);
        Replacement { replaced: !same, uncovered: !same }
    }
}

/// The accumulators of one pixel.
struct PairSums<'a> {
    after: &'a mut PixelAccumulator,
    before: &'a mut PixelAccumulator,
    lighter: &'a mut PixelAccumulator,
    darker: &'a mut PixelAccumulator,
    shown: &'a mut PixelAccumulator,
    /// After and before, of every other sample.
    half: [&'a mut PixelAccumulator; 2],
    /// Those of the passes.
    passes: Vec<&'a mut PixelAccumulator>,
    /// Their values in the present sample.
    light: &'a mut [Rgb],
}

impl PairSums<'_> {
    fn push(&mut self, before: Rgb, after: Rgb, replacement: Replacement) {
        let Replacement { replaced, uncovered } = replacement;
        self.before.push(before);
        self.after.push(after);
        // A sample that is not finite is black in all passes.
        let is_number = after.is_finite();
        for (pass, light) in self.passes.iter_mut().zip(&*self.light) {
            pass.push(if is_number { *light } else { Rgb::ZERO });
        }
        let change = if replaced { Rgb::ZERO } else { after - before };
        self.lighter.push(change.max(Rgb::ZERO));
        self.darker.push((-change).max(Rgb::ZERO));
        let one = |is: bool| f32::from(u8::from(is));
        self.shown.push(Rgb::new(one(replaced), one(uncovered), 0.0));
    }
}

/// The light that the edits take away from surfaces which both scenes show: shadows.
pub fn shadow(paired: &Image<Paired>) -> RgbImage {
    paired.map(|pixel| (-pixel.kept_change).max(Rgb::ZERO))
}

/// The light that the edits add to surfaces which both scenes show: reflections and bounced light.
pub fn reflection(paired: &Image<Paired>) -> RgbImage {
    paired.map(|pixel| pixel.kept_change.max(Rgb::ZERO))
}

/// The picture of the edited scene.
pub fn after(paired: &Image<Paired>) -> RgbImage {
    paired.map(|pixel| pixel.after)
}
