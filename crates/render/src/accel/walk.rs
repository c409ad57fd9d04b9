//! Traversal of the 8-wide tree, nearest box first, with a stack of children still to visit.
//!
//! The traversal is written once. The box test is a parameter, [`Boxes`]; everything is inlined
//! into the function that chooses it. The slab test is that of [Kay and Kajiya 1986], with the far
//! side widened by its rounding error [Ize 2013].

use super::tree::{ChildRef, Node, Tree, WIDTH};
use super::woop::{ShearedRay, three};
use super::{Hit, Ray, build};
use glam::Vec4;
use std::mem::MaybeUninit;

/// Widens the far side of the slab test by twice its rounding error, `1 + 2 gamma(3)` of [Ize
/// 2013]. With a quarter of the margin rays may miss boxes; double of it visits a few more boxes.
const ROUNDING: f32 = 1.0 + 2.0 * 3.0 * f32::EPSILON;
/// Entries of the stack. Each level leaves at most seven children behind. Below `DEPTH_MAX` each
/// level divides the triangles by eight, of which there are fewer than 2^31: eleven levels.
const STACK: usize = (WIDTH - 1) * (build::DEPTH_MAX + 11);

/// What the slab test needs of a ray.
pub(super) struct RaySlabs {
    pub(super) origin: [f32; 3],
    /// The inverse of the direction, for the near and for the far sides of boxes.
    pub(super) inverse: [[f32; 3]; 2],
    /// For each axis the side of boxes that the ray meets first.
    pub(super) near: [usize; 3],
}

/// The test of the eight boxes of a node against one ray.
pub(super) trait Boxes {
    /// Proof that the processor has the instructions of this test.
    type Proof: Copy;

    /// Prepares a ray.
    fn new(proof: Self::Proof, ray: RaySlabs) -> Self;

    /// Where the ray enters each box, and a bit for each box that it enters before `t_max`.
    fn enter(&self, node: &Node, t_max: f32) -> (Lanes, u32);

    /// Loads `child` into the cache, since the traversal visits it soon.
    fn prefetch(tree: &Tree, child: ChildRef);
}

/// One number per child, aligned so that it never crosses a cache line: with the alignment of `f32`
/// a ray took half as long again where the stack frame happened to make it cross one.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f32; WIDTH]);

/// The traversal for any processor.
pub(super) fn portable<const ANY: bool>(tree: &Tree, ray: &Ray) -> Option<Hit> {
    walk::<Slabs, ANY>((), tree, ray)
}

/// The hit that a query for any hit returns: callers only ask whether there is one.
const ANY_HIT: Hit = Hit { t: 0.0, triangle: 0, barycentric: [0.0; 2] };

/// The nearest triangle along the ray, or with `ANY` only whether there is one.
#[inline(always)]
#[expect(unsafe_code, reason = "the stack is not initialised beyond its depth")]
pub(super) fn walk<B: Boxes, const ANY: bool>(
    proof: B::Proof,
    tree: &Tree,
    ray: &Ray,
) -> Option<Hit> {
    let boxes = boxes::<B>(proof, ray);
    let sheared = ShearedRay::new(ray);
    let mut t_max = ray.t_max;
    let mut best = None;
    let mut stack = Stack::new();
    // The number of entries of `stack` that were written: it changes only by what
    // `push_but_nearest` and `pop` return.
    let mut depth = 0;
    let mut child = ChildRef::ROOT;
    loop {
        if child.is_leaf() {
            for block in &tree.blocks[child.blocks()] {
                if ANY {
                    if block.is_met(&sheared, t_max) {
                        return Some(ANY_HIT);
                    }
                } else if let Some(hit) = block.nearest(&sheared, t_max) {
                    t_max = hit.t;
                    best = Some(hit);
                }
            }
        } else {
            let node = &tree.nodes[child.0 as usize];
            let (enter, entered) = boxes.enter(node, t_max);
            if entered != 0 {
                let prefetch = |child| B::prefetch(tree, child);
                let entered = (&enter, entered);
                // SAFETY: the entries below `depth` were written.
                (depth, child) =
                    unsafe { stack.push_but_nearest(depth, &node.children, entered, prefetch) };
                continue;
            }
        }
        // SAFETY: the entries below `depth` were written.
        match unsafe { stack.pop(depth, t_max) } {
            Some(next) => (depth, child) = next,
            None => return best,
        }
    }
}

/// Prepares the ray for the box test.
#[inline(always)]
fn boxes<B: Boxes>(proof: B::Proof, ray: &Ray) -> B {
    // A direction of zero would give 0 * infinity, which is no number; a huge finite slope does
    // not.
    let direction = ray.direction.extend(1.0);
    let usable = direction.abs().cmpgt(Vec4::splat(1e-18));
    let steep = Vec4::splat(1e18).copysign(direction);
    let inverse = Vec4::select(usable, direction.recip(), steep);
    let negative = inverse.is_negative_bitmask() as usize;
    let [x, y, z, _] = inverse.to_array();
    let far = [x * ROUNDING, y * ROUNDING, z * ROUNDING];
    let near = [negative & 1, negative >> 1 & 1, negative >> 2 & 1];
    let origin = ray.origin.to_array();
    B::new(proof, RaySlabs { origin, inverse: [[x, y, z], far], near })
}

