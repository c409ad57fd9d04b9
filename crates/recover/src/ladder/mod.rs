//! Climbing the ladder: from evidence to the next hypothesis, for all groups in every iteration,
//! since each one lights the others [Boivin and Gagalowicz 2002, Figure 1].
//!
//! Other hypotheses are proposed for the groups that the present ones explain worst (`candidates`), all numbers
//! being fitted together (`refine`).

pub(crate) mod candidates;
mod compared;
mod evidence_pair;
pub(crate) mod proposal;
pub(crate) mod textures;
