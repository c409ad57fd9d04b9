//! A roughness of a group, searched by its logarithm, which keeps it positive; all channels share it.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::unknown::Unknown;
use unrender_render::Parameter;

/// The logarithm of a roughness.
pub(super) struct Roughness(pub(super) Along);

/// Along which direction.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    /// Along both: the lobe is round.
    Both,
    X,
    Y,
}

/// The standard deviation of the prior: a factor of e either way. Half of it pulls hardly determined
/// lobes towards the start, double of it lets them run to a bound.
const DEVIATION: f64 = 1.0;
/// No step changes the logarithm by more than this, a factor of 1.5. Half of it takes more passes; a
/// lobe that is twice as wide hardly overlaps with what it was linearised about.
const STEP: f64 = 0.4;
/// The relative standard deviation that is small enough. With half of it and of the other blocks' a room of 11 groups
/// takes half as long again and comes no nearer; double was not tried.
const PRECISE: f64 = 4e-3;

impl Roughness {
    fn bounds(&self, guess: &Guess<'_>, u: &Unknown) -> [f32; 2] {
        let bounds = &guess.problem.groups[u.of].expected.bounds;
        match self.0 {
            Along::Both => bounds.round(),
            Along::X => bounds.along(),
            Along::Y => bounds.across(),
        }
    }
}

impl ParameterKind for Roughness {
    fn name(&self) -> &'static str {
        match self.0 {
            Along::Both => "alpha",
            Along::X => "alpha_x",
            Along::Y => "alpha_y",
        }
    }

    fn prior(&self, _: &Guess<'_>, _: &Unknown) -> Prior {
        Prior { mean: None, deviation: DEVIATION }
    }

    fn precise_enough(&self, _: &Guess<'_>, _: &Unknown) -> f64 {
        PRECISE
    }

    /// A share of a roughness is a difference of its logarithm.
    fn likeness(&self, _: f64, within: f64) -> Option<f64> {
        Some(within)
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        let material = &at.guess.materials[u.of];
        f64::from(if self.0 == Along::Y { material.alpha_y } else { material.alpha_x }.ln())
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        let [low, high] = self.bounds(guess, u);
        let material = &mut guess.materials[u.of];
        // The exponential of a bound's logarithm is not the bound to the bit.
        let alpha = (value as f32).exp().clamp(low, high.max(low));
        if self.0 != Along::Y {
            material.alpha_x = alpha;
        }
        if self.0 != Along::X {
            material.alpha_y = alpha;
        }
    }

    fn range(&self, guess: &Guess<'_>, u: &Unknown, _: f64) -> Range {
        let [low, high] = self.bounds(guess, u).map(|alpha| f64::from(alpha).ln());
        Range { low, high, step: STEP }
    }

    fn parameters(&self, of: u32) -> [Parameter; 2] {
        match self.0 {
            Along::Both => [Parameter::AlphaX(of), Parameter::AlphaY(of)],
            Along::X => [Parameter::AlphaX(of); 2],
            Along::Y => [Parameter::AlphaY(of); 2],
        }
    }

    /// `dL / d ln alpha = alpha dL / d alpha`.
    fn derivative(&self, at: At<'_>, u: &Unknown, linear: &Linear<'_>) -> f64 {
        let material = &at.guess.materials[u.of];
        let alpha = if self.0 == Along::Y { material.alpha_y } else { material.alpha_x };
        linear.derivative * f64::from(alpha)
    }
}
