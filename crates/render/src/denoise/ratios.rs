//! Ratios of pictures without most of their noise: the share of a lamp in the light, the relative change by a colour.
//!
//! Numerator and denominator come from the same paths, so that their ratio has less noise than they have; and it knows no
//! texture, which both have. Each half of a ratio is averaged with the weights of non-local means from the other half
//! [Rousselle et al. 2012], numerator and denominator with the same ones, over pixels that show one surface.
//!
//! It takes about a microsecond of one core a pixel and ratio: a fortieth of what [`super::denoise`] takes, which keeps
//! more detail.

use super::signal::boxed;
use crate::geometry::{GeometryBuffers, PixelGeometry};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use unrender_scene::{Camera, Rgb, RgbImage};

/// Pixels to either side that are averaged. At half of it the noise is twice as large, at double the time four times.
const RADIUS: usize = 5;
/// Pixels to either side of two that are compared. With one less noise decides what is alike, with one more edges have a
/// seam of noise.
const PATCH: usize = 1;
/// The variance of single pixels is estimated over squares of this many pixels to either side.
const VARIANCE_RADIUS: usize = 2;
/// Differences that do not matter, as a share of the ratio. At half of it only noiseless ratios change, at double of it
/// faint edges go.
const INVISIBLE: f32 = 0.01;
/// The differences, in variances of both, at which pixels are no longer alike. At half of it noise remains, at double of it
/// faint edges go.
const UNLIKE: f32 = 4.0;
/// Rows that are averaged at a time.
const BAND: usize = 16;

/// A ratio, twice with independent noise.
#[derive(Clone, Copy, Debug)]
pub struct Ratio<'a> {
    /// What is divided, not negative.
    pub numerator: [&'a RgbImage; 2],
    /// What it is divided by, not negative.
    pub denominator: [&'a RgbImage; 2],
}

/// Smooths the ratios of pictures of one view.
#[derive(Debug)]
pub struct Smoother<'a> {
    geometry: &'a GeometryBuffers,
    /// The points that the pixels show, world space.
    points: Vec<Vec3>,
    /// Whether a neighbour of a pixel shows another surface.
    is_edge: Vec<bool>,
}

/// The mean of the channels of a half's ratio.
fn grey(of: &Ratio<'_>, half: usize) -> Vec<f32> {
    let pairs = of.numerator[half].pixels().iter().zip(of.denominator[half].pixels());
    pairs.map(|(over, under)| over_or_zero(*over, *under).element_sum() / 3.0).collect()
}

/// `over / under` by channel, zero where that is not a number.
pub fn over_or_zero(over: Rgb, under: Rgb) -> Rgb {
    Rgb::from_array([0, 1, 2].map(|c: usize| {
        let ratio = over[c] / under[c];
        if under[c] > 0.0 && ratio.is_finite() { ratio } else { 0.0 }
    }))
}

/// The variance of one half's pixels.
fn variance([a, b]: &[Vec<f32>; 2], width: usize) -> Vec<f32> {
    let squares: Vec<f64> =
        a.iter().zip(b).map(|(a, b)| f64::from((a - b) * (a - b)) / 2.0).collect();
    boxed(&squares, width, VARIANCE_RADIUS).into_iter().map(|v| v as f32).collect()
}

/// What decides which pixels are alike.
struct Guide<'a> {
    ratio: Vec<f32>,
    variance: &'a [f32],
}

impl Guide<'_> {
    /// How far two pixels differ, in variances of both: zero where noise explains it.
    fn difference(&self, a: usize, b: usize) -> f32 {
        let (mine, other) = (self.variance[a], self.variance[b]);
        let off = self.ratio[a] - self.ratio[b];
        let least = INVISIBLE * (self.ratio[a] + self.ratio[b]) / 2.0;
        (off * off - (mine + mine.min(other))) / (mine + other + least * least + f32::MIN_POSITIVE)
    }
}

