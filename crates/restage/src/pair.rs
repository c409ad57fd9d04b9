//! A scene before and after its edits, rendered with the same random numbers.
//!
//! Each path is walked twice with the same numbers, once in either scene. Paths that meet nothing of
//! the edit are alike to the bit and their difference is nothing; so the noise of the difference is
//! that of the change and not that of the picture. Its variance is that of the differences, path by
//! path.
//!
//! A path also tells *what* is seen: perfect mirrors are followed to what stands in them, and if that
//! is another surface before and after, or wears another material, then what the photograph shows
//! there has been replaced.

use crate::edit::Change;
use glam::Vec3;
use rayon::prelude::*;
use rayon::slice::ChunksMut;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_render::accel::Ray;
use unrender_render::adaptive::{self, Samples, Shares};
use unrender_render::film::{camera_ray, picture_sampler};
use unrender_render::path::Transport;
use unrender_render::surface::Surface;
use unrender_render::{Moments, Settings, Tally, Tracer};
use unrender_scene::{Camera, Image, Material, Rgb, RgbImage, Scene};

/// What one pixel is, before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paired {
    /// Radiance before the edits, W sr^-1 m^-2 per channel.
    pub before: Rgb,
    /// Radiance after.
    pub after: Rgb,
    /// The part of `after - before` that comes by paths which see the same surface.
    pub kept_change: Rgb,
    /// Variance of `kept_change`: where nothing is replaced, that of `after - before`.
    pub change_variance: Rgb,
    /// Variance of `before`.
    pub before_variance: Rgb,
    /// Variance of `after`.
    pub after_variance: Rgb,
    /// The share of the pixel that shows something else than before, 0 to 1.
    pub replaced: f32,
    /// The share of the pixel that shows a surface of the old scene which something hid before.
    pub uncovered: f32,
}

/// The scene before and after.
#[derive(Clone, Copy, Debug)]
pub struct Scenes<'a> {
    /// The scene that the photograph shows.
    pub before: &'a Scene,
    /// The same with the edits, validated.
    pub after: &'a Scene,
    /// What the edits did.
    pub change: &'a Change,
}

/// The sums that a pairing keeps of every pixel, each in a tally of its own: the radiance after and
/// before; what the paths that see the same surface as before bring more than before, and less; and
/// one, in the first channel, for each path that sees something else, in the second for each that
/// sees what was uncovered.
pub const LAYERS: [&str; 5] = ["after", "before", "lighter", "darker", "shown"];

/// Pixels that one task renders before it reports progress.
const CHUNK: usize = 128;
/// Mirrors in a row that are looked through at most.
const MIRRORS_MAX: usize = 16;

/// Both scenes, ready to be rendered together.
#[derive(Debug)]
pub struct Pairing<'a> {
    scenes: Scenes<'a>,
    before: (Tracer, Vec<Material>),
    after: (Tracer, Vec<Material>),
    camera: &'a Camera,
    settings: Settings,
}

impl<'a> Pairing<'a> {
    /// Prepares both scenes, as `camera` sees them; `settings.spp` does not count.
    pub fn new(scenes: Scenes<'a>, camera: &'a Camera, settings: Settings) -> Self {
        let side = |scene: &Scene| (Tracer::new(scene), scene.materials());
        let (before, after) = (side(scenes.before), side(scenes.after));
        Self { scenes, before, after, camera, settings }
    }

