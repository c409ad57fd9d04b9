//! Residuals: how far a model is from the photograph, pixel by pixel and block by block, apart from all noise.
//!
//! One rule holds for clipped pixels everywhere: what they show is a lower bound, so that they have a residual only in the
//! channels in which the model is darker, those of a block together. Pixels of something that is not in the model have none.
//!
//! `relative^2 = (sum W r_A r_B - sum W sigma^2) / sum W B^2`: the share of the photograph that
//! neither the model nor the noise explains. The products of residuals under two seeds are free of
//! the rendering noise; the photograph's own is subtracted. `deviation` is the standard deviation of
//! `relative^2`, from the spread of the pixels' contributions.
//!
//! A difference like this may be anything when its own noise is large. It is therefore never shown
//! as less than its standard deviation, and hypotheses are not compared by it, but by their
//! likelihoods ([`crate::compare::likelihood`]).

use crate::evidence::Evidence;
use crate::observe::observation::Reading;
use crate::observe::sample::{Observed, Sample};
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// The unexplained part of a group's photograph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualStats {
    /// Relative square of the error that noise does not explain; may fall below zero by chance.
    pub squared: f64,
    /// Standard deviation of `squared`.
    pub deviation: f64,
    /// Relative square of the error with the photograph's noise left in.
    pub with_noise: f64,
}

impl ResidualStats {
    /// Of pixels with these weighted terms: the product of both residuals, the photograph's noise, and the squared
    /// photograph.
    pub(crate) fn of(terms: &[[f64; 3]]) -> Self {
        let [sum, noise, scale] = [0, 1, 2].map(|k: usize| terms.iter().map(|t| t[k]).sum::<f64>());
        let scale = if scale > 0.0 { scale } else { f64::INFINITY };
        let shares: Vec<f64> = terms.iter().map(|t| t[0] / scale).collect();
        Self {
            squared: (sum - noise) / scale,
            deviation: deviation_of_sum(&shares),
            with_noise: sum / scale,
        }
    }

    /// The relative error that noise does not explain, 0.01 is one percent; where it is not
    /// significant, its standard deviation.
    pub fn relative(&self) -> f64 {
        self.squared.max(self.deviation).max(0.0).sqrt()
    }

    /// The relative difference of photograph and re-rendering, without the rendering noise.
    pub fn total(&self) -> f64 {
        self.with_noise.max(0.0).sqrt()
    }
}

/// The residual statistics of the radiances `model`, rendered twice.
pub fn residual_stats(pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> ResidualStats {
    let of_pixel = |(i, pixel): (usize, &Observed)| {
        let [mut product, mut noise, mut scale] = [0.0; 3];
        for channel in 0..3 {
            let f = |v: Rgb| f64::from(v[channel]);
            let (w, b) = (f(pixel.weight), f(pixel.radiance));
            let light = 0.5 * (f(model[0][i]) + f(model[1][i]));
            // A clipped pixel has no residual where the model is brighter.
            if pixel.reading == Reading::Nothing || pixel.reading == Reading::AtLeast && light >= b
            {
                continue;
            }
            product += w * (b - f(model[0][i])) * (b - f(model[1][i]));
            noise += w * f(pixel.variance);
            scale += w * b * b;
        }
        [product, noise, scale]
    };
    let terms: Vec<[f64; 3]> = pixels.iter().enumerate().map(of_pixel).collect();
    ResidualStats::of(&terms)
}

/// The standard deviation of a sum, from the spread of its terms.
pub fn deviation_of_sum(terms: &[f64]) -> f64 {
    let n = terms.len().max(1) as f64;
    let sum: f64 = terms.iter().sum();
    let squares: f64 = terms.iter().map(|t| t * t).sum();
    (squares - sum * sum / n).max(0.0).sqrt()
}

/// The residuals of a model over the blocks of a group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlockResiduals {
    /// Photograph minus model, the mean over each block.
    pub residual: Vec<Rgb>,
    /// The residual's variance due to the noise of the photograph and the renderings.
    pub noise: Vec<Rgb>,
    /// The part of that due to the renderings' noise alone.
    pub rendering: Vec<Rgb>,
    /// The first of the two renderings less their mean.
    pub half: Vec<Rgb>,
    /// The part of `noise` that was added for a comparison: the residual does not have it.
    pub missing: Vec<Rgb>,
    /// The squared level of each block.
    pub level2: Vec<Rgb>,
    /// The light of the reference model: an error of the incident light is a share of it.
    pub light: Vec<Rgb>,
}

impl BlockResiduals {
    /// The residuals of the radiances `model`, rendered twice, of the pixels of `evidence`. The
    /// levels are those of the last [`Evidence::reweigh`].
    pub fn of(evidence: &Evidence, model: &[Vec<Rgb>; 2]) -> Self {
        let residuals = Self::over(&evidence.sample, model);
        // That a candidate happens to be sampled well is no evidence for it.
        match &evidence.least_noise {
            Some(least) => residuals.with_noise(least),
            None => residuals,
        }
    }

    /// Photograph less each of the two renderings, of every block.
    pub fn halves(&self) -> [Vec<Rgb>; 2] {
        let both = || self.residual.iter().zip(&self.half);
        [both().map(|(r, h)| *r - *h).collect(), both().map(|(r, h)| *r + *h).collect()]
    }

    /// The squared difference of the light from that of `other` relative to the squared light, as a product of
    /// two renderings: free of their noise.
    pub fn change_from(&self, other: &Self) -> f64 {
        let ([a, b], [c, d]) = (self.halves(), other.halves());
        let n = a.len();
        let apart: f64 =
            (0..n).map(|k| f64::from(((a[k] - c[k]) * (b[k] - d[k])).element_sum())).sum();
        let light: f64 = self.light.iter().map(|v| f64::from((*v * *v).element_sum())).sum();
        if light > 0.0 { apart / light } else { 0.0 }
    }

