//! A recovery over several machines: the renderer's work is done by workers, everything else here.
//!
//! [`Remote`] is a [`Renderer`] that cuts each request into tiles, hands these to [`Workers`], and puts
//! the answers together in the order of the tiles. What a [`Worker`] computes for a pixel depends on
//! nothing but the request and the pixel, so the answers have the bits of one machine, whatever the
//! tiles and whoever answers them; a tile whose worker is lost is computed again by another one. What
//! needs all pixels at once (fits, selection of hypotheses, normal equations) is done once, by the
//! caller.
//!
//! Requests:
//!
//! | request | cut by | bytes of the answer |
//! |---|---|---|
//! | probes | pixels | about 105 a probe, 24 an incident sample |
//! | Jacobian | pixels | 12 (1 + parameters) a pixel |
//! | the same on stored paths | pixels | 12 (1 + parameters) a pixel |
//! | radiance of pixels | pixels | 12 a pixel |
//! | picture with path reuse | sample numbers | at most 57 a pixel and part |
//!
//! Each refers to three pieces of shared data that outlive it: the view (scene, camera, size), the
//! appearance, the radiance cache. Scene and tree are built from the first, once per worker. Workers keep the paths of
//! their pixels that are replayed (module `kept`), and trace them again where they lack them: that costs time, and
//! changes no bit.
//!
//! Transport, and the loss of workers, are left to the implementation of [`Workers`].

mod kept;
mod paths;
mod wire;
mod worker;

pub use worker::{Fault, Worker};

use glam::Vec3;
use std::hash::{DefaultHasher, Hasher};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use unrender_render::Query;
use unrender_render::view::{Renderer, Stored, View};
use unrender_render::{
    Accumulator, Appearance, GeometryBuffers, Integrator, Jacobian, PixelAccumulator,
    ProbeSettings, Probes, RadianceCache, Settings,
};
use unrender_scene::{BrdfModel, Rgb, Scene};
use wire::Request;

/// Tiles for each worker in a request. With one, the others wait for the slowest worker with nothing to do; with four,
/// twice as many messages travel.
const TILES_A_WORKER: usize = 2;
/// The fewest pixels of a tile, where each takes some hundred rays (probes) or some paths. Half of it is computed in
/// the time that a message takes, about a millisecond; double leaves workers idle in small requests.
const PROBES_MIN: usize = 32;
const PIXELS_MIN: usize = 256;
/// Ranges of sample numbers that a picture is cut into for each worker.
const RANGES_A_WORKER: usize = 1;

/// Data that several requests refer to.
#[derive(Clone, Debug)]
pub struct Shared {
    /// A hash of the data, by which workers find data that they hold.
    pub number: u64,
    /// The data.
    pub bytes: Arc<[u8]>,
}

/// Machines that answer requests.
pub trait Workers: Sync {
    /// How many there are now.
    fn count(&self) -> usize;
    /// The results of [`Worker::answer`] for each of `requests`, in their order, on a worker that was built from the
    /// first of `shared`; none if there is no worker. Answers that are not understood count as none.
    fn answers(&self, shared: &[Shared; 3], requests: &[Vec<u8>]) -> Option<Vec<Vec<u8>>>;
}

/// A [`View`] whose work is done by workers, or by itself where they cannot.
pub struct Remote<'a> {
    view: View<'a>,
    workers: &'a dyn Workers,
    setup: Shared,
    shelf: Mutex<Shelf>,
}

/// The cache that was shared last, so that it is not written again while it stays the same.
#[derive(Default)]
struct Shelf(Option<(RadianceCache, Shared)>);

impl<'a> Remote<'a> {
    /// `view`, which shows `scene`, with its work done by `workers`.
    pub fn new(view: View<'a>, scene: &Scene, workers: &'a dyn Workers) -> Self {
        let geometry = view.geometry();
        let bytes = wire::setup(scene, view.camera(), (geometry.width(), geometry.height()));
        Self { view, workers, setup: Shared::new(bytes), shelf: Mutex::default() }
    }

