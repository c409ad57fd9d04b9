//! The camera that takes the photograph: exposure and shot noise.

use std::f32::consts::TAU;
use unrender::render::sampler::mix;
use unrender::scene::{Rgb, RgbImage};

/// Standard deviation of the noise at middle grey (0.18), relative to it.
const NOISE_AT_GREY: f32 = 0.01;
const GREY: f32 = 0.18;

/// The linear pixel values of the picture that the camera takes of `radiance`: its noise grows with
/// the square root of the light. Values above one are clipped when the file is written.
pub(crate) fn expose(radiance: &RgbImage, exposure: f32, seed: u64) -> RgbImage {
    let shot = NOISE_AT_GREY * NOISE_AT_GREY * GREY;
    let pixel = |index: usize, radiance: Rgb| {
        let noisy = |channel: usize| {
            let value = radiance[channel] / exposure;
            value + (shot * value).sqrt() * normal(mix(seed) ^ (3 * index + channel) as u64)
        };
        Rgb::new(noisy(0), noisy(1), noisy(2))
    };
    let pixels = radiance.pixels().iter().enumerate().map(|(i, &r)| pixel(i, r)).collect();
    RgbImage::new(radiance.width(), radiance.height(), pixels)
}

/// A number of the standard normal distribution for each key [Box and Muller 1958].
fn normal(key: u64) -> f32 {
    let uniform = |bits: u64| ((bits >> 40) as f32 + 0.5) / (1u64 << 24) as f32;
    let (first, second) = (mix(key), mix(mix(key)));
    (-2.0 * uniform(first).ln()).sqrt() * (TAU * uniform(second)).cos()
}
