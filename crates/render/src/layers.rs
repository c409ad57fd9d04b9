//! Light layers: what each light source contributes to a picture, all from the same paths.
//!
//! Light transport is linear in the emission of the sources, so a picture is the sum of one layer a source,
//! and under other brightnesses of the sources it is the sum of the layers times the factors [Dorsey et al.
//! 1995]. Each event of a path that finds light belongs to the layer of its source. The picture itself is
//! added up beside the layers, by the same operations as without them: it has the bits of
//! [`crate::Integrator::Path`].
//!
//! One more layer may have the direct light: that of paths with one reflection at most.

use crate::accel::Ray;
use crate::adaptive::SampleAllocation;
use crate::appearance::{Appearance, LightSource, SourceLayout};
use crate::bsdf::BsdfSample;
use crate::camera_sample::camera_ray;
use crate::film::{Accumulator, PixelAccumulator};
use crate::integrator::CHUNK;
use crate::path::{DirectLight, Emission, PathObserver, RadianceSum, Transport, Vertex, Way};
use crate::radiance_cache::Cached;
use crate::sampler::Sampler;
use crate::settings::Settings;
use crate::tracer::Tracer;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_scene::{Camera, Rgb, RgbImage};

/// A source without a layer.
const NO_LAYER: usize = usize::MAX;

/// The picture under other brightnesses of its sources: the sum of `layers` times their `factors`, which are
/// at least zero. Where one is shorter than the other, the rest is left out.
///
/// ```
/// use unrender_render::layers::relight;
/// use unrender_scene::{Rgb, RgbImage};
///
/// let layer = |radiance| RgbImage::new(1, 1, vec![Rgb::splat(radiance)]);
/// let picture = relight(&[layer(1.0), layer(4.0)], &[Rgb::ONE, Rgb::new(0.5, 0.0, 1.0)]).unwrap();
/// assert_eq!(*picture.at(0, 0), Rgb::new(3.0, 1.0, 5.0));
/// ```
///
/// Returns none without layers.
///
/// # Panics
/// If the layers differ in size.
pub fn relight(layers: &[RgbImage], factors: &[Rgb]) -> Option<RgbImage> {
    let (width, height) = layers.first().map(|layer| (layer.width(), layer.height()))?;
    let mut sum = vec![Rgb::ZERO; width * height];
    sum.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, sums)| {
        for (layer, factor) in layers.iter().zip(factors) {
            assert_eq!((layer.width(), layer.height()), (width, height), "layers have one size");
            let radiances = &layer.pixels()[chunk * CHUNK..][..sums.len()];
            sums.iter_mut().zip(radiances).for_each(|(sum, radiance)| *sum += *radiance * *factor);
        }
    });
    Some(RgbImage::new(width, height, sum))
}

/// The mean of `picture` without its `direct` light, of the same samples: with that it adds up to the picture.
///
/// # Panics
/// If the two differ in size.
pub fn indirect(picture: &Accumulator, direct: &Accumulator) -> RgbImage {
    let (width, height) = picture.size();
    assert_eq!(direct.size(), (width, height), "sums of one picture have one size");
    let pairs = picture.image().pixels().iter().zip(direct.image().pixels());
    let rest = |(whole, direct): (&PixelAccumulator, &PixelAccumulator)| {
        // A sample's parts add up to it but for rounding.
        let sum = [0, 1, 2].map(|channel| whole.sum[channel].saturating_sub(direct.sum[channel]));
        PixelAccumulator { sum, ..*whole }.mean()
    };
    RgbImage::new(width, height, pairs.map(rest).collect())
}

impl Tracer {
    /// The sources that have a layer, by their place in [`SourceLayout`], ascending: those that emit.
    pub fn light_sources(&self) -> Vec<usize> {
        let layout = self.emitters.layout();
        let emits = |place: &usize| {
            *place >= layout.groups as usize || self.emitters.emits_from_group(*place as u32)
        };
        let around = layout.index(LightSource::Environment(glam::Vec3::Y)) as usize;
        let end = if self.emitters.has_environment() { layout.count() } else { around };
        (0..end).filter(emits).collect()
    }

    /// As [`Tracer::accumulate`], by independent paths whatever `settings.integrator` says: adds the samples to the
    /// first of `layers`, which is the picture, and the contribution of each of [`Tracer::light_sources`] to one of the
    /// layers behind that, in their order. One more layer, if there is one, gets the direct light: what is seen to emit, and
    /// the light that has been reflected once.
    ///
    /// # Panics
    /// If there is another number of layers, or they differ in size.
    pub fn accumulate_layers<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        samples: &SampleAllocation<'_>,
        layers: &mut [Accumulator],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let split = LightSplit::new(self);
        let behind = layers.len() - 1;
        let is_complete = [split.sources, split.sources + 1].contains(&behind);
        assert!(is_complete, "one layer a source, and the picture");
        let size = layers[0].size();
        assert!(layers.iter().all(|layer| layer.size() == size), "layers have one size");
        let transport = Transport::new(self, appearance.into(), settings.max_bounces);
        let picture = LayeredPicture { transport, split, camera, size, settings };
        let done = AtomicUsize::new(0);
        chunks(layers).into_par_iter().enumerate().for_each(|(chunk, mut layers)| {
            let mut light = picture.split.sums();
            for offset in 0..layers[0].len() {
                let pixel = chunk * CHUNK + offset;
                for index in samples.of(pixel) {
                    let whole = picture.sample(pixel as u32, index, &mut light);
                    layers[0][offset].push(whole);
                    // A sample that is not finite is black in all layers.
                    let is_number = whole.is_finite();
                    for (layer, light) in layers[1..].iter_mut().zip(&light) {
                        layer[offset].push(if is_number { *light } else { Rgb::ZERO });
                    }
                }
            }
            let so_far = done.fetch_add(layers[0].len(), Ordering::Relaxed) + layers[0].len();
            progress(so_far as f64 / (size.0 * size.1) as f64);
        });
    }
}

