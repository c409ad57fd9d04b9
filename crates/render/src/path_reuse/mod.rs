//! Pictures whose neighbouring pixels share what their paths find.
//!
//! A path from the camera looks at a surface, `x`, and goes on to a second one, `y`. The light that
//! was found there goes to the surfaces that neighbouring pixels look at as well, at the price of a
//! ray that asks whether they see it [Bekaert, Sbert and Halton, "Accelerating Path Tracing by
//! Re-Using Paths", EGWR 2002]. With N pixels and their `x_1..x_N`, each of which found a `y_j` that
//! reflects the radiance `L` to all sides, pixel i gets
//!
//! ```text
//! sum over j of  f_i(y_j) cos_i G(x_i, y_j) L(y_j) / sum over k of p_k(y_j)
//! ```
//!
//! where `G = V cos_y / r^2` and `p_k = pdf_k G(x_k, y_j)` is the density over area with which `x_k`
//! would have found `y_j`: the balance heuristic over N strategies [Veach 1997], which biases
//! nothing. Where `y` has a lobe, `L` is `f(y) cos` times the light that arrives from a direction `w`,
//! and the density of having found both is `p_k(y) p(w | y, x_k)`. One path a pixel brings the noise
//! of up to N there. Whether anything stands between `y` and the N surfaces is asked for all of them at
//! once ([`crate::accel`]'s shafts); mostly nothing does, and else a ray is much cheaper than a path.
//! What lies behind a perfect mirror is not shared.
//!
//! A path that shares takes the time of about three. Where most of the noise is not in what can be
//! shared but in what stands in a pixel, leaves or grass say, that is not worth it; a few squares of
//! the picture tell beforehand.
//!
//! The noise of pixels that share is alike. So that the squares do not show, they lie elsewhere for
//! each sample; noise is then softer than that of independent pixels, and what is fitted to pictures
//! or measured in them over many pixels should be without sharing.

mod first;
mod grid;
mod second;
mod viewers;

use crate::adaptive::{Samples, TILE};
use crate::film::{camera_ray, picture_sampler};
use crate::path::Transport;
use crate::sampler::mix;
use crate::tally::Tally;
use first::First;
use glam::DVec3;
use grid::Grid;
use rayon::prelude::*;
use second::{Lobe, Reflection, Second};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender_scene::{Camera, Rgb};
use viewers::{Link, Viewers};

/// The side of the squares whose pixels share, pixels; with a number of samples that depends on the
/// noise those of a square have the same.
const SIDE: usize = TILE;
/// Squares that are rendered at once, at least: enough for many threads.
const BATCH: usize = 1024;
/// The time of a path that shares, in paths that do not: measured, 2.8.
const PRICE: f64 = 3.0;
/// Squares, drawn anywhere, and paths a pixel in each half, that tell whether that is well spent.
const PILOT: (usize, u32) = (16, 2);
/// Keeps the numbers of those apart from the picture's under the same seed.
const STREAM: u64 = 0x50A4_0000_0000_0000;

/// What the samples of a square need; kept from one to the next.
#[derive(Default)]
pub(crate) struct Workspace {
    firsts: Vec<First>,
    /// The same, four by four.
    viewers: Viewers,
    /// With the index of the first surface that found it.
    seconds: Vec<(usize, Second)>,
    links: Vec<Link>,
    /// What a lobe reflects of some light towards each of the links.
    reflected: Vec<Rgb>,
    radiance: Vec<Rgb>,
}

/// What the squares of a picture share.
#[derive(Clone, Copy)]
pub(crate) struct Sharing<'a> {
    pub(crate) transport: &'a Transport<'a>,
    pub(crate) camera: &'a Camera,
    pub(crate) size: (usize, usize),
    pub(crate) seed: u64,
}

