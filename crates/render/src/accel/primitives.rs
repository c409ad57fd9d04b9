//! The boxes that the binary builder clusters: one per triangle, but one for each large stack of
//! triangles with equal boxes, and all scaled so that areas are finite.
//!
//! *Coincident boxes.* PLOC merges two neighbours only where each is the other's best partner.
//! Among `n` equal boxes all costs are equal, a pass merges one pair, and the build takes `O(n^2)`
//! steps. A stack of more than [`LEAF_MAX`] equal boxes therefore becomes one primitive; the
//! collapse splits it by index. No stack that PLOC sees is larger than a leaf, so passes merge at
//! least one of [`LEAF_MAX`] boxes of a stack. Smaller stacks, such as the two halves of an upright
//! quad, stay apart: their trees are those of PLOC.
//!
//! *Huge boxes.* The surface area of a box of side 2e19 exceeds the largest number of single
//! precision, and the builder compares infinite costs. Boxes of scenes larger than [`EXTENT_MAX`]
//! are scaled by a power of two, which is exact. Other scenes are not scaled. Boxes whose areas
//! underflow to zero beside a huge one have equal costs, too, and become one primitive.

use super::tree::LEAF_MAX;
use glam::{Vec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use std::ops::Range;

/// Largest coordinate of boxes whose areas are compared, 2^48 (in metres: 1 900 light minutes). An
/// area is below 2^99 then, and the sum of the costs of 2^24 such boxes below the largest number.
/// At 2^60 that sum could overflow; at 2^24 ordinary scenes in millimetres would be scaled.
const EXTENT_MAX: f32 = (1u64 << 48) as f32;

/// What the binary builder sees of a scene.
pub(super) struct Primitives {
    /// The triangles in the order of their primitives.
    order: Vec<u32>,
    /// For each primitive: its triangles, a range of `order`.
    ranges: Vec<Range<u32>>,
    /// For each primitive: the box around its triangles, scaled.
    bounds: Vec<Aabb>,
    /// The power of two that boxes were multiplied with.
    scale: f32,
}

/// A box in the type that the builder takes.
pub(super) struct Bounded(Aabb);

impl Boundable for Bounded {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Primitives {
    /// Of `triangles`, at least one.
    pub(super) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let largest = triangles.iter().flatten().fold(0.0, |max, p| p.abs().max_element().max(max));
        let scale = scale(largest);
        let boxes: Vec<Aabb> = triangles.iter().map(|t| scaled_box(t, scale)).collect();
        let stacks = stacks(&boxes);
        let mut stacked = vec![false; if stacks.is_empty() { 0 } else { boxes.len() }];
        stacks.iter().flatten().for_each(|&triangle| stacked[triangle as usize] = true);
        let is_single = |triangle: &u32| stacked.is_empty() || !stacked[*triangle as usize];
        let mut order: Vec<u32> = (0..boxes.len() as u32).filter(is_single).collect();
        let mut ranges: Vec<Range<u32>> = (0..order.len() as u32).map(|i| i..i + 1).collect();
        let mut bounds: Vec<Aabb> = order.iter().map(|&i| boxes[i as usize]).collect();
        for stack in stacks {
            let first = order.len() as u32;
            order.extend(&stack);
            ranges.push(first..order.len() as u32);
            let union = |all: Aabb, &triangle: &u32| all.union(&boxes[triangle as usize]);
            bounds.push(stack.iter().fold(Aabb::empty(), union));
        }
        Self { order, ranges, bounds, scale }
    }

    /// The boxes to cluster.
    pub(super) fn bounded(&self) -> Vec<Bounded> {
        self.bounds.iter().copied().map(Bounded).collect()
    }

    /// The triangles of a primitive.
    pub(super) fn triangles(&self, primitive: u32) -> &[u32] {
        let range = &self.ranges[primitive as usize];
        &self.order[range.start as usize..range.end as usize]
    }

    /// A scaled box in the scene's units. Powers of two cancel without rounding.
    pub(super) fn unscaled(&self, bounds: Aabb) -> [Vec3; 2] {
        let inverse = 1.0 / self.scale;
        [Vec3::from(bounds.min) * inverse, Vec3::from(bounds.max) * inverse]
    }
}

/// The power of two that brings the coordinate `largest` down to [`EXTENT_MAX`]; one if it is less.
fn scale(largest: f32) -> f32 {
    let mut scale = 1.0;
    while largest * scale > EXTENT_MAX {
        scale *= 0.5;
    }
    scale
}

fn scaled_box(triangle: &[Vec3; 3], scale: f32) -> Aabb {
    Aabb::from_points(&triangle.map(|corner| Vec3A::from(corner * scale)))
}

/// The triangles of each set of more than [`LEAF_MAX`] equal boxes, in the order of their indices;
/// all boxes without an area count as equal.
fn stacks(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let key = |triangle: &u32| {
        let bounds = boxes[*triangle as usize];
        let Aabb { min, max } = if bounds.half_area() > 0.0 { bounds } else { Aabb::default() };
        [min.x, min.y, min.z, max.x, max.y, max.z].map(f32::to_bits)
    };
    let mut sorted: Vec<u32> = (0..boxes.len() as u32).collect();
    sorted.sort_unstable_by_key(|triangle| (key(triangle), *triangle));
    let equal = sorted.chunk_by(|a, b| key(a) == key(b));
    equal.filter(|stack| stack.len() > LEAF_MAX).map(<[u32]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    /// The largest number of equal boxes bounds the passes of PLOC, each of linear cost.
    #[test]
    fn the_builder_sees_few_boxes_in_one_place() {
        for count in [33, 20_000] {
            let primitives = Primitives::new(&vec![TRIANGLE; count]);
            assert_eq!(primitives.bounded().len(), 1);
            assert_eq!(primitives.triangles(0).len(), count);
        }
        let at = |i: u32| TRIANGLE.map(|p| p + (i % 7) as f32 * Vec3::Z);
        let triangles: Vec<_> = (0..7000).map(at).collect();
        let primitives = Primitives::new(&triangles);
        assert_eq!(primitives.bounded().len(), 7);
        let mut all: Vec<u32> = (0..7).flat_map(|i| primitives.triangles(i).to_vec()).collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..7000));
    }

    #[test]
    fn boxes_whose_areas_underflow_are_one_primitive() {
        let at = |i: u32| TRIANGLE.map(|p| p + i as f32 * Vec3::Z);
        let mut triangles: Vec<_> = (0..7000).map(at).collect();
        triangles.push(TRIANGLE.map(|p| f32::MAX * p));
        let primitives = Primitives::new(&triangles);
        assert_eq!(primitives.bounded().len(), 2);
        assert_eq!(primitives.triangles(1).len(), 7000);
    }

    #[test]
    fn small_stacks_and_other_scenes_stay_as_they_are() {
        let mut triangles = vec![TRIANGLE; LEAF_MAX];
        triangles.push(TRIANGLE.map(|p| 1e6 * p));
        let primitives = Primitives::new(&triangles);
        assert_eq!(primitives.bounded().len(), triangles.len());
        for (index, triangle) in triangles.iter().enumerate() {
            assert_eq!(primitives.triangles(index as u32), [index as u32]);
            let bounds = primitives.bounded()[index].aabb();
            assert_eq!(bounds, Aabb::from_points(&triangle.map(Vec3A::from)));
        }
    }

    #[test]
    fn huge_boxes_have_finite_areas_and_come_back_to_the_bit() {
        for size in [2e19, f32::MAX] {
            let huge = [size * Vec3::NEG_ONE, size * Vec3::X, size * Vec3::ONE];
            let primitives = Primitives::new(&[TRIANGLE, huge]);
            let bounds = primitives.bounded()[1].aabb();
            assert!(bounds.half_area().is_finite() && bounds.half_area() > 0.0);
            assert_eq!(primitives.unscaled(bounds), [size * Vec3::NEG_ONE, size * Vec3::ONE]);
        }
    }
}
