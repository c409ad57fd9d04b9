//! The reflectances of a group, a number a channel, between zero and one.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::hypothesis::{Hypothesis, textured};
use crate::unknown::{Quantity, Unknown};
use unrender_render::Parameter;

/// The diffuse reflectance; of a texture its mean.
pub(super) struct Diffuse;
/// The specular reflectance.
pub(super) struct Specular;

/// The standard deviation of the prior: nothing in [0, 1] is unlikely. Half of it pulls black and white
/// surfaces towards the start; double of it changes nothing that was measured.
const DEVIATION: f64 = 0.5;
/// The standard deviation of the prior of a texture's mean, for a texture that is seen as a whole, and what
/// is added if nothing of it is seen: seen texels are known from their own pixels, which the refinement does
/// not use, and the others are guesses from these. At half or double of either, the stated uncertainty of the groups
/// that it lights is too small or too large.
const TEXTURE: f64 = 0.003;
const UNSEEN: f64 = 0.15;
/// The prior mean of a group out of sight without a starting value: the middle.
const MIDDLE: f64 = 0.5;

/// No step changes a reflectance by more than this. Half of it takes more passes; double of it goes
/// beyond where the light between groups is about linear in it.
const STEP: f64 = 0.3;
/// Nor the specular reflectance of a lobe by more than this share of its brightest channel, or what is hardly visible,
/// if that is more: the strength of a lobe and its roughness are not linear in each other. Half of it takes more
/// passes, double of it lets lobes vanish in one step.
const STEP_LOBE: f64 = 0.6;
const STEP_LOBE_MIN: f64 = 0.002;

/// The standard deviations that are small enough: of a reflectance that is seen, and of one that is known only by the
/// light that it sends to others, never precisely. With half of it and of the other blocks' a room of 11 groups takes
/// half as long again and comes no nearer to the truth; double was not tried.
const PRECISE: f64 = 1.4e-3;
const PRECISE_UNSEEN: f64 = 1e-2;

/// Reflectances of like materials differ by a share of them, or of this if it is larger: relative differences of nearly
/// black ones mean nothing. At half of it black groups are tied closer than anyone means, at double of it grey ones
/// looser.
const DARK: f64 = 0.02;

fn likeness(value: f64, within: f64) -> Option<f64> {
    Some(within * value.max(DARK))
}

fn is_out_of_sight(guess: &Guess<'_>, group: usize) -> bool {
    guess.observation.pixels_of_group[group].is_empty()
}

fn precise_enough(guess: &Guess<'_>, group: usize) -> f64 {
    if is_out_of_sight(guess, group) { PRECISE_UNSEEN } else { PRECISE }
}

/// The channel of an unknown that has one.
fn channel(u: &Unknown) -> usize {
    u.channel.unwrap_or(0)
}

impl ParameterKind for Diffuse {
    fn name(&self) -> &'static str {
        "rho_d"
    }

    fn complement(&self) -> Option<Quantity> {
        Some(Quantity::RhoS)
    }

    fn prior(&self, guess: &Guess<'_>, u: &Unknown) -> Prior {
        let of_group = &guess.groups[u.of];
        let deviation = if of_group.hypothesis == Hypothesis::Textured {
            let seen = of_group.seen_texels.as_ref();
            TEXTURE + UNSEEN * f64::from(seen.map_or(0.0, textured::unseen_share))
        } else {
            DEVIATION
        };
        // The ladder has no answer for groups out of sight.
        let expected = &guess.problem.groups[u.of].expected;
        let start = expected.start.rho_d.map_or(MIDDLE, |start| f64::from(start[channel(u)]));
        Prior { mean: is_out_of_sight(guess, u.of).then_some(start), deviation }
    }

    fn precise_enough(&self, guess: &Guess<'_>, u: &Unknown) -> f64 {
        precise_enough(guess, u.of)
    }

    fn likeness(&self, value: f64, within: f64) -> Option<f64> {
        likeness(value, within)
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        f64::from(at.guess.materials[u.of].rho_d[channel(u)])
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        let material = &mut guess.materials[u.of];
        match &guess.groups[u.of].seen_texels {
            Some(seen) => textured::set_mean(material, seen, channel(u), value as f32),
            None => material.rho_d[channel(u)] = value as f32,
        }
    }

    fn range(&self, guess: &Guess<'_>, u: &Unknown, _: f64) -> Range {
        let [low, high] = guess.problem.groups[u.of].expected.bounds.rho_d;
        let [low, high] = [low, high].map(|bound| f64::from(bound[channel(u)]));
        Range { low, high, step: STEP }
    }

    fn parameters(&self, of: u32) -> [Parameter; 2] {
        [Parameter::RhoD(of); 2]
    }

    fn derivative(&self, at: At<'_>, u: &Unknown, linear: &Linear<'_>) -> f64 {
        if at.guess.materials[u.of].texture.is_none() {
            return linear.derivative;
        }
        // The renderer's derivative is by a factor on the texture.
        linear.derivative / self.value(at, u).max(f64::from(textured::MEAN_MIN))
    }
}

impl ParameterKind for Specular {
    fn name(&self) -> &'static str {
        "rho_s"
    }

    fn prior(&self, _: &Guess<'_>, _: &Unknown) -> Prior {
        Prior { mean: None, deviation: DEVIATION }
    }

    fn precise_enough(&self, guess: &Guess<'_>, u: &Unknown) -> f64 {
        precise_enough(guess, u.of)
    }

    fn likeness(&self, value: f64, within: f64) -> Option<f64> {
        likeness(value, within)
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        f64::from(at.guess.materials[u.of].rho_s[channel(u)])
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        guess.materials[u.of].rho_s[channel(u)] = value as f32;
    }

    fn range(&self, guess: &Guess<'_>, u: &Unknown, _: f64) -> Range {
        let material = &guess.materials[u.of];
        let brightest = f64::from(material.rho_s.max_element());
        let of_lobe = (STEP_LOBE * brightest).clamp(STEP_LOBE_MIN, STEP);
        let [low, high] = guess.problem.groups[u.of].expected.bounds.rho_s;
        let [low, high] = [low, high].map(|bound| f64::from(bound[channel(u)]));
        Range { low, high, step: if material.is_glossy() { of_lobe } else { STEP } }
    }

    fn parameters(&self, of: u32) -> [Parameter; 2] {
        [Parameter::RhoS(of); 2]
    }

    fn derivative(&self, _: At<'_>, _: &Unknown, linear: &Linear<'_>) -> f64 {
        linear.derivative
    }
}
