//! Shaft culling: the triangles that may occlude the segments from one point, the apex, to a bundle
//! of points [Haines and Wallace 1991].
//!
//! All segments lie in a shaft. A box that no segment enters is culled with all that it holds, by a
//! slab test on the intervals of the segments' directions [Boulos et al. 2006]. With the apex as
//! origin, a triangle `a b c` intersects the segment to `q` if
//!
//! ```text
//! s (n . q) >= |v|  and  s (a x b . q), s (b x c . q), s (c x a . q) >= 0,
//! n = a x b + b x c + c x a,  v = a . (b x c),  s = sign v,
//! ```
//!
//! so it is culled if the maximum of one of these over the bundle's box is too small. In a room
//! most shafts are empty, and none of their segments needs a shadow ray; others hold a few
//! triangles.

use super::tree::{ChildRef, Node, WIDTH};
use super::woop::{ShearedRay, Triangles4};
use super::{Accel, Ray};
use crate::lanes::{Vec3x4, cross, dot, dot_one};
use glam::{BVec4A, Vec3, Vec4};

/// Most blocks of triangles that are tested one by one. With more a ray through the tree costs
/// less: it tests about as many blocks. Half of it sends more segments through the tree, double of
/// it tests long lists.
const FEW: usize = 8;
/// Entries of the traversal stack. A shaft that enters more nodes at once holds too many triangles
/// and is not refined.
const STACK: usize = 64;
/// Bound of the relative rounding error of the triangle test: about eight roundings of 6e-8 each,
/// doubled. Half of it might cull a triangle that a ray would find; double of it culls hardly less.
const ROUNDING: f32 = 1e-6;

/// Oriented bounding box of a set of points, with their axis-aligned one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bundle {
    low: Vec3,
    high: Vec3,
    centre: Vec3,
    /// The half axes of the oriented box.
    half: [Vec3; 3],
}

/// The triangles that may occlude the segments between a point and a bundle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Occluders {
    /// The first so many of these blocks of triangles; none if the count is zero.
    Blocks([u32; FEW], usize),
    /// Too many to list: ask the tree.
    Many,
}

impl Bundle {
    /// The bounds of `points`, with one axis along the unit vector `normal`.
    pub(crate) fn new(points: impl Iterator<Item = Vec3> + Clone, normal: Vec3) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        let axes = [x, y, normal];
        let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let around = |[low, high]: [Vec3; 2], p: Vec3| [low.min(p), high.max(p)];
        let [low, high] = points.clone().fold(nothing, around);
        let local = |p: Vec3| Vec3::from_array(axes.map(|axis| axis.dot(p)));
        let [from, to] = points.map(local).fold(nothing, around);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let centre = x * middle.x + y * middle.y + normal * middle.z;
        Self { low, high, centre, half: [x * half.x, y * half.y, normal * half.z] }
    }
}

impl Accel {
    /// What may occlude the segments between `apex` and the points of `bundle`.
    pub(crate) fn occluders(&self, apex: Vec3, bundle: &Bundle) -> Occluders {
        let shaft = Shaft::new(apex, bundle);
        let (mut blocks, mut count) = ([0; FEW], 0);
        let (mut stack, mut depth) = ([ChildRef::ROOT; STACK], 1);
        while depth > 0 {
            depth -= 1;
            let child = stack[depth];
            if child.is_leaf() {
                for block in child.blocks() {
                    if shaft.may_meet(&self.tree.blocks[block]) {
                        if count == FEW {
                            return Occluders::Many;
                        }
                        blocks[count] = block as u32;
                        count += 1;
                    }
                }
                continue;
            }
            let node = &self.tree.nodes[child.0 as usize];
            let mut entered = shaft.enters(node);
            if depth + entered.count_ones() as usize > STACK {
                return Occluders::Many;
            }
            while entered != 0 {
                stack[depth] = node.children[entered.trailing_zeros() as usize % WIDTH];
                entered &= entered - 1;
                depth += 1;
            }
        }
        Occluders::Blocks(blocks, count)
    }

