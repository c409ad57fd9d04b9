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
    /// For the residuals of two renderings, pixel by pixel of `blocks`, where a pixel `counts`.
    pub(crate) fn of(
        blocks: &Blocks,
        [a, b]: [&[Rgb]; 2],
        variance: impl Fn(usize) -> Rgb,
        counts: impl Fn(usize) -> bool + Copy,
    ) -> Self {
        let means = [a, b].map(|residuals| blocks.mean_where(residuals, counts));
        let mut within = Self::default();
        let mut counted = vec![false; blocks.len()];
        for (i, &block) in blocks.of_pixel.iter().enumerate().filter(|(i, _)| counts(*i)) {
            let at = block as usize;
            let product = (a[i] - means[0][at]) * (b[i] - means[1][at]);
            let squares = product / variance(i).max(Rgb::splat(f32::MIN_POSITIVE));
            within.squares += f64::from(squares.element_sum());
            // The mean takes one of a block's.
            within.count += if counted[at] { 3.0 } else { 0.0 };
            counted[at] = true;
        }
        within
    }

    /// Whether this leaves so much less than `other` that `parameters` that fit chance do not, at so many
    /// standard deviations.
    pub(crate) fn gains(&self, other: &Self, parameters: f64, deviations: f64) -> bool {
        other.squares - self.squares > parameters + deviations * (2.0 * parameters).sqrt()
    }
}
