//! What the photograph shows, and what a residual may be besides a wrong hypothesis: which pixels count
//! ([`observation`]), with which noise ([`noise`]), in which blocks ([`blocks`]), and how wrong model and light may be
//! ([`model_error`]). It ends in the [`sample`], the one type for some pixels of a group.

pub mod blocks;
pub mod model_error;
pub mod noise;
pub mod observation;
pub(crate) mod photometric;
pub(crate) mod same_place;
pub mod sample;
