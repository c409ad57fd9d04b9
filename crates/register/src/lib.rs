//! How well the model is registered to the photograph, and which pixels are therefore doubtful
//! [Boivin and Gagalowicz 2002, section 3.2: the model may be several pixels off].
//!
//! The model says where the photograph should have edges ([`edges`]); how far away the photograph's are ([`offset`])
//! gives the camera under which both agree ([`mod@align`]). Either that camera is taken, or, where the given one is to
//! be kept, the pixels next to an edge of the model ([`margin`]) or of the photograph ([`steep`]) are not valid, as far
//! as the model's picture is off there.

pub mod align;
pub mod edges;
pub mod margin;
pub mod offset;
mod own;
pub mod steep;

use align::{Alignment, Offset, align, median, vote};
use edges::{Edgel, edgels, finer};
use glam::{Vec2, Vec3};
use offset::EdgePicture;
use serde::{Deserialize, Serialize};
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::{Camera, Image, RgbImage};

/// How far from the model's edges the photograph's are looked for, in pixels per row of the
/// picture, at first; later steps look less far.
const REACH: f32 = 0.025;
const REACH_PIXELS: [f32; 2] = [4.0, 16.0];
/// Steps towards the camera at most.
const STEPS_MAX: usize = 8;
/// The search ends when the edge points' median move is at most this, pixels.
const ARRIVED: f32 = 0.05;
/// Edges along fewer pixels than this fix no camera.
const EDGELS_MIN: usize = 60;

/// Traces what a camera sees in a picture of so many columns and rows.
pub type GeometryOf<'a> = &'a dyn Fn(&Camera, usize, usize) -> GeometryBuffers;

/// The registration of a model to a photograph.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Registration {
    /// The camera that brings the model's edges onto the photograph's; the given one if no other
    /// brings more of them there.
    pub camera: Camera,
    /// The median distance of the given model's edges from there, pixels.
    pub displacement: f32,
    /// What remains under that camera: the spread of the offsets, pixels.
    pub deviation: f32,
    /// The standard deviation of where that camera puts a point, pixels.
    pub uncertainty: f32,
    /// Edge points of the model that the photograph confirms.
    pub confirmed: usize,
    /// For each pixel: how far the model's picture is off there, pixels.
    pub displacements: Image<f32>,
    /// For each object: how far its own edges are off under that camera, pixels; zero where its edge
    /// points are too few to tell.
    pub own: Vec<f32>,
}

impl Registration {
    /// The registration once [`Registration::camera`] is the camera.
    #[must_use]
    pub fn taken(mut self) -> Self {
        self.displacements = self.displacements.map(|_| 0.0);
        self
    }
}

/// Registers the model, as `camera` sees it, to the photograph's linear `values`. None if the photograph has too few
/// edges where the model has them.
pub fn register(
    values: &RgbImage,
    camera: &Camera,
    geometry_of: GeometryOf<'_>,
) -> Option<Registration> {
    let size = (values.width(), values.height());
    let finer = finer(size);
    let search = Search { picture: EdgePicture::new(values), size, finer, geometry_of };
    let reach = (REACH * size.1 as f32).clamp(REACH_PIXELS[0], REACH_PIXELS[1]);
    let offsets = search.offsets(camera, reach);
    if offsets.len() < EDGELS_MIN * finer {
        return None;
    }
    let mut found = align(&offsets, camera, size, vote(&offsets, reach).0, finer)?;
    for _ in 1..STEPS_MAX {
        let reach = (4.0 * found.deviation as f32).clamp(REACH_PIXELS[0], reach);
        let offsets = search.offsets(&found.camera, reach);
        let next = align(&offsets, &found.camera, size, Vec2::ZERO, finer)?;
        let moved = offsets.iter().map(|o| moved(&o.edgel.at, o.edgel.point, &next.camera, size));
        let moved = median(moved)?;
        found = next;
        if moved < ARRIVED {
            break;
        }
    }
    if search.in_place(&found.camera) <= search.in_place(camera) {
        // Some edges were followed and more were lost.
        found.camera = camera.clone();
    }
    (found.inliers >= EDGELS_MIN * finer).then(|| search.report(camera, found))
}

/// A photograph to be searched for the edges of a model.
struct Search<'a> {
    picture: EdgePicture,
    size: (usize, usize),
    finer: usize,
    geometry_of: GeometryOf<'a>,
}

impl Search<'_> {
    fn edgels(&self, camera: &Camera) -> Vec<Edgel> {
        let (width, height) = self.size;
        let finer = self.finer;
        edgels(&(self.geometry_of)(camera, finer * width, finer * height), camera, finer)
    }

    /// How far the photograph's edges are from the model's, where they are found.
    fn offsets(&self, camera: &Camera, reach: f32) -> Vec<Offset> {
        let measured = |edgel: Edgel| {
            self.picture.offset(&edgel, reach).map(|distance| Offset { edgel, distance })
        };
        self.edgels(camera).into_iter().filter_map(measured).collect()
    }

    /// Edge points of the model that lie on an edge of the photograph.
    fn in_place(&self, camera: &Camera) -> usize {
        /// An edge within this many pixels is in place: a smaller displacement may come from the photograph's own blur.
        const CLOSE: f32 = 0.75;
        let offsets = self.offsets(camera, REACH_PIXELS[0]);
        offsets.iter().filter(|offset| offset.distance.abs() < CLOSE).count()
    }

    fn report(&self, camera: &Camera, found: Alignment) -> Registration {
        let (width, height) = self.size;
        let geometry = (self.geometry_of)(camera, width, height);
        let displacement = |x: usize, y: usize| {
            let pixel = geometry.at(x, y);
            if pixel.object == NOTHING {
                return 0.0;
            }
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let point = camera.origin() + camera.direction(at.x, at.y, width, height) * pixel.depth;
            moved(&at, point, &found.camera, self.size)
        };
        let of_edges = self.edgels(camera);
        let of_edges = of_edges.iter().map(|e| moved(&e.at, e.point, &found.camera, self.size));
        let objects = geometry.pixels().iter().map(|p| p.object).filter(|&o| o != NOTHING);
        let objects = objects.max().map_or(0, |last| last + 1);
        Registration {
            displacement: median(of_edges).unwrap_or(0.0),
            deviation: found.deviation as f32,
            uncertainty: found.uncertainty as f32,
            confirmed: found.inliers,
            displacements: Image::from_fn(width, height, displacement),
            own: own::displacements(self, &found.camera, objects),
            camera: found.camera,
        }
    }
}

/// How far a point that was seen at `at` is from there under `camera`; zero where it leaves the
/// picture.
fn moved(at: &Vec2, point: Vec3, camera: &Camera, (width, height): (usize, usize)) -> f32 {
    camera.project(point, width, height).map_or(0.0, |(x, y)| at.distance(Vec2::new(x, y)))
}
