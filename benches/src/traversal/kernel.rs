//! The kernels that find triangles: the same query to each program.

use glam::Vec3;
use std::hint::black_box;
use unrender::render::accel::{Accel, Ray};

/// A program that has made its tree.
pub(crate) trait Kernel: Sync {
    /// For each ray the distance to the nearest triangle; infinite where there is none.
    fn closest(&self, rays: &[Ray], distances: &mut [f32]);

    /// For each ray zero if it is blocked, otherwise infinity.
    fn occluded(&self, rays: &[Ray], distances: &mut [f32]);
}

/// unrender's tree.
pub(crate) struct Ours(Accel);

impl Ours {
    /// Makes the tree over `triangles`.
    pub(crate) fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self(Accel::build(triangles))
    }
}

impl Kernel for Ours {
    fn closest(&self, rays: &[Ray], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            // The other program also returns the triangle and the place on it.
            let hit = black_box(self.0.closest(ray));
            *distance = hit.map_or(f32::INFINITY, |hit| hit.t);
        }
    }

    fn occluded(&self, rays: &[Ray], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            *distance = if self.0.occluded(ray) { 0.0 } else { f32::INFINITY };
        }
    }
}
