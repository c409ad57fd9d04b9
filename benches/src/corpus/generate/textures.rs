//! Textures: checks, stripes, blots, and smooth clouds of two or three colours.

use super::super::dice::Dice;
use super::colors::color;
use glam::Vec2;
use std::sync::Arc;
use unrender::scene::{Image, Rgb, Texture, Wrap};

/// Texels per side. At the corpus' picture sizes a texel is about a pixel.
const SIDE: usize = 48;

/// A random texture, rounded to 8 bits, so that a file stores it exactly.
pub(crate) fn texture(dice: &mut Dice) -> Arc<Texture> {
    let colors = [(); 3].map(|()| color(dice, 0.05, 0.85));
    let pattern = dice.index(4);
    let count = dice.count(2, 5) as f32;
    let turn = Vec2::from_angle(dice.range(0.0, 3.0));
    let waves: Vec<(Vec2, f32, f32)> = (0..6)
        .map(|_| {
            let wave = Vec2::new(dice.range(-3.0, 3.0).round(), dice.range(-3.0, 3.0).round());
            (wave, dice.range(0.0, 6.3), dice.range(0.4, 1.0))
        })
        .collect();
    let cloud = |at: Vec2| -> f32 {
        let sum: f32 =
            waves.iter().map(|(k, p, a)| a * (std::f32::consts::TAU * k.dot(at) + p).sin()).sum();
        0.5 + 0.25 * sum
    };
    let image = Image::from_fn(SIDE, SIDE, |x, y| {
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / SIDE as f32;
        let cell = (at * count).floor();
        let color = match pattern {
            0 => colors[(cell.x + cell.y) as usize % 2],
            1 => colors[((turn.dot(at) * count * 1.4).floor().rem_euclid(3.0)) as usize],
            2 => colors[usize::from(cloud(at) > 0.5)],
            _ => colors[0].lerp(colors[1], cloud(at).clamp(0.0, 1.0)),
        };
        eight_bits(color)
    });
    Arc::new(Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat })
}

/// The nearest colour that an 8-bit sRGB file can store.
fn eight_bits(color: Rgb) -> Rgb {
    use unrender::scene::color::{linear_from_srgb, srgb_from_linear};
    Rgb::from_array(
        color.to_array().map(|v| linear_from_srgb((255.0 * srgb_from_linear(v)).round() / 255.0)),
    )
}
