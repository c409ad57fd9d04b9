//! Path reuse: the paths of neighbouring pixels contribute to each other [Bekaert et al. 2002].
//!
//! The path of a pixel hits a first vertex `x`, the *receiver*, and a second vertex `y`. The light
//! reflected at `y` also goes to the receivers of neighbouring pixels, at the cost of a visibility
//! test each. With the N pixels of a tile, receivers `x_1..x_N`, and vertices `y_j` that reflect
//! the radiance `L` diffusely, pixel i receives
//!
//! ```text
//! sum over j of  f_i(y_j) cos_i G(x_i, y_j) L(y_j) / sum over k of p_k(y_j)
//! ```
//!
//! with `G = V cos_y / r^2` and `p_k = pdf_k G(x_k, y_j)`, the density over area with which `x_k`
//! samples `y_j`. This is the balance heuristic over N strategies [Veach and Guibas 1995], so the
//! estimator is unbiased. Where the BRDF at `y` is glossy, `L` is `f(y) cos` times the light
//! incident from a direction `w`, and the density is that of sampling both, `p_k(y) p(w | y, x_k)`.
//! One path per pixel has the variance of up to N paths. Paths behind perfect mirrors are not
//! reused.
//!
//! Cost: a sample takes the time of about three independent ones ([`COST`]). The visibility of `y`
//! from all receivers is found at once by shaft culling ([`crate::accel`]); most shafts are empty,
//! and otherwise a shadow ray is much cheaper than a path. Where most of the variance lies within
//! pixels (leaves, grass) reuse does not pay; a pilot of a few tiles decides.
//!
//! Reuse correlates the noise of the pixels of a tile. Each sample number has a tiling with a
//! random offset, so that tiles are not visible; the noise is still correlated over a few pixels.
//! Fits to pictures and measurements of noise over many pixels should use independent paths.

mod connection;
mod receiver;
mod reused;
mod tiles;

use crate::adaptive::{SampleAllocation, TILE};
use crate::camera_sample::{PixelSamples, camera_ray};
use crate::film::Accumulator;
use crate::path::Transport;
use crate::sampler::mix;
use connection::{Connection, ReceiverSet};
use glam::DVec3;
use rayon::prelude::*;
use receiver::{CameraHit, Contribution, Receiver};
use reused::{GlossyReflection, Reflection, ReusableVertex};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use tiles::Tiling;
use unrender_scene::{Camera, Rgb};

/// The side of the tiles, pixels: that of the tiles of adaptive sampling, whose pixels have the
/// same number of samples. Connections grow with its square: half of it reuses a quarter of the
/// paths, with double of it the receivers differ so much that most connections contribute nothing.
const SIDE: usize = TILE;
/// Tiles that are rendered in one batch, at least: enough for many threads, few enough to fit in
/// memory.
const BATCH: usize = 1024;
/// The time of a sample with reuse, in independent samples: measured, 2.8.
const COST: f64 = 3.0;
/// The pilot: the number of tiles, drawn at random. With half of them its decision depends on the
/// seed, with double of them it takes as long as small pictures.
const PILOT_TILES: usize = 16;
/// Samples per pixel in each half of the pilot.
const PILOT_SPP: u32 = 2;
/// Separates the random numbers of the pilot from those of the picture under the same seed.
const STREAM: u64 = 0x50A4_0000_0000_0000;

/// The buffers of a tile, kept from one tile to the next.
#[derive(Default)]
pub(crate) struct Workspace {
    receivers: Vec<Receiver>,
    receiver_set: ReceiverSet,
    vertices: Vec<StoredVertex>,
    connections: Vec<Connection>,
    /// The BRDF of a glossy vertex towards each of `connections`.
    f_cos: Vec<Rgb>,
    radiance: Vec<Rgb>,
}

/// A reusable vertex and the index of the receiver that found it.
struct StoredVertex {
    finder: usize,
    vertex: ReusableVertex,
}

/// The integrator of one picture.
#[derive(Clone, Copy)]
pub(crate) struct PathReuse<'a> {
    pub(crate) transport: &'a Transport<'a>,
    pub(crate) camera: &'a Camera,
    pub(crate) size: (usize, usize),
    pub(crate) samples: PixelSamples,
}