/// The children that the ray has still to visit. An entry holds the entry distance, which is not
/// negative, in its upper 32 bits and the child in its lower ones; entries compare as distances do.
///
/// The caller keeps the depth, in a register. Entries at and beyond it may be uninitialised.
struct Stack([MaybeUninit<u64>; STACK]);

impl Stack {
    /// An empty stack. It is left uninitialised: clearing 2 kB takes as long as a short ray.
    #[inline(always)]
    fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; STACK])
    }

    /// Entry number `index`.
    ///
    /// # Safety
    /// The entry must have been written.
    #[inline(always)]
    #[expect(unsafe_code, reason = "the stack is not initialised beyond its depth")]
    unsafe fn get(&self, index: usize) -> u64 {
        // SAFETY: the caller promises that the entry was written.
        unsafe { self.0[index].assume_init() }
    }

    /// Pushes the `children` whose bit is set in `entered`, at least one, except the nearest,
    /// sorted so that nearer ones are popped first, and prefetches them. Returns the new depth,
    /// below which all entries are written, and the nearest child.
    ///
    /// # Safety
    /// All entries below `depth` must have been written.
    #[inline(always)]
    #[expect(unsafe_code, reason = "the stack is not initialised beyond its depth")]
    unsafe fn push_but_nearest(
        &mut self,
        mut depth: usize,
        children: &[ChildRef; WIDTH],
        (Lanes(enter), mut entered): (&Lanes, u32),
        prefetch: impl Fn(ChildRef),
    ) -> (usize, ChildRef) {
        let next = |entered: &mut u32| {
            let lane = entered.trailing_zeros() as usize % WIDTH;
            *entered &= *entered - 1;
            u64::from(enter[lane].to_bits()) << 32 | u64::from(children[lane].0)
        };
        let mut nearest = next(&mut entered);
        let base = depth;
        while entered != 0 {
            let other = next(&mut entered);
            let far = nearest.max(other);
            nearest = nearest.min(other);
            prefetch(ChildRef(far as u32));
            let mut at = depth;
            depth += 1;
            // SAFETY: `base <= at - 1 < at`, and this loop has written the entries from `base` up
            // to the old depth, which `at` starts from.
            while at > base && unsafe { self.get(at - 1) } < far {
                self.0[at] = self.0[at - 1];
                at -= 1;
            }
            self.0[at].write(far);
        }
        (depth, ChildRef(nearest as u32))
    }

    /// The topmost of the `depth` entries that the ray enters before `t_max`, and the depth below
    /// it.
    ///
    /// # Safety
    /// All entries below `depth` must have been written.
    #[inline(always)]
    #[expect(unsafe_code, reason = "the stack is not initialised beyond its depth")]
    unsafe fn pop(&self, mut depth: usize, t_max: f32) -> Option<(usize, ChildRef)> {
        while depth > 0 {
            depth -= 1;
            // SAFETY: the index is below the depth that the caller gave.
            let top = unsafe { self.get(depth) };
            if f32::from_bits((top >> 32) as u32) <= t_max {
                return Some((depth, ChildRef(top as u32)));
            }
        }
        None
    }
}

/// Four boxes at a time by glam's vectors: SSE2 on x86-64, NEON on ARM.
struct Slabs {
    origin: [Vec4; 3],
    inverse: [[Vec4; 3]; 2],
    near: [usize; 3],
}

impl Boxes for Slabs {
    type Proof = ();

    #[inline(always)]
    fn new((): (), RaySlabs { origin, inverse, near }: RaySlabs) -> Self {
        let inverse = [three(inverse[0], Vec4::splat), three(inverse[1], Vec4::splat)];
        Self { origin: three(origin, Vec4::splat), inverse, near }
    }

    #[inline(always)]
    fn enter(&self, node: &Node, t_max: f32) -> (Lanes, u32) {
        let mut enters = Lanes([0.0; WIDTH]);
        let mut entered = 0;
        for half in [0, 4] {
            let side = |axis: usize, far: usize| {
                let bounds = &node.bounds[axis][self.near[axis] ^ far];
                (Vec4::from_slice(&bounds[half..]) - self.origin[axis]) * self.inverse[far][axis]
            };
            let enter = side(0, 0).max(side(1, 0)).max(side(2, 0)).max(Vec4::ZERO);
            let leave = side(0, 1).min(side(1, 1)).min(side(2, 1));
            let inside = enter.cmple(leave.min(Vec4::splat(t_max)));
            entered |= inside.bitmask() << half;
            enter.write_to_slice(&mut enters.0[half..]);
        }
        (enters, entered)
    }

    #[inline(always)]
    fn prefetch(_: &Tree, _: ChildRef) {}
}
