//! Random colours of surfaces.

use super::super::dice::Dice;
use unrender::scene::Rgb;

/// A muted or strong colour whose brightest channel lies between `low` and `high`.
pub(crate) fn color(dice: &mut Dice, low: f32, high: f32) -> Rgb {
    let value = dice.range(low.sqrt(), high.sqrt()).powi(2);
    let saturation = dice.unit().powi(2) * 0.9;
    let mut channels = [1.0, 1.0 - saturation * dice.unit(), 1.0 - saturation];
    dice.shuffle(&mut channels);
    round(value * Rgb::from_array(channels))
}

/// Rounded to four digits, so that files contain exactly the rendered colour.
pub(crate) fn round(color: Rgb) -> Rgb {
    (color * 1e4).round() / 1e4
}
