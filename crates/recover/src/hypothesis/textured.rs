//! Rung 7, a texture: `rho_d` per texel = (photograph - specular) / `D` (section 4.2.6).
//!
//! The paper balances the texture extracted from the photograph against the one extracted from the
//! re-rendering ([`rebalance`]), and names shadows in textures an open problem. `D` holds the
//! shadows, the fall-off and the interreflections, so dividing by it leaves none of them in the
//! texture ([`extract`]).
//!
//! A pixel sees the four texels about its texture coordinate, with the weights `w` of bilinear
//! interpolation. The texture minimises the squared differences of the photograph and `D` times the
//! interpolated reflectance, by simultaneous iterative reconstruction [Gilbert 1972]: from zero, each
//! step adds `sum w (D B - D_A D_B T) / sum w D_A D_B` to the texel, `T` being the interpolated
//! texture so far. The first step alone is a blurred texture; many follow the noise.
//! Texels that no pixel sees are filled from their neighbours over a pyramid [Gortler et al. 1996], and
//! marked.

mod detailed;

pub use detailed::Detail;

use crate::evidence::{Evidence, SampleBudget};
use crate::observe::sample::{Observed, Stage};
use glam::{DVec3, Vec2};
use std::sync::Arc;
use unrender_render::{Appearance, GeometryBuffers};
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

/// A side of a texture has this many texels at most.
const SIDE_MAX: f32 = 2048.0;
/// Texels are this many pixels wide in the middle of the range of sizes. At half of it most fall between
/// pixels, at double edges blur.
const PIXELS_PER_TEXEL: f32 = 1.0;
/// Steps of the reconstruction. At half of them edges are a texel softer, at double noise grows.
const STEPS: usize = 6;

/// The texture of group `group` under the light of the current `appearance`; none if the group has
/// no texture coordinates. `specular` holds the specular part of the reflectance. With the finer photograph as
/// `detail`, the texels are made of its pixels.
pub fn extract(
    (stage, detail): (&Stage<'_>, Option<&dyn Detail>),
    appearance: Appearance<'_>,
    group: usize,
    specular: &Material,
    budget: &SampleBudget,
) -> Option<Extracted> {
    let geometry = stage.renderer.geometry();
    let valid = &stage.observation.pixels_of_group[group];
    let side = detail.map_or(1, Detail::side);
    let [width, height] = texels(resolution(geometry, valid)?.map(|along| along * side as f32));
    let (evidence, diffuse) = lit(stage, appearance, group, budget);
    let shine = evidence.specular(specular);
    let light = |i: usize| {
        let [a, b] = [diffuse[0][i], diffuse[1][i]];
        Lit { sets: [a, b], shine: specular.rho_s * 0.5 * (shine[0][i] + shine[1][i]) }
    };
    let light: Vec<Lit> = (0..evidence.sample.pixels.len()).map(light).collect();
    let samples = match detail {
        Some(detail) => detailed::samples((stage, detail), group, &evidence, &light),
        None => {
            let pixels = evidence.sample.pixels.iter().zip(&light);
            let one = |(pixel, light): (&Observed, &Lit)| {
                TexelSample::new(geometry.pixels()[pixel.pixel as usize].uv, pixel.radiance, light)
            };
            pixels.map(one).collect()
        }
    };
    let mut extracted: Option<Extracted> = None;
    for _ in 0..STEPS {
        let mut splat = Splat::new(width, height);
        for TexelSample { uv, shown, light } in &samples {
            let so_far = extracted.as_ref().map_or(Rgb::ZERO, |e| e.texture.sample(*uv));
            splat.add(*uv, *shown - *light * so_far, *light);
        }
        extracted = Some(splat.finish(extracted.as_ref().map(|e| &e.texture.image)));
    }
    let deviation = deviation(&evidence, &diffuse, side);
    extracted.map(|extracted| Extracted { deviation, ..extracted })
}

/// The light at a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Lit {
    /// The radiance of a white diffuse surface there, twice.
    sets: [Rgb; 2],
    /// The specular radiance.
    shine: Rgb,
}

