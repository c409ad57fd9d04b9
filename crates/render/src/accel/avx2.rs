//! The test of eight boxes at once by AVX2.
//!
//! After the distances are known, minima, maxima and comparisons are done on their bits as
//! integers, which takes a quarter of the time: for numbers of at least zero, bits are ordered as
//! the numbers are. The bits of a negative number, read as a signed integer, are less than those of
//! any number of at least zero; which of two negative numbers is less does not matter, since the
//! entry distance is raised to zero. (Minus zero counts as negative: a box whose far side lies at
//! the origin of the ray holds nothing in front of it.)
//!
//! The intrinsics are undefined on a processor without AVX2. A value of [`Avx2`] is the proof that
//! the processor has it: only [`Avx2::detect`] makes one, and every function here that uses the
//! intrinsics takes one, by itself or inside [`Slabs8`].
#![expect(unsafe_code, reason = "AVX2 intrinsics, behind the proof that the processor has AVX2")]

use super::tree::{ChildRef, Node, Tree, WIDTH};
use super::walk::{self, Boxes, Lanes, RaySlabs};
use super::woop::{Triangles4, three};
use super::{Hit, Ray};
use std::arch::x86_64::{
    __m256, _MM_HINT_T0, _mm_prefetch, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_cmpgt_epi32, _mm256_loadu_ps, _mm256_max_epi32, _mm256_min_epi32, _mm256_movemask_ps,
    _mm256_mul_ps, _mm256_set1_ps, _mm256_setzero_si256, _mm256_storeu_si256, _mm256_sub_ps,
};

/// Proof that this processor has AVX2 and BMI1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Avx2(());

impl Avx2 {
    /// Asks the processor.
    pub(super) fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1")).then_some(Self(()))
    }
}

/// The nearest triangle along the ray, or with `ANY` only whether there is one.
#[inline]
pub(super) fn walk<const ANY: bool>(proof: Avx2, tree: &Tree, ray: &Ray) -> Option<Hit> {
    // SAFETY: `proof` was made by `Avx2::detect`, so the processor has both features.
    unsafe { walk_with_features::<ANY>(proof, tree, ray) }
}

/// [`walk`], compiled for AVX2; all that it calls is inlined into it.
///
/// # Safety
/// The processor must have AVX2 and BMI1.
#[target_feature(enable = "avx2,bmi1")]
unsafe fn walk_with_features<const ANY: bool>(proof: Avx2, tree: &Tree, ray: &Ray) -> Option<Hit> {
    walk::walk::<Slabs8, ANY>(proof, tree, ray)
}

/// A ray for the test of eight boxes.
struct Slabs8 {
    origin: [__m256; 3],
    inverse: [[__m256; 3]; 2],
    near: [usize; 3],
    /// That this value exists means that the processor has AVX2.
    _proof: Avx2,
}

impl Boxes for Slabs8 {
    type Proof = Avx2;

    #[inline(always)]
    fn new(proof: Avx2, RaySlabs { origin, inverse, near }: RaySlabs) -> Self {
        // SAFETY: `proof` says that the processor has AVX2.
        let splat = |x| unsafe { _mm256_set1_ps(x) };
        let inverse = [three(inverse[0], splat), three(inverse[1], splat)];
        Self { origin: three(origin, splat), inverse, near, _proof: proof }
    }

    #[inline(always)]
    fn enter(&self, node: &Node, t_max: f32) -> (Lanes, u32) {
        // SAFETY: `_proof` says that the processor has AVX2. The loads read eight floats from
        // arrays of eight, the store writes eight floats to an array of eight; neither needs
        // alignment.
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
    fn prefetch(tree: &Tree, child: ChildRef) {
        let (start, bytes) = if child.is_leaf() {
            let first = child.blocks().start;
            (tree.blocks.as_ptr().wrapping_add(first).cast::<i8>(), size_of::<Triangles4>())
        } else {
            let index = child.0 as usize;
            (tree.nodes.as_ptr().wrapping_add(index).cast(), size_of::<Node>())
        };
        for line in (0..bytes).step_by(64) {
            // SAFETY: a prefetch is a hint, which is allowed at any address; x86-64 has SSE.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line)) };
        }
    }
}
