//! Photographs by other renderers: each is two independent halves of one rendering, so that its noise
//! is known.

mod cycles;
mod mitsuba;
mod radiance;

use super::family::Renderer;
use super::generate::Plan;
use crate::Failure;
use std::path::Path;
use unrender::scene::{Camera, Rgb, RgbImage, Scene};

/// A rendering in two independent halves.
#[derive(Clone, Debug)]
pub(crate) struct Photograph {
    pub(crate) halves: [RgbImage; 2],
    /// Samples of a pixel, both halves together.
    pub(crate) spp: u32,
}

/// The noise and the most samples of a rendering.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleBudget {
    /// The relative noise of a pixel at which rendering ends; the root of the mean over the pixels.
    pub(crate) noise: f64,
    /// The most samples of a pixel.
    pub(crate) spp_max: u32,
}

impl Photograph {
    /// The mean of both halves.
    pub(crate) fn mean(&self) -> RgbImage {
        let [a, b] = &self.halves;
        RgbImage::from_fn(a.width(), a.height(), |x, y| 0.5 * (*a.at(x, y) + *b.at(x, y)))
    }

    /// The standard deviation of a pixel's luminance over its mean: the median over pixels, on which a
    /// few very bright pixels have no influence.
    pub(crate) fn noise(&self) -> f64 {
        let [a, b] = &self.halves;
        let level = |rgb: &Rgb| f64::from(rgb.element_sum());
        let mut ratios: Vec<f64> = a
            .pixels()
            .iter()
            .zip(b.pixels())
            .filter(|(a, b)| level(a) + level(b) > 0.0)
            .map(|(a, b)| (level(a) - level(b)).abs() / (level(a) + level(b)))
            .collect();
        if ratios.is_empty() {
            return 0.0;
        }
        ratios.sort_by(f64::total_cmp);
        // The median of the absolute value of a normal variable is 0.6745 of its standard
        // deviation.
        ratios[ratios.len() / 2] / 0.6745
    }
}

/// The photograph of `scene` by `renderer` from `camera`; `work` is a folder for its files.
///
/// # Errors
/// If the renderer is not available or fails.
pub(crate) fn take(
    plan: &Plan,
    scene: &Scene,
    camera: &Camera,
    renderer: Renderer,
    budget: SampleBudget,
    work: &Path,
) -> Result<Photograph, Failure> {
    match renderer {
        Renderer::Mitsuba => mitsuba::take(plan, scene, camera, budget, work),
        Renderer::Cycles => cycles::take(plan, scene, camera, budget, work),
        Renderer::Radiance => radiance::take(plan, scene, camera, budget, work),
    }
}

/// Sums of pictures in two halves.
pub(crate) struct Halves {
    sums: [Vec<glam::DVec3>; 2],
    counts: [u32; 2],
    size: (usize, usize),
}

impl Halves {
    /// Without any picture.
    pub(crate) fn new(size: (usize, usize)) -> Self {
        let none = vec![glam::DVec3::ZERO; size.0 * size.1];
        Self { sums: [none.clone(), none], counts: [0; 2], size }
    }

    /// Adds a picture to the half that has fewer pictures.
    pub(crate) fn add(&mut self, picture: &RgbImage) {
        let half = usize::from(self.counts[1] < self.counts[0]);
        self.counts[half] += 1;
        for (sum, value) in self.sums[half].iter_mut().zip(picture.pixels()) {
            *sum += value.as_dvec3();
        }
    }

    /// Both halves' means; `spp` is that of one picture.
    pub(crate) fn photograph(&self, spp: u32) -> Photograph {
        let mean = |half: usize| {
            let scale = 1.0 / f64::from(self.counts[half].max(1));
            let pixels = self.sums[half].iter().map(|sum| (*sum * scale).as_vec3()).collect();
            RgbImage::new(self.size.0, self.size.1, pixels)
        };
        Photograph { halves: [mean(0), mean(1)], spp: spp * (self.counts[0] + self.counts[1]) }
    }
}