/// What a pixel says of the texels about `uv`.
#[derive(Clone, Copy, Debug)]
struct TexelSample {
    uv: Vec2,
    /// `D B`.
    shown: Rgb,
    /// `D_A D_B`.
    light: Rgb,
}

impl TexelSample {
    fn new(uv: Vec2, radiance: Rgb, Lit { sets: [a, b], shine }: &Lit) -> Self {
        Self { uv, shown: 0.5 * (*a + *b) * (radiance - *shine), light: *a * *b }
    }
}

/// The relative noise of the light that a texture is divided by. At half of it dim groups cost four times
/// as many paths; at double the noise shows in their textures, and speaks against them.
const NOISE: f32 = 0.03;
/// The light is gathered again with at most so many times the samples.
const MORE_MAX: f32 = 16.0;

/// The evidence on all pixels of a group, and the light there, smoothed: gathered again with more samples
/// where a dim group's is too noisy.
fn lit(
    stage: &Stage<'_>,
    appearance: Appearance<'_>,
    group: usize,
    budget: &SampleBudget,
) -> (Evidence, [Vec<Rgb>; 2]) {
    let geometry = stage.renderer.geometry();
    let valid = &stage.observation.pixels_of_group[group];
    let gather = |budget: &SampleBudget| {
        let evidence = Evidence::gather(stage, appearance, group, valid, budget);
        let diffuse = smoothed(geometry, &evidence, evidence.diffuse());
        (evidence, diffuse)
    };
    let found = gather(budget);
    let more = (noise(&found.1) / NOISE).powi(2).min(MORE_MAX);
    if more <= 1.0 {
        return found;
    }
    let mut again = budget.clone();
    again.probe.cosine = (budget.probe.cosine as f32 * more).ceil() as u32;
    gather(&again)
}

/// The relative noise of the mean of both halves of a light.
fn noise([a, b]: &[Vec<Rgb>; 2]) -> f32 {
    let pairs = || a.iter().zip(b);
    let difference: Rgb = pairs().map(|(a, b)| (*a - *b) * (*a - *b)).sum();
    let sum: Rgb = pairs().map(|(a, b)| (*a + *b) * (*a + *b)).sum();
    (difference / sum.max(Rgb::splat(f32::MIN_POSITIVE))).max_element().sqrt()
}

/// The standard deviation of a texel, root mean square over the pixels: `q = B/D` has the relative
/// variance of `B` (the photograph's noise) and of `D` (ours, from the difference of its two
/// renderings), and a texel takes in [`PIXELS_PER_TEXEL`]^2 pixels. A pixel here is the mean of `side`^2 of those that
/// texels are made of.
fn deviation(evidence: &Evidence, diffuse: &[Vec<Rgb>; 2], side: usize) -> Rgb {
    let of_photograph = (side * side) as f32;
    let mut sum = DVec3::ZERO;
    for (i, pixel) in evidence.sample.pixels.iter().enumerate() {
        let [a, b] = [diffuse[0][i], diffuse[1][i]];
        let d = (0.5 * (a + b)).max(Rgb::splat(f32::MIN_POSITIVE));
        let q = pixel.radiance / d;
        let of_light = 0.25 * (a - b) * (a - b);
        let variance = (of_photograph * pixel.variance + q * q * of_light) / (d * d);
        // A texel in the dark says nothing of the others.
        sum += variance.min(Rgb::ONE).as_dvec3();
    }
    let n = evidence.sample.pixels.len().max(1) as f64 * f64::from(PIXELS_PER_TEXEL.powi(2));
    (sum / n).map(f64::sqrt).as_vec3()
}

/// The paper's own step: the texture times the ratio of what is extracted from the photograph and
/// from the re-rendering `rerendered` (one radiance for each of `pixels`).
pub fn rebalance(
    stage: &Stage<'_>,
    texture: Option<&Texture>,
    pixels: &[u32],
    rerendered: &[Rgb],
) -> Option<Extracted> {
    let geometry = stage.renderer.geometry();
    let [width, height] = texels(resolution(geometry, pixels)?);
    let mut splat = Splat::new(width, height);
    for (&pixel, &radiance) in pixels.iter().zip(rerendered) {
        let uv = geometry.pixels()[pixel as usize].uv;
        let photo = stage.exposure * stage.observation.picture.values.pixels()[pixel as usize];
        let before = texture.map_or(Rgb::ONE, |t| t.sample(uv));
        splat.add(uv, before * photo, radiance);
    }
    Some(splat.finish(None))
}

