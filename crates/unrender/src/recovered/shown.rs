//! The re-rendering as it is shown: denoised, of independent paths. The last picture of a recovery has few paths, which
//! neighbouring pixels share: its noise is a mosaic, and no denoiser can tell it from the picture.

use super::Recovered;
use crate::Job;
use crate::progressive_render::{PictureRender, ProgressiveRender};
use unrender_recover::{Effort, Termination};
use unrender_render::adaptive::SampleAllocation;
use unrender_render::{Accumulator, Integrator, Settings};
use unrender_scene::{Rgb, RgbImage};

/// Samples per pixel, which take a third of the time; the rest is denoising. At half of it single bright paths leave
/// flecks; double of it looks the same at the size of a page.
const SPP: u32 = 16;

/// The denoised picture is shown if its estimated error is less than this share of its mean. In rooms that are lit through
/// windows so few independent paths leave 10 %, which shows as blotches. At half of it boxes keep their mosaic; at double
/// of it blotched rooms are shown.
const ERROR_MAX: f64 = 0.05;

impl Recovered {
    /// The re-rendering without noise, radiance, at the reduced size. None where it is not worth the time: a draft, which it
    /// would make a third longer, a large picture in all pixels of the photograph, a recovery that was interrupted; nor
    /// where it is not good. With several photographs use [`Recovered::alone`].
    pub(crate) fn denoised(&self, job: &Job) -> Option<RgbImage> {
        let is_draft = self.options.effort == Effort::Draft;
        let is_interrupted = self.recovery.termination == Termination::Interrupted;
        if is_draft || is_interrupted || !self.full.is_empty() {
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
        (denoised.error < ERROR_MAX).then_some(denoised.radiance)
    }
}
