//! Textures: a base whose reflectance has a pattern (section 4.2.6).
//!
//! The paper balances the texture extracted from the photograph against the one extracted from the re-rendering, and names
//! shadows in textures an open problem. The light on a white base, `D`, holds the shadows, the fall-off and the
//! interreflections, so that `(photograph - specular) / D` has none of them. The texels are those that explain it best over
//! the pixels' footprints (`footprint`), by weighted least squares (`texels`): what repeats is pooled. Texels that no
//! pixel sees are filled from their neighbours over a pyramid [Gortler et al. 1996], and marked.
//!
//! A texture has as many unknowns as pixels: that it fits is no evidence. It is one if texels from some pixels predict
//! others better than the best uniform reflectance does (`pattern`).

mod detailed;
mod footprint;
mod lit;
mod look;
mod near;
mod pattern;
mod smooth;
#[cfg(test)]
mod tests;
mod texels;

pub use detailed::Detail;
pub(crate) use look::{Asked, Found, look};

use crate::evidence::SampleBudget;
use crate::observe::observation::Noise;
use crate::observe::sample::Stage;
use footprint::{Footprint, Rows};
use glam::{DVec3, Vec2};
use lit::Lit;
use near::Near;
use rayon::prelude::*;
use std::sync::Arc;
use texels::{Prior, Texels};
use unrender_render::Appearance;
use unrender_scene::{Image, Material, Rgb, RgbImage, Texture, Wrap};

/// A texture and which of its texels the photograph shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Extracted {
    /// The texture, filled everywhere.
    pub texture: Arc<Texture>,
    /// True for texels that a pixel shows; the others are guessed from their neighbours.
    pub seen: Image<bool>,
    /// The standard deviation of one of these, root mean square; zero where it was not asked for.
    pub deviation: Rgb,
}

/// A side of a texture has this many texels at most. At half of it photographs of 12 megapixels lose detail, double of it
/// was not tried.
const SIDE_MAX: f32 = 2048.0;
/// Texels along a pixel: what repeats at other places in the pixels is resolved beyond them. At half of it edges blur to
/// two pixels; at double nothing is gained.
const DENSITY: f32 = 1.9;
/// How much alike neighbouring texels may be asked to be, in units of a texel's mean weight; other pixels decide. A tenth
/// of the least follows the noise of every texture that was tried, ten times the most blurs every one.
const ALIKE: [f32; 4] = [0.003, 0.03, 0.3, 3.0];
/// The side of the squares of pixels of which half are fitted and half are predicted, pixels: no wider than details that
/// texels may hold. Half and double of it were not tried.
const SQUARE: usize = 4;
/// What a pixel shows is wrong by at least this share of the mean reflectance, beyond the photograph's noise; and by so much
/// before anything is known. Half and double of either change no texture that was tried.
const LEAST: f32 = 0.01;
const START: f32 = 0.05;

