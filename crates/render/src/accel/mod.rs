//! How rays find triangles: a small interface, and one tree behind it.
//!
//! The interface is [`Accel::closest`] and [`Accel::occluded`], and for what stands between one point
//! and many `Accel::between` (`shaft`); nobody outside this module knows what stands behind them. The
//! binary tree of `obvhs` is collapsed to eight boxes a node (`build`) and walked with a watertight
//! triangle test (`woop`): a ray that meets an edge or a vertex of a closed mesh never slips through.
//! The walk (`walk`) is written once; eight boxes are tested by AVX2 where the processor has it
//! (`avx2`) and four at a time by glam's vectors, SSE2 or NEON, elsewhere. Both find the same bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod build;
mod shaft;
mod tree;
mod walk;
mod woop;

pub(crate) use shaft::{Between, Bundle};
pub(crate) use woop::front_normal;
pub use woop::offset;

use glam::Vec3;
use tree::Tree;

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

/// Finds the triangles that rays meet.
#[derive(Debug)]
pub struct Accel {
    tree: Tree,
    bounds: [Vec3; 2],
    kernel: Kernel,
}

/// What tests the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kernel {
    Portable,
    /// Chosen only where the processor has AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Kernel {
    /// The fastest that this processor has.
    fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if avx2::is_there() {
            return Self::Avx2;
        }
        Self::Portable
    }
}

impl Accel {
    /// Builds the tree over all triangles of a scene; there must be one at least.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        let (tree, bounds) = build::build(triangles);
        Self { tree, bounds, kernel: Kernel::best() }
    }

    /// The lower and upper corner of the box around everything.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// The nearest triangle along the ray, from either side.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.walk::<false>(ray)
    }

    /// Whether anything stands on the ray before its end.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.walk::<true>(ray).is_some()
    }

    /// The nearest triangle, or with `ANY` only whether there is one.
    #[inline]
    fn walk<const ANY: bool>(&self, ray: &Ray) -> Option<Hit> {
        match self.kernel {
            Kernel::Portable => walk::portable::<ANY>(&self.tree, ray),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this kernel is chosen only where `avx2::is_there`.
            #[expect(unsafe_code, reason = "AVX2 is used after it was looked for")]
            Kernel::Avx2 => unsafe { avx2::walk::<ANY>(&self.tree, ray) },
        }
    }
}

#[cfg(test)]
mod tests;
