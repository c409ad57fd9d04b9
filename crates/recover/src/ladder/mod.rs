//! Climbing the ladder: from evidence to the next hypothesis, for all groups in every iteration,
//! since each one lights the others [Boivin and Gagalowicz 2002, Figure 1].
//!
//! Two ways up: the default one, which proposes other hypotheses for the groups that the present ones explain
//! worst (`candidates`), all numbers being fitted together (`refine`); and `paper`, the paper's method as
//! written.

pub(crate) mod candidates;
mod compared;
mod evidence_pair;
pub(crate) mod paper;
pub(crate) mod textures;
