//! The seam to the crates that do the work: scene files, the renderer, the recovery.
//!
//! Nothing is connected yet: each function says so in an error of its own.

use crate::progress::Progress;
use crate::{Error, Job};
use std::path::Path;
use unrender_scene::{Camera, RgbImage, Scene, Warnings};

/// How to render.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RenderSettings {
    /// Samples a pixel.
    pub(crate) spp: u32,
    /// Chooses the noise.
    pub(crate) seed: u64,
    /// The longest path; none for no limit but the renderer's own.
    pub(crate) max_bounces: Option<u32>,
}

/// How to recover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecoverSettings {
    /// Which ladder of hypotheses is climbed.
    pub(crate) ladder: crate::commands::recover::Ladder,
    /// Chooses the noise.
    pub(crate) seed: u64,
    /// Samples a pixel; none for the recovery's own choice.
    pub(crate) spp: Option<u32>,
}

/// Reads the scene at `path`.
pub(crate) fn load_scene(path: &Path) -> Result<(Scene, Warnings), Error> {
    if !path.is_file() {
        return Err(unrender_formats::FileError::new(path, "there is no such file").into());
    }
    Err(Error::NotConnected("reading scenes"))
}

/// Renders `scene` as `camera` sees it.
pub(crate) fn render(
    scene: &Scene,
    camera: &Camera,
    (width, height): (usize, usize),
    settings: &RenderSettings,
    progress: &Progress,
) -> Result<RgbImage, Error> {
    let _ = (scene, camera, width, height, settings.spp, settings.seed, settings.max_bounces);
    progress.set(0.0);
    Err(Error::NotConnected("rendering"))
}

/// Recovers the materials of `job`'s groups.
pub(crate) fn recover(
    job: &Job,
    settings: &RecoverSettings,
    progress: &Progress,
) -> Result<(), Error> {
    let _ = (job, settings.ladder, settings.seed, settings.spp);
    progress.set(0.0);
    Err(Error::NotConnected("recovering"))
}
