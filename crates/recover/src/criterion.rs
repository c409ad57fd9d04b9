//! The difference of two fits of one group on the same evidence, in units of the noise.

use crate::block_residuals::BlockResiduals;
use crate::contrast::{Contrast, Side, independent_share};
use crate::evidence::Evidence;
use crate::likelihood::{Likelihood, ResidualCovariance};
use std::ops::Neg;

/// The gain of one hypothesis over another counts less so many of its standard deviations by the light's noise. At
/// none, a plain ceiling of a real room becomes a lobe under one seed of six; half and double of it were not tried.
const CERTAIN: f64 = 2.0;

/// What a fit leaves unexplained.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Explained<'a> {
    pub(crate) residuals: &'a BlockResiduals,
    pub(crate) likelihood: &'a Likelihood,
}

/// The information criterion of one fit less that of another.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Excess {
    pub(crate) value: f64,
    /// Its standard deviation by the light's noise.
    pub(crate) deviation: f64,
}

impl Neg for Excess {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Excess {
    /// The lower end of what is likely.
    pub(crate) fn least(self) -> f64 {
        self.value - CERTAIN * self.deviation
    }

    /// The upper end of what is likely.
    pub(crate) fn most(self) -> f64 {
        self.value + CERTAIN * self.deviation
    }
}

/// The squared residuals of the first less those of the second, in units of their covariance, of which so many blocks are
/// `independent`.
pub(crate) fn difference(
    sides: [Explained<'_>; 2],
    evidence: &Evidence,
    independent: f64,
) -> Excess {
    let (field, floor) = (&evidence.field, evidence.allowance.floor);
    let sides = sides.map(|side| Side { residuals: side.residuals, field, floor });
    let contrast = Contrast::of(&evidence.blocks, sides.each_ref());
    let scale = independent / evidence.blocks.len().max(1) as f64;
    Excess { value: scale * contrast.difference, deviation: scale * contrast.noise.sqrt() }
}

/// How many of the blocks are independent of each other under a fit.
pub(crate) fn independent_blocks(of: Explained<'_>, evidence: &Evidence) -> f64 {
    let residuals =
        ResidualCovariance::of(of.residuals, &evidence.field, of.likelihood).standardised();
    evidence.blocks.len() as f64 * independent_share(&evidence.blocks, &residuals)
}