impl Sharing<'_> {
    /// How many paths that share nothing a path that shares is worth, by the noise of a few squares;
    /// none where that is less than its price, since most of the noise is what stands in the pixel.
    /// Depends on all that the picture does but on its samples.
    pub(crate) fn worth(&self) -> Option<f64> {
        let grid = Grid::new(self.size, (0, 0));
        if grid.squares() == 0 {
            return None;
        }
        let noise: Vec<[f64; 2]> = (0..PILOT.0 as u64)
            .into_par_iter()
            .map_init(Workspace::default, |space, i| {
                // Anywhere: a fixed step might stay in one column.
                let pixels = grid.pixels(mix(i) as usize % grid.squares());
                [false, true].map(|shared| self.noise(pixels.clone(), shared, space))
            })
            .collect();
        let sum = |way: usize| noise.iter().map(|noise| noise[way]).sum::<f64>();
        (sum(0) > PRICE * sum(1)).then(|| sum(0) / sum(1))
    }

    /// The squared difference of two pictures of some pixels, under numbers of their own.
    fn noise(
        &self,
        pixels: impl Iterator<Item = u32> + Clone,
        shared: bool,
        space: &mut Workspace,
    ) -> f64 {
        let mut difference: Vec<DVec3> = pixels.clone().map(|_| DVec3::ZERO).collect();
        for (half, sign) in [(0, 1.0), (1, -1.0)] {
            let seed = mix(self.seed ^ STREAM).wrapping_add(half);
            let pilot = Self { seed, ..*self };
            for index in 0..PILOT.1 {
                if shared {
                    pilot.sample(pixels.clone(), index, space);
                } else {
                    space.radiance.clear();
                    space.radiance.extend(pixels.clone().map(|pixel| pilot.alone(pixel, index)));
                }
                for (difference, radiance) in difference.iter_mut().zip(&space.radiance) {
                    *difference += sign * radiance.as_dvec3();
                }
            }
        }
        difference.iter().map(|d| d.length_squared()).sum()
    }

    /// What the path number `index` brings a pixel that shares nothing.
    fn alone(&self, pixel: u32, index: u32) -> Rgb {
        let mut sampler = picture_sampler(self.seed, pixel, index);
        let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
        self.transport.radiance(&ray, &mut sampler, 0)
    }

    /// Adds the paths that `samples` asks for to `tally`. `progress` hears the share done, 0 to 1.
    pub(crate) fn accumulate(
        &self,
        samples: &Samples<'_>,
        tally: &mut Tally,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let ranges: Vec<Range<u32>> =
            (0..self.size.0 * self.size.1).map(|i| samples.of(i)).collect();
        let start = ranges.iter().map(|range| range.start).min().unwrap_or(0);
        let end = ranges.iter().map(|range| range.end).max().unwrap_or(0);
        let drifts = matches!(samples, Samples::Even(_));
        let at_once = BATCH.div_ceil(Grid::new(self.size, (0, 0)).squares().max(1)) as u32;
        let mut next = start;
        while next < end {
            let batch = next..end.min(next.saturating_add(at_once));
            let share = |index: u32| f64::from(index - start) / f64::from(end - start);
            let (from, to) = (share(batch.start), share(batch.end));
            next = batch.end;
            let layers: Vec<Layer> =
                batch.map(|index| Layer::new(self.size, index, drifts)).collect();
            self.add(&layers, &ranges, tally, &|done| progress(from + (to - from) * done));
        }
    }

    /// Adds the paths of some numbers to those pixels that they are for.
    fn add(
        &self,
        layers: &[Layer],
        ranges: &[Range<u32>],
        tally: &mut Tally,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let squares =
            layers.iter().flat_map(|layer| (0..layer.grid.squares()).map(move |s| (layer, s)));
        let squares: Vec<_> = squares.collect();
        let (done, all) = (AtomicUsize::new(0), squares.len());
        let radiance: Vec<Vec<Rgb>> = squares
            .into_par_iter()
            .map_init(Workspace::default, |space, (layer, square)| {
                let pixels = layer.grid.pixels(square);
                let is_asked = |pixel: &u32| ranges[*pixel as usize].contains(&layer.index);
                if !pixels.clone().any(|pixel| is_asked(&pixel)) {
                    return Vec::new();
                }
                self.sample(pixels, layer.index, space);
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
                space.radiance.clone()
            })
            .collect();
        let rows = tally.moments.pixels_mut().par_chunks_mut(self.size.0.max(1));
        rows.enumerate().for_each(|(y, row)| {
            let mut first = 0;
            for layer in layers {
                for (x, moments) in row.iter_mut().enumerate() {
                    if ranges[y * self.size.0 + x].contains(&layer.index) {
                        let (square, place) = layer.grid.place(x, y);
                        moments.push(radiance[first + square][place]);
                    }
                }
                first += layer.grid.squares();
            }
        });
    }

    /// The radiance that the paths number `index` bring the pixels of a square, into `space`.
    fn sample(&self, pixels: impl Iterator<Item = u32>, index: u32, space: &mut Workspace) {
        space.firsts.clear();
        space.seconds.clear();
        space.radiance.clear();
        for pixel in pixels {
            let mut sampler = picture_sampler(self.seed, pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            let radiance =
                match First::met(self.transport, &ray, space.radiance.len(), &mut sampler) {
                    Ok(first) => {
                        let (radiance, second) = first.radiance(self.transport, &mut sampler);
                        let finder = space.firsts.len();
                        space.seconds.extend(second.map(|second| (finder, second)));
                        space.firsts.push(first);
                        radiance
                    }
                    Err(radiance) => radiance,
                };
            space.radiance.push(radiance);
        }
        space.viewers.gather(&space.firsts);
        for (finder, second) in &space.seconds {
            space.viewers.links(self.transport, &space.firsts, (*finder, second), &mut space.links);
            share(second, &space.links, &mut space.reflected, &mut space.radiance);
        }
    }
}