/// The texture of group `group` under the light of the current `appearance`; none if the group has
/// no texture coordinates. `lobe` is the specular part over a black base. With the finer photograph as
/// `detail`, the texels are made of its pixels.
pub(crate) fn extract(
    (stage, detail): (&Stage<'_>, Option<&dyn Detail>),
    appearance: Appearance<'_>,
    group: usize,
    lobe: &Material,
    budget: &SampleBudget,
) -> Option<Extracted> {
    let geometry = stage.renderer.geometry();
    let pixels = &stage.observation.pixels_of_group[group];
    let footprint = |pixel: &u32| Footprint::of(geometry, *pixel as usize);
    let lit = gather(stage, appearance, (group, pixels), lobe, budget);
    let shown = match detail {
        Some(detail) => detailed::shown((stage, detail), group, &lit),
        None => Shown {
            footprints: lit.pixels.iter().map(footprint).collect(),
            near: Near::of(&lit.pixels, geometry.width()),
            under: lit.under(),
            light: lit.base,
            noise: lit.noise,
        },
    };
    let lattice = footprint::lattice(&shown.footprints, DENSITY, SIDE_MAX)?;
    Some(solved(&shown, lattice))
}

/// Pixels that show a texture.
struct Shown {
    footprints: Vec<Footprint>,
    near: Near,
    /// The radiance of the base, and the photograph's noise.
    under: Vec<Rgb>,
    noise: Vec<Noise>,
    /// The radiance of a white base, twice.
    light: [Vec<Rgb>; 2],
}

impl Shown {
    /// The reflectance that each pixel shows, and the inverse of its variance, where pixels of this `mean` reflectance are
    /// wrong by a `share` of it beyond the photograph's noise. Neither depends on the pixel's own noise: what is weighted by
    /// its own scatter is too dark, since bright outliers count less. The light's power is the product of both halves.
    fn reflectances(&self, mean: Rgb, share: f32) -> (Vec<Rgb>, Vec<f32>) {
        let [a, b] = &self.light;
        let one = |i: usize| {
            let (light, power) = (0.5 * (a[i] + b[i]), a[i] * b[i]);
            let value =
                Rgb::select(power.cmpgt(Rgb::ZERO), light * self.under[i] / power, Rgb::ZERO);
            let noise = self.noise[i].variance(mean * light).element_sum() / 3.0;
            let error = (share * mean * light).length_squared() / 3.0;
            let power = power.max(Rgb::ZERO).element_sum() / 3.0;
            (value, power / (noise + error).max(1e-30))
        };
        (0..self.under.len()).into_par_iter().map(one).unzip()
    }
}

/// The texture that explains `shown` best.
fn solved(shown: &Shown, lattice: [usize; 2]) -> Extracted {
    let texels = Texels::new(Rows::of(&shown.footprints, lattice), lattice);
    let [sum, power] = both(&shown.under, &lit::mean(&shown.light));
    let mean = (sum / power.max(DVec3::splat(1e-30))).as_vec3().clamp(Rgb::ZERO, Rgb::ONE);
    let start = vec![mean; texels.places.len()];
    // The error beyond the noise is what a first texture leaves.
    let (values, weights) = shown.reflectances(mean, START);
    let first = texels.solve(&values, &weights, Prior { alike: ALIKE[1], small: 0.0 }, &start);
    let left = left(&values, &weights, &texels.seen(&first));
    let share = (left - variance(&weights)).max(0.0).sqrt() / mean.element_sum().max(1e-6) * 3.0;
    let (values, weights) = shown.reflectances(mean, share.clamp(LEAST, 1.0));
    let alike = chosen(&texels, (&values, &weights), &shown.near, &first);
    let now = texels.solve_bounded(&values, &weights, Prior { alike, small: 0.0 }, &first);
    let per_texel = (values.len() as f32 / texels.places.len().max(1) as f32).max(1.0);
    let deviation = (self::left(&values, &weights, &texels.seen(&now)) / per_texel).sqrt();
    let [width, height] = lattice;
    let mut seen = Image::new(width, height, vec![false; width * height]);
    let mut image = RgbImage::new(width, height, vec![mean; width * height]);
    for (place, value) in texels.places.iter().zip(&now) {
        seen.pixels_mut()[*place as usize] = true;
        image.pixels_mut()[*place as usize] = *value;
    }
    let image = filled(&image, &seen);
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Extracted { texture: Arc::new(texture), seen, deviation: Rgb::splat(deviation.min(1.0)) }
}

/// The sums of `a b` and of `b b`.
fn both(a: &[Rgb], b: &[Rgb]) -> [DVec3; 2] {
    let products =
        a.iter().zip(b).map(|(a, b)| (a.as_dvec3() * b.as_dvec3(), (*b * *b).as_dvec3()));
    let (sum, power) =
        products.fold((DVec3::ZERO, DVec3::ZERO), |(s, p), (ab, bb)| (s + ab, p + bb));
    [sum, power]
}

/// The weighted mean of the squared differences of `values` and what is `seen`, over the channels.
fn left(values: &[Rgb], weights: &[f32], seen: &[Rgb]) -> f32 {
    let of = |((value, seen), weight): ((&Rgb, &Rgb), &f32)| {
        f64::from(*weight) * f64::from((*value - *seen).length_squared() / 3.0)
    };
    let sum: f64 = values.iter().zip(seen).zip(weights).map(of).sum();
    (sum / weights.iter().map(|weight| f64::from(*weight)).sum::<f64>().max(1e-30)) as f32
}

/// The weighted mean of the variances that `weights` are the inverses of.
fn variance(weights: &[f32]) -> f32 {
    let (count, sum) = weights
        .iter()
        .filter(|weight| **weight > 0.0)
        .fold((0.0, 0.0), |(n, sum), w| (n + 1.0, sum + f64::from(*w)));
    (count / f64::max(sum, 1e-30)) as f32
}

/// Which of [`ALIKE`] predicts half of the pixels best from the others.
fn chosen(texels: &Texels, (values, weights): (&[Rgb], &[f32]), near: &Near, start: &[Rgb]) -> f32 {
    let checkers = near.checkers(SQUARE, 0);
    let is_fitted = |i: usize| checkers[i].0 == 0;
    let fitted: Vec<f32> =
        weights.iter().enumerate().map(|(i, w)| if is_fitted(i) { *w } else { 0.0 }).collect();
    let (mut best, mut least, mut now) = (ALIKE[0], f64::INFINITY, start.to_vec());
    for alike in ALIKE.into_iter().rev() {
        now = texels.solve(values, &fitted, Prior { alike, small: 0.0 }, &now);
        let seen = texels.seen(&now);
        let left = |i: usize| {
            let deviations = (values[i] - seen[i]).abs() * weights[i].sqrt();
            f64::from(deviations.min(Rgb::splat(3.0)).length_squared())
        };
        let left: f64 = (0..values.len()).filter(|i| !is_fitted(*i)).map(left).sum();
        if left < least {
            (best, least) = (alike, left);
        }
    }
    best
}

/// The relative noise of the light that a texture is divided by. At half of it dim groups cost four times
/// as many paths; at double the noise shows in their textures, and speaks against them.
const NOISE: f32 = 0.03;
/// The light is gathered again with at most so many times the samples.
const MORE_MAX: f32 = 16.0;

/// The light on all pixels of a group, smoothed: gathered again with more samples where a dim group's is too noisy.
fn gather(
    stage: &Stage<'_>,
    appearance: Appearance<'_>,
    pixels: (usize, &[u32]),
    lobe: &Material,
    budget: &SampleBudget,
) -> Lit {
    let gather = |budget: &SampleBudget| {
        let lit = Lit::gather(stage, appearance, pixels, lobe, &budget.probe);
        lit.smoothed(stage.renderer.geometry())
    };
    let found = gather(budget);
    let more = (found.scatter() / NOISE).powi(2).min(MORE_MAX);
    if more <= 1.0 {
        return found;
    }
    let mut again = budget.clone();
    again.probe.cosine = (budget.probe.cosine as f32 * more).ceil() as u32;
    again.probe.per_lobe = (budget.probe.per_lobe as f32 * more).ceil() as u32;
    gather(&again)
}

/// The image with its unseen texels filled: from the next coarser level of a pyramid in which each
/// texel is the mean of the seen ones below it.
pub fn filled(image: &RgbImage, seen: &Image<bool>) -> RgbImage {
    let (width, height) = (image.width(), image.height());
    if width * height == 1 || seen.pixels().iter().all(|s| *s) {
        return image.clone();
    }
    let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
    let below = |x: usize, y: usize| {
        let rows = 2 * y..(2 * y + 2).min(height);
        let all = rows.flat_map(move |r| (2 * x..(2 * x + 2).min(width)).map(move |c| (c, r)));
        all.filter(|&(c, r)| *seen.at(c, r))
            .fold((Rgb::ZERO, 0.0), |(sum, n), (c, r)| (sum + *image.at(c, r), n + 1.0))
    };
    let coarse_seen = Image::from_fn(half_width, half_height, |x, y| below(x, y).1 > 0.0);
    let coarse = RgbImage::from_fn(half_width, half_height, |x, y| {
        let (sum, n) = below(x, y);
        sum / f32::max(n, 1.0)
    });
    let coarse = filled(&coarse, &coarse_seen);
    let smooth = Texture { image: coarse, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge };
    RgbImage::from_fn(width, height, |x, y| {
        if *seen.at(x, y) {
            return *image.at(x, y);
        }
        smooth.sample(Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32))
    })
}

/// The mean reflectance of the texels that are seen.
pub fn mean(extracted: &Extracted) -> Rgb {
    let texels = extracted.texture.image.pixels().iter().zip(extracted.seen.pixels());
    let (sum, count) = texels
        .filter(|(_, seen)| **seen)
        .fold((DVec3::ZERO, 0.0), |(sum, count), (value, _)| (sum + value.as_dvec3(), count + 1.0));
    (sum / f64::max(count, 1.0)).as_vec3()
}

/// The mean of a texture counts as at least this: a factor on what is black changes nothing.
pub(crate) const MEAN_MIN: f32 = 1e-4;

/// Gives one channel of the diffuse reflectance the mean `rho_d`: that of every texel changes by the same factor.
pub(crate) fn set_mean(material: &mut Material, channel: usize, rho_d: f32) {
    let factor = rho_d / material.rho_d[channel].max(MEAN_MIN);
    material.rho_d[channel] = rho_d;
    let Some(texture) = &mut material.texture else { return };
    let texels = Arc::make_mut(texture).image.pixels_mut();
    texels.iter_mut().for_each(|texel| texel[channel] = (factor * texel[channel]).clamp(0.0, 1.0));
}
