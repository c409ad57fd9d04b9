//! How rays find triangles: a small interface, and one tree behind it.
//!
//! The interface is [`Accel::closest`] and [`Accel::occluded`]; nobody outside this module knows
//! what stands behind them. The tree is built by `obvhs` and walked four boxes at a time with a
//! watertight triangle test (`woop`): a ray that meets an edge or a vertex of a closed mesh
//! never slips through. The vectors are glam's, hence SSE2 or NEON without any unsafe code.

mod bvh4;
mod woop;

pub(crate) use woop::front_normal;
pub use woop::offset;

pub use bvh4::Accel;

use glam::Vec3;

/// A half line from `origin` along the unit vector `direction`, up to the distance `t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Unit vector along it.
    pub direction: Vec3,
    /// Only what is nearer than this is met; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub t: f32,
    /// The triangle, counted over the whole scene.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: [f32; 2],
}
