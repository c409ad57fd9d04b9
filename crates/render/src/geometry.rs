//! Geometry buffers (G-buffers): object, group, depth and normal at each pixel's centre.

use crate::accel::Ray;
pub use crate::surface::NOTHING;
use crate::tracer::Tracer;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use unrender_scene::{Camera, Image};

/// The first surface behind the centre of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGeometry {
    /// The object's index in the scene, or [`NOTHING`].
    pub object: u32,
    /// The group's index in the scene, or [`NOTHING`].
    pub group: u32,
    /// Distance from the camera's centre, metres; infinite without a surface.
    pub depth: f32,
    /// Unit shading normal of the mesh on the viewer's side, world space, without a normal map; zero without a surface.
    pub normal: Vec3,
    /// Unit tangent, from which the angle of anisotropy is measured, world space; zero without a
    /// surface.
    pub tangent: Vec3,
    /// `TEXCOORD_0`; zero without a surface or without coordinates.
    pub uv: Vec2,
    /// Whether the front (counter-clockwise) side is visible.
    pub front: bool,
}

/// Normals of one surface have a cosine above this, 18 degrees. At 9 degrees curved surfaces fall apart, at 36 degrees
/// faces at an edge are mixed up.
const SAME_NORMAL: f32 = 0.95;
/// A point is of the surface of a pixel if its distance from the tangent plane there is below this share of the
/// depth, which is about the size of a pixel. Half of it breaks curved surfaces up, double of it mixes up thin
/// layers.
const SAME_PLANE: f32 = 2e-3;

/// The geometry of all pixels.
pub type GeometryBuffers = Image<PixelGeometry>;

impl PixelGeometry {
    /// A pixel without a surface.
    pub const EMPTY: Self = Self {
        object: NOTHING,
        group: NOTHING,
        depth: f32::INFINITY,
        normal: Vec3::ZERO,
        tangent: Vec3::ZERO,
        uv: Vec2::ZERO,
        front: true,
    };

    /// Whether a point of `object`, with its unit `normal` and `away` from the point that the pixel shows, metres, is of the
    /// same surface.
    pub fn shows(&self, object: u32, normal: Vec3, away: Vec3) -> bool {
        self.object == object
            && self.normal.dot(normal) > SAME_NORMAL
            && away.dot(self.normal).abs() < SAME_PLANE * self.depth
    }
}

impl Tracer {
    /// The first surface behind the centre of every pixel.
    pub fn geometry(&self, camera: &Camera, width: usize, height: usize) -> GeometryBuffers {
        let at = |index: usize| {
            let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            let direction = camera.direction(x, y, width, height);
            let ray = Ray::new(camera.start(direction), direction);
            self.surface(&ray).map_or(PixelGeometry::EMPTY, |surface| PixelGeometry {
                object: surface.object,
                group: surface.group,
                depth: (surface.point - camera.origin()).length(),
                normal: surface.mesh_normal,
                tangent: surface.frame.tangent,
                uv: surface.uv,
                front: surface.front,
            })
        };
        let pixels = (0..width * height).into_par_iter().map(at).collect();
        Image::new(width, height, pixels)
    }
}