    /// Whether one of `occluders` intersects the ray before its end.
    pub(crate) fn occluded_among(&self, occluders: &Occluders, ray: &Ray) -> bool {
        match occluders {
            Occluders::Many => self.occluded(ray),
            Occluders::Blocks(_, 0) => false,
            Occluders::Blocks(blocks, count) => {
                let sheared = ShearedRay::new(ray);
                let mut blocks = blocks[..*count].iter();
                let block = |index: &u32| &self.tree.blocks[*index as usize];
                blocks.any(|index| block(index).is_met(&sheared, ray.t_max))
            }
        }
    }
}

/// The set of segments from an apex to a bundle.
struct Shaft {
    apex: Vec3,
    /// Its bounding box.
    low: Vec3,
    high: Vec3,
    /// The slab test of each axis.
    slabs: [Slab; 3],
    /// Centre, relative to the apex, and half axes of the bundle's box.
    centre: Vec3,
    half: [Vec3; 3],
}

/// The slab test of one axis: factors that turn the distances of a box's near and far side from the
/// apex into bounds of the segment parameter, 0 at the apex and 1 at the bundle.
#[derive(Clone, Copy)]
struct Slab {
    /// The side of boxes that segments meet first.
    near: usize,
    enter: f32,
    leave: f32,
    /// One where directions have both signs, so that the axis bounds nothing; else zero.
    always: f32,
}

impl Slab {
    /// For segments whose extents along the axis lie between `low` and `high`.
    fn new(low: f32, high: f32) -> Self {
        const LEAST: f32 = 1e-18;
        if low > LEAST {
            Self { near: 0, enter: 1.0 / high, leave: 1.0 / low, always: 0.0 }
        } else if high < -LEAST {
            Self { near: 1, enter: 1.0 / low, leave: 1.0 / high, always: 0.0 }
        } else {
            Self { near: 0, enter: 0.0, leave: 0.0, always: 1.0 }
        }
    }
}

impl Shaft {
    fn new(apex: Vec3, bundle: &Bundle) -> Self {
        let (from, to) = ((bundle.low - apex).to_array(), (bundle.high - apex).to_array());
        Self {
            apex,
            low: apex.min(bundle.low),
            high: apex.max(bundle.high),
            slabs: [0, 1, 2].map(|axis| Slab::new(from[axis], to[axis])),
            centre: bundle.centre - apex,
            half: bundle.half,
        }
    }

    /// A bit for each child of a node that a segment may enter.
    fn enters(&self, node: &Node) -> u32 {
        let mut bits = 0;
        for part in [0, 4] {
            let mut first = Vec4::ZERO;
            let mut last = Vec4::ONE;
            let mut overlaps = BVec4A::from_array([true; 4]);
            for axis in 0..3 {
                let side = |side: usize| Vec4::from_slice(&node.bounds[axis][side][part..]);
                let Slab { near, enter, leave, always } = self.slabs[axis];
                let apex = Vec4::splat(self.apex[axis]);
                first = first.max((side(near) - apex) * enter);
                last = last.min((side(near ^ 1) - apex) * leave + always);
                overlaps &= side(0).cmple(Vec4::splat(self.high[axis]));
                overlaps &= side(1).cmpge(Vec4::splat(self.low[axis]));
            }
            let entered = overlaps & first.cmple(last * (1.0 + 8.0 * f32::EPSILON));
            bits |= entered.bitmask() << part;
        }
        bits
    }

    /// Whether a segment may intersect one of the four triangles.
    fn may_meet(&self, block: &Triangles4) -> bool {
        let corner = |corner: usize| {
            let [x, y, z] = block.corner(corner);
            [x - self.apex.x, y - self.apex.y, z - self.apex.z]
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let edges = [cross(a, b), cross(b, c), cross(c, a)];
        let normal = [0, 1, 2].map(|i| edges[0][i] + edges[1][i] + edges[2][i]);
        let volume = dot(a, edges[1]);
        let sign = Vec4::ONE.copysign(volume);
        // The maximum over the bundle of the product with a vector, plus the rounding error.
        let maximum = |vector: Vec3x4| {
            let centre = dot_one(vector, self.centre) * sign;
            let reach = |half: Vec3| dot_one(vector, half).abs();
            let reach = reach(self.half[0]) + reach(self.half[1]) + reach(self.half[2]);
            (centre + reach) + (centre.abs() + reach) * ROUNDING
        };
        let mut hits = maximum(normal).cmpge(volume.abs());
        for edge in edges {
            hits &= maximum(edge).cmpge(Vec4::ZERO);
        }
        hits.any()
    }
}
