//! A scene for the other programs.

use crate::Failure;
use std::path::Path;
use unrender::converted::convert;
use unrender::formats::LightUnits;
use unrender::formats::export::{self, Target};
use unrender::scene::{Camera, Material, Scene};

/// The scene, camera and size of a picture.
#[derive(Clone, Copy)]
pub(crate) struct Shot<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
    /// Width and height, pixels.
    pub(crate) size: (usize, usize),
}

/// Writes it into `folder`, which is made again, as `unrender export` would.
///
/// # Errors
/// If it cannot be expressed or written.
pub(crate) fn export(shot: &Shot, target: Target, folder: &Path) -> Result<(), Failure> {
    let scene = shot.scene;
    let material = |m: &Material| convert(m, scene.brdf, target.lobe(scene.brdf)).material;
    let materials: Vec<Material> = scene.groups.iter().map(|g| material(&g.material)).collect();
    let Shot { camera, size, .. } = *shot;
    let light_units = LightUnits::default();
    let shot = export::SceneView { scene, materials: &materials, camera, size, light_units };
    let (files, _) = export::export(&shot, target, folder)?;
    if folder.exists() {
        std::fs::remove_dir_all(folder)?;
    }
    if let Some(parent) = folder.parent() {
        std::fs::create_dir_all(parent)?;
    }
    Ok(export::write(folder, target, &files)?)
}
