//! Eight boxes at a time by AVX2.
//!
//! What follows a distance is done in integers, which takes a quarter of the time: the bits of numbers
//! that are not negative are ordered as the numbers are, and a negative one is less than those either
//! way; which of two negative ones is less makes no difference to whether a box is entered. (Minus
//! zero is one of those: a box that is left where the ray starts holds nothing that lies before it.)
//!
//! Intrinsics may only run on a processor that has them: all of this is reached through [`walk`],
//! which carries the feature, and which is called after [`is_there`] has said so. What it calls is
//! inlined into it.
#![expect(unsafe_code, reason = "AVX2 is reached through intrinsics and functions that carry it")]

use super::tree::{Link, Node, Tree, WIDTH};
use super::walk::{self, Boxes, Lanes, three};
use super::woop::Triangles4;
use super::{Hit, Ray};
use std::arch::x86_64::{
    __m256, _MM_HINT_T0, _mm_prefetch, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_cmpgt_epi32, _mm256_loadu_ps, _mm256_max_epi32, _mm256_min_epi32, _mm256_movemask_ps,
    _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_si256, _mm256_storeu_si256, _mm256_sub_ps,
};

/// Whether this processor has what [`walk`] needs.
pub(super) fn is_there() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1")
}

/// The nearest triangle along the ray, or with `ANY` only whether there is one.
///
/// # Safety
/// The processor must have the features: [`is_there`].
#[target_feature(enable = "avx2,bmi1")]
pub(super) unsafe fn walk<const ANY: bool>(tree: &Tree, ray: &Ray) -> Option<Hit> {
    walk::walk::<Slabs8, ANY>(tree, ray)
}

struct Slabs8 {
    origin: [__m256; 3],
    inverse: [[__m256; 3]; 2],
    near: [usize; 3],
}

impl Boxes for Slabs8 {
    #[inline(always)]
    fn new(origin: [f32; 3], inverse: [[f32; 3]; 2], near: [usize; 3]) -> Self {
        // SAFETY: inlined into `walk`, which runs only where AVX2 is.
        let splat = |x| unsafe { _mm256_set1_ps(x) };
        let inverse = [three(inverse[0], splat), three(inverse[1], splat)];
        Self { origin: three(origin, splat), inverse, near }
    }

    #[inline(always)]
    fn enter(&self, node: &Node, t_max: f32) -> (Lanes, u32) {
        // SAFETY: inlined into `walk`, which runs only where AVX2 is; eight floats are read from
        // arrays of eight, and written to one.
        unsafe {
            let side = |axis: usize, far: usize| {
                let bounds = &node.bounds[axis][self.near[axis] ^ far];
                let bounds = _mm256_loadu_ps(bounds.as_ptr());
                let distance = _mm256_sub_ps(bounds, self.origin[axis]);
                _mm256_castps_si256(_mm256_mul_ps(distance, self.inverse[far][axis]))
            };
            let enter = _mm256_max_epi32(
                _mm256_max_epi32(side(0, 0), side(1, 0)),
                _mm256_max_epi32(side(2, 0), _mm256_setzero_si256()),
            );
            let end = _mm256_castps_si256(_mm256_set1_ps(t_max));
            let leave = _mm256_min_epi32(
                _mm256_min_epi32(side(0, 1), side(1, 1)),
                _mm256_min_epi32(side(2, 1), end),
            );
            let outside = _mm256_castsi256_ps(_mm256_cmpgt_epi32(enter, leave));
            let inside = !_mm256_movemask_ps(outside) & 0xff;
            let mut enters = Lanes([0.0; WIDTH]);
            _mm256_storeu_si256(enters.0.as_mut_ptr().cast(), enter);
            (enters, inside as u32)
        }
    }

    #[inline(always)]
    fn fetch(tree: &Tree, link: Link) {
        let (start, bytes) = if link.is_leaf() {
            let first = link.blocks().start;
            (tree.blocks.as_ptr().wrapping_add(first).cast::<i8>(), size_of::<Triangles4>())
        } else {
            let index = link.0 as usize;
            (tree.nodes.as_ptr().wrapping_add(index).cast(), size_of::<Node>())
        };
        for line in (0..bytes).step_by(64) {
            // SAFETY: a prefetch is a hint, which is allowed at any address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line)) };
        }
    }
}
