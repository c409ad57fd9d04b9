//! The tree as it lies in memory: nodes of eight boxes, and blocks of four triangles.

use super::woop::Triangles4;

/// Children of a node.
pub(super) const WIDTH: usize = 8;
/// Marks a link to a leaf.
const LEAF: u32 = 1 << 31;
/// The bits of a leaf's link that say how many blocks it has, less one.
const COUNT_BITS: u32 = 3;
/// Triangles in a leaf at most.
pub(super) const LEAF_MAX: usize = 4 << COUNT_BITS;

/// Nodes and leaves of a scene; the root is node 0.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<Triangles4>,
}

/// Eight children; those that are not there have boxes that no ray enters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[axis][side]`, side 0 the lower one, one lane a child.
    pub(super) bounds: [[[f32; WIDTH]; 2]; 3],
    pub(super) children: [Link; WIDTH],
}

/// Where a child lies: a node, or the blocks of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link(pub(super) u32);

impl Node {
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Link(0); WIDTH],
    };
}

impl Link {
    pub(super) const ROOT: Self = Self(0);

    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// A leaf of `count` blocks from the block `first` on.
    pub(super) fn leaf(first: usize, count: usize) -> Self {
        debug_assert!((1..=1 << COUNT_BITS).contains(&count) && first < 1 << (31 - COUNT_BITS));
        Self(LEAF | (first as u32) << COUNT_BITS | (count as u32 - 1))
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// The blocks of a leaf.
    #[inline(always)]
    pub(super) fn blocks(self) -> std::ops::Range<usize> {
        let first = ((self.0 & !LEAF) >> COUNT_BITS) as usize;
        first..first + (self.0 & ((1 << COUNT_BITS) - 1)) as usize + 1
    }
}