/// The index in `evidence` of every pixel; `u32::MAX` where it has none.
fn places(geometry: &GeometryBuffers, evidence: &Evidence) -> Vec<u32> {
    let mut place = vec![u32::MAX; geometry.pixels().len()];
    for (i, pixel) in evidence.sample.pixels.iter().enumerate() {
        place[pixel.pixel as usize] = i as u32;
    }
    place
}

/// `D` averaged over the neighbours of the sample that show the same object: light changes slowly.
fn smoothed(geometry: &GeometryBuffers, evidence: &Evidence, d: [Vec<Rgb>; 2]) -> [Vec<Rgb>; 2] {
    let place = places(geometry, evidence);
    d.map(|d| {
        let mean = |pixel: u32| {
            let centre = geometry.pixels()[pixel as usize].object;
            let near = geometry.neighbourhood(pixel as usize);
            let same = near.filter(|&n| geometry.pixels()[n].object == centre);
            let (sum, count) = same
                .filter_map(|n| d.get(place[n] as usize))
                .fold((Rgb::ZERO, 0.0), |(sum, count), v| (sum + *v, count + 1.0));
            sum / f32::max(count, 1.0)
        };
        evidence.sample.pixels.iter().map(|p| mean(p.pixel)).collect()
    })
}

/// Texels per unit of u and v: about one a pixel. None without texture coordinates.
fn resolution(geometry: &GeometryBuffers, pixels: &[u32]) -> Option<[f32; 2]> {
    let width = geometry.width();
    let mut steps_u = Vec::new();
    let mut steps_v = Vec::new();
    for &pixel in pixels {
        let index = pixel as usize;
        let here = geometry.pixels()[index];
        let beside = [index + 1, index + width].map(|n| geometry.pixels().get(n));
        if let [Some(right), Some(below)] = beside
            && right.object == here.object
            && below.object == here.object
        {
            let (dx, dy) = (right.uv - here.uv, below.uv - here.uv);
            steps_u.push(dx.x.hypot(dy.x));
            steps_v.push(dx.y.hypot(dy.y));
        }
    }
    let side = |steps: &mut Vec<f32>| {
        let middle = steps.len() / 2;
        let step = *steps.get_mut(..)?.select_nth_unstable_by(middle, f32::total_cmp).1;
        (step > 0.0).then(|| 1.0 / (PIXELS_PER_TEXEL * step))
    };
    if steps_u.is_empty() {
        return None;
    }
    Some([side(&mut steps_u)?, side(&mut steps_v)?])
}

/// The texels along each side, not too few and not too many.
fn texels(along: [f32; 2]) -> [usize; 2] {
    along.map(|texels| texels.clamp(2.0, SIDE_MAX).round() as usize)
}

/// Sums of numerators and denominators over texels.
struct Splat {
    numerator: RgbImage,
    denominator: RgbImage,
    weight: Image<f32>,
}

/// Texels with less than this share of a pixel count as not seen.
const WEIGHT_MIN: f32 = 0.05;

impl Splat {
    fn new(width: usize, height: usize) -> Self {
        let zero = RgbImage::from_fn(width, height, |_, _| Rgb::ZERO);
        let weight = Image::from_fn(width, height, |_, _| 0.0);
        Self { numerator: zero.clone(), denominator: zero, weight }
    }