impl<'a> Smoother<'a> {
    /// That of the view in which `camera` saw the `geometry`.
    pub fn new(camera: &Camera, geometry: &'a GeometryBuffers) -> Self {
        let (width, height) = (geometry.width(), geometry.height());
        let point = |(index, shown): (usize, &PixelGeometry)| {
            let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            camera.origin() + shown.depth * camera.direction(x, y, width, height)
        };
        let points = geometry.pixels().iter().enumerate().map(point).collect();
        let is_edge = vec![false; width * height];
        let plain = Self { geometry, points, is_edge };
        let edge =
            |pixel: usize| geometry.neighbourhood(pixel).any(|near| !plain.is_same(pixel, near));
        let is_edge = (0..width * height).map(edge).collect();
        Self { is_edge, ..plain }
    }

    /// The ratio without most of its noise; zero where the denominator is zero.
    ///
    /// # Panics
    /// If the pictures have another size than the view.
    pub fn smooth(&self, of: &Ratio<'_>) -> RgbImage {
        let (width, height) = self.size();
        let plain = [0, 1].map(|half| grey(of, half));
        let variance = variance(&plain, width);
        let guides = plain.map(|ratio| Guide { ratio, variance: &variance });
        let bands: Vec<Range<usize>> =
            (0..height).step_by(BAND).map(|y| y..(y + BAND).min(height)).collect();
        let band = |rows: &Range<usize>| {
            let [a, b] = [0, 1].map(|half| self.averaged(of, half, &guides[1 - half], rows));
            // A half without samples adds nothing.
            let both = a.into_iter().zip(b).map(|(a, b)| over_or_zero(a.0 + b.0, a.1 + b.1));
            both.collect::<Vec<Rgb>>()
        };
        let pixels = bands.par_iter().flat_map_iter(band).collect();
        RgbImage::new(width, height, pixels)
    }

    fn size(&self) -> (usize, usize) {
        (self.geometry.width(), self.geometry.height())
    }

    fn is_same(&self, a: usize, b: usize) -> bool {
        let [shown, other] = [a, b].map(|pixel| &self.geometry.pixels()[pixel]);
        shown.shows(other.object, other.normal, self.points[b] - self.points[a])
            && self.is_edge[a] == self.is_edge[b]
    }

    /// Numerator and denominator of a half in some rows, averaged by the `guide` of the other half.
    fn averaged(
        &self,
        of: &Ratio<'_>,
        half: usize,
        guide: &Guide<'_>,
        rows: &Range<usize>,
    ) -> Vec<(Rgb, Rgb)> {
        let (width, _) = self.size();
        let first = rows.start * width;
        let [over, under] = [of.numerator[half].pixels(), of.denominator[half].pixels()];
        let own = first..rows.end * width;
        let mut sums: Vec<(Rgb, Rgb)> = own.map(|pixel| (over[pixel], under[pixel])).collect();
        let steps = -(RADIUS as i64)..=RADIUS as i64;
        for (dy, dx) in steps.clone().flat_map(|dy| steps.clone().map(move |dx| (dy, dx))) {
            if (dx, dy) == (0, 0) {
                continue;
            }
            let differences = self.differences(guide, rows, (dx, dy));
            for (index, difference) in differences.into_iter().enumerate() {
                // Pixels that are not of one surface differ by infinity.
                let like = 1.0 - difference / UNLIKE;
                if like > 0.0 {
                    let weight = like.min(1.0);
                    let weight = weight * weight;
                    let other = (first as i64 + index as i64 + dy * width as i64 + dx) as usize;
                    sums[index].0 += weight * over[other];
                    sums[index].1 += weight * under[other];
                }
            }
        }
        sums
    }

