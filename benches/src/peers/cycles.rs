//! Runs Cycles, from `bpy` of PyPI: 350 MB.

use super::Worker;
use crate::Failure;
use serde_json::json;
use std::path::{Path, PathBuf};
use unrender::formats::picture;
use unrender::scene::RgbImage;

/// A Python that has Blender as a module.
///
/// # Errors
/// If it cannot be installed.
pub(crate) fn python() -> Result<PathBuf, String> {
    super::python("bpy", &["bpy==4.5.*", "numpy<2"])
}

/// A Blender that has built a scene.
pub(crate) struct Cycles {
    worker: Worker,
    picture: PathBuf,
}

impl Cycles {
    /// Builds the scene that was exported into `folder`.
    ///
    /// # Errors
    /// If Blender fails here.
    pub(crate) fn load(python: &Path, folder: &Path) -> Result<Self, Failure> {
        let folder = std::path::absolute(folder)?;
        let worker = Worker::start(python, "cycles_render.py", [folder.display().to_string()])?;
        Ok(Self { worker, picture: folder.join("picture.exr") })
    }

    /// A picture of `spp` samples per pixel.
    ///
    /// # Errors
    /// If Blender ended.
    pub(crate) fn render(&mut self, spp: u32, seed: u32) -> Result<RgbImage, Failure> {
        self.worker.ask(&json!({ "spp": spp, "seed": seed, "picture": self.picture }))?;
        Ok(picture::read(&self.picture)?.0.values)
    }
}
