//! Inputs that take quadratic time in the binary builder, and a builder of bounded time for them.
//!
//! PLOC merges two clusters only where each is the other's best partner. A row of equal boxes at
//! equal distances has ties everywhere, and each pass merges one pair. Reinsertion searches the
//! nodes that a node could join at little cost: where all triangles lie in one place it visits the
//! whole tree for each node.
//!
//! [`is_degenerate`] counts both on samples of the input: the passes of PLOC on windows of the
//! Morton order, and the partners that some boxes could join at little cost. Such inputs are split
//! at the median of the widest axis, which takes `O(n log^2 n)` steps and gives a tree of the least
//! depth.

use super::primitives::Bounded;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::morton::morton_encode_u64_unorm;

/// Windows of the Morton order whose passes are counted, evenly spaced.
const WINDOWS: usize = 8;
/// Boxes in a window. A row of so many equal boxes takes as many passes.
const WINDOW: usize = 256;
/// Most passes of a window in which boxes have no ties: half of the boxes of random scenes merge in
/// each pass, so that 256 boxes take about twenty. A row of equal boxes takes 255.
const PASSES_MAX: usize = 64;
/// The search distance of PLOC ([`obvhs::ploc::PlocSearchDistance::VeryHigh`]).
const SEARCH: usize = 32;
/// Boxes whose cheap partners are counted, evenly spaced.
const SAMPLES: usize = 128;
/// Two boxes are cheap partners if their union has at most this times the larger one's area.
const CHEAP: f32 = 1.1;
/// Most cheap partners of a box on average. In a mesh there are few; where there are so many,
/// reinsertion visits hundreds of nodes for each. Half of it would reject dense foliage, double of
/// it takes twice as long.
const PARTNERS_MAX: usize = 512;

/// Whether the binary builder would take quadratic time.
pub(super) fn is_degenerate(boxes: &[Bounded]) -> bool {
    boxes.len() > PARTNERS_MAX
        && (mean_partners(boxes) > PARTNERS_MAX || passes(boxes) > PASSES_MAX)
}

/// The mean number of cheap partners of a box, itself included, over some boxes.
fn mean_partners(boxes: &[Bounded]) -> usize {
    let step = boxes.len().div_ceil(SAMPLES);
    let samples = boxes.iter().step_by(step);
    let count = samples.clone().count();
    let partners = |one: &Bounded| {
        let (one, area) = (one.aabb(), one.aabb().half_area());
        let is_cheap = |other: &&Bounded| {
            let other = other.aabb();
            one.union(&other).half_area() <= CHEAP * area.max(other.half_area())
        };
        boxes.iter().filter(is_cheap).count()
    };
    samples.map(partners).sum::<usize>() / count
}

/// The median over some windows of the Morton order of the number of passes that PLOC takes.
fn passes(boxes: &[Bounded]) -> usize {
    let all = boxes.iter().fold(Aabb::empty(), |all, one| all.union(&one.aabb()));
    let extent = all.diagonal().as_dvec3().max(glam::DVec3::splat(f64::MIN_POSITIVE));
    let code = |one: &Bounded| {
        let centre = one.aabb().center() - all.min;
        morton_encode_u64_unorm(centre.as_dvec3() / extent)
    };
    let mut sorted: Vec<(u64, u32)> = boxes.iter().map(code).zip(0..).collect();
    sorted.sort_unstable();
    let step = (sorted.len() / WINDOWS).max(1);
    let windows = (0..WINDOWS).map(|k| k * step).filter(|start| *start < sorted.len());
    let mut counts: Vec<usize> = windows
        .map(|start| {
            let window = &sorted[start..sorted.len().min(start + WINDOW)];
            passes_of(window.iter().map(|(_, i)| boxes[*i as usize].aabb()).collect())
        })
        .collect();
    counts.sort_unstable();
    counts[counts.len() / 2]
}

/// The number of passes until PLOC has merged `clusters` into one, or more than [`PASSES_MAX`].
fn passes_of(mut clusters: Vec<Aabb>) -> usize {
    let mut count = 0;
    while clusters.len() > 1 && count <= PASSES_MAX {
        // As in the builder, the first pass compares direct neighbours only, and the last of
        // equally good partners wins.
        let reach = if count == 0 { 1 } else { SEARCH };
        let best = |index: usize| {
            let near = index.saturating_sub(reach)..(index + reach + 1).min(clusters.len());
            let cost = |other: usize| clusters[index].union(&clusters[other]).half_area();
            let better = |best: usize, other: usize| {
                if cost(other) <= cost(best) { other } else { best }
            };
            near.filter(|other| *other != index).reduce(better).unwrap_or(index)
        };
        let partners: Vec<usize> = (0..clusters.len()).map(best).collect();
        let merged = (0..clusters.len()).filter_map(|index| {
            let partner = partners[index];
            match partners[partner] == index {
                true if partner < index => None,
                true => Some(clusters[index].union(&clusters[partner])),
                false => Some(clusters[index]),
            }
        });
        clusters = merged.collect();
        count += 1;
    }
    count
}