    /// Adds the paths that `samples` asks for to `layers`, whose size is the picture's. However the paths are cut into calls, the sums have the same bits.
    /// `progress` hears the share done, 0 to 1, from any thread.
    ///
    /// # Panics
    /// If there is not one tally for each of [`LAYERS`].
    pub fn accumulate(
        &self,
        samples: &Samples<'_>,
        layers: &mut [Tally],
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let [after, before, lighter, darker, shown] = layers else {
            panic!("a pairing has {} layers", LAYERS.len());
        };
        let size = after.size();
        let pair = self.pair(size);
        let done = AtomicUsize::new(0);
        (chunks(after), chunks(before), chunks(lighter), chunks(darker), chunks(shown))
            .into_par_iter()
            .enumerate()
            .for_each(|(chunk, (after, before, lighter, darker, shown))| {
                for offset in 0..after.len() {
                    let pixel = chunk * CHUNK + offset;
                    let mut sums = Sums {
                        after: &mut after[offset],
                        before: &mut before[offset],
                        lighter: &mut lighter[offset],
                        darker: &mut darker[offset],
                        shown: &mut shown[offset],
                    };
                    pair.add(pixel as u32, samples.of(pixel), &mut sums);
                }
                let so_far = done.fetch_add(after.len(), Ordering::Relaxed) + after.len();
                progress(so_far as f64 / (size.0 * size.1) as f64);
            });
    }

    /// Renders a pilot of a picture of `size` and says how many paths each pixel should get, by the
    /// noise of what goes into a composite: the change, or where something new is seen the radiance.
    pub fn shares(&self, (width, height): (usize, usize)) -> Shares {
        let settings = Settings { seed: adaptive::pilot_seed(self.settings.seed), ..self.settings };
        let pilot = Self::new(self.scenes, self.camera, settings);
        let mut layers = LAYERS.map(|_| Tally::new(width, height));
        pilot.accumulate(&Samples::Even(0..adaptive::PILOT), &mut layers, &|_| ());
        let moments = |index: usize| {
            let of = |layer: usize| layers[layer].moments().pixels()[index];
            // Each path counts twice then, as lighter and as darker; in all pixels alike.
            let mut change = of(2);
            change.add(&of(3));
            if of(4).sum[0] > 0 { of(0) } else { change }
        };
        let moments = (0..width * height).map(moments).collect();
        Shares::by_noise(&Tally::from_moments(Image::new(width, height, moments)))
    }

    fn pair(&self, size: (usize, usize)) -> Pair<'_> {
        Pair {
            before: Side::new(&self.before, &self.settings),
            after: Side::new(&self.after, &self.settings),
            origin: &self.scenes.change.origin,
            repainted: repainted(&self.scenes),
            new_surroundings: self.scenes.before.environment != self.scenes.after.environment,
            camera: self.camera,
            size,
            settings: &self.settings,
        }
    }
}

fn chunks(tally: &mut Tally) -> ChunksMut<'_, Moments> {
    tally.moments_mut().pixels_mut().par_chunks_mut(CHUNK)
}

/// What the sums in `layers`, one tally for each of [`LAYERS`], say of every pixel.
///
/// # Panics
/// If tallies are missing.
pub fn paired(layers: &[Tally]) -> Image<Paired> {
    let (width, height) = layers[0].size();
    let of_pixel = |index: usize| {
        let of = |layer: usize| layers[layer].moments().pixels()[index];
        let (after, before, lighter, darker) = (of(0), of(1), of(2), of(3));
        let shown = of(4).mean();
        let n = (lighter.count as f32 - 1.0).max(1.0);
        Paired {
            before: before.mean(),
            after: after.mean(),
            kept_change: lighter.mean() - darker.mean(),
            // A channel of a path is lighter or darker, so their product is nothing.
            change_variance: lighter.variance()
                + darker.variance()
                + 2.0 * lighter.mean() * darker.mean() / n,
            before_variance: before.variance(),
            after_variance: after.variance(),
            replaced: shown.x,
            uncovered: shown.y,
        }
    };
    Image::new(width, height, (0..width * height).map(of_pixel).collect())
}

/// Renders both scenes as `camera` sees them in `width` x `height` pixels. `progress` hears the
/// share done, 0 to 1, from any thread.
pub fn render(
    scenes: &Scenes<'_>,
    camera: &Camera,
    (width, height): (usize, usize),
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Image<Paired> {
    let mut layers = LAYERS.map(|_| Tally::new(width, height));
    let pairing = Pairing::new(*scenes, camera, *settings);
    pairing.accumulate(&Samples::Even(0..settings.spp), &mut layers, progress);
    paired(&layers)
}

/// For each group of the old scene: whether it reflects or emits differently after.
fn repainted(scenes: &Scenes<'_>) -> Vec<bool> {
    let pairs = scenes.before.groups.iter().zip(&scenes.after.groups);
    pairs.map(|(b, a)| b.material != a.material || b.emission != a.emission).collect()
}

struct Side<'a> {
    transport: Transport<'a>,
    materials: &'a [Material],
}

