//! Building the hierarchy: a binary tree by `obvhs` (PLOC [Meister and Bittner 2018a] and parallel
//! reinsertion [Meister and Bittner 2018b]), collapsed to eight children per node.
//!
//! The collapse decides which binary nodes become nodes of the wide tree and which become leaves.
//! It minimises the surface-area cost
//!
//! ```text
//! sum over nodes of area * COST_NODE  +  sum over leaves of area * blocks
//! ```
//!
//! by dynamic programming from the leaves to the root [Ylitie et al. 2017, section 3.1].

use super::degenerate;
use super::primitives::Primitives;
use super::tree::{ChildRef, LEAF_MAX, Node, Tree, WIDTH};
use super::woop::Triangles4;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::PlocSearchDistance;
use std::time::Duration;

/// The cost of visiting a node (eight box tests and the ordering of the hits), in tests of a block
/// of four triangles. Half of it gives deeper trees with smaller leaves, double of it shallower
/// trees whose leaves hold triangles that most rays miss.
const COST_NODE: f32 = 3.0;
/// Below this depth nodes are split into equal parts by index, whatever the cost. This bounds the
/// depth of the tree, and so the traversal stack (`walk`), even where nearly all triangles lie in
/// one place. Half of it would cut unbalanced trees of real scenes, double of it would double the
/// stack.
pub(super) const DEPTH_MAX: usize = 26;

/// Parameters of the binary builder. Reinsertion is thorough, since one tree serves millions of
/// rays.
const QUALITY: BvhBuildParams = BvhBuildParams {
    reinsertion_batch_ratio: 0.4,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ploc_search_distance: PlocSearchDistance::VeryHigh,
    search_depth_threshold: 1,
    // The collapse below forms the leaves.
    max_prims_per_leaf: 1,
    ..BvhBuildParams::medium_build()
};

/// The tree over `triangles`, at least one, whose indices in the scene are `ids`, and the lower and upper corner of their
/// bounding box.
pub(super) fn build(triangles: &[[Vec3; 3]], ids: &[u32]) -> (Tree, [Vec3; 2]) {
    let primitives = Primitives::new(triangles);
    let bounded = primitives.bounded();
    let binary = if degenerate::is_degenerate(&bounded) {
        degenerate::median_split(&bounded)
    } else {
        build_bvh2(&bounded, QUALITY, &mut Duration::default())
    };
    let bounds = primitives.unscaled(binary.nodes[0].aabb);
    let mut collapse = Collapse {
        costs: Costs::of(&binary, &primitives),
        binary: &binary,
        primitives: &primitives,
        triangles,
        ids,
        tree: Tree::default(),
    };
    collapse.node(&Subtree::Below(0), 0);
    (collapse.tree, bounds)
}

/// A set of triangles that becomes a node or a leaf.
enum Subtree {
    /// All triangles below a node of the binary tree.
    Below(usize),
    /// These triangles.
    Triangles(Vec<u32>),
}

/// The costs of the dynamic programme, one entry per binary node.
struct Costs {
    /// Number of triangles below the node.
    triangles: Vec<u32>,
    /// `forests[k - 1]`: the least cost of the node's triangles as at most `k` subtrees.
    forests: Vec<[f32; WIDTH]>,
}

impl Costs {
    fn of(binary: &Bvh2, primitives: &Primitives) -> Self {
        let count = binary.nodes.len();
        let mut costs = Self { triangles: vec![0; count], forests: vec![[0.0; WIDTH]; count] };
        for index in children_first(binary) {
            let node = &binary.nodes[index];
            let area = node.aabb.half_area();
            if node.is_leaf() {
                let triangles = triangles_of_leaf(binary, primitives, index).count() as u32;
                costs.triangles[index] = triangles;
                costs.forests[index] = [area * blocks(triangles); WIDTH];
                continue;
            }
            let [left, right] = children(binary, index);
            costs.triangles[index] = costs.triangles[left] + costs.triangles[right];
            let mut forests = [f32::INFINITY; WIDTH];
            for wanted in (1..WIDTH).rev() {
                forests[wanted] = costs.distributed([left, right], wanted + 1).cost;
            }
            let as_node = forests[WIDTH - 1] + area * COST_NODE;
            forests[0] = as_node.min(costs.as_leaf(binary, index));
            for more in 1..WIDTH {
                forests[more] = forests[more].min(forests[more - 1]);
            }
            costs.forests[index] = forests;
        }
        costs
    }

    /// The cost of a binary node as one leaf; infinite if it has too many triangles.
    fn as_leaf(&self, binary: &Bvh2, index: usize) -> f32 {
        let triangles = self.triangles[index];
        if triangles as usize > LEAF_MAX {
            return f32::INFINITY;
        }
        binary.nodes[index].aabb.half_area() * blocks(triangles)
    }