/// The binary tree that halves the boxes at the median of the widest axis of their centres.
pub(super) fn median_split(boxes: &[Bounded]) -> Bvh2 {
    let mut binary = Bvh2::zeroed(boxes.len());
    binary.nodes = vec![Bvh2Node::new(Aabb::empty(), 1, 0)];
    binary.primitive_indices = (0..boxes.len() as u32).collect();
    let mut open = vec![(0, 0..boxes.len())];
    while let Some((index, range)) = open.pop() {
        let ids = &mut binary.primitive_indices[range.clone()];
        let aabb = |id: u32| boxes[id as usize].aabb();
        let bounds = ids.iter().fold(Aabb::empty(), |all, id| all.union(&aabb(*id)));
        if ids.len() == 1 {
            binary.nodes[index] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let mut centres = Aabb::empty();
        ids.iter().for_each(|id| _ = centres.extend(aabb(*id).center()));
        let size = centres.diagonal();
        let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
        let half = ids.len() / 2;
        let centre = |id: u32| aabb(id).center()[axis];
        ids.select_nth_unstable_by(half, |a, b| {
            centre(*a).total_cmp(&centre(*b)).then_with(|| a.cmp(b))
        });
        let first = binary.nodes.len();
        binary.nodes[index] = Bvh2Node::new(bounds, 0, first as u32);
        binary.nodes.extend([Bvh2Node::new(Aabb::empty(), 1, 0); 2]);
        let middle = range.start + half;
        open.extend([(first, range.start..middle), (first + 1, middle..range.end)]);
    }
    binary
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::primitives::Primitives;
    use glam::Vec3;

    fn boxes(triangle: impl Fn(f32) -> [Vec3; 3]) -> Vec<Bounded> {
        let triangles: Vec<_> = (0..20_000).map(|i| triangle(i as f32)).collect();
        Primitives::new(&triangles).bounded()
    }

    const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    /// The counts bound the passes of PLOC and the nodes that reinsertion visits.
    #[test]
    fn rows_and_triangles_in_one_place_are_degenerate_and_meshes_are_not() {
        let random = |i: f32| {
            Vec3::from_array(sobol_burley::sample_4d(i as u32, 0, 1)[..3].try_into().unwrap())
        };
        for (name, degenerate, boxes) in [
            ("row", true, boxes(|i| TRIANGLE.map(|p| p + i * Vec3::X))),
            ("concentric", true, boxes(|i| TRIANGLE.map(|p| (1.0 + random(i).x) * (p - 0.3)))),
            ("nearly coincident", true, boxes(|i| TRIANGLE.map(|p| p + 1e-4 * random(i)))),
            ("scattered", false, boxes(|i| TRIANGLE.map(|p| 0.02 * p + random(i)))),
            (
                "grid",
                false,
                boxes(|i| {
                    let corner = Vec3::new((i / 2.0).floor() % 100.0, 0.0, (i / 200.0).floor());
                    let quad = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::X + Vec3::Z];
                    let first = (i % 2.0) as usize;
                    [0, 1, 2].map(|k| corner + quad[first + k])
                }),
            ),
        ] {
            let counts = (mean_partners(&boxes), passes(&boxes));
            assert_eq!(is_degenerate(&boxes), degenerate, "{name}: {counts:?}");
        }
    }

    #[test]
    fn the_median_split_has_the_least_depth() {
        let boxes = boxes(|i| TRIANGLE.map(|p| p + i * Vec3::X));
        let binary = median_split(&boxes);
        assert_eq!(binary.nodes.len(), 2 * boxes.len() - 1);
        let (mut open, mut deepest) = (vec![(0, 0)], 0);
        while let Some((index, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let node = &binary.nodes[index];
            if !node.is_leaf() {
                let first = node.first_index as usize;
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
        }
        assert_eq!(deepest, 15, "20 000 < 2^15");
    }
}