/// The paths of one number through all pixels.
struct Layer {
    index: u32,
    grid: Grid,
}

impl Layer {
    /// With squares that drift from one number to the next, or stand in their tiles.
    fn new(size: (usize, usize), index: u32, drifts: bool) -> Self {
        let random = mix(u64::from(index));
        let shift = |bits: u64| if drifts { bits as usize % SIDE } else { 0 };
        Self { index, grid: Grid::new(size, (shift(random), shift(random >> 32))) }
    }
}

/// Adds to the pixels' radiance what `second` reflects towards those that see it.
fn share(second: &Second, links: &[Link], reflected: &mut Vec<Rgb>, radiance: &mut [Rgb]) {
    match &second.reflection {
        Reflection::Even(leaving) => {
            let density: f32 = links.iter().map(|link| link.view.pdf * link.geometry).sum();
            if density > 0.0 {
                for link in links {
                    radiance[link.pixel] += link.view.f_cos * (leaving * (link.geometry / density));
                }
            }
        }
        Reflection::Lobe(lobe) => share_by_lobe(lobe, links, reflected, radiance),
    }
}

/// The same for a lobe, by which the light goes to each in another measure, and would have been
/// found from each with another density.
fn share_by_lobe(lobe: &Lobe, links: &[Link], reflected: &mut Vec<Rgb>, radiance: &mut [Rgb]) {
    for arrival in lobe.arrivals.iter().flatten() {
        reflected.clear();
        let mut density = 0.0;
        for link in links {
            let (f_cos, pdf) = lobe.f_cos_and_pdf(arrival, lobe.towards(link.view.wi));
            density += link.view.pdf * link.geometry * pdf;
            reflected.push(f_cos);
        }
        if density > 0.0 && density.is_finite() {
            for (link, f_cos) in links.iter().zip(reflected.iter()) {
                let f_cos = link.view.f_cos * f_cos;
                radiance[link.pixel] += f_cos * (arrival.radiance * (link.geometry / density));
            }
        }
    }
}
