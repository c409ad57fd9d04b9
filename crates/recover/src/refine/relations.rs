//! Soft relations between unknowns: groups that the user calls alike, and directions beside each other in an
//! unknown environment.
//!
//! The difference `d = p_a - p_b` of a number of both groups has the prior `d ~ N(0, sigma^2)`, which adds
//! `(e_a - e_b)(e_a - e_b)^T / sigma^2` to the precision of the prior. The number's kind gives `sigma`
//! ([`super::parameters::ParameterKind::likeness`]). Only numbers that both groups' hypotheses have are related; those of
//! a known group are fixed, and those of an assumed one say nothing.

use super::parameters::{self, At};
use crate::expected::Like;
use crate::hypothesis::{self, Hypothesis};
use crate::problem::Role;
use crate::unknown::{Quantity, Unknown};

/// The standard deviation of the difference of two directions beside each other, as a share of the mean radiance
/// from everywhere. At half of it a window fades into the wall about it, at double what the photograph does not
/// show of the environment is left open without gain elsewhere.
const SMOOTH: f64 = 0.7;

/// One relation of an unknown.
pub(super) struct Relation {
    /// Its index.
    pub(super) unknown: usize,
    /// What it is like.
    pub(super) other: Other,
    /// The standard deviation of their difference.
    pub(super) deviation: f64,
}

/// What an unknown is like.
pub(super) enum Other {
    /// Another unknown.
    Unknown(usize),
    /// A number that is known.
    Fixed(f64),
}

impl Relation {
    /// How far apart both are.
    pub(super) fn difference(&self, value: impl Fn(usize) -> f64) -> f64 {
        let other = match self.other {
            Other::Unknown(other) => value(other),
            Other::Fixed(other) => other,
        };
        value(self.unknown) - other
    }

    /// The indices of its unknowns, each with its sign in the difference.
    pub(super) fn signs(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        let other = match self.other {
            Other::Unknown(other) => Some((other, -1.0)),
            Other::Fixed(_) => None,
        };
        std::iter::once((self.unknown, 1.0)).chain(other)
    }
}

/// All relations of the unknowns in `list`.
pub(super) fn find(list: &[Unknown], at: At<'_>) -> Vec<Relation> {
    let of = |(index, unknown): (usize, &Unknown)| {
        let kind = parameters::of(unknown.quantity);
        if kind.is_nuisance() {
            return None;
        }
        let Like { group, within } = at.guess.problem.groups[unknown.of].expected.like?;
        let other = &at.guess.groups[group].hypothesis;
        let is_uniform = |hypothesis: &Hypothesis| *hypothesis != Hypothesis::Textured;
        let own = &at.guess.groups[unknown.of].hypothesis;
        let has_it =
            hypothesis::quantities(*other, &at.guess.materials[group]).contains(&unknown.quantity);
        if !(has_it && is_uniform(other) && is_uniform(own)) {
            return None;
        }
        let named = Unknown { of: group, ..*unknown };
        let value = kind.value(at, &named);
        let deviation = kind.likeness(value, within)?;
        let other = match list.iter().position(|unknown| *unknown == named) {
            Some(place) => Other::Unknown(place),
            None if at.guess.problem.groups[group].role == Role::Known => Other::Fixed(value),
            None => return None,
        };
        Some(Relation { unknown: index, other, deviation })
    };
    let alike = list.iter().enumerate().filter_map(of);
    alike.chain(neighbours(list, at)).collect()
}

/// Neighbouring parts of an unknown environment differ by about [`SMOOTH`] of the mean of such parts, channel by
/// channel.
fn neighbours<'a>(list: &'a [Unknown], at: At<'a>) -> impl Iterator<Item = Relation> + 'a {
    let pairs = &at.guess.problem.neighbouring_lights;
    let place = |of: usize, channel: usize| {
        let wanted = Unknown { quantity: Quantity::Light, of, channel: Some(channel) };
        list.iter().position(|unknown| *unknown == wanted)
    };
    let mean = |channel: usize| {
        let factors = pairs.iter().flatten().map(|of| at.guess.appearance().light(*of as u32));
        factors.map(|factor| f64::from(factor[channel])).sum::<f64>() / (2 * pairs.len()) as f64
    };
    (0..3).flat_map(move |channel| {
        let deviation = SMOOTH * mean(channel).max(f64::MIN_POSITIVE);
        pairs.iter().filter_map(move |[a, b]| {
            let other = Other::Unknown(place(*b, channel)?);
            Some(Relation { unknown: place(*a, channel)?, other, deviation })
        })
    })
}