impl PathReuse<'_> {
    /// The number of independent samples that have the variance of one sample with reuse, estimated
    /// from a pilot; none where that is less than [`COST`], or if there is glass, which connections do not know. Does not
    /// depend on the samples of the picture.
    pub(crate) fn efficiency(&self) -> Option<f64> {
        let tiling = Tiling::new(self.size, (0, 0));
        if tiling.count() == 0 || self.transport.tracer.has_glass() {
            return None;
        }
        let errors: Vec<[f64; 2]> = (0..PILOT_TILES as u64)
            .into_par_iter()
            .map_init(Workspace::default, |space, i| {
                // At random: with a constant step all tiles might lie in one column.
                let pixels = tiling.pixels(mix(i) as usize % tiling.count());
                [false, true].map(|reuse| self.squared_error(pixels.clone(), reuse, space))
            })
            .collect();
        let sum = |way: usize| errors.iter().map(|errors| errors[way]).sum::<f64>();
        (sum(0) > COST * sum(1)).then(|| sum(0) / sum(1))
    }

    /// The squared difference of two independent pictures of some pixels, which is proportional to
    /// the variance.
    fn squared_error(
        &self,
        pixels: impl Iterator<Item = u32> + Clone,
        reuse: bool,
        space: &mut Workspace,
    ) -> f64 {
        let mut difference: Vec<DVec3> = pixels.clone().map(|_| DVec3::ZERO).collect();
        for (half, sign) in [(0, 1.0), (1, -1.0)] {
            let seed = mix(self.samples.seed ^ STREAM).wrapping_add(half);
            let pilot = Self { samples: PixelSamples { seed, ..self.samples }, ..*self };
            for index in 0..PILOT_SPP {
                if reuse {
                    pilot.sample_tile(pixels.clone(), index, space);
                } else {
                    let sample = |pixel| pilot.sample_pixel(pixel, index);
                    space.radiance.clear();
                    space.radiance.extend(pixels.clone().map(sample));
                }
                for (difference, radiance) in difference.iter_mut().zip(&space.radiance) {
                    *difference += sign * radiance.as_dvec3();
                }
            }
        }
        difference.iter().map(|d| d.length_squared()).sum()
    }

    /// The independent sample number `index` of a pixel.
    fn sample_pixel(&self, pixel: u32, index: u32) -> Rgb {
        let mut sampler = self.samples.sampler(pixel, index);
        let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
        self.transport.radiance(&ray, &mut sampler)
    }

    /// Adds the samples of the allocation to `accumulator`. `progress` is called with the completed
    /// fraction, 0 to 1.
    pub(crate) fn accumulate(
        &self,
        samples: &SampleAllocation<'_>,
        accumulator: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let ranges: Vec<Range<u32>> =
            (0..self.size.0 * self.size.1).map(|i| samples.of(i)).collect();
        let start = ranges.iter().map(|range| range.start).min().unwrap_or(0);
        let end = ranges.iter().map(|range| range.end).max().unwrap_or(0);
        let shifts = matches!(samples, SampleAllocation::Uniform(_));
        let at_once = BATCH.div_ceil(Tiling::new(self.size, (0, 0)).count().max(1)) as u32;
        let mut next = start;
        while next < end {
            let batch = next..end.min(next.saturating_add(at_once));
            let fraction = |index: u32| f64::from(index - start) / f64::from(end - start);
            let (from, to) = (fraction(batch.start), fraction(batch.end));
            next = batch.end;
            let passes: Vec<Pass> =
                batch.map(|index| Pass::new(self.size, index, shifts)).collect();
            let progress = |done| progress(from + (to - from) * done);
            self.add(&passes, &ranges, accumulator, &progress);
        }
    }

    /// Adds the samples of some passes to the pixels whose range has their number.
    fn add(
        &self,
        passes: &[Pass],
        ranges: &[Range<u32>],
        accumulator: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let tiles = passes.iter().flat_map(|pass| (0..pass.tiling.count()).map(move |t| (pass, t)));
        let tiles: Vec<_> = tiles.collect();
        let (done, all) = (AtomicUsize::new(0), tiles.len());
        let radiance: Vec<Vec<Rgb>> = tiles
            .into_par_iter()
            .map_init(Workspace::default, |space, (pass, tile)| {
                let pixels = pass.tiling.pixels(tile);
                let is_wanted = |pixel: &u32| ranges[*pixel as usize].contains(&pass.index);
                if !pixels.clone().any(|pixel| is_wanted(&pixel)) {
                    return Vec::new();
                }
                self.sample_tile(pixels, pass.index, space);
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
                space.radiance.clone()
            })
            .collect();
        let rows = accumulator.image_mut().pixels_mut().par_chunks_mut(self.size.0.max(1));
        rows.enumerate().for_each(|(y, row)| {
            let mut first = 0;
            for pass in passes {
                for (x, pixel) in row.iter_mut().enumerate() {
                    if ranges[y * self.size.0 + x].contains(&pass.index) {
                        let (tile, place) = pass.tiling.place(x, y);
                        pixel.push(radiance[first + tile][place]);
                    }
                }
                first += pass.tiling.count();
            }
        });
    }

    /// Writes the sample number `index` of the pixels of a tile to `space.radiance`.
    fn sample_tile(&self, pixels: impl Iterator<Item = u32>, index: u32, space: &mut Workspace) {
        space.receivers.clear();
        space.vertices.clear();
        space.radiance.clear();
        for pixel in pixels {
            let mut sampler = self.samples.sampler(pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            let place = space.radiance.len();
            let radiance = match Receiver::trace(self.transport, &ray, place, &mut sampler) {
                CameraHit::Receiver(receiver) => {
                    let Contribution { radiance, reusable } =
                        receiver.contribution(self.transport, &mut sampler);
                    let finder = space.receivers.len();
                    space.vertices.extend(reusable.map(|vertex| StoredVertex { finder, vertex }));
                    space.receivers.push(receiver);
                    radiance
                }
                CameraHit::Radiance(radiance) => radiance,
            };
            space.radiance.push(radiance);
        }
        let Workspace { receivers, receiver_set, vertices, connections, f_cos, radiance } = space;
        receiver_set.assign(receivers);
        for StoredVertex { finder, vertex } in vertices {
            receiver_set.connect(self.transport, receivers, (*finder, vertex), connections);
            distribute(&vertex.reflection, connections, f_cos, radiance);
        }
    }
}