    /// Shares a pixel out over the four texels about `uv`.
    fn add(&mut self, uv: Vec2, numerator: Rgb, denominator: Rgb) {
        let (width, height) = (self.weight.width(), self.weight.height());
        let at = uv * Vec2::new(width as f32, height as f32) - 0.5;
        let (low, share) = (at.floor(), at - at.floor());
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let x = if dx == 1 { share.x } else { 1.0 - share.x };
            let y = if dy == 1 { share.y } else { 1.0 - share.y };
            let column = Wrap::Repeat.apply(low.x as i64 + dx, width);
            let row = Wrap::Repeat.apply(low.y as i64 + dy, height);
            let index = row * width + column;
            self.numerator.pixels_mut()[index] += x * y * numerator;
            self.denominator.pixels_mut()[index] += x * y * denominator;
            self.weight.pixels_mut()[index] += x * y;
        }
    }

    /// The texture `before`, if there is one, plus the quotients.
    fn finish(self, before: Option<&RgbImage>) -> Extracted {
        let seen = self.weight.map(|w| *w > WEIGHT_MIN);
        let quotient = |i: usize| {
            let (n, d) = (self.numerator.pixels()[i], self.denominator.pixels()[i]);
            let q = n / d.max(Rgb::splat(1e-20));
            let before = before.map_or(Rgb::ZERO, |image| image.pixels()[i]);
            (before + Rgb::select(d.cmpgt(Rgb::ZERO), q, Rgb::ZERO)).clamp(Rgb::ZERO, Rgb::ONE)
        };
        let (width, height) = (seen.width(), seen.height());
        let image = RgbImage::new(width, height, (0..width * height).map(quotient).collect());
        let image = fill(&image, &seen);
        let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
        Extracted { texture: Arc::new(texture), seen, deviation: Rgb::ZERO }
    }
}

/// The image with its unseen texels filled: from the next coarser level of a pyramid in which each
/// texel is the mean of the seen ones below it.
fn fill(image: &RgbImage, seen: &Image<bool>) -> RgbImage {
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
    let coarse = fill(&coarse, &coarse_seen);
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

/// The share of the texels that are neither seen nor near a seen one.
pub(crate) fn unseen_share(seen: &Image<bool>) -> f32 {
    share(&unseen(seen))
}

fn share(flags: &[bool]) -> f32 {
    flags.iter().filter(|flag| **flag).count() as f32 / flags.len().max(1) as f32
}

/// A texel with a seen one within this distance, texels, is known from it.
const BESIDE: usize = 2;

/// Whether each texel is neither seen nor near a seen one.
fn unseen(seen: &Image<bool>) -> Vec<bool> {
    let (width, height) = (seen.width(), seen.height());
    let near = |at: usize, end: usize| at.saturating_sub(BESIDE)..(at + BESIDE + 1).min(end);
    let is_unseen = |i: usize| {
        let (x, y) = (i % width, i / width);
        near(y, height).all(|y| near(x, width).all(|x| !*seen.at(x, y)))
    };
    (0..width * height).map(is_unseen).collect()
}

/// Fewer unseen texels than this share are not adjusted to the light that the group sends: at half of it a percent of
/// that light doubles or blackens them, at double nothing changes.
const ANSWERING: f32 = 0.05;
/// The mean of a texture counts as at least this: a factor on what is black changes nothing.
pub(crate) const MEAN_MIN: f32 = 1e-4;

/// Whether enough texels are unseen to be adjusted to the light that they send to other groups.
pub(crate) fn is_partly_unseen(seen: &Image<bool>) -> bool {
    unseen_share(seen) >= ANSWERING
}

/// Gives one channel of a texture the mean `rho_d`, found from the light that it sends to other groups: only its unseen
/// texels change, since the photograph shows the others.
pub(crate) fn set_mean(material: &mut Material, seen: &Image<bool>, channel: usize, rho_d: f32) {
    let sent = rho_d / material.rho_d[channel].max(MEAN_MIN);
    material.rho_d[channel] = rho_d;
    let Some(texture) = &mut material.texture else { return };
    let unseen = unseen(seen);
    let factor = 1.0 + (sent - 1.0) / share(&unseen).max(ANSWERING);
    let texels = Arc::make_mut(texture).image.pixels_mut().iter_mut().zip(unseen);
    for (texel, _) in texels.filter(|(_, unseen)| *unseen) {
        texel[channel] = (factor * texel[channel]).clamp(0.0, 1.0);
    }
}
