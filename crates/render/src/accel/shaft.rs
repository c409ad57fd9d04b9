//! What may stand between one point and many: their segments asked at once.
//!
//! The segments from an apex to the points of a bundle lie in a shaft [Haines and Wallace, "Shaft
//! Culling for Efficient Ray-Cast Radiosity", 1991]. A box that no segment enters is left out with
//! all that it holds, by slabs with intervals for the directions [Boulos et al., "Geometric and
//! Arithmetic Culling Methods for Entire Ray Packets", 2006]. A triangle `a b c`, seen from the apex,
//! meets the segment to `q` if
//!
//! ```text
//! s (n . q) >= |v|  and  s (a x b . q), s (b x c . q), s (c x a . q) >= 0,
//! n = a x b + b x c + c x a,  v = a . (b x c),  s = sign v,
//! ```
//!
//! so it is left out if the greatest value of one of these over the bundle's box is too small. Most
//! shafts of a room hold nothing then, and none of their segments needs a ray; in others a few
//! triangles are left to ask.

use super::tree::{Link, Node, WIDTH};
use super::woop::{ShearedRay, Triangles4};
use super::{Accel, Ray};
use crate::lanes::{Vec3x4, cross, dot, dot_one};
use glam::{BVec4A, Vec3, Vec4};

/// More blocks of triangles than this are not worth asking one by one.
const FEW: usize = 8;
/// Nodes that wait to be visited; a shaft that has more of them in its way holds too much.
const STACK: usize = 64;
/// What rounding may do, relative.
const ROUNDING: f32 = 1e-6;

/// Points in a box that need not be upright.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bundle {
    low: Vec3,
    high: Vec3,
    centre: Vec3,
    /// From the centre to three sides.
    half: [Vec3; 3],
}

/// The triangles that may stand between a point and a bundle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Between {
    /// These blocks of triangles, maybe none.
    Blocks([u32; FEW], usize),
    /// Too many to say.
    Many,
}

impl Bundle {
    /// The box around `points`, flat along the unit vector `normal` if they are.
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
    /// What may stand between `apex` and the points of `bundle`.
    pub(crate) fn between(&self, apex: Vec3, bundle: &Bundle) -> Between {
        let shaft = Shaft::new(apex, bundle);
        let (mut blocks, mut count) = ([0; FEW], 0);
        let (mut stack, mut depth) = ([Link::ROOT; STACK], 1);
        while depth > 0 {
            depth -= 1;
            let link = stack[depth];
            if link.is_leaf() {
                for block in link.blocks() {
                    if shaft.may_meet(&self.tree.blocks[block]) {
                        if count == FEW {
                            return Between::Many;
                        }
                        blocks[count] = block as u32;
                        count += 1;
                    }
                }
                continue;
            }
            let node = &self.tree.nodes[link.0 as usize];
            let mut entered = shaft.enters(node);
            if depth + entered.count_ones() as usize > STACK {
                return Between::Many;
            }
            while entered != 0 {
                stack[depth] = node.children[entered.trailing_zeros() as usize % WIDTH];
                entered &= entered - 1;
                depth += 1;
            }
        }
        Between::Blocks(blocks, count)
    }

    /// Whether one of the triangles that stand `between` stands on the ray before its end.
    pub(crate) fn occluded_among(&self, between: &Between, ray: &Ray) -> bool {
        match between {
            Between::Many => self.occluded(ray),
            Between::Blocks(_, 0) => false,
            Between::Blocks(blocks, count) => {
                let sheared = ShearedRay::new(ray);
                let mut blocks = blocks[..*count].iter();
                let block = |index: &u32| &self.tree.blocks[*index as usize];
                blocks.any(|index| block(index).is_met(&sheared, ray.t_max))
            }
        }
    }
}

/// The segments from an apex to a bundle.
struct Shaft {
    apex: Vec3,
    /// The box around them.
    low: Vec3,
    high: Vec3,
    /// For each axis: on which side boxes are entered, and what turns the distance of that side and
    /// of the other into the first and the last place that a segment can be in the box.
    slabs: [Slab; 3],
    /// The bundle's centre and half sides, seen from the apex.
    centre: Vec3,
    half: [Vec3; 3],
}

/// Along one axis.
#[derive(Clone, Copy)]
struct Slab {
    near: usize,
    enter: f32,
    leave: f32,
    /// One where segments go both ways, so that the axis says nothing.
    always: f32,
}

impl Slab {
    /// For segments whose extents along the axis are from `low` to `high`.
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

    /// A bit for each child of a node that segments may enter.
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

    /// Whether a segment may meet one of the four triangles.
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
        // The greatest value over the bundle of its product with a vector, and what rounding may add.
        let greatest = |vector: Vec3x4| {
            let centre = dot_one(vector, self.centre) * sign;
            let reach = |half: Vec3| dot_one(vector, half).abs();
            let reach = reach(self.half[0]) + reach(self.half[1]) + reach(self.half[2]);
            (centre + reach) + (centre.abs() + reach) * ROUNDING
        };
        let mut meets = greatest(normal).cmpge(volume.abs());
        for edge in edges {
            meets &= greatest(edge).cmpge(Vec4::ZERO);
        }
        meets.any()
    }
}
