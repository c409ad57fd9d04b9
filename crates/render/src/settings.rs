//! How to render: plain numbers.

use crate::camera_sample::PixelSamples;
use crate::path::MAX_BOUNCES;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Which estimator the samples of a picture come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Integrator {
    /// Path tracing: the paths of all pixels are independent; their random numbers are stratified together with those of
    /// neighbours.
    #[default]
    Path,
    /// Path reuse among neighbouring pixels [Bekaert et al. 2002] where a pilot finds it efficient,
    /// else path tracing. It reduces the variance and correlates the noise of neighbouring pixels.
    /// It renders whole pictures only.
    PathReuse,
}

impl Integrator {
    /// [`Integrator::PathReuse`] if `reuse`, else [`Integrator::Path`].
    pub fn with_path_reuse(reuse: bool) -> Self {
        if reuse { Self::PathReuse } else { Self::Path }
    }
}

/// The samples of a pixel of a picture that are stratified among themselves: as many as it usually has. At a quarter
/// of it pixels are noisier by a twentieth and means over 8 x 8 less noisy by as much; double was not tried.
pub const TOGETHER: u32 = 64;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Samples per pixel.
    pub spp: u32,
    /// The number of each pixel's first sample, usually zero. A rendering that goes on where others of the same seed
    /// ended is stratified with them: their mean is less noisy than that of as many with other seeds.
    pub first: u32,
    /// So many samples of a pixel are stratified among themselves, a power of two, and beyond them together with those of
    /// the other pixels of their block of 8 x 8. Fewer make pixels noisier and means over blocks less noisy.
    pub together: u32,
    /// The seed of the random numbers; the same seed gives the same bits.
    pub seed: u64,
    /// Most reflections along a path; one means direct light only.
    pub max_bounces: u32,
    /// The estimator.
    pub integrator: Integrator,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            spp: 64,
            first: 0,
            together: TOGETHER,
            seed: 0,
            max_bounces: MAX_BOUNCES,
            integrator: Integrator::Path,
        }
    }
}

impl Settings {
    /// The random numbers of the pixels of a picture of `width` columns.
    pub fn pixels(&self, width: usize) -> PixelSamples {
        PixelSamples { seed: self.seed, width, together: self.together }
    }

    /// The numbers of the samples of a pixel.
    pub fn samples(&self) -> Range<u32> {
        self.first..self.first + self.spp
    }
}
