//! Ray intersection: a bounding volume hierarchy behind a small interface.
//!
//! The interface is [`Accel::closest`], [`Accel::occluded`], and `Accel::occluders` (`shaft`),
//! which bounds what may occlude the segments from one point to many. The structure behind it is
//! private to this module:
//!  - `primitives`, `degenerate` and `build`: the binary tree of `obvhs`, or of median splits where
//!    that would take quadratic time, collapsed to eight children per node;
//!  - `tree`: its memory layout;
//!  - `walk`: the traversal, written once, with two box tests: AVX2 (`avx2`), or glam's vectors of
//!    four (SSE2, NEON). Both give the same bits;
//!  - `woop`: the watertight triangle test [Woop et al. 2013]: no ray slips through an edge or a
//!    vertex of a closed mesh.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod build;
mod degenerate;
mod primitives;
mod shaft;
mod tree;
mod walk;
mod woop;

pub(crate) use shaft::{Bundle, Occluders};
pub use woop::clearance;
pub(crate) use woop::front_normal;

use glam::Vec3;
use tree::{Node, Tree};

/// A ray from `origin` along the unit vector `direction`, up to the distance `t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Unit vector along it.
    pub direction: Vec3,
    /// Hits at this distance or beyond do not count; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }
}

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub t: f32,
    /// The triangle's index in the scene.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: [f32; 2],
}

/// The acceleration structure over all triangles of a scene.
#[derive(Debug)]
pub struct Accel {
    tree: Tree,
    bounds: [Vec3; 2],
    kernel: Kernel,
}

/// The box test in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kernel {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
}

impl Kernel {
    /// The fastest one on this processor; without AVX2 if the variable `UNRENDER_AVX2` is 0, so that
    /// both can be compared.
    fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::env::var_os("UNRENDER_AVX2").is_none_or(|value| value != "0")
            && let Some(proof) = avx2::Avx2::detect()
        {
            return Self::Avx2(proof);
        }
        Self::Portable
    }
}

impl Accel {
    /// Builds the hierarchy over all of `triangles`, at least one.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        let ids: Vec<u32> = (0..triangles.len() as u32).collect();
        Self::of(triangles, &ids)
    }

    /// Builds the hierarchy over those of `triangles` with the indices `ids`, by which hits name them. Without any, no ray
    /// hits anything.
    pub(crate) fn of(triangles: &[[Vec3; 3]], ids: &[u32]) -> Self {
        let own: Vec<_> = ids.iter().map(|&id| triangles[id as usize]).collect();
        let (tree, bounds) = match own.is_empty() {
            true => (Tree { nodes: vec![Node::EMPTY], blocks: Vec::new() }, [Vec3::ZERO; 2]),
            false => build::build(&own, ids),
        };
        Self { tree, bounds, kernel: Kernel::best() }
    }

    /// The lower and upper corner of the bounding box of all triangles.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// The nearest intersection along the ray, from either side of triangles.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.walk::<false>(ray)
    }

    /// Whether any triangle intersects the ray before its end.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.walk::<true>(ray).is_some()
    }

    /// The nearest triangle, or with `ANY` only whether there is one.
    #[inline]
    fn walk<const ANY: bool>(&self, ray: &Ray) -> Option<Hit> {
        match self.kernel {
            Kernel::Portable => walk::portable::<ANY>(&self.tree, ray),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2(proof) => avx2::walk::<ANY>(proof, &self.tree, ray),
        }
    }
}

#[cfg(test)]
mod tests;
