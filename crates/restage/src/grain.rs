//! Sensor noise for the synthetic parts of a composite.
//!
//! The variance is that of read noise plus `shot` times the radiance. Where the fraction `r` of a pixel is
//! synthetic, the composite has the noise of the photograph with the weight `1 - r`. The missing
//! variance, `(read + shot radiance) (1 - (1 - r)^2)` less the variance of the rendering, is added.

use crate::pair::Paired;
use std::f32::consts::TAU;
use unrender_render::sampler::mix;
use unrender_scene::{Image, Rgb, RgbImage};

/// Adds noise to the synthetic parts of `picture`, of a variance of `read` plus `shot` times its radiance.
pub fn add(picture: &mut RgbImage, paired: &Image<Paired>, [read, shot]: [Rgb; 2], seed: u64) {
    let pixels = picture.pixels_mut().iter_mut().zip(paired.pixels()).enumerate();
    for (index, (radiance, pixel)) in pixels.filter(|(_, (_, pixel))| pixel.replaced > 0.0) {
        let photographed = 1.0 - pixel.replaced;
        let variance = read + shot * *radiance;
        let missing = variance * (1.0 - photographed * photographed) - pixel.after_variance;
        let noise = |channel: usize| {
            let key = mix(seed ^ GRAIN) ^ (3 * index + channel) as u64;
            missing[channel].max(0.0).sqrt() * normal(key)
        };
        *radiance = (*radiance + Rgb::new(noise(0), noise(1), noise(2))).max(Rgb::ZERO);
    }
}

/// Separates these random numbers from those of paths.
const GRAIN: u64 = 0x6A21_0000_0000_0000;

/// A standard normal number for each key [Box and Muller 1958].
fn normal(key: u64) -> f32 {
    let uniform = |bits: u64| ((bits >> 40) as f32 + 0.5) / (1u64 << 24) as f32;
    let (first, second) = (mix(key), mix(mix(key)));
    (-2.0 * uniform(first).ln()).sqrt() * (TAU * uniform(second)).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn synthetic_parts_get_the_missing_variance_and_others_nothing() {
        let (read, shot, level) = (2e-4, 1e-3, 0.5);
        let variance = read + shot * level;
        let of = |replaced| Paired {
            replaced,
            after_variance: Rgb::splat(0.2 * variance),
            ..Paired::default()
        };
        let paired = Image::from_fn(200, 200, |_, y| of(if y < 100 { 1.0 } else { 0.0 }));
        let mut picture = paired.map(|_| Rgb::splat(level));
        add(&mut picture, &paired, [read, shot].map(Rgb::splat), 1);
        let squares = |pixels: &[Rgb]| {
            pixels.iter().map(|p| (p.y - level).powi(2)).sum::<f32>() / pixels.len() as f32
        };
        let (synthetic, photographed) = picture.pixels().split_at(100 * 200);
        let share = squares(synthetic) / (0.8 * variance);
        assert!((share - 1.0).abs() < 0.03, "{share}");
        assert_eq!(squares(photographed), 0.0);
    }
}
