//! The rug's pattern, painted in code.

use glam::Vec2;
use std::sync::Arc;
use unrender::scene::color::{linear_from_srgb, srgb_from_linear};
use unrender::scene::{Image, Rgb, Texture, Wrap};

const WIDTH: usize = 256;
const HEIGHT: usize = 128;
/// Width over height, on the floor.
const ASPECT: f32 = 2.0;
/// Half the width of the softest edge of the pattern: a weave has no sharp ones.
const SOFT: f32 = 0.03;

const FIELD: Rgb = Rgb::new(0.42, 0.09, 0.07);
const CREAM: Rgb = Rgb::new(0.66, 0.57, 0.42);
const NAVY: Rgb = Rgb::new(0.06, 0.09, 0.20);
const OCHRE: Rgb = Rgb::new(0.58, 0.36, 0.10);

/// The pattern: a border in two bands and a medallion of nested diamonds.
///
/// Its values are those that a PNG of 8 bits can hold, so that the file is the truth.
pub(crate) fn texture() -> Arc<Texture> {
    let image = Image::from_fn(WIDTH, HEIGHT, |x, y| {
        let size = Vec2::new(WIDTH as f32, HEIGHT as f32);
        let uv = (Vec2::new(x as f32, y as f32) + 0.5) / size;
        Rgb::from_array(colour(uv).to_array().map(as_in_a_png))
    });
    let wrap = Wrap::ClampToEdge;
    Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap })
}

fn as_in_a_png(linear: f32) -> f32 {
    linear_from_srgb((255.0 * srgb_from_linear(linear)).round() / 255.0)
}

fn colour(uv: Vec2) -> Rgb {
    let from_edge = (uv.min(1.0 - uv) * Vec2::new(ASPECT, 1.0)).min_element();
    let diamond = (uv - 0.5).abs().element_sum();
    let mut rgb = FIELD;
    for (radius, next) in [(0.40, CREAM), (0.32, NAVY), (0.20, OCHRE)] {
        rgb = rgb.lerp(next, below(diamond, radius));
    }
    for (width, next) in [(0.13, NAVY), (0.045, CREAM)] {
        rgb = rgb.lerp(next, below(from_edge, width));
    }
    rgb
}

/// One where `value` is below `limit`, zero above, with a soft step between.
fn below(value: f32, limit: f32) -> f32 {
    let t = ((limit - value) / (2.0 * SOFT) + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
