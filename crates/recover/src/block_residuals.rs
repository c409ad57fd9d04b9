//! The residuals of a model over the blocks of a group, with the variances that they have under the
//! observation model ([`crate::model_error`]).

use crate::blocks::Blocks;
use crate::evidence::{Evidence, Observed};
use crate::observation::Reading;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

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
        let residuals = Self::over(&evidence.blocks, &evidence.pixels, model);
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

    /// As [`BlockResiduals::of`] for `pixels` in `blocks`.
    pub fn over(blocks: &Blocks, pixels: &[Observed], model: &[Vec<Rgb>; 2]) -> Self {
        let n = pixels.len();
        let light: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] + model[1][i])).collect();
        let residual: Vec<Rgb> = (0..n).map(|i| pixels[i].radiance - light[i]).collect();
        let smooth = blocks.smooth(&light);
        // A clipped pixel counts only where the model is darker.
        let counts = |i: usize| {
            let dark = || (smooth[blocks.of_pixel[i] as usize]).cmplt(pixels[i].radiance).any();
            pixels[i].reading == Reading::Value || dark()
        };
        let half: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] - model[1][i])).collect();
        let rendering: Vec<Rgb> = half.iter().map(|half| *half * *half).collect();
        let photograph: Vec<Rgb> = pixels.iter().map(|p| p.variance).collect();
        let level2: Vec<Rgb> = pixels.iter().map(|p| p.level * p.level).collect();
        let mut level2 = blocks.mean_where(&level2, |_| true);
        let rendering = pooled(&blocks.smooth(&rendering), &smooth);
        blocks.spread_over_fine(&mut level2);
        let photograph = blocks.mean_where(&photograph, counts);
        let size = |k: usize| blocks.sizes[k] as f32;
        let rendering: Vec<Rgb> = (0..blocks.len()).map(|k| rendering[k] / size(k)).collect();
        let noise = (0..blocks.len()).map(|k| photograph[k] / size(k) + rendering[k]).collect();
        let missing = vec![Rgb::ZERO; blocks.len()];
        let residual = blocks.mean_where(&residual, counts);
        let half = blocks.mean_where(&half, counts);
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