    /// The answers to `requests`; none if one is missing.
    fn ask(
        &self,
        (appearance, drawn): (Appearance<'_>, Option<Appearance<'_>>),
        cache: Option<&RadianceCache>,
        requests: impl Iterator<Item = Request>,
    ) -> Option<Vec<Vec<u8>>> {
        let requests: Vec<Vec<u8>> = requests.map(|request| wire::encode(&request)).collect();
        let shared = {
            let mut shelf = self.shelf.lock().unwrap_or_else(PoisonError::into_inner);
            let appearances = wire::appearances(appearance, drawn);
            [self.setup.clone(), Shared::new(appearances), shelf.shared(cache)]
        };
        let answers = self.workers.answers(&shared, &requests)?;
        (answers.len() == requests.len()).then_some(answers)
    }

    /// `pixels` cut into tiles of `least` pixels or more; none without workers.
    fn tiles<'p, P>(&self, pixels: &'p [P], least: usize) -> Option<std::slice::Chunks<'p, P>> {
        let tiles = match self.workers.count() {
            0 => return None,
            // Nothing is gained by cutting.
            1 => 1,
            workers => TILES_A_WORKER * workers,
        };
        Some(pixels.chunks(pixels.len().div_ceil(tiles).max(least)))
    }

    /// The sample numbers of a picture of `spp`, cut into ranges.
    fn ranges(&self, spp: u32) -> impl Iterator<Item = Range<u32>> + use<> {
        let ranges = (RANGES_A_WORKER * self.workers.count()).clamp(1, spp.max(1) as usize) as u64;
        let edge = move |k: u64| (u64::from(spp) * k / ranges) as u32;
        (0..ranges).map(move |k| edge(k)..edge(k + 1))
    }

    fn asked_probes(&self, query: &Query<'_, u32, ProbeSettings>) -> Option<Probes> {
        let Query { appearance, pixels, settings, seen, .. } = *query;
        let request = |tile: &[u32]| Request::Probe(tile.to_vec(), settings.clone());
        let tiles = self.tiles(pixels, PROBES_MIN)?;
        let mut all = Probes::default();
        for answer in self.ask((appearance, None), seen, tiles.map(request))? {
            all.append(wire::probes(&answer)?);
        }
        Some(all)
    }

    /// The answers to `request` for tiles of `pixels`: the radiance and so many derivatives of
    /// each.
    fn asked_jacobian<P>(
        &self,
        appearances: (Appearance<'_>, Option<Appearance<'_>>),
        (pixels, parameters): (&[P], usize),
        seen: Option<&RadianceCache>,
        request: impl Fn(&[P]) -> Request,
    ) -> Option<Jacobian> {
        let tiles = self.tiles(pixels, PIXELS_MIN)?;
        let sizes: Vec<usize> = tiles.clone().map(<[P]>::len).collect();
        let answers = self.ask(appearances, seen, tiles.map(request))?;
        let mut all = Jacobian::default();
        for (answer, size) in answers.iter().zip(sizes) {
            let tile = wire::jacobian(answer, size, parameters)?;
            all.radiance.extend(tile.radiance);
            all.derivatives.extend(tile.derivatives);
        }
        Some(all)
    }

    fn asked_radiance(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> Option<Vec<Rgb>> {
        let request = |tile: &[u32]| Request::Radiance(tile.to_vec(), *settings);
        let tiles = self.tiles(pixels, PIXELS_MIN)?;
        let sizes: Vec<usize> = tiles.clone().map(<[u32]>::len).collect();
        let answers = self.ask((appearance, None), None, tiles.map(request))?;
        let mut all = Vec::with_capacity(pixels.len());
        for (answer, size) in answers.iter().zip(sizes) {
            all.extend(wire::radiances(answer, size)?);
        }
        Some(all)
    }

    /// A picture whose samples are added as whole numbers, so that the ranges do not matter.
    fn asked_picture(&self, appearance: Appearance<'_>, plan: &Settings) -> Option<Vec<Rgb>> {
        let (width, height) = (self.geometry().width(), self.geometry().height());
        if plan.integrator == Integrator::Path {
            let pixels: Vec<u32> = (0..(width * height) as u32).collect();
            return self.asked_radiance(appearance, &pixels, plan);
        }
        if self.workers.count() == 0 {
            return None;
        }
        let request = |samples: Range<u32>| Request::Samples(samples, *plan);
        let answers = self.ask((appearance, None), None, self.ranges(plan.spp).map(request))?;
        let mut sums = Accumulator::new(width, height);
        for (answer, samples) in answers.iter().zip(self.ranges(plan.spp)) {
            let part = wire::sums(answer, width * height)?;
            let count = samples.end - samples.start;
            let pixels = sums.image_mut().pixels_mut().iter_mut();
            pixels.zip(part).for_each(|(pixel, sum)| {
                pixel.add(&PixelAccumulator { sum, count, ..PixelAccumulator::default() });
            });
        }
        Some(sums.mean().pixels().to_vec())
    }
}

