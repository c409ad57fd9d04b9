//! The tree: a binary one by `obvhs` (PLOC and reinsertion), collapsed to eight children a node.
//!
//! Which nodes of the binary tree become nodes of the wide one, and which leaves, is the choice that
//! makes `sum over nodes of area * COST_NODE + sum over leaves of area * blocks` smallest, found by
//! dynamic programming from the leaves up [Ylitie, Karras and Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1].

use super::tree::{LEAF_MAX, Link, Node, Tree, WIDTH};
use super::woop::Triangles4;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::PlocSearchDistance;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// What a node costs, in tests of a block of four triangles.
const COST_NODE: f32 = 3.0;
/// Below this depth nodes are split in equal parts, whatever they cost: no tree is deeper than the
/// stack of the walk can bear, not even one over triangles that all lie in one place.
pub(super) const DEPTH_MAX: usize = 26;

/// How good the binary tree is: much reinsertion, since a tree is built once for millions of rays.
const QUALITY: BvhBuildParams = BvhBuildParams {
    reinsertion_batch_ratio: 0.4,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ploc_search_distance: PlocSearchDistance::VeryHigh,
    search_depth_threshold: 1,
    // Leaves are made by the collapse.
    max_prims_per_leaf: 1,
    ..BvhBuildParams::medium_build()
};

struct Boxed<'a>(&'a [Vec3; 3]);

impl Boundable for Boxed<'_> {
    fn aabb(&self) -> Aabb {
        Aabb::from_points(&self.0.map(Vec3A::from))
    }
}

/// The tree over `triangles`, one at least, and the box around everything.
pub(super) fn build(triangles: &[[Vec3; 3]]) -> (Tree, [Vec3; 2]) {
    let boxed: Vec<Boxed<'_>> = triangles.iter().map(Boxed).collect();
    let binary = build_bvh2(&boxed, QUALITY, &mut Duration::default());
    let bounds = binary.nodes[0].aabb;
    let mut collapse =
        Collapse { costs: Costs::of(&binary), binary: &binary, triangles, tree: Tree::default() };
    collapse.node(&Part::Below(0), 0);
    (collapse.tree, [bounds.min.into(), bounds.max.into()])
}

/// What becomes a node or a leaf.
enum Part {
    /// Everything below a binary node.
    Below(usize),
    /// These triangles.
    Triangles(Vec<u32>),
}

/// For each binary node: its triangles, and the least cost of what is below it as `1..WIDTH` parts.
struct Costs {
    triangles: Vec<u32>,
    parts: Vec<[f32; WIDTH]>,
}

impl Costs {
    fn of(binary: &Bvh2) -> Self {
        let count = binary.nodes.len();
        let mut costs = Self { triangles: vec![0; count], parts: vec![[0.0; WIDTH]; count] };
        for index in children_first(binary) {
            let node = &binary.nodes[index];
            let area = node.aabb.half_area();
            if node.is_leaf() {
                costs.triangles[index] = node.prim_count;
                costs.parts[index] = [area * leaf_cost(node.prim_count); WIDTH];
                continue;
            }
            let [left, right] = children(binary, index);
            costs.triangles[index] = costs.triangles[left] + costs.triangles[right];
            let mut parts = [f32::INFINITY; WIDTH];
            for wanted in (1..WIDTH).rev() {
                parts[wanted] = costs.shared([left, right], wanted + 1).0;
            }
            let as_node = parts[WIDTH - 1] + area * COST_NODE;
            parts[0] = as_node.min(area * leaf_cost(costs.triangles[index]));
            for more in 1..WIDTH {
                parts[more] = parts[more].min(parts[more - 1]);
            }
            costs.parts[index] = parts;
        }
        costs
    }

    /// The least cost of two binary nodes as `wanted` parts, and how many of them the first has.
    fn shared(&self, [left, right]: [usize; 2], wanted: usize) -> (f32, usize) {
        (1..wanted)
            .map(|k| (self.parts[left][k - 1] + self.parts[right][wanted - k - 1], k))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f32::INFINITY, 1))
    }
}

/// What a leaf costs per area; infinite if it would be too large.
fn leaf_cost(triangles: u32) -> f32 {
    if triangles as usize > LEAF_MAX { f32::INFINITY } else { triangles.div_ceil(4) as f32 }
}

fn children(binary: &Bvh2, index: usize) -> [usize; 2] {
    let first = binary.nodes[index].first_index as usize;
    [first, first + 1]
}

