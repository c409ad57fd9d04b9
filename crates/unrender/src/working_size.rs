//! The size at which a photograph is worked on.
//!
//! What a recovery asks of a group it asks of some thousands of its pixels, however many there are. A photograph of
//! many more is worked on as the means of squares of its pixels: they have less noise, which is independent from one
//! to the next as that of a camera's pixels is not. Only textures go back to the pixels of the photograph.

use crate::Job;
use unrender_photo::{Photo, Transfer, develop, squares};
use unrender_recover::Detail;
use unrender_render::{GeometryBuffers, PixelGeometry, Tracer};
use unrender_scene::{Camera, Image, Rgb, RgbImage};

/// A photograph of more pixels is worked on as squares of them. At half of it the rims of small objects are a larger
/// share of them, at double registration and textures take twice the time.
const PIXELS_MAX: usize = 1 << 20;

/// The pixels on a side of each square of photographs of these widths and heights.
fn side(sizes: &[(usize, usize)]) -> usize {
    let pixels: usize = sizes.iter().map(|(width, height)| width * height).sum();
    let side = (1..).find(|side| pixels <= PIXELS_MAX * side * side).unwrap_or(1);
    // A picture may be narrower than that.
    sizes.iter().fold(side, |side, (width, height)| side.min(*width).min(*height)).max(1)
}

impl Job {
    /// Works on the photographs at a size that no question needs more of.
    pub fn reduce(&mut self) {
        let size = |k: usize| self.alone_size(k);
        let side = side(&(0..self.photographs()).map(size).collect::<Vec<_>>());
        if self.side != 1 || side == 1 {
            return;
        }
        let of_squares = |job: &Self, mask: Option<&Image<bool>>| {
            let photo = job.developed(&job.transfer);
            let mask = mask.map(|mask| squares(mask, side, |counts| !counts.contains(&false)));
            let camera = job.camera.part(job.photograph_size(), (0, 0), job.whole_squares());
            (photo, mask, camera)
        };
        self.side = side;
        for k in 0..self.further.len() {
            let alone = self.alone(k + 1);
            let (photo, mask, camera) = of_squares(&alone, alone.mask.as_ref());
            let shot = &mut self.further[k];
            (shot.photo, shot.mask, shot.camera) = (photo, mask, camera);
        }
        (self.photo, self.mask, self.camera) = of_squares(self, self.mask.as_ref());
    }

    /// Width and height of the file of `photograph`, pixels.
    fn alone_size(&self, photograph: usize) -> (usize, usize) {
        let further = photograph.checked_sub(1).map(|further| &self.further[further].picture);
        let picture = further.unwrap_or(&self.picture);
        (picture.values.width(), picture.values.height())
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

/// The photographs behind the squares of a job, each seen by the camera of these.
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
        if self.job.photographs() == 1 {
            return develop(&self.job.picture, &self.job.transfer).radiance;
        }
        let whole = |k: usize| {
            let alone = self.job.alone(k);
            let radiance = develop(&alone.picture, &alone.transfer).radiance;
            let (width, height) = alone.whole_squares();
            RgbImage::from_fn(width, height, |x, y| *radiance.at(x, y))
        };
        let each: Vec<RgbImage> = (0..self.job.photographs()).map(whole).collect();
        let each: Vec<&RgbImage> = each.iter().collect();
        self.job.sheet().finer(self.job.side).stack(&each, &Rgb::ZERO)
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