impl Renderer for Remote<'_> {
    fn geometry(&self) -> &GeometryBuffers {
        self.view.geometry()
    }

    fn point(&self, pixel: u32) -> Option<Vec3> {
        self.view.point(pixel)
    }

    fn model(&self) -> BrdfModel {
        self.view.model()
    }

    fn probe(&self, query: &Query<'_, u32, ProbeSettings>) -> Probes {
        self.asked_probes(query).unwrap_or_else(|| self.view.probe(query))
    }

    fn jacobian(&self, query: &Query<'_, (u32, Range<u32>)>) -> Jacobian {
        let Query { appearance, pixels, parameters, settings, seen } = *query;
        let request = |tile: &[(u32, Range<u32>)]| {
            Request::Jacobian(tile.to_vec(), parameters.to_vec(), *settings)
        };
        self.asked_jacobian((appearance, None), (pixels, parameters.len()), seen, request)
            .unwrap_or_else(|| self.view.jacobian(query))
    }

    fn store<'s>(&'s self, query: &Query<'_>) -> Box<dyn Stored + 's> {
        Box::new(paths::Paths::new(self, query))
    }

    fn rerender(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<Rgb> {
        self.asked_radiance(appearance, pixels, settings)
            .unwrap_or_else(|| self.view.rerender(appearance, pixels, settings))
    }

    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb> {
        let plan = self.view.plan(appearance, settings);
        let picture = self.asked_picture(appearance, &plan);
        let picture = picture.unwrap_or_else(|| self.view.picture(appearance, settings, progress));
        progress(1.0);
        picture
    }
}

impl Shared {
    fn new(bytes: Vec<u8>) -> Self {
        let mut hasher = DefaultHasher::new();
        hasher.write(&bytes);
        Self { number: hasher.finish(), bytes: bytes.into() }
    }
}

impl Shelf {
    fn shared(&mut self, cache: Option<&RadianceCache>) -> Shared {
        let Some(cache) = cache else { return Shared::new(Vec::new()) };
        match &self.0 {
            Some((last, shared)) if is_same(last, cache) => shared.clone(),
            _ => {
                let shared = Shared::new(wire::encode(cache));
                self.0 = Some((cache.clone(), shared.clone()));
                shared
            }
        }
    }
}

/// Whether two caches are the same to the bit.
fn is_same(a: &RadianceCache, b: &RadianceCache) -> bool {
    let bits = |rgb: &Rgb| rgb.to_array().map(f32::to_bits);
    let (left, right) = (a.radiance.pixels(), b.radiance.pixels());
    left.len() == right.len()
        && a.valid == b.valid
        && left.iter().zip(right).all(|(left, right)| bits(left) == bits(right))
}