/// The samples with one number of all pixels.
struct Pass {
    index: u32,
    tiling: Tiling,
}

impl Pass {
    /// If `shifts`, the tiling has a random offset that depends on the number; else it is that of
    /// adaptive sampling.
    fn new(size: (usize, usize), index: u32, shifts: bool) -> Self {
        let random = mix(u64::from(index));
        let shift = |bits: u64| if shifts { bits as usize % SIDE } else { 0 };
        Self { index, tiling: Tiling::new(size, (shift(random), shift(random >> 32))) }
    }
}

/// Adds the light that a vertex reflects to the pixels of its connections.
fn distribute(
    reflection: &Reflection,
    connections: &[Connection],
    f_cos: &mut Vec<Rgb>,
    radiance: &mut [Rgb],
) {
    match reflection {
        Reflection::Diffuse(leaving) => {
            let density: f32 = connections.iter().map(|c| c.receiver.pdf * c.geometry).sum();
            if density > 0.0 {
                for c in connections {
                    radiance[c.pixel] += c.receiver.f_cos * (leaving * (c.geometry / density));
                }
            }
        }
        Reflection::Glossy(glossy) => distribute_glossy(glossy, connections, f_cos, radiance),
    }
}

/// [`distribute`] for a glossy vertex, whose BRDF and densities differ from connection to
/// connection.
fn distribute_glossy(
    glossy: &GlossyReflection,
    connections: &[Connection],
    at_vertex: &mut Vec<Rgb>,
    radiance: &mut [Rgb],
) {
    for incident in glossy.incident.iter().flatten() {
        at_vertex.clear();
        let mut density = 0.0;
        for c in connections {
            let (f_cos, pdf) = glossy.f_cos_and_pdf(incident, glossy.towards(c.receiver.wi));
            density += c.receiver.pdf * c.geometry * pdf;
            at_vertex.push(f_cos);
        }
        if density > 0.0 && density.is_finite() {
            for (c, f_cos) in connections.iter().zip(at_vertex.iter()) {
                let f_cos = c.receiver.f_cos * f_cos;
                radiance[c.pixel] += f_cos * (incident.radiance * (c.geometry / density));
            }
        }
    }
}
