//! Compositing: the rendered change added to the photograph.
//!
//! With `P` the radiance of the photograph, `B` and `A` the renderings before and after the edits,
//! `r` the fraction of the pixel that shows another surface than before, `K` the part of `A - B` of paths
//! that show the same surface, and `D` the significant change (module [`crate::touched`]: `K`, or
//! its local mean), a touched pixel becomes
//!
//! ```text
//! C = (A - K) + (1 - r) (P - B) + g D
//! ```
//!
//! Where the same surface is visible, `r = 0`, `A - K = B`, and `C = P + g D`. With the gain `g =
//! 1` this is differential rendering [Fournier et al. 1993; Debevec 1998]: the residual `P - B` is
//! kept. With `g = P/B` it is the ratio image [Liu et al. 2001], `C = P R` with `R` the ratio `A/B`
//! without most of its noise ([`crate::pair::smoothed`]): the residual is attributed to reflectance
//! and shaded like it. Where another surface is visible, `r = 1` and `C = A`.
//!
//! Where the light becomes less, `R < 1`, it is the ratio: the residual cannot keep light that is
//! gone. Where it becomes more, it is the ratio where the residual is plausibly reflectance: on
//! surfaces without specular term, where the photograph is not clipped, `P/B` lies within [`GAIN_MAX`] of one and `B`
//! exceeds [`SIGMAS`] standard deviations of its noise. Elsewhere the gain is one.

use crate::pair::Paired;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::{Image, Material, Rgb, RgbImage};

/// Gains beyond this or its inverse are not plausible as errors of a reflectance. With half of it
/// (no gain at all) textures that the model lacks are not shaded; with double of it shadows that
/// the model lacks are taken for reflectance.
pub const GAIN_MAX: f32 = 2.0;
/// `B` below this many standard deviations gives no gain: the relative error of `P/B` is then above
/// 1/8. With half of it noise shows in dark parts, with double of it dark parts have no gain.
pub const SIGMAS: f32 = 8.0;

/// How the residual of the model responds to a change of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Gain {
    /// Per pixel, as described in the module head.
    #[default]
    Auto,
    /// The residual is kept: `g = 1`.
    Difference,
    /// The residual is shaded: `g = P/B` where `B` is not zero.
    Ratio,
}

/// How a pixel of a composite was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// The photograph's.
    Untouched,
    /// The photograph's times the ratio of the light.
    Ratio,
    /// The photograph's plus the difference of the light.
    Difference,
    /// It shows another surface, at least in part.
    Replaced,
    /// As by [`How::Ratio`] or [`How::Difference`], but neither holds: the photograph is clipped or black there, and its light
    /// changes by more than [`GAIN_MAX`] or its inverse.
    Neither,
}

/// A composite.
#[derive(Clone, Debug)]
pub struct Composite {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
    /// How each pixel was made.
    pub how: Image<How>,
}

/// The photograph and the scene that it shows.
#[derive(Clone, Copy, Debug)]
pub struct Photograph<'a> {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: &'a RgbImage,
    /// True in clipped pixels, whose radiance is a lower bound.
    pub clipped: &'a Image<bool>,
    /// The geometry that it shows.
    pub geometry: &'a GeometryBuffers,
    /// The materials of the groups before the edits.
    pub materials: &'a [Material],
}

/// The composite of the two renderings `paired` and of the picture `after` the edits, which may be denoised; pixels without
/// a change in `touched` keep the radiance of the photograph to the bit.
pub fn composite(
    photograph: &Photograph<'_>,
    (paired, after): (&Image<Paired>, &RgbImage),
    touched: &Image<Option<Rgb>>,
    gain: Gain,
) -> Composite {
    let pixel = |index: usize| {
        let photographed = photograph.radiance.pixels()[index];
        let Some(change) = touched.pixels()[index] else { return (photographed, How::Untouched) };
        let (pixel, after) = (&paired.pixels()[index], after.pixels()[index]);
        if pixel.replaced == 1.0 {
            return (after.max(Rgb::ZERO), How::Replaced);
        }
        let clipped = photograph.clipped.pixels()[index];
        // The model may show that a clipped pixel was brighter.
        let photographed = if clipped { photographed.max(pixel.before) } else { photographed };
        let group = photograph.geometry.pixels()[index].group;
        let specular =
            group == NOTHING || photograph.materials[group as usize].rho_s.max_element() > 0.0;
        let own = |gain: Gain| match gain {
            Gain::Difference => Rgb::ONE,
            Gain::Ratio => ratio(photographed, pixel.before, Rgb::ZERO, f32::INFINITY),
            Gain::Auto if specular || clipped => Rgb::ONE,
            Gain::Auto => ratio(photographed, pixel.before, pixel.before_variance, GAIN_MAX),
        };
        if pixel.replaced == 0.0 && pixel.before.min_element() > 0.0 && gain != Gain::Difference {
            let by_ratio = photographed * pixel.ratio;
            let rises = pixel.ratio.cmpgt(Rgb::ONE);
            // The change without the noise of the pair, by the brighter picture, whose noise is less.
            let change = after * (Rgb::ONE - Rgb::ONE / pixel.ratio.max(Rgb::ONE));
            let by_gain = photographed + own(gain) * change;
            let made = Rgb::select(rises, by_gain, by_ratio).max(Rgb::ZERO);
            let is_by_ratio = !rises.any() || own(gain) != Rgb::ONE;
            let is_lost = clipped || photographed.max_element() <= 0.0;
            let (least, most) = (pixel.ratio.min_element(), pixel.ratio.max_element());
            let how = match is_by_ratio {
                _ if is_lost && least.min(1.0 / most) < 1.0 / GAIN_MAX => How::Neither,
                true => How::Ratio,
                false => How::Difference,
            };
            return (made, how);
        }
        let gain = own(gain);
        let residual = (1.0 - pixel.replaced) * (photographed - pixel.before);
        let made = pixel.after - pixel.kept_change + residual + gain * change;
        let how = if pixel.replaced > 0.0 { How::Replaced } else { How::Difference };
        (made.max(Rgb::ZERO), how)
    };
    let (width, height) = (paired.width(), paired.height());
    let both = Image::from_fn(width, height, |x, y| pixel(y * width + x));
    Composite { radiance: both.map(|both| both.0), how: both.map(|both| both.1) }
}

/// `photographed / before` by channel, or one where it is not significant.
fn ratio(photographed: Rgb, before: Rgb, variance: Rgb, most: f32) -> Rgb {
    let channel = |i: usize| {
        let gain = photographed[i] / before[i];
        let significant = before[i] > SIGMAS * variance[i].sqrt() && before[i] > 0.0;
        if significant && gain <= most && gain >= 1.0 / most { gain } else { 1.0 }
    };
    Rgb::new(channel(0), channel(1), channel(2))
}
