//! What the fine passes of one round found, as the unknowns of the next round see it.
//!
//! A round that ends with a simpler hypothesis has found all that the next one needs: of its normal
//! equations some unknowns are set and leave, and two roughnesses become one, whose derivative is the sum of
//! theirs. The residuals are carried along to where the unknowns were set, as they are from pass to pass.

use super::Solution;
use super::means::Mean;
use super::unknowns::Unknowns;
use crate::state::State;
use crate::unknown::{Quantity, Unknown};
use nalgebra::DVector;

/// What was found is dropped after a step of so many standard deviations: it was found too far away. At half of it
/// passes are dropped for their noise; at double the model is taken as linear where it is not.
pub(super) const FAR: f64 = 4.0;

/// What fine passes have found.
pub(super) struct Found {
    /// Chooses the pixels.
    pub(super) pixels_seed: u64,
    /// The paths a pixel of every group of the next pass.
    pub(super) spp: Vec<u32>,
    /// The average of the passes.
    pub(super) average: Vec<Mean>,
    /// Passes that were made.
    pub(super) passes: usize,
}

impl Solution {
    /// What its passes found, for the unknowns of `state`, whose hypotheses were made simpler after they had
    /// the `values`. None where that is too far away, or a number is free that was not.
    pub(super) fn carried(self, state: &State<'_>, values: &DVector<f64>) -> Option<Found> {
        let (before, after) = (&self.unknowns, Unknowns::of(state));
        let step =
            |(u, value): (&Unknown, &f64)| set_to(state, before, u).map_or(0.0, |v| v - value);
        let step = DVector::from_iterator(values.len(), before.list.iter().zip(values).map(step));
        let is_far = |k: usize| {
            step[k].powi(2) > FAR.powi(2) * self.covariance[(k, k)].max(f64::MIN_POSITIVE)
        };
        let places: Vec<Option<usize>> = before.list.iter().map(|u| place(u, &after)).collect();
        let is_known = |k: usize| places.contains(&Some(k));
        let mut found = self.found;
        if (0..step.len()).any(is_far)
            || !(0..after.len()).all(is_known)
            || found.average.is_empty()
        {
            return None;
        }
        for mean in &mut found.average {
            mean.move_by(&step);
            mean.rename(&places);
        }
        Some(found)
    }
}

/// What an unknown was set to; none where it has no effect any longer.
fn set_to(state: &State<'_>, before: &Unknowns, u: &Unknown) -> Option<f64> {
    let has_effect = match u.quantity {
        Quantity::Theta => false,
        Quantity::Alpha | Quantity::AlphaX | Quantity::AlphaY => state.materials[u.of].is_glossy(),
        _ => true,
    };
    has_effect.then(|| before.value(state, u))
}

/// The unknown of `after` that `u` is or became a part of.
fn place(u: &Unknown, after: &Unknowns) -> Option<usize> {
    let of = |unknown: Unknown| after.list.iter().position(|other| *other == unknown);
    let round = || match u.quantity {
        Quantity::AlphaX | Quantity::AlphaY => of(Unknown { quantity: Quantity::Alpha, ..*u }),
        _ => None,
    };
    of(*u).or_else(round)
}
