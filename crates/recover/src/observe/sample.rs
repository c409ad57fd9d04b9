//! Some pixels of one group in blocks: what the photograph shows there, how much of it is noise, and how the light may be
//! wrong. All fits and comparisons look at samples.
//!
//! A residual is weighted by the inverse of its variance under the observation model ([`crate::observe::model_error`]): the
//! photograph's noise at the *model's* brightness, and the model error. The photograph's own value never enters its
//! weight, since dark pixels would then dominate ([`Sample::reweigh`]).

use crate::observe::blocks::{Blocks, Grid};
use crate::observe::model_error::{LightError, LightField, ModelError, followed, level2};
use crate::observe::observation::{Noise, Observation, Reading};
use crate::observe::photometric::PhotometricParameter;
use crate::observe::same_place;
use unrender_render::{RadianceCache, Renderer};
use unrender_scene::Rgb;

/// Some pixels of one group.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The pixels.
    pub pixels: Vec<Observed>,
    /// The block of every pixel.
    pub blocks: Blocks,
    /// How the light that arrives there may be wrong.
    pub field: LightField,
}

/// One pixel of the photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// The pixel's index.
    pub pixel: u32,
    /// Its radiance.
    pub radiance: Rgb,
    /// Whether the radiance is a measurement or a lower bound of one.
    pub reading: Reading,
    /// The photograph's noise there.
    pub noise: Noise,
    /// The variance of its noise, at the model's brightness.
    pub variance: Rgb,
    /// The radiance that relative errors are relative to: the root mean square of the group's mean
    /// and of the model's light here.
    pub level: Rgb,
    /// The weight of its residual in fits: the inverse of its variance.
    pub weight: Rgb,
}

/// Where evidence comes from: the photograph, the scale of its values, and the renderer.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The photograph, sorted by groups, as it was developed.
    pub observation: &'a Observation,
    /// Numbers of the camera that are estimated, and how far each is from where the photograph was developed.
    pub camera: (&'a [PhotometricParameter], &'a [f64]),
    /// Scene radiance per unit of the photograph's values.
    pub exposure: Rgb,
    /// The renderer, behind the photograph's camera.
    pub renderer: &'a dyn Renderer,
    /// Where the photograph itself says what radiance the surfaces send.
    pub seen: Option<&'a RadianceCache>,
}

impl Stage<'_> {
    /// The photograph's value at a pixel with the camera's numbers as they stand, before exposure.
    pub fn value(&self, pixel: u32) -> Rgb {
        let changes = self.camera.0.iter().zip(self.camera.1);
        let change: Rgb =
            changes.map(|(by, step)| by.change(self.observation, pixel) * *step as f32).sum();
        self.observation.picture.values.pixels()[pixel as usize] + change
    }

    /// What the photograph shows of `group` in `pixels`, weighted as if they were all as bright as their mean.
    pub fn observe(&self, group: usize, pixels: &[u32]) -> Vec<Observed> {
        let value = |p: u32| self.exposure * self.value(p);
        let mean = pixels.iter().map(|&p| value(p)).sum::<Rgb>() / pixels.len().max(1) as f32;
        let level2 = level2(mean, mean);
        let one = |&pixel: &u32| {
            let noise = self.observation.noise(group, pixel, self.exposure);
            let variance = noise.variance(mean);
            Observed {
                pixel,
                radiance: value(pixel),
                reading: self.observation.reading(pixel),
                noise,
                variance,
                level: level2.map(f32::sqrt),
                weight: ModelError::START.weight(variance, level2, 1.0),
            }
        };
        pixels.iter().map(one).collect()
    }
}

impl Sample {
    /// At most `count` of the `valid` pixels of `group` in each photograph, as the `seed` has it, and the grid of their
    /// blocks.
    pub fn choose(
        observation: &Observation,
        group: usize,
        valid: &[u32],
        count: usize,
        seed: u64,
    ) -> (Vec<u32>, Grid) {
        let count = observation.sheet.of_all(count);
        let grid = Grid::of(observation, group, valid, count);
        (grid.sample(valid, count, seed ^ group as u64), grid)
    }

    /// What the photograph of `stage` shows of `group` in `pixels`, in blocks of `grid`, where the light may be wrong by
    /// `light` at least.
    pub fn of(
        stage: &Stage<'_>,
        group: usize,
        (pixels, grid): (&[u32], &Grid),
        light: LightError,
    ) -> Self {
        let Stage { observation, renderer, .. } = *stage;
        let blocks = same_place::paired(Blocks::of(pixels, grid), renderer, pixels);
        let geometry = (&observation.sheet, renderer.geometry());
        let field = LightField::of(&blocks, pixels, geometry, light);
        Self { pixels: stage.observe(group, pixels), blocks, field }
    }

    /// The numbers of its pixels.
    pub fn numbers(&self) -> Vec<u32> {
        self.pixels.iter().map(|seen| seen.pixel).collect()
    }

    /// Weights the residual of each pixel by the inverse of its variance, under a model with this `error` and `light`. The
    /// light is averaged over blocks, so that its noise does not enter the weights.
    pub fn reweigh(&mut self, light: &[Rgb], error: ModelError) {
        let smooth = self.blocks.smooth(light);
        let count = light.len().max(1) as f32;
        let photograph: Vec<Rgb> = self.pixels.iter().map(|p| p.radiance).collect();
        let shown = self.blocks.smooth(&photograph);
        let shown_mean = photograph.iter().sum::<Rgb>() / count;
        let mean = light.iter().sum::<Rgb>() / count;
        for (pixel, &block) in self.pixels.iter_mut().zip(&self.blocks.of_pixel) {
            let block = block as usize;
            let (mean, local) = followed((mean, smooth[block]), (shown_mean, shown[block]));
            let level2 = level2(mean, local);
            pixel.level = level2.map(f32::sqrt);
            pixel.variance = pixel.noise.variance(local);
            let pixels = self.blocks.sizes[block] as f32 * self.blocks.places[block].fine_blocks();
            pixel.weight = error.weight(pixel.variance, level2, pixels);
        }
    }

    /// The same without the pixels that are flagged.
    #[must_use]
    pub fn without(self, flags: &[bool]) -> Self {
        let field = self.field.without(&self.blocks, flags);
        let kept = self.pixels.into_iter().zip(flags).filter(|(_, flag)| !**flag);
        let pixels = kept.map(|(seen, _)| seen).collect();
        Self { pixels, blocks: self.blocks.without(flags), field }
    }
}

#[cfg(test)]
impl Sample {
    /// A square of pixels without noise, each of the weight one and of the `radiance` of its number, in blocks of so many
    /// pixels along each side; the light may be wrong by a percent.
    pub(crate) fn square(side: usize, block: usize, radiance: impl Fn(usize) -> Rgb) -> Self {
        let numbers: Vec<u32> = (0..(side * side) as u32).collect();
        let sheet = unrender_scene::Sheet::of(&[(side, side)]);
        let blocks = Blocks::of(&numbers, &Grid::even(&sheet, block));
        let observed = |i: usize| Observed {
            pixel: i as u32,
            radiance: radiance(i),
            reading: Reading::Value,
            noise: Noise::NONE,
            variance: Rgb::splat(1e-4),
            level: Rgb::ONE,
            weight: Rgb::ONE,
        };
        let pixels = (0..side * side).map(observed).collect();
        let field = LightField::constant(blocks.len(), LightError { share: 0.01 });
        Self { pixels, blocks, field }
    }
}