    /// How far the pixels of some rows differ from those a step away, in the mean of their patches.
    fn differences(
        &self,
        guide: &Guide<'_>,
        rows: &Range<usize>,
        (dx, dy): (i64, i64),
    ) -> Vec<f32> {
        let (width, height) = self.size();
        let other = |x: usize, y: usize| {
            let (x, y) = (x as i64 + dx, y as i64 + dy);
            let is_inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
            is_inside.then(|| y as usize * width + x as usize)
        };
        let grown = rows.start.saturating_sub(PATCH)..(rows.end + PATCH).min(height);
        // Sums along rows: the difference of each pixel, and how many have one.
        let mut along = vec![(0.0f32, 0u32); grown.len() * width];
        for (y, along) in grown.clone().zip(along.chunks_mut(width)) {
            for x in 0..width {
                let Some(there) = other(x, y) else { continue };
                let difference = guide.difference(y * width + x, there);
                for near in x.saturating_sub(PATCH)..(x + PATCH + 1).min(width) {
                    along[near].0 += difference;
                    along[near].1 += 1;
                }
            }
        }
        let mean = |(x, y): (usize, usize)| {
            let here = y * width + x;
            if !other(x, y).is_some_and(|there| self.is_same(here, there)) {
                return f32::INFINITY;
            }
            let near = y.saturating_sub(PATCH).max(grown.start)..(y + PATCH + 1).min(grown.end);
            let sums = near.map(|row| along[(row - grown.start) * width + x]);
            let (sum, count) = sums.fold((0.0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
            sum / count.max(1) as f32
        };
        rows.clone().flat_map(|y| (0..width).map(move |x| (x, y))).map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::mix;
    use glam::Vec2;
    use unrender_scene::Image;

    const SIDE: usize = 48;

    /// A wall that fills the picture.
    fn wall() -> (Camera, GeometryBuffers) {
        let camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.6);
        let at = |x: usize, y: usize| {
            let direction = camera.direction(x as f32 + 0.5, y as f32 + 0.5, SIDE, SIDE);
            PixelGeometry {
                object: 0,
                group: 0,
                depth: -1.0 / direction.z,
                normal: Vec3::Z,
                tangent: Vec3::X,
                uv: Vec2::ZERO,
                front: true,
            }
        };
        (camera.clone(), Image::from_fn(SIDE, SIDE, at))
    }

    fn noise(seed: usize) -> f32 {
        (mix(seed as u64) >> 40) as f32 / 16_777_216.0 - 0.5
    }

    /// The root mean square error of the ratio `truth` of pictures with a texture and noise.
    fn error(truth: impl Fn(usize, usize) -> f32) -> [f32; 2] {
        let (camera, geometry) = wall();
        let texture =
            |x: usize, y: usize| if (x / 3 + y / 3).is_multiple_of(2) { 1.0 } else { 0.2 };
        let halves: Vec<[RgbImage; 2]> = [1, 2]
            .map(|half| {
                let at = |x: usize, y: usize| {
                    let place = (half * SIDE + y) * SIDE + x;
                    let over = truth(x, y) * texture(x, y) * (1.0 + 0.4 * noise(2 * place));
                    let rest =
                        (1.0 - truth(x, y)) * texture(x, y) * (1.0 + 0.4 * noise(2 * place + 1));
                    (Rgb::splat(over), Rgb::splat(over + rest))
                };
                [
                    RgbImage::from_fn(SIDE, SIDE, |x, y| at(x, y).0),
                    RgbImage::from_fn(SIDE, SIDE, |x, y| at(x, y).1),
                ]
            })
            .into();
        let of = Ratio {
            numerator: [&halves[0][0], &halves[1][0]],
            denominator: [&halves[0][1], &halves[1][1]],
        };
        let smooth = Smoother::new(&camera, &geometry).smooth(&of);
        let plain = [0, 1].map(|half| grey(&of, half));
        let root = |value: &dyn Fn(usize) -> f32| {
            let square = |i: usize| (value(i) - truth(i % SIDE, i / SIDE)).powi(2);
            ((0..SIDE * SIDE).map(square).sum::<f32>() / (SIDE * SIDE) as f32).sqrt()
        };
        [root(&|i| 0.5 * (plain[0][i] + plain[1][i])), root(&|i| smooth.pixels()[i].x)]
    }

    #[test]
    fn a_slope_loses_its_noise() {
        let [before, after] = error(|x, _| 0.2 + 0.6 * x as f32 / SIDE as f32);
        assert!(after < 0.35 * before, "{before} {after}");
    }

    #[test]
    fn the_edge_of_a_shadow_stays() {
        let [before, after] = error(|x, y| if x > y { 0.9 } else { 0.1 });
        assert!(after < 0.5 * before, "{before} {after}");
    }
}
