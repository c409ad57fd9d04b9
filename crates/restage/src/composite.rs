//! The change put into the photograph.
//!
//! With `P` the photograph's radiance, `B` and `A` the renderings before and after, `r` the share of
//! the pixel that shows something else than before, `K` the part of `A - B` that comes by paths which
//! see the same surface, and `D` the change that is believed (module [`crate::touched`]: `K`, or its
//! mean over the face), a touched pixel becomes
//!
//! ```text
//! C = (A - K) + (1 - r) (P - B) + g D
//! ```
//!
//! Where the same surface is seen, `r = 0`, `A - K = B`, and `C = P + g D`. With `g = 1` this is differential
//! rendering [Fournier et al. 1993; Debevec 1998]: what the model does not explain, `P - B`, stays as
//! it is. With `g = P/B` and `D = A - B` it is the
//! ratio, `C = P A/B`: what the model does not explain is taken for
//! reflectance, and is shaded like it. Where something new is seen, `r = 1` and `C = A`: the
//! photograph knows nothing of it.
//!
//! The gain is `P/B` where that is a matter of reflectance and well known: on surfaces without a
//! shine, where the photograph is not clipped, `P/B` lies within [`GAIN_MAX`] of one and `B` is above
//! [`SIGMAS`] standard deviations of its noise. Else it is one.

use crate::pair::Paired;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::{Image, Material, Rgb, RgbImage};

/// Beyond this, or its inverse, photograph and model differ by more than a reflectance.
pub const GAIN_MAX: f32 = 2.0;
/// `B` below so many standard deviations gives no gain.
pub const SIGMAS: f32 = 8.0;

/// How what the model does not explain goes through a change of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Gain {
    /// Pixel by pixel, as the head of this module says.
    #[default]
    Auto,
    /// It stays: `g = 1`.
    Difference,
    /// It is shaded: `g = P/B` where `B` is not nothing.
    Ratio,
}

/// The photograph, as far as it is needed here.
#[derive(Clone, Copy, Debug)]
pub struct Photograph<'a> {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: &'a RgbImage,
    /// True in pixels that are cut off at the top: their radiance is at least this.
    pub clipped: &'a Image<bool>,
    /// What the camera saw.
    pub geometry: &'a GeometryBuffers,
    /// The materials of the groups before the edits.
    pub materials: &'a [Material],
}

/// The photograph with the change in it; pixels without a change in `touched` keep their radiance
/// to the bit.
pub fn composite(
    photograph: &Photograph<'_>,
    paired: &Image<Paired>,
    touched: &Image<Option<Rgb>>,
    gain: Gain,
) -> RgbImage {
    let pixel = |index: usize| {
        let seen = photograph.radiance.pixels()[index];
        let Some(change) = touched.pixels()[index] else { return seen };
        let pixel = &paired.pixels()[index];
        let clipped = photograph.clipped.pixels()[index];
        // What is cut off was at least as bright as the model says.
        let seen = if clipped { seen.max(pixel.before) } else { seen };
        let group = photograph.geometry.pixels()[index].group;
        let shines =
            group == NOTHING || photograph.materials[group as usize].rho_s.max_element() > 0.0;
        let gain = match gain {
            Gain::Difference => Rgb::ONE,
            Gain::Ratio => ratio(seen, pixel.before, Rgb::ZERO, f32::INFINITY),
            Gain::Auto if shines || clipped => Rgb::ONE,
            Gain::Auto => ratio(seen, pixel.before, pixel.before_variance, GAIN_MAX),
        };
        let unexplained = (1.0 - pixel.replaced) * (seen - pixel.before);
        (pixel.after - pixel.kept_change + unexplained + gain * change).max(Rgb::ZERO)
    };
    let (width, height) = (paired.width(), paired.height());
    Image::from_fn(width, height, |x, y| pixel(y * width + x))
}

/// `seen / before` by channel, or one where it is not well known.
fn ratio(seen: Rgb, before: Rgb, variance: Rgb, most: f32) -> Rgb {
    let channel = |i: usize| {
        let gain = seen[i] / before[i];
        let known = before[i] > SIGMAS * variance[i].sqrt() && before[i] > 0.0;
        if known && gain <= most && gain >= 1.0 / most { gain } else { 1.0 }
    };
    Rgb::new(channel(0), channel(1), channel(2))
}
