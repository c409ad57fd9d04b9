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
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_render::accel::Ray;
use unrender_render::film::{camera_ray, picture_sampler};
use unrender_render::path::Transport;
use unrender_render::surface::Surface;
use unrender_render::{Moments, Settings, Tracer};
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

/// Pixels that one task renders before it reports progress.
const CHUNK: usize = 128;
/// Mirrors in a row that are looked through at most.
const MIRRORS_MAX: usize = 16;

/// Renders both scenes as `camera` sees them in `width` x `height` pixels. `progress` hears the
/// share done, 0 to 1, from any thread.
pub fn render(
    scenes: &Scenes<'_>,
    camera: &Camera,
    (width, height): (usize, usize),
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Image<Paired> {
    let (before, after) = (Tracer::new(scenes.before), Tracer::new(scenes.after));
    let (before_materials, after_materials) = (scenes.before.materials(), scenes.after.materials());
    let pair = Pair {
        before: Side::new(&before, &before_materials, settings),
        after: Side::new(&after, &after_materials, settings),
        origin: &scenes.change.origin,
        repainted: repainted(scenes),
        new_surroundings: scenes.before.environment != scenes.after.environment,
        camera,
        size: (width, height),
        settings,
    };
    let pixels: Vec<u32> = (0..(width * height) as u32).collect();
    let done = AtomicUsize::new(0);
    let paired = pixels
        .par_chunks(CHUNK)
        .flat_map_iter(|chunk| {
            let of_pixel = |&pixel: &u32| {
                let mut sums = Sums::default();
                pair.add(pixel, 0..settings.spp, &mut sums);
                sums.paired()
            };
            let part: Vec<Paired> = chunk.iter().map(of_pixel).collect();
            let so_far = done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len();
            progress(so_far as f64 / pixels.len() as f64);
            part
        })
        .collect();
    Image::new(width, height, paired)
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
    fn new(tracer: &'a Tracer, materials: &'a [Material], settings: &Settings) -> Self {
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
    fn add(&self, pixel: u32, samples: Range<u32>, sums: &mut Sums) {
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

/// The sums over a pixel's paths, in whole numbers: paths that are added up in any order, in any
/// parts, give the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    /// Radiance before the edits.
    pub before: Moments,
    /// Radiance after.
    pub after: Moments,
    /// What the paths that see the same surface as before bring more than before.
    pub lighter: Moments,
    /// What they bring less.
    pub darker: Moments,
    /// One, in the first channel, for each path that sees something else; in the second for each
    /// that sees what was uncovered.
    pub shown: Moments,
}

impl Sums {
    fn push(&mut self, before: Rgb, after: Rgb, (replaced, uncovered): (bool, bool)) {
        self.before.push(before);
        self.after.push(after);
        let change = if replaced { Rgb::ZERO } else { after - before };
        self.lighter.push(change.max(Rgb::ZERO));
        self.darker.push((-change).max(Rgb::ZERO));
        let one = |is: bool| f32::from(u8::from(is));
        self.shown.push(Rgb::new(one(replaced), one(uncovered), 0.0));
    }

    /// What they say of the pixel.
    pub fn paired(&self) -> Paired {
        let (lighter, darker) = (self.lighter.mean(), self.darker.mean());
        let shown = self.shown.mean();
        let n = (self.lighter.count as f32 - 1.0).max(1.0);
        Paired {
            before: self.before.mean(),
            after: self.after.mean(),
            kept_change: lighter - darker,
            // A channel of a path is lighter or darker, so their product is nothing.
            change_variance: self.lighter.variance()
                + self.darker.variance()
                + 2.0 * lighter * darker / n,
            before_variance: self.before.variance(),
            after_variance: self.after.variance(),
            replaced: shown.x,
            uncovered: shown.y,
        }
    }
}

/// The picture of the scene after its edits.
pub fn after(paired: &Image<Paired>) -> RgbImage {
    paired.map(|pixel| pixel.after)
}
