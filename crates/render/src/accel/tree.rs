//! Memory layout of the 8-wide bounding volume hierarchy: nodes of eight boxes, leaves of blocks of
//! four triangles.

use super::woop::Triangles4;

/// Children per node.
pub(super) const WIDTH: usize = 8;
/// The bit of a [`ChildRef`] that marks a leaf.
const LEAF: u32 = 1 << 31;
/// Bits of a leaf's [`ChildRef`] that hold its number of blocks minus one.
const COUNT_BITS: u32 = 3;
/// Most blocks of triangles in one leaf: as many as [`COUNT_BITS`] can count.
const BLOCKS_MAX: usize = 1 << COUNT_BITS;
/// Most triangles in one leaf.
pub(super) const LEAF_MAX: usize = 4 * BLOCKS_MAX;

/// The nodes and leaves of a scene; the root is node 0.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<Triangles4>,
}

/// Eight children. Unused lanes hold the empty box, which no ray enters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `bounds[axis][side]`: side 0 the lower bound, side 1 the upper one; one lane per child.
    pub(super) bounds: [[[f32; WIDTH]; 2]; 3],
    pub(super) children: [ChildRef; WIDTH],
}

/// A child of a node: the index of a node, or the range of blocks of a leaf, packed into 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChildRef(pub(super) u32);

impl Node {
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [ChildRef(0); WIDTH],
    };
}

impl ChildRef {
    pub(super) const ROOT: Self = Self(0);

    pub(super) fn node(index: usize) -> Self {
        assert!(index < LEAF as usize, "a tree of {index} nodes is too large for its indices");
        Self(index as u32)
    }

    /// The leaf of `count` blocks that starts at the block `first`.
    pub(super) fn leaf(first: usize, count: usize) -> Self {
        assert!((1..=BLOCKS_MAX).contains(&count), "a leaf of {count} blocks");
        assert!(first < 1 << (31 - COUNT_BITS), "{first} blocks are too many for their indices");
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
