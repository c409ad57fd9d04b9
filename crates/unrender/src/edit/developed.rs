//! The developed photograph for composites.

use unrender_formats::picture::Picture;
use unrender_photo::{Photo, Transfer};
use unrender_scene::Camera;

/// The photograph, and the camera that took it.
#[derive(Debug)]
pub struct Photograph {
    /// The code values of the file.
    pub picture: Picture,
    /// The photograph as radiance.
    pub photo: Photo,
    /// The transfer function between radiance and its code values.
    pub transfer: Transfer,
    /// The camera.
    pub camera: Camera,
}

impl Photograph {
    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.picture.values.width(), self.picture.values.height())
    }
}
