//! Radiance that is known without tracing: the photograph as a cache.
//!
//! A diffuse surface sends the same radiance everywhere. Where the camera sees one, the photograph
//! says what it sends, whatever light makes it do so: a path that reaches such a point can end
//! there. That takes out the noise of everything beyond (the caustics of a glossy floor on a wall,
//! say) and, in a recovery, most of what the groups' errors would do to each other.

use crate::geometry::GeometryBuffers;
use crate::surface::Surface;
use unrender_scene::{Camera, Image, Rgb, RgbImage};

/// The radiance of diffuse surfaces as the camera sees them.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenRadiance {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
    /// True in pixels that may be believed and that show a diffuse surface without emission.
    pub known: Image<bool>,
}

/// [`SeenRadiance`] with the camera and the geometry that tell which pixel shows a point.
#[derive(Clone, Copy, Debug)]
pub struct Lookup<'a> {
    /// The radiance.
    pub seen: &'a SeenRadiance,
    /// The camera that sees it.
    pub camera: &'a Camera,
    /// What it sees.
    pub geometry: &'a GeometryBuffers,
}

/// A point belongs to what its pixel shows if the normals are this close (cosine) ...
const SAME_NORMAL: f32 = 0.95;
/// ... and it lies within this share of the depth from the plane through the pixel's point.
const SAME_PLANE: f32 = 2e-3;

impl Lookup<'_> {
    /// The radiance that leaves `surface`, if the camera sees the same point.
    pub(crate) fn radiance(&self, surface: &Surface) -> Option<Rgb> {
        let (width, height) = (self.geometry.width(), self.geometry.height());
        let (x, y) = self.camera.project(surface.point, width, height)?;
        let (column, row) = (x as usize, y as usize);
        let shown = self.geometry.at(column, row);
        let centre = (column as f32 + 0.5, row as f32 + 0.5);
        let same_surface = *self.seen.known.at(column, row)
            && shown.object == surface.object
            && shown.normal.dot(surface.frame.normal) > SAME_NORMAL;
        if !same_surface {
            return None;
        }
        let direction = self.camera.direction(centre.0, centre.1, width, height);
        let shown_point = self.camera.origin() + shown.depth * direction;
        let off_plane = (surface.point - shown_point).dot(shown.normal).abs();
        (off_plane < SAME_PLANE * shown.depth).then(|| *self.seen.radiance.at(column, row))
    }
}
