//! The paper's textures: the texture so far times the ratio of what is extracted from the photograph and from the
//! re-rendering (section 4.2.6).

use glam::Vec2;
use std::sync::Arc;
use unrender_recover::observe::sample::Stage;
use unrender_recover::texture::{self, Extracted};
use unrender_render::GeometryBuffers;
use unrender_scene::{Image, Rgb, RgbImage, Texture, Wrap};

/// A side of a texture has this many texels at most.
const SIDE_MAX: f32 = 2048.0;
/// Texels are this many pixels wide in the middle of the range of sizes. At half of it most fall between
/// pixels, at double edges blur.
const PIXELS_PER_TEXEL: f32 = 1.0;

/// The paper's own step: the texture times the ratio of what is extracted from the photograph and
/// from the re-rendering `rerendered` (one radiance for each of `pixels`).
pub(crate) fn rebalance(
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
    Some(splat.finish())
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

    /// The texture of the quotients.
    fn finish(self) -> Extracted {
        let seen = self.weight.map(|w| *w > WEIGHT_MIN);
        let quotient = |i: usize| {
            let (n, d) = (self.numerator.pixels()[i], self.denominator.pixels()[i]);
            let q = n / d.max(Rgb::splat(1e-20));
            Rgb::select(d.cmpgt(Rgb::ZERO), q, Rgb::ZERO).clamp(Rgb::ZERO, Rgb::ONE)
        };
        let (width, height) = (seen.width(), seen.height());
        let image = RgbImage::new(width, height, (0..width * height).map(quotient).collect());
        let image = texture::filled(&image, &seen);
        let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
        Extracted { texture: Arc::new(texture), seen, deviation: Rgb::ZERO }
    }
}