struct Pair<'a> {
    before: Side<'a>,
    after: Side<'a>,
    origin: &'a [Option<usize>],
    repainted: Vec<bool>,
    new_surroundings: bool,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

/// What a path sees: an object and a point of it.
type Shown = Option<(u32, u32, Vec3)>;

impl<'a> Side<'a> {
    fn new((tracer, materials): &'a (Tracer, Vec<Material>), settings: &Settings) -> Self {
        let transport = Transport::new(tracer, materials.into(), settings.max_bounces);
        Self { transport, materials }
    }

    /// Object, group and point that `surface` shows to a viewer along `direction`: itself, or what
    /// stands in it if it is a perfect mirror.
    fn shown(&self, mut surface: Surface, mut direction: Vec3) -> Shown {
        for _ in 0..MIRRORS_MAX {
            if !self.materials[surface.group as usize].is_pure_mirror() {
                break;
            }
            let normal = surface.frame.normal;
            let wi = direction - 2.0 * direction.dot(normal) * normal;
            if !surface.is_above(wi) {
                return None;
            }
            surface = self.transport.surface(&Transport::leave(&surface, wi))?;
            direction = wi;
        }
        Some((surface.object, surface.group, surface.point))
    }

    /// What arrives along a ray, and what is seen.
    fn look(&self, ray: &Ray, sampler: &mut unrender_render::sampler::Sampler) -> (Rgb, Shown) {
        let radiance = self.transport.radiance(ray, sampler, 0);
        let shown = self.transport.surface(ray).and_then(|s| self.shown(s, ray.direction));
        (radiance, shown)
    }
}

impl Pair<'_> {
    /// Adds the paths of the numbers `samples` to those of a pixel.
    fn add(&self, pixel: u32, samples: Range<u32>, sums: &mut Sums<'_>) {
        for index in samples {
            let mut sampler = picture_sampler(self.settings.seed, pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            let mut again = sampler;
            let (before, was) = self.before.look(&ray, &mut sampler);
            let (after, is) = self.after.look(&ray, &mut again);
            sums.push(before, after, self.compare(was, is));
        }
    }

    /// Whether what is seen was replaced, and whether it was uncovered.
    fn compare(&self, was: Shown, is: Shown) -> (bool, bool) {
        let Some((object, group, point)) = is else {
            return (was.is_some() || self.new_surroundings, was.is_some());
        };
        let Some(origin) = self.origin[object as usize] else { return (true, false) };
        if self.repainted[group as usize] {
            return (true, false);
        }
        let same = was.is_some_and(|(old, _, at)| old as usize == origin && at == point);
        (!same, !same)
    }
}

/// The sums over a pixel's paths.
struct Sums<'a> {
    after: &'a mut Moments,
    before: &'a mut Moments,
    lighter: &'a mut Moments,
    darker: &'a mut Moments,
    shown: &'a mut Moments,
}

impl Sums<'_> {
    fn push(&mut self, before: Rgb, after: Rgb, (replaced, uncovered): (bool, bool)) {
        self.before.push(before);
        self.after.push(after);
        let change = if replaced { Rgb::ZERO } else { after - before };
        self.lighter.push(change.max(Rgb::ZERO));
        self.darker.push((-change).max(Rgb::ZERO));
        let one = |is: bool| f32::from(u8::from(is));
        self.shown.push(Rgb::new(one(replaced), one(uncovered), 0.0));
    }
}

/// The picture of the scene after its edits.
pub fn after(paired: &Image<Paired>) -> RgbImage {
    paired.map(|pixel| pixel.after)
}
