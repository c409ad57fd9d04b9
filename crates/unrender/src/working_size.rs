//! The size at which a photograph is worked on.
//!
//! What a recovery asks of a group it asks of some thousands of its pixels, however many there are. A photograph of
//! many more is worked on as the means of squares of its pixels: they have less noise, which is independent from one
//! to the next as that of a camera's pixels is not. Only textures go back to the pixels of the photograph.

use crate::Job;
use unrender_photo::{Photo, Transfer, develop, squares};
use unrender_recover::Detail;
use unrender_render::{GeometryBuffers, Tracer};
use unrender_scene::{Camera, RgbImage};

/// A photograph of more pixels is worked on as squares of them. At half of it the rims of small objects are a larger
/// share of them, at double registration and textures take twice the time.
const PIXELS_MAX: usize = 1 << 20;

/// The pixels on a side of each square of a photograph of `width` x `height` pixels.
fn side((width, height): (usize, usize)) -> usize {
    let side = (1..).find(|side| width * height <= PIXELS_MAX * side * side).unwrap_or(1);
    // A picture may be narrower than that.
    side.min(width).min(height).max(1)
}

impl Job {
    /// Works on the photograph at a size that no question needs more of.
    pub fn reduce(&mut self) {
        let size = self.photograph_size();
        let side = side(size);
        if self.side != 1 || side == 1 {
            return;
        }
        self.side = side;
        self.photo = self.developed(&self.transfer);
        self.mask =
            self.mask.as_ref().map(|mask| squares(mask, side, |counts| !counts.contains(&false)));
        self.camera = self.camera.part(size, (0, 0), self.whole_squares());
    }

    /// Width and height of the photograph's file, pixels.
    pub fn photograph_size(&self) -> (usize, usize) {
        (self.picture.values.width(), self.picture.values.height())
    }

    /// Width and height of what of the photograph is in whole squares, pixels.
    fn whole_squares(&self) -> (usize, usize) {
        let (width, height) = self.photograph_size();
        (width / self.side * self.side, height / self.side * self.side)
    }

    /// The camera of the whole photograph where that of the squares is `camera`.
    pub(crate) fn camera_of_photograph(&self, camera: &Camera) -> Camera {
        camera.part(self.whole_squares(), (0, 0), self.photograph_size())
    }

    /// The photograph as `transfer` develops it, in squares.
    pub(crate) fn developed(&self, transfer: &Transfer) -> Photo {
        develop(&self.picture, transfer).binned(self.side)
    }
}

/// The photograph behind the squares of a job, seen by the camera of these.
pub(crate) struct WholePhotograph<'a> {
    pub(crate) job: &'a Job,
    pub(crate) tracer: &'a Tracer,
    pub(crate) camera: &'a Camera,
}

impl Detail for WholePhotograph<'_> {
    fn side(&self) -> usize {
        self.job.side
    }

    fn values(&self) -> RgbImage {
        develop(&self.job.picture, &self.job.transfer).radiance
    }

    fn geometry(&self, first: usize, rows: usize) -> GeometryBuffers {
        let whole = self.job.whole_squares();
        let band = (whole.0, rows);
        let camera = self.camera.part(whole, (0, first as i64), band);
        self.tracer.geometry(&camera, band.0, band.1)
    }
}
