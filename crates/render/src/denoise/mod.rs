//! Denoising of final pictures: less noise for a small bias.
//!
//! A picture is rendered as two halves of independent samples ([`Tracer::accumulate_half`]). [`denoise`] filters each:
//!
//!  1. What is known without noise is taken out (`signal`): emission that is seen directly or in perfect mirrors is
//!     subtracted, and the rest divided by the reflectance of what is seen ([`crate::features`]).
//!  2. The other half decides which pixels are alike (`similarity`), by the weights of non-local means for pictures of
//!     known variance [Rousselle et al. 2012]: these are independent of the noise that they average.
//!  3. About every other pixel of every other row a model that is linear in position, normal, distance and reflectance
//!     is fitted to the pixels that are alike, and all models that reach a pixel are averaged (`regression`, `filter`):
//!     nonlinearly weighted first-order regression [Bitterli et al. 2016].
//!  4. Of two bandwidths and no filter, each pixel has those whose error, estimated from the halves, is least
//!     (`selection`) [Bitterli et al. 2016].
//!
//! The mean of both filtered halves is the picture. It is no longer an unbiased estimate: details that are fainter than
//! the noise and not in the features are averaged away. It is for pictures to be looked at, not for recovery.
//!
//! The cost is that of a ray for each sample, more of them where edges are, and about 40 microseconds of one core a pixel.

mod filter;
pub mod ratios;
mod regression;
mod selection;
mod signal;
mod similarity;

use crate::adaptive::SampleAllocation;
use crate::appearance::Appearance;
use crate::features::FeatureBuffers;
use crate::film::Accumulator;
use crate::settings::{Integrator, Settings};
use crate::tracer::Tracer;
use signal::Signal;
use unrender_scene::{Camera, Rgb, RgbImage};

/// Separates the random numbers of the second half from those of the first under the same seed.
const STREAM: u64 = 0xDE01_0000_0000_0000;

/// The two halves of a picture: samples whose random numbers are independent, and what they saw.
#[derive(Clone, Copy, Debug)]
pub struct Halves<'a> {
    /// The samples.
    pub samples: [&'a Accumulator; 2],
    /// Their features, of the same size.
    pub features: [&'a FeatureBuffers; 2],
    /// The features of the whole picture, as well as they are known.
    pub finer: &'a FeatureBuffers,
}

/// A denoised picture.
#[derive(Clone, Debug)]
pub struct Denoised {
    /// Radiance, W sr^-1 m^-2 per channel; finite and not negative.
    pub radiance: RgbImage,
    /// Its relative error, estimated from the halves: the root mean square of all pixels and channels over their mean,
    /// noise and bias together.
    pub error: f64,
    /// The share of the picture that was left as it was, 0 to 1.
    pub untouched: f64,
}

impl Tracer {
    /// Adds the samples of one half, 0 or 1, of an allocation to `accumulator`. As
    /// [`Tracer::accumulate`], with independent paths whatever `settings.integrator` says.
    pub fn accumulate_half<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        (samples, half): (&SampleAllocation<'_>, usize),
        accumulator: &mut Accumulator,
        progress: &(dyn Fn(f64) + Sync),
    ) {
        let samples = SampleAllocation::Half(samples, half);
        let settings = of_half(settings, half);
        self.accumulate(appearance, camera, &settings, &samples, accumulator, progress);
    }

    /// Denoises the picture of two halves, which [`Tracer::accumulate_half`] made with the same arguments from the
    /// first samples on.
    ///
    /// # Panics
    /// If the halves differ in size.
    pub fn denoise<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        samples: [&Accumulator; 2],
    ) -> Denoised {
        let appearance = appearance.into();
        let [a, b] = [0, 1]
            .map(|half| self.features(appearance, camera, &of_half(settings, half), samples[half]));
        let first = of_half(settings, 0);
        let finer = self.finer_features(appearance, camera, &first, samples[0], [&a, &b]);
        denoise(&Halves { samples, features: [&a, &b], finer: &finer })
    }
}

fn of_half(settings: &Settings, half: usize) -> Settings {
    let seed = if half == 0 { settings.seed } else { settings.seed ^ STREAM };
    Settings { seed, integrator: Integrator::Path, ..*settings }
}

/// Denoises the picture of two halves.
///
/// # Panics
/// If the halves or their features differ in size.
pub fn denoise(halves: &Halves<'_>) -> Denoised {
    let signal = Signal::new(halves);
    let filtered = [0, 1].map(|half| filter::filter(&signal, half));
    let selected = selection::select(&signal, &filtered);
    let (width, height) = signal.size();
    let at = |x: usize, y: usize| {
        let pixel = y * width + x;
        let [a, b] = signal.shares[pixel];
        let reflected = selected.halves[0][pixel] * a + selected.halves[1][pixel] * b;
        reflected.max(Rgb::ZERO) + halves.finer.pixels()[pixel].emission
    };
    let radiance = RgbImage::from_fn(width, height, at);
    let n = 3.0 * (width * height) as f64;
    let mean = radiance.pixels().iter().map(|p| f64::from(p.element_sum())).sum::<f64>() / n;
    let error = (selected.error.iter().sum::<f64>() / n).max(0.0).sqrt() / mean.max(1e-30);
    Denoised { radiance, error, untouched: selected.untouched }
}
