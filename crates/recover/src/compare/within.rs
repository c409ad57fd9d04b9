//! The residuals of the differences between the pixels of a block: a pattern that is finer than blocks shows only
//! there, and errors of the light hardly do.

use crate::observe::blocks::Blocks;
use crate::observe::observation::Reading;
use crate::observe::sample::Sample;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// The squared differences of residuals from the means of their blocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Within {
    /// Their sum over a block's pixels and channels, in units of their variance, as products of two renderings, to
    /// which their noise adds zero on average. One number a block.
    squares: Vec<f64>,
    /// How many of them are independent.
    pub(crate) count: f64,
}

impl Within {
    /// For the pixels of `sample` in the renderings `model`.
    /// The part of a block's residuals that is proportional to the light's change over the block is left out: a lobe
    /// that is a little too sharp or turned leaves that on the slope of a highlight, and a pattern does not. Each
    /// rendering's residuals are regressed on the other's light: its own has the same noise.
    pub(crate) fn of(sample: &Sample, model: &[Vec<Rgb>; 2]) -> Self {
        let Sample { pixels, blocks, .. } = sample;
        let counts = |i: usize| pixels[i].reading == Reading::Value;
        let residuals = |half: &Vec<Rgb>| -> Vec<Rgb> {
            pixels.iter().zip(half).map(|(seen, light)| seen.radiance - *light).collect()
        };
        let from_means = |values: &[Rgb]| -> Vec<Rgb> {
            let means = blocks.mean_where(values, counts);
            let both = values.iter().zip(&blocks.of_pixel);
            both.map(|(value, block)| *value - means[*block as usize]).collect()
        };
        let [a, b] = [0, 1].map(|half| {
            let (residuals, light) =
                (from_means(&residuals(&model[half])), from_means(&model[1 - half]));
            without_slope(blocks, &residuals, &light, counts)
        });
        let mut within = Self { squares: vec![0.0; blocks.len()], count: 0.0 };
        let mut counted = vec![0; blocks.len()];
        for (i, &block) in blocks.of_pixel.iter().enumerate().filter(|(i, _)| counts(*i)) {
            let squares = a[i] * b[i] * pixels[i].weight;
            within.squares[block as usize] += f64::from(squares.element_sum());
            // The mean takes one degree of freedom of a block, the slope another.
            let counted = &mut counted[block as usize];
            within.count += if *counted >= 2 { 3.0 } else { 0.0 };
            *counted += 1;
        }
        within
    }

    /// The squares over their assumed variance; one if nothing was counted.
    pub(crate) fn over_variance(&self) -> f64 {
        if self.count > 0.0 { self.squares.iter().sum::<f64>() / self.count } else { 1.0 }
    }

    /// Whether this leaves less than `other` by more than `parameters` gain from chance, plus so many standard
    /// `deviations` of the gain: by its spread over the blocks, which holds chance and the renderings' noise.
    pub(crate) fn gains(&self, other: &Self, parameters: f64, deviations: f64) -> bool {
        let gained = || other.squares.iter().zip(&self.squares).map(|(other, mine)| other - mine);
        let sum: f64 = gained().sum();
        let mean = sum / self.squares.len().max(1) as f64;
        let variance: f64 = gained().map(|gain| (gain - mean).powi(2)).sum();
        sum > parameters + deviations * variance.sqrt()
    }
}

/// `residuals` without the part proportional to `light` in each block, both less their block means.
fn without_slope(
    blocks: &Blocks,
    residuals: &[Rgb],
    light: &[Rgb],
    counts: impl Fn(usize) -> bool + Copy,
) -> Vec<Rgb> {
    let with_light = |values: &[Rgb]| {
        let products: Vec<Rgb> = values.iter().zip(light).map(|(v, l)| *v * *l).collect();
        blocks.mean_where(&products, counts)
    };
    let slope = |(together, power): (Rgb, Rgb)| {
        Rgb::select(power.cmpgt(Rgb::ZERO), together / power, Rgb::ZERO)
    };
    let slopes: Vec<Rgb> =
        with_light(residuals).into_iter().zip(with_light(light)).map(slope).collect();
    let both = residuals.iter().zip(light).zip(&blocks.of_pixel);
    both.map(|((residual, light), block)| *residual - slopes[*block as usize] * *light).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::sampler::mix;

    const SIDE: usize = 12;

    /// Of a model that leaves this `share` of a noise of `deviation`, where the deviation is taken as one.
    fn left(share: f32, deviation: f32) -> Within {
        let sign = |i: usize| if (i * 7919) % 13 < 6 { 1.0 } else { -1.0 };
        let shown = |i: usize| Rgb::splat(1.0 + share * deviation * sign(i));
        let light = vec![Rgb::ONE; SIDE * SIDE];
        Within::of(&Sample::square(SIDE, 3, shown), &[light.clone(), light])
    }

    #[test]
    fn the_slope_of_a_highlight_is_no_pattern() {
        // Steps of 10 from column to column, which the model has too small by a fifth of its light.
        let light: Vec<Rgb> =
            (0..SIDE * SIDE).map(|i| Rgb::splat(10.0 * (i % SIDE) as f32)).collect();
        let sample = Sample::square(SIDE, 3, |i| 1.2 * light[i]);
        let within = Within::of(&sample, &[light.clone(), light]);
        assert!(within.over_variance().abs() < 1e-4, "{}", within.over_variance());
    }

    #[test]
    fn noise_of_the_renderings_leaves_nothing() {
        const SIDE: usize = 60;
        // Uniform numbers in (-1, 1), of deviation 0.577: others in each half.
        let noise = |half: u64| -> Vec<Rgb> {
            let at = |i: u64| (mix(2 * i + half) >> 40) as f32 / (1u64 << 23) as f32 - 1.0;
            (0..(SIDE * SIDE) as u64).map(|i| Rgb::splat(at(i))).collect()
        };
        let mut sample = Sample::square(SIDE, 30, |_| Rgb::ZERO);
        sample.pixels.iter_mut().for_each(|seen| seen.weight = Rgb::splat(3.0));
        let within = Within::of(&sample, &[0, 1].map(noise));
        // A product of two such numbers has the deviation of one in units of this variance.
        let chance = (3.0 * f64::from((SIDE * SIDE) as u32)).sqrt() * 3f64.sqrt();
        let sum: f64 = within.squares.iter().sum();
        assert!(sum.abs() < 3.0 * chance, "{sum} of {chance}");
    }

    #[test]
    fn what_is_usual_elsewhere_is_no_pattern() {
        // A noise of twice its assumed deviation, and a texture that fits nearly all of it.
        let (texture, plain) = (left(0.1, 2.0), left(1.0, 2.0));
        assert!(texture.gains(&plain, plain.count, 3.0));
        let usual = plain.over_variance();
        assert!((3.0..5.0).contains(&usual), "{usual}");
        assert!(!texture.gains(&plain, usual * plain.count, 3.0));
        // A pattern of three times that is one all the same.
        assert!(left(0.1, 2.0).gains(&left(1.0, 6.0), usual * plain.count, 3.0));
    }
}
