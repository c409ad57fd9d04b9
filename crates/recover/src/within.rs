//! What a model leaves of the differences between the pixels of a block: a pattern that is finer than blocks
//! shows nowhere else, and errors of the light hardly show there.

use crate::blocks::Blocks;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// The squared differences of residuals from the means of their blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Within {
    /// Their sum over pixels and channels, in units of their variance, as products of two renderings: free
    /// of the renderings' noise.
    pub(crate) squares: f64,
    /// How many of them are independent.
    pub(crate) count: f64,
}

impl Within {
    /// For the residuals of two renderings of the mean `light`, pixel by pixel of `blocks`, where a pixel `counts`.
    /// What of a block's residuals goes with the light's own change over the block is left out: a lobe that is
    /// a little too sharp or turned leaves that on the slope of a highlight, and a pattern does not.
    pub(crate) fn of(
        blocks: &Blocks,
        ([a, b], light): ([&[Rgb]; 2], &[Rgb]),
        variance: impl Fn(usize) -> Rgb,
        counts: impl Fn(usize) -> bool + Copy,
    ) -> Self {
        let [a, b, light] = [a, b, light]
            .map(|values| from_means(values, &blocks.mean_where(values, counts), blocks));
        let products = |values: &[Rgb]| -> Vec<Rgb> {
            values.iter().zip(&light).map(|(value, light)| *value * *light).collect()
        };
        let power = blocks.mean_where(&products(&light), counts);
        let slopes = [&a, &b].map(|residuals| {
            let together = blocks.mean_where(&products(residuals), counts);
            let slope = |(together, power): (&Rgb, &Rgb)| {
                Rgb::select(power.cmpgt(Rgb::ZERO), *together / *power, Rgb::ZERO)
            };
            together.iter().zip(&power).map(slope).collect::<Vec<Rgb>>()
        });
        let mut within = Self::default();
        let mut counted = vec![0; blocks.len()];
        for (i, &block) in blocks.of_pixel.iter().enumerate().filter(|(i, _)| counts(*i)) {
            let at = block as usize;
            let product = (a[i] - slopes[0][at] * light[i]) * (b[i] - slopes[1][at] * light[i]);
            let squares = product / variance(i).max(Rgb::splat(f32::MIN_POSITIVE));
            within.squares += f64::from(squares.element_sum());
            // The mean takes one of a block's, the slope another.
            within.count += if counted[at] >= 2 { 3.0 } else { 0.0 };
            counted[at] += 1;
        }
        within
    }

    /// The squares over the variance that they were thought to have; one if nothing was counted.
    pub(crate) fn over_variance(&self) -> f64 {
        if self.count > 0.0 { self.squares / self.count } else { 1.0 }
    }

    /// Whether this leaves so much less than `other` that `parameters` that fit chance do not, at so many
    /// standard deviations.
    pub(crate) fn gains(&self, other: &Self, parameters: f64, deviations: f64) -> bool {
        other.squares - self.squares > parameters + deviations * (2.0 * parameters).sqrt()
    }
}

/// `values`, pixel by pixel of `blocks`, less the `means` of their blocks.
fn from_means(values: &[Rgb], means: &[Rgb], blocks: &Blocks) -> Vec<Rgb> {
    let both = values.iter().zip(&blocks.of_pixel);
    both.map(|(value, block)| *value - means[*block as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::Grid;

    const SIDE: usize = 12;

    /// What a model leaves that fits the share `left` of a noise of `deviation`, where the noise is taken as one.
    fn left(share: f32, deviation: f32) -> Within {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let blocks = Blocks::of(&pixels, &Grid::even(SIDE, 3));
        let sign = |i: usize| if (i * 7919) % 13 < 6 { 1.0 } else { -1.0 };
        let residuals: Vec<Rgb> =
            (0..SIDE * SIDE).map(|i| Rgb::splat(share * deviation * sign(i))).collect();
        let light = vec![Rgb::ONE; SIDE * SIDE];
        Within::of(&blocks, ([&residuals, &residuals], &light), |_| Rgb::ONE, |_| true)
    }

    #[test]
    fn the_slope_of_a_highlight_is_no_pattern() {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let blocks = Blocks::of(&pixels, &Grid::even(SIDE, 3));
        // Steps of 10 from column to column, which the model has too small by a fifth.
        let light: Vec<Rgb> =
            (0..SIDE * SIDE).map(|i| Rgb::splat(10.0 * (i % SIDE) as f32)).collect();
        let residuals: Vec<Rgb> = light.iter().map(|light| 0.2 * *light).collect();
        let within =
            Within::of(&blocks, ([&residuals, &residuals], &light), |_| Rgb::ONE, |_| true);
        assert!(within.squares.abs() < 1e-3, "{}", within.squares);
    }

    #[test]
    fn what_is_usual_elsewhere_is_no_pattern() {
        // A noise of twice the deviation that it is thought to have, and a texture that fits nearly all of it.
        let (texture, plain) = (left(0.1, 2.0), left(1.0, 2.0));
        assert!(texture.gains(&plain, plain.count, 3.0));
        let usual = plain.over_variance();
        assert!((3.0..5.0).contains(&usual), "{usual}");
        assert!(!texture.gains(&plain, usual * plain.count, 3.0));
        // A pattern of three times that is one all the same.
        assert!(left(0.1, 2.0).gains(&left(1.0, 6.0), usual * plain.count, 3.0));
    }
}