    /// The cheapest way to divide `wanted` subtrees between two binary nodes.
    fn distributed(&self, [left, right]: [usize; 2], wanted: usize) -> Distribution {
        (1..wanted)
            .map(|first| Distribution {
                cost: self.forests[left][first - 1] + self.forests[right][wanted - first - 1],
                first,
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .unwrap_or(Distribution { cost: f32::INFINITY, first: 1 })
    }
}

/// Subtrees divided between two binary nodes.
struct Distribution {
    cost: f32,
    /// How many of them the first node gets.
    first: usize,
}

/// The number of blocks of four that hold so many triangles.
fn blocks(triangles: u32) -> f32 {
    triangles.div_ceil(4) as f32
}

fn children(binary: &Bvh2, index: usize) -> [usize; 2] {
    let first = binary.nodes[index].first_index as usize;
    [first, first + 1]
}

/// The triangles of a leaf of the binary tree.
fn triangles_of_leaf<'a>(
    binary: &'a Bvh2,
    primitives: &'a Primitives,
    index: usize,
) -> impl Iterator<Item = u32> + 'a {
    let node = &binary.nodes[index];
    let first = node.first_index as usize;
    let own = &binary.primitive_indices[first..first + node.prim_count as usize];
    own.iter().flat_map(|&primitive| primitives.triangles(primitive)).copied()
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

/// The wide tree while it is built.
struct Collapse<'a> {
    binary: &'a Bvh2,
    primitives: &'a Primitives,
    costs: Costs,
    triangles: &'a [[Vec3; 3]],
    /// Their indices in the scene.
    ids: &'a [u32],
    tree: Tree,
}

impl Collapse<'_> {
    /// Adds the node of a subtree and all nodes and leaves below it.
    fn node(&mut self, subtree: &Subtree, depth: usize) -> ChildRef {
        let parts = match subtree {
            Subtree::Below(index) if depth < DEPTH_MAX && !self.is_stack(*index) => {
                let mut parts = Vec::with_capacity(WIDTH);
                self.open(*index, &mut parts);
                parts
            }
            _ => {
                let ids = self.ids(subtree);
                let size = ids.len().div_ceil(WIDTH);
                ids.chunks(size).map(|ids| Subtree::Triangles(ids.to_vec())).collect()
            }
        };
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Node::EMPTY);
        for (lane, part) in parts.iter().enumerate() {
            let child =
                if self.is_leaf(part) { self.leaf(part) } else { self.node(part, depth + 1) };
            let [low, high] = self.bounds(part);
            let node = &mut self.tree.nodes[index];
            node.children[lane] = child;
            for axis in 0..3 {
                node.bounds[axis][0][lane] = low[axis];
                node.bounds[axis][1][lane] = high[axis];
            }
        }
        ChildRef::node(index)
    }

    /// Appends the cheapest [`WIDTH`] subtrees, or fewer, of the binary node `index`.
    fn open(&self, index: usize, parts: &mut Vec<Subtree>) {
        if self.binary.nodes[index].is_leaf() {
            return parts.push(Subtree::Below(index));
        }
        let children = children(self.binary, index);
        let first = self.costs.distributed(children, WIDTH).first;
        self.divide(children[0], first, parts);
        self.divide(children[1], WIDTH - first, parts);
    }

    /// Appends the binary node `index` as `wanted` subtrees or fewer.
    fn divide(&self, index: usize, wanted: usize, parts: &mut Vec<Subtree>) {
        let costs = &self.costs.forests[index];
        let fewest = (0..wanted).find(|&k| costs[k] <= costs[wanted - 1]).unwrap_or(0) + 1;
        if fewest == 1 || self.binary.nodes[index].is_leaf() {
            return parts.push(Subtree::Below(index));
        }
        let children = children(self.binary, index);
        let first = self.costs.distributed(children, fewest).first;
        self.divide(children[0], first, parts);
        self.divide(children[1], fewest - first, parts);
    }

    /// Whether a binary node is a stack of boxes too large for a leaf, to be split by index.
    fn is_stack(&self, index: usize) -> bool {
        self.binary.nodes[index].is_leaf() && self.costs.triangles[index] as usize > LEAF_MAX
    }

    fn is_leaf(&self, subtree: &Subtree) -> bool {
        match subtree {
            Subtree::Triangles(ids) => ids.len() <= LEAF_MAX,
            Subtree::Below(index) => {
                let as_leaf = self.costs.as_leaf(self.binary, *index);
                self.costs.triangles[*index] as usize <= LEAF_MAX
                    && (self.binary.nodes[*index].is_leaf()
                        || as_leaf <= self.costs.forests[*index][0])
            }
        }
    }

    /// Stores the triangles of a subtree in blocks of four.
    fn leaf(&mut self, subtree: &Subtree) -> ChildRef {
        let first = self.tree.blocks.len();
        for four in self.ids(subtree).chunks(4) {
            let one = |at: usize| (self.ids[at], self.triangles[at]);
            let block: Vec<_> = four.iter().map(|&at| one(at as usize)).collect();
            self.tree.blocks.push(Triangles4::new(&block));
        }
        ChildRef::leaf(first, self.tree.blocks.len() - first)
    }

    /// The triangles of a subtree.
    fn ids(&self, subtree: &Subtree) -> Vec<u32> {
        let top = match subtree {
            Subtree::Triangles(ids) => return ids.clone(),
            Subtree::Below(index) => *index,
        };
        let (mut ids, mut open) = (Vec::new(), vec![top]);
        while let Some(index) = open.pop() {
            if self.binary.nodes[index].is_leaf() {
                ids.extend(triangles_of_leaf(self.binary, self.primitives, index));
            } else {
                open.extend(children(self.binary, index).iter().rev());
            }
        }
        ids
    }

    /// The lower and upper corner of a subtree's bounding box.
    fn bounds(&self, subtree: &Subtree) -> [Vec3; 2] {
        match subtree {
            Subtree::Below(index) => self.primitives.unscaled(self.binary.nodes[*index].aabb),
            Subtree::Triangles(ids) => {
                let corners = ids.iter().flat_map(|&id| self.triangles[id as usize]);
                let bounds = Aabb::from_points(&corners.map(Vec3A::from).collect::<Vec<_>>());
                [bounds.min.into(), bounds.max.into()]
            }
        }
    }
}
