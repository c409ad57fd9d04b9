//! The working size of a photograph: it is reduced to squares of its pixels.
//!
//! A recovery uses some thousands of pixels of a group, however many there are. So a photograph of many more pixels
//! is replaced by the means of squares of them: they have less noise, and, unlike that of a camera's pixels, it is
//! independent from one to the next. Only textures use the pixels of the photograph itself.

use crate::Job;
use unrender_formats::picture::Picture;
use unrender_photo::{Photo, Transfer, develop, squares};
use unrender_recover::Detail;
use unrender_render::{GeometryBuffers, PixelGeometry, Tracer};
use unrender_scene::{Camera, Image, Rgb, RgbImage};

/// A photograph of more pixels is reduced to squares. At half of it the edges of small objects are a larger share of
/// them, at double registration and textures take twice the time.
const PIXELS_MAX: usize = 1 << 20;

/// The pixels on a side of each square of photographs of these widths and heights.
fn side(sizes: &[(usize, usize)]) -> usize {
    let pixels: usize = sizes.iter().map(|(width, height)| width * height).sum();
    let side = (1..).find(|side| pixels <= PIXELS_MAX * side * side).unwrap_or(1);
    // A picture may be narrower than that.
    sizes.iter().fold(side, |side, (width, height)| side.min(*width).min(*height)).max(1)
}

/// Width and height of a photograph's file, pixels.
fn size_of(picture: &Picture) -> (usize, usize) {
    (picture.values.width(), picture.values.height())
}

impl Job {
    /// Reduces the photographs to the working size.
    pub fn reduce(&mut self) {
        let size = |k: usize| size_of(self.picture_of(k));
        let side = side(&(0..self.photographs()).map(size).collect::<Vec<_>>());
        if self.side != 1 || side == 1 {
            return;
        }
        self.side = side;
        for k in 0..self.further.len() {
            let (photo, mask, camera) = self.in_squares(k + 1, &self.further[k].camera);
            let shot = &mut self.further[k];
            (shot.photo, shot.mask, shot.camera) = (photo, mask, camera);
        }
        (self.photo, self.mask, self.camera) = self.in_squares(0, &self.camera);
    }

    /// The `photograph`, its mask, and `camera`, which took it, in squares.
    fn in_squares(
        &self,
        photograph: usize,
        camera: &Camera,
    ) -> (Photo, Option<Image<bool>>, Camera) {
        let photo = self.developed(photograph, self.transfer_of(photograph));
        let mask = self.mask_of(photograph);
        let mask = mask.map(|mask| squares(mask, self.side, |counts| !counts.contains(&false)));
        let size = size_of(self.picture_of(photograph));
        (photo, mask, camera.part(size, (0, 0), self.in_whole_squares(size)))
    }

    /// Width and height of the photograph's file, pixels.
    pub fn photograph_size(&self) -> (usize, usize) {
        size_of(&self.picture)
    }

    /// Width and height of the part of the photograph that whole squares cover, pixels.
    fn whole_squares(&self) -> (usize, usize) {
        self.in_whole_squares(self.photograph_size())
    }

    /// The same for a photograph of this size.
    fn in_whole_squares(&self, (width, height): (usize, usize)) -> (usize, usize) {
        (width / self.side * self.side, height / self.side * self.side)
    }

    /// The camera of the whole photograph, if that of the squares is `camera`.
    pub(crate) fn camera_of_photograph(&self, camera: &Camera) -> Camera {
        camera.part(self.whole_squares(), (0, 0), self.photograph_size())
    }

    /// The `photograph` as `transfer` develops it, in squares.
    pub(crate) fn developed(&self, photograph: usize, transfer: &Transfer) -> Photo {
        develop(self.picture_of(photograph), transfer).binned(self.side)
    }
}

/// The photographs from which the squares of a job were made, each seen by the camera of the
/// squares.
pub(crate) struct WholePhotographs<'a> {
    pub(crate) job: &'a Job,
    pub(crate) tracer: &'a Tracer,
    pub(crate) cameras: Vec<&'a Camera>,
}

impl Detail for WholePhotographs<'_> {
    fn side(&self) -> usize {
        self.job.side
    }

    fn values(&self) -> RgbImage {
        let job = self.job;
        if job.photographs() == 1 {
            return develop(&job.picture, &job.transfer).radiance;
        }
        let whole = |k: usize| {
            let radiance = develop(job.picture_of(k), job.transfer_of(k)).radiance;
            let (width, height) = job.in_whole_squares(size_of(job.picture_of(k)));
            RgbImage::from_fn(width, height, |x, y| *radiance.at(x, y))
        };
        let each: Vec<RgbImage> = (0..job.photographs()).map(whole).collect();
        job.sheet().finer(job.side).stack(&each, &Rgb::ZERO)
    }

    fn geometry(&self, first: usize, rows: usize) -> GeometryBuffers {
        let sheet = self.job.sheet().finer(self.job.side);
        let width = sheet.size().0;
        let mut pixels = vec![PixelGeometry::EMPTY; width * rows];
        for (k, camera) in self.cameras.iter().enumerate() {
            let [_, top, wide, high] = sheet.place(k);
            let band = first.max(top)..(first + rows).min(top + high);
            if band.is_empty() {
                continue;
            }
            let camera =
                camera.part((wide, high), (0, (band.start - top) as i64), (wide, band.len()));
            let seen = self.tracer.geometry(&camera, wide, band.len());
            for (row, from) in band.zip(seen.pixels().chunks(wide)) {
                let at = (row - first) * width;
                pixels[at..at + wide].copy_from_slice(from);
            }
        }
        GeometryBuffers::new(width, rows, pixels)
    }
}
