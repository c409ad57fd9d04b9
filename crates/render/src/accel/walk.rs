//! The way of a ray through the tree, near boxes first.
//!
//! Written once for all processors: what tests the boxes of a node is a parameter, `Boxes`, and
//! everything is inlined into the function that chooses it.

use super::tree::{Link, Node, Tree, WIDTH};
use super::woop::ShearedRay;
use super::{Hit, Ray, build};
use glam::Vec4;
use std::mem::MaybeUninit;

/// Widens the far side of the slab test by more than its rounding error (Ize 2013).
const ROUNDING: f32 = 1.0 + 2.0 * 3.0 * f32::EPSILON;
/// Each level leaves at most seven children behind; below `DEPTH_MAX` levels each divides the
/// triangles by eight, of which there are fewer than 2^31.
const STACK: usize = (WIDTH - 1) * (build::DEPTH_MAX + 11);

/// Tests the eight boxes of a node against one ray.
pub(super) trait Boxes {
    /// A ray made ready, from its origin, the inverse of its direction for near and for far sides of
    /// boxes, and for each axis which side it meets first.
    fn new(origin: [f32; 3], inverse: [[f32; 3]; 2], near: [usize; 3]) -> Self;

    /// Where the ray enters each box, and a bit for each box that it does enter before `t_max`.
    fn enter(&self, node: &Node, t_max: f32) -> (Lanes, u32);

    /// Tells the processor that what is behind `link` will be wanted soon.
    fn fetch(tree: &Tree, link: Link);
}

/// One number a child. Where this crossed a line of the cache, as it may wherever the system happens
/// to put the stack, a ray would take half as long again.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f32; WIDTH]);

/// The walk for any processor.
pub(super) fn portable<const ANY: bool>(tree: &Tree, ray: &Ray) -> Option<Hit> {
    walk::<Slabs, ANY>(tree, ray)
}

/// What is said of a triangle of which was only asked whether there is one.
const SOMETHING: Hit = Hit { t: 0.0, triangle: 0, barycentric: [0.0; 2] };

/// The nearest triangle along the ray, or with `ANY` only whether there is one.
#[inline(always)]
pub(super) fn walk<B: Boxes, const ANY: bool>(tree: &Tree, ray: &Ray) -> Option<Hit> {
    let boxes = boxes::<B>(ray);
    let sheared = ShearedRay::new(ray);
    let mut t_max = ray.t_max;
    let mut best = None;
    let mut stack = Stack::new();
    let mut depth = 0;
    let mut link = Link::ROOT;
    loop {
        if link.is_leaf() {
            for block in &tree.blocks[link.blocks()] {
                if ANY {
                    if block.is_met(&sheared, t_max) {
                        return Some(SOMETHING);
                    }
                } else if let Some(hit) = block.nearest(&sheared, t_max) {
                    t_max = hit.t;
                    best = Some(hit);
                }
            }
        } else {
            let node = &tree.nodes[link.0 as usize];
            let (enter, entered) = boxes.enter(node, t_max);
            if entered != 0 {
                (depth, link) =
                    stack.push_but_nearest(depth, &node.children, (&enter, entered), |link| {
                        B::fetch(tree, link);
                    });
                continue;
            }
        }
        match stack.pop(depth, t_max) {
            Some(next) => (depth, link) = next,
            None => return best,
        }
    }
}

/// The ray as the box test wants it.
#[inline(always)]
fn boxes<B: Boxes>(ray: &Ray) -> B {
    // A direction of zero would make 0 * infinity; a huge finite slope does not.
    let direction = ray.direction.extend(1.0);
    let usable = direction.abs().cmpgt(Vec4::splat(1e-18));
    let steep = Vec4::splat(1e18).copysign(direction);
    let inverse = Vec4::select(usable, direction.recip(), steep);
    let negative = inverse.is_negative_bitmask() as usize;
    let [x, y, z, _] = inverse.to_array();
    let far = [x * ROUNDING, y * ROUNDING, z * ROUNDING];
    let near = [negative & 1, negative >> 1 & 1, negative >> 2 & 1];
    B::new(ray.origin.to_array(), [[x, y, z], far], near)
}

/// `array::map`, which the compiler leaves out of line: at this place that costs as much as a box.
#[inline(always)]
pub(super) fn three<T: Copy, U>([x, y, z]: [T; 3], f: impl Fn(T) -> U) -> [U; 3] {
    [f(x), f(y), f(z)]
}

/// What the ray has still to visit. An entry holds where the ray enters, a distance not below zero
/// whose bits are ordered as it is, over the link: one number to sort by.
struct Stack([MaybeUninit<u64>; STACK]);

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        // Setting 2 kB to zero would take as long as a short ray.
        Self([const { MaybeUninit::uninit() }; STACK])
    }

    /// Entry number `index`, which must have been written.
    #[inline(always)]
    fn get(&self, index: usize) -> u64 {
        // SAFETY: callers ask below the depth, and all entries below it have been written.
        #[expect(unsafe_code, reason = "entries below the depth are written")]
        unsafe {
            self.0[index].assume_init()
        }
    }

    /// Puts all `children` that `entered` has a bit of, at least one, but the nearest onto the
    /// `depth` entries that are there, nearer ones higher up, and has them fetched. The new depth, and the
    /// nearest.
    #[inline(always)]
    fn push_but_nearest(
        &mut self,
        mut depth: usize,
        children: &[Link; WIDTH],
        (Lanes(enter), mut entered): (&Lanes, u32),
        fetch: impl Fn(Link),
    ) -> (usize, Link) {
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
            fetch(Link(far as u32));
            let mut at = depth;
            depth += 1;
            while at > base && self.get(at - 1) < far {
                self.0[at] = self.0[at - 1];
                at -= 1;
            }
            self.0[at].write(far);
        }
        (depth, Link(nearest as u32))
    }

    /// The nearest of the `depth` entries that the ray reaches, and the depth below it.
    #[inline(always)]
    fn pop(&self, mut depth: usize, t_max: f32) -> Option<(usize, Link)> {
        while depth > 0 {
            depth -= 1;
            let top = self.get(depth);
            if f32::from_bits((top >> 32) as u32) <= t_max {
                return Some((depth, Link(top as u32)));
            }
        }
        None
    }
}

/// Four boxes at a time by glam's vectors.
struct Slabs {
    origin: [Vec4; 3],
    inverse: [[Vec4; 3]; 2],
    near: [usize; 3],
}

impl Boxes for Slabs {
    #[inline(always)]
    fn new(origin: [f32; 3], inverse: [[f32; 3]; 2], near: [usize; 3]) -> Self {
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
    fn fetch(_: &Tree, _: Link) {}
}