/// All binary nodes, each after its children.
fn children_first(binary: &Bvh2) -> Vec<usize> {
    let mut order = vec![0];
    let mut done = 0;
    while let Some(&index) = order.get(done) {
        if !binary.nodes[index].is_leaf() {
            order.extend(children(binary, index));
        }
        done += 1;
    }
    order.reverse();
    order
}

struct Collapse<'a> {
    binary: &'a Bvh2,
    costs: Costs,
    triangles: &'a [[Vec3; 3]],
    tree: Tree,
}

impl Collapse<'_> {
    /// Makes a node of a part, and all that is below it.
    fn node(&mut self, part: &Part, depth: usize) -> Link {
        let parts = match part {
            Part::Below(index) if depth < DEPTH_MAX => {
                let mut parts = Vec::with_capacity(WIDTH);
                self.open(*index, &mut parts);
                parts
            }
            _ => {
                let ids = self.ids(part);
                let size = ids.len().div_ceil(WIDTH);
                ids.chunks(size).map(|ids| Part::Triangles(ids.to_vec())).collect()
            }
        };
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::EMPTY);
        for (lane, part) in parts.iter().enumerate() {
            let child =
                if self.is_leaf(part) { self.leaf(part) } else { self.node(part, depth + 1) };
            let bounds = self.bounds(part);
            let node = &mut self.tree.nodes[index];
            node.children[lane] = child;
            for axis in 0..3 {
                node.bounds[axis][0][lane] = bounds.min[axis];
                node.bounds[axis][1][lane] = bounds.max[axis];
            }
        }
        Link::node(index)
    }

    /// The parts that the binary node `index` is best opened into.
    fn open(&self, index: usize, parts: &mut Vec<Part>) {
        if self.binary.nodes[index].is_leaf() {
            return parts.push(Part::Below(index));
        }
        let children = children(self.binary, index);
        let (_, first) = self.costs.shared(children, WIDTH);
        self.divide(children[0], first, parts);
        self.divide(children[1], WIDTH - first, parts);
    }

    /// The binary node `index` as `wanted` parts or fewer.
    fn divide(&self, index: usize, wanted: usize, parts: &mut Vec<Part>) {
        let costs = &self.costs.parts[index];
        let fewest = (0..wanted).find(|&k| costs[k] <= costs[wanted - 1]).unwrap_or(0) + 1;
        if fewest == 1 || self.binary.nodes[index].is_leaf() {
            return parts.push(Part::Below(index));
        }
        let children = children(self.binary, index);
        let (_, first) = self.costs.shared(children, fewest);
        self.divide(children[0], first, parts);
        self.divide(children[1], fewest - first, parts);
    }

    fn is_leaf(&self, part: &Part) -> bool {
        match part {
            Part::Triangles(ids) => ids.len() <= LEAF_MAX,
            Part::Below(index) => {
                let as_leaf = self.binary.nodes[*index].aabb.half_area()
                    * leaf_cost(self.costs.triangles[*index]);
                self.binary.nodes[*index].is_leaf() || as_leaf <= self.costs.parts[*index][0]
            }
        }
    }

    /// Stores the triangles of a part in blocks of four.
    fn leaf(&mut self, part: &Part) -> Link {
        let first = self.tree.blocks.len();
        for four in self.ids(part).chunks(4) {
            let block: Vec<_> = four.iter().map(|&id| (id, self.triangles[id as usize])).collect();
            self.tree.blocks.push(Triangles4::new(&block));
        }
        Link::leaf(first, self.tree.blocks.len() - first)
    }

    /// The triangles of a part.
    fn ids(&self, part: &Part) -> Vec<u32> {
        let top = match part {
            Part::Triangles(ids) => return ids.clone(),
            Part::Below(index) => *index,
        };
        let (mut ids, mut open) = (Vec::new(), vec![top]);
        while let Some(index) = open.pop() {
            let node = &self.binary.nodes[index];
            if node.is_leaf() {
                let first = node.first_index as usize;
                let own = first..first + node.prim_count as usize;
                ids.extend_from_slice(&self.binary.primitive_indices[own]);
            } else {
                open.extend(children(self.binary, index).iter().rev());
            }
        }
        ids
    }

    fn bounds(&self, part: &Part) -> Aabb {
        match part {
            Part::Below(index) => self.binary.nodes[*index].aabb,
            Part::Triangles(ids) => {
                let corners = ids.iter().flat_map(|&id| self.triangles[id as usize]);
                Aabb::from_points(&corners.map(Vec3A::from).collect::<Vec<_>>())
            }
        }
    }
}
