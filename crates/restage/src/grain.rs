//! The photograph's noise for what was not photographed.
//!
//! A sensor's noise has a variance of `shot` times the light. Where the share `r` of a pixel is
//! synthetic, the photograph's noise is there with the weight `1 - r`; what lacks is added, less what
//! the rendering itself has.

use crate::pair::Paired;
use std::f32::consts::TAU;
use unrender_render::sampler::mix;
use unrender_scene::{Image, Rgb, RgbImage};

/// Adds noise to the synthetic parts of `picture`, of a variance of `shot` times its radiance.
pub fn add(picture: &mut RgbImage, paired: &Image<Paired>, shot: Rgb, seed: u64) {
    let pixels = picture.pixels_mut().iter_mut().zip(paired.pixels()).enumerate();
    for (index, (radiance, pixel)) in pixels.filter(|(_, (_, pixel))| pixel.replaced > 0.0) {
        let kept = 1.0 - pixel.replaced;
        let lacking = shot * *radiance * (1.0 - kept * kept) - pixel.after_variance;
        let noise = |channel: usize| {
            let key = mix(seed ^ GRAIN) ^ (3 * index + channel) as u64;
            lacking[channel].max(0.0).sqrt() * normal(key)
        };
        *radiance = (*radiance + Rgb::new(noise(0), noise(1), noise(2))).max(Rgb::ZERO);
    }
}

/// Keeps these numbers apart from those of paths.
const GRAIN: u64 = 0x6A21_0000_0000_0000;

/// A number of the standard normal distribution for each key [Box & Muller 1958].
fn normal(key: u64) -> f32 {
    let uniform = |bits: u64| ((bits >> 40) as f32 + 0.5) / (1u64 << 24) as f32;
    let (first, second) = (mix(key), mix(mix(key)));
    (-2.0 * uniform(first).ln()).sqrt() * (TAU * uniform(second)).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn synthetic_parts_get_the_variance_that_lacks_and_others_nothing() {
        let (shot, level) = (1e-3, 0.5);
        let of = |replaced| Paired {
            replaced,
            after_variance: Rgb::splat(0.2 * shot * level),
            ..Paired::default()
        };
        let paired = Image::from_fn(200, 200, |_, y| of(if y < 100 { 1.0 } else { 0.0 }));
        let mut picture = paired.map(|_| Rgb::splat(level));
        add(&mut picture, &paired, Rgb::splat(shot), 1);
        let squares = |pixels: &[Rgb]| {
            pixels.iter().map(|p| (p.y - level).powi(2)).sum::<f32>() / pixels.len() as f32
        };
        let (synthetic, photographed) = picture.pixels().split_at(100 * 200);
        let share = squares(synthetic) / (0.8 * shot * level);
        assert!((share - 1.0).abs() < 0.03, "{share}");
        assert_eq!(squares(photographed), 0.0);
    }
}
