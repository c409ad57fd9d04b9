//! The image-based radiance cache: the photograph as known radiance of diffuse surfaces.
//!
//! A diffuse surface reflects the same radiance in all directions. Where the camera sees one, the
//! photograph is a measurement of that radiance, under all of the light transport. A path that
//! reaches such a point ends there with the measured value, as in final gathering from a cache
//! [Ward et al. 1988]. This removes the variance of everything beyond (caustics of a glossy floor
//! on a wall, say) and, in a recovery, most of the influence of one group's error on the others.

use crate::geometry::GeometryBuffers;
use crate::surface::Surface;
use serde::{Deserialize, Serialize};
use unrender_scene::{Camera, Image, Rgb, RgbImage};

/// The radiance of diffuse surfaces as a camera measured it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadianceCache {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
    /// The valid mask: pixels with a reliable value that show a diffuse surface without emission.
    pub valid: Image<bool>,
}

/// A [`RadianceCache`] with the camera and geometry that find the pixel of a surface point.
#[derive(Clone, Copy, Debug)]
pub struct CacheLookup<'a> {
    /// The radiance.
    pub cache: &'a RadianceCache,
    /// The camera that measured it.
    pub camera: &'a Camera,
    /// The geometry that it saw.
    pub geometry: &'a GeometryBuffers,
}

/// Where a path ends in a [`RadianceCache`].
pub(crate) struct Cached {
    /// The index of the pixel in the cache.
    pub(crate) pixel: u32,
    /// Its radiance.
    pub(crate) radiance: Rgb,
}

impl CacheLookup<'_> {
    /// The pixel that shows `surface` with its radiance, if the camera sees the same point in a valid pixel.
    pub(crate) fn at(&self, surface: &Surface) -> Option<Cached> {
        let (width, height) = (self.geometry.width(), self.geometry.height());
        let (x, y) = self.camera.project(surface.point, width, height)?;
        let (column, row) = (x as usize, y as usize);
        let shown = self.geometry.at(column, row);
        if !*self.cache.valid.at(column, row) {
            return None;
        }
        let centre = (column as f32 + 0.5, row as f32 + 0.5);
        let direction = self.camera.direction(centre.0, centre.1, width, height);
        let away = surface.point - (self.camera.origin() + shown.depth * direction);
        shown.shows(surface.object, surface.mesh_normal, away).then(|| Cached {
            pixel: (row * width + column) as u32,
            radiance: *self.cache.radiance.at(column, row),
        })
    }
}
