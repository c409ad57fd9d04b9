//! The re-rendering as it is shown: denoised, of independent paths. The last picture of a recovery has few paths, which
//! neighbouring pixels share: its noise is a mosaic, and no denoiser can tell it from the picture.

use super::Recovered;
use crate::Job;
use crate::progressive_render::{PictureRender, ProgressiveRender};
use unrender_recover::{GroupResult, Status, Termination, expected_seconds};
use unrender_render::adaptive::SampleAllocation;
use unrender_render::{Accumulator, Integrator, Settings};
use unrender_scene::color::luminance;
use unrender_scene::{Rgb, RgbImage};

/// Samples per pixel, which take a third of the time; the rest is denoising. At half of it single bright paths leave
/// flecks; double of it looks the same at the size of a page.
const SPP: u32 = 16;
/// Seconds that they and denoising take for a pixel on two cores: 7 for 512 x 512 pixels, 1 to 3 for 256 x 192. Half and
/// double of it shift the size up to which pictures are denoised by as much.
const SECONDS: f64 = 25e-6;
/// The share of a recovery's time that a picture to look at is worth. With it drafts of rooms are denoised (480 x 360 pixels,
/// 12 groups), and one of Figure 8 (512 x 512, 6 groups), which would take a third longer, is not; at half of it the same,
/// at double Figure 8 is, too.
const WORTH: f64 = 0.2;

impl Recovered {
    /// The re-rendering without noise, radiance, at the reduced size. None where it is not worth the time, in all pixels of a
    /// large photograph or after an interruption; nor where noise and bias leave more than the noise of the last picture.
    /// With several photographs use [`Recovered::alone`].
    pub(crate) fn denoised(&self, job: &Job) -> Option<RgbImage> {
        let is_interrupted = self.recovery.termination == Termination::Interrupted;
        if is_interrupted || !self.full.is_empty() || !self.is_worth_denoising() {
            return None;
        }
        let mut scene = self.scene(job);
        job.off.iter().for_each(|source| scene.scale_source(*source as usize, Rgb::ZERO));
        let size = (self.recovery.rerendered.width(), self.recovery.rerendered.height());
        let settings = Settings {
            spp: SPP,
            seed: self.options.seed,
            max_bounces: self.options.max_bounces,
            integrator: Integrator::Path,
            ..Settings::default()
        };
        let camera = self.camera(job);
        let render = PictureRender::new(&scene, &camera, settings).halved(true);
        let mut layers = [(); 2].map(|()| Accumulator::new(size.0, size.1));
        render.accumulate(&SampleAllocation::Uniform(0..SPP), &mut layers, &|_| ());
        let denoised = render.denoised(&layers)?;
        (denoised.error < self.noise_of_last()).then_some(denoised.radiance)
    }

    /// Whether denoising takes a small share of what the recovery is expected to take; the clock is not asked, so that the
    /// same recovery has the same files.
    fn is_worth_denoising(&self) -> bool {
        let is_seen =
            |group: &&GroupResult| group.valid_pixels > 0 && group.status != Status::Known;
        let groups = self.recovery.groups.iter().filter(is_seen).count();
        let pixels = self.recovery.rerendered.pixels().len();
        let expected = expected_seconds(groups, pixels, &self.options);
        WORTH * expected > SECONDS * pixels as f64
    }

    /// The relative error that noise leaves in the last picture: its root mean square over the picture's mean.
    fn noise_of_last(&self) -> f64 {
        let square = |noise: &f32| f64::from(*noise).powi(2);
        let noise = self.recovery.noise_sample.pixels();
        let light = self.recovery.rerendered.pixels().iter();
        let mean = light.map(|value| f64::from(luminance(*value))).sum::<f64>();
        let count = noise.len().max(1) as f64;
        (noise.iter().map(square).sum::<f64>() / count).sqrt()
            / (mean / count).max(f64::MIN_POSITIVE)
    }
}