/// The pixels of all layers, a chunk of the picture each.
fn chunks(layers: &mut [Accumulator]) -> Vec<Vec<&mut [PixelAccumulator]>> {
    let mut chunks: Vec<Vec<&mut [PixelAccumulator]>> = Vec::new();
    for layer in layers {
        let pixels = layer.image_mut().pixels_mut();
        chunks.resize_with(pixels.len().div_ceil(CHUNK), Vec::new);
        chunks.iter_mut().zip(pixels.chunks_mut(CHUNK)).for_each(|(all, one)| all.push(one));
    }
    chunks
}

/// A picture whose light is separated by source.
struct LayeredPicture<'a> {
    transport: Transport<'a>,
    split: LightSplit<'a>,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

impl LayeredPicture<'_> {
    /// The radiance of a sample, and in `light` what [`LightSplit::radiance`] puts there.
    fn sample(&self, pixel: u32, index: u32, light: &mut [Rgb]) -> Rgb {
        let mut sampler = self.settings.pixels(self.size.0).sampler(pixel, index);
        let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
        self.split.radiance(&self.transport, &ray, &mut sampler, light)
    }
}

/// Light separated by source, and direct light.
pub struct LightSplit<'a> {
    layout: &'a SourceLayout,
    /// The layer of each source.
    layer_of: Vec<usize>,
    /// The number of sources that have a layer.
    sources: usize,
}

impl<'a> LightSplit<'a> {
    /// The light of the scene of `tracer`.
    pub fn new(tracer: &'a Tracer) -> Self {
        let (layout, sources) = (tracer.emitters.layout(), tracer.light_sources());
        let mut layer_of = vec![NO_LAYER; layout.count()];
        sources.iter().enumerate().for_each(|(layer, &place)| layer_of[place] = layer);
        Self { layout, layer_of, sources: sources.len() }
    }

    /// Zero for each of [`Tracer::light_sources`], and for the direct light behind them.
    pub fn sums(&self) -> Vec<Rgb> {
        vec![Rgb::ZERO; self.sources + 1]
    }

    /// The radiance that arrives along `ray`, with the bits of [`Transport::radiance`]. `light` has as many places as
    /// [`LightSplit::sums`], and gets the part of each source and the direct light.
    pub fn radiance(
        &self,
        transport: &Transport<'_>,
        ray: &Ray,
        sampler: &mut Sampler,
        light: &mut [Rgb],
    ) -> Rgb {
        light.fill(Rgb::ZERO);
        let Self { layout, layer_of, .. } = self;
        let whole = RadianceSum::new(transport);
        let [light @ .., direct] = light else { return Rgb::ZERO };
        let mut sums = LightSums { whole, layout, layer_of, light, direct, reflections: 0 };
        transport.trace_ray(ray, sampler, &mut sums);
        sums.whole.radiance
    }
}

/// The observer that adds up radiance as a whole and by source.
struct LightSums<'a> {
    whole: RadianceSum<'a>,
    layout: &'a SourceLayout,
    layer_of: &'a [usize],
    light: &'a mut [Rgb],
    direct: &'a mut Rgb,
    /// The reflections of the path so far.
    reflections: u32,
}

impl LightSums<'_> {
    /// Adds `radiance` that `source` would cause in the scene as it is, by way of so many reflections.
    fn add(&mut self, source: LightSource, radiance: Rgb, reflections: u32) {
        if radiance == Rgb::ZERO {
            return;
        }
        if reflections <= 1 {
            *self.direct += radiance * self.whole.appearance.brightness(self.layout, source);
        }
        let first = self.layout.index(source);
        let mut put = |place: u32, share: f32| {
            let factor = self.whole.appearance.light(place) * share;
            match self.light.get_mut(self.layer_of[place as usize]) {
                Some(light) => *light += radiance * factor,
                None => debug_assert!(false, "light from a source that does not emit"),
            }
        };
        match self.layout.corners(source) {
            None => put(first, 1.0),
            Some(corners) => {
                let parts = corners.pixels.iter().zip(corners.shares());
                parts.for_each(|(part, share)| put(first + *part as u32, share));
            }
        }
    }
}

impl PathObserver for LightSums<'_> {
    fn record_vertex(&mut self, _: &Vertex<'_>) {}

    fn record_direct(&mut self, throughput: Rgb, at: &Vertex<'_>, light: &DirectLight<'_>) {
        self.whole.record_direct(throughput, at, light);
        let arriving = light.sample.weight * light.transmittance;
        let radiance = throughput * (light.f_cos * arriving * light.mis);
        let by_mirrors = light.passed.all().len() as u32;
        self.add(light.sample.source, radiance, self.reflections + 1 + by_mirrors);
    }

    fn record_bounce(&mut self, _: &Vertex<'_>, _: &BsdfSample, _: f32) {
        self.reflections += 1;
    }

    fn record_glass(&mut self, _: &Way) {}

    fn record_emission(&mut self, throughput: Rgb, emission: &Emission, mis: f32) {
        self.whole.record_emission(throughput, emission, mis);
        self.add(emission.source, throughput * emission.radiance * mis, self.reflections);
    }

    fn record_cache_hit(&mut self, throughput: Rgb, cached: &Cached) {
        // A cache does not know where its light comes from; pictures are rendered without one.
        self.whole.record_cache_hit(throughput, cached);
    }
}