    /// The same residuals with at least the noise `least`, as if they had it.
    #[must_use]
    pub fn with_noise(&self, least: &[Rgb]) -> Self {
        let raised: Vec<Rgb> = self.noise.iter().zip(least).map(|(a, b)| a.max(*b)).collect();
        let more = raised.iter().zip(&self.noise).zip(&self.missing);
        let missing = more.map(|((raised, noise), missing)| *missing + *raised - *noise).collect();
        Self { noise: raised, missing, ..self.clone() }
    }

    /// As [`BlockResiduals::of`] for the pixels of `sample`.
    pub fn over(sample: &Sample, model: &[Vec<Rgb>; 2]) -> Self {
        let Sample { pixels, blocks, .. } = sample;
        let n = pixels.len();
        let light: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] + model[1][i])).collect();
        let residual: Vec<Rgb> = (0..n).map(|i| pixels[i].radiance - light[i]).collect();
        let smooth = blocks.smooth(&light);
        // The clipped pixels of a block count in the channels in which the model is darker than them.
        let beyond = blocks.mean_where(&residual, |i| pixels[i].reading == Reading::AtLeast);
        let counts = |i: usize| match pixels[i].reading {
            Reading::Value => Rgb::ONE,
            Reading::AtLeast => {
                let is_darker = beyond[blocks.of_pixel[i] as usize].cmpgt(Rgb::ZERO);
                Rgb::select(is_darker, Rgb::ONE, Rgb::ZERO)
            }
            Reading::Nothing => Rgb::ZERO,
        };
        let half: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] - model[1][i])).collect();
        let rendering: Vec<Rgb> = half.iter().map(|half| *half * *half).collect();
        let photograph: Vec<Rgb> = pixels.iter().map(|p| p.variance).collect();
        let level2: Vec<Rgb> = pixels.iter().map(|p| p.level * p.level).collect();
        let mut level2 = blocks.mean_where(&level2, |_| true);
        let rendering = pooled(&blocks.smooth(&rendering), &smooth);
        blocks.spread_over_fine(&mut level2);
        let photograph = blocks.mean_where(&photograph, |_| true);
        let mut counted = vec![Rgb::ZERO; blocks.len()];
        (0..n).for_each(|i| counted[blocks.of_pixel[i] as usize] += counts(i));
        let size = |k: usize| counted[k].max(Rgb::ONE);
        let rendering: Vec<Rgb> = (0..blocks.len()).map(|k| rendering[k] / size(k)).collect();
        let noise = (0..blocks.len()).map(|k| photograph[k] / size(k) + rendering[k]).collect();
        let missing = vec![Rgb::ZERO; blocks.len()];
        let residual = blocks.mean_of(&residual, counts);
        let half = blocks.mean_of(&half, counts);
        Self { residual, noise, rendering, half, missing, level2, light: smooth }
    }
}

/// The variance of the rendering noise of a pixel in every block: the mean of that `measured` around the block and of
/// the whole group's, scaled to the model's own `light` there. The first alone is too small where by chance no bright
/// path was found. With any other scale, a mirror that shows a lamp somewhere would be noisy everywhere, and nothing
/// could speak against it.
pub(crate) fn pooled(measured: &[Rgb], light: &[Rgb]) -> Vec<Rgb> {
    let variance: Rgb = measured.iter().sum();
    let squares: Rgb = light.iter().map(|light| *light * *light).sum();
    let relative = variance / squares.max(Rgb::splat(f32::MIN_POSITIVE));
    let of_block = |(v, light): (&Rgb, &Rgb)| 0.5 * (*v + relative * *light * *light);
    measured.iter().zip(light).map(of_block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 4;

    /// The residuals over one block of pixels clipped at one, under a model of the radiance `model` of each.
    fn clipped(model: impl Fn(usize) -> Rgb) -> BlockResiduals {
        let mut sample = Sample::square(SIDE, SIDE, |_| Rgb::ONE);
        sample.pixels.iter_mut().for_each(|seen| seen.reading = Reading::AtLeast);
        let model: Vec<Rgb> = (0..SIDE * SIDE).map(model).collect();
        BlockResiduals::over(&sample, &[model.clone(), model])
    }

    #[test]
    fn clipped_pixels_have_a_residual_in_the_channels_in_which_the_model_is_darker() {
        let of = clipped(|_| Rgb::new(3.0, 1.0, 0.8));
        assert!((of.residual[0] - Rgb::new(0.0, 0.0, 0.2)).length() < 1e-6, "{:?}", of.residual);
        // The noise of a channel that says nothing is no less than that of one pixel.
        assert!(of.noise[0].z < of.noise[0].x + 1e-9, "{:?}", of.noise);
    }

    #[test]
    fn noise_of_a_bright_model_is_no_residual_of_clipped_pixels() {
        let of = clipped(|i| Rgb::splat(if i % 4 == 0 { 0.5 } else { 1.5 }));
        assert_eq!(of.residual[0], Rgb::ZERO);
    }

    #[test]
    fn measured_pixels_count_beside_clipped_ones() {
        let mut sample = Sample::square(SIDE, SIDE, |_| Rgb::ONE);
        sample.pixels[0].reading = Reading::AtLeast;
        let model = vec![Rgb::splat(1.5); SIDE * SIDE];
        let of = BlockResiduals::over(&sample, &[model.clone(), model]);
        assert!((of.residual[0] + Rgb::splat(0.5)).length() < 1e-6, "{:?}", of.residual);
    }
}
