//! The reflectances of a group, a number a channel, between zero and one.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::problem::UNSEEN;
use crate::texture;
use crate::unknown::{Quantity, Unknown};
use unrender_render::Parameter;
use unrender_scene::Rgb;

/// The diffuse reflectance; of a texture its mean.
pub(super) struct Diffuse;
/// The specular reflectance.
pub(super) struct Specular;

/// The standard deviation of the prior: nothing in [0, 1] is unlikely. Half of it pulls black and white
/// surfaces towards the start; double of it changes nothing that was measured.
const DEVIATION: f64 = 0.5;
/// The same of a group out of sight, whose mean is [`UNSEEN`]: most walls, ceilings and floors of rooms are within two. At
/// half of it what their light says hardly counts, at double dark rooms behind the camera are bright.
const DEVIATION_UNSEEN: f64 = 0.2;

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
        if !is_out_of_sight(guess, u.of) {
            return Prior { mean: None, deviation: DEVIATION };
        }
        // The ladder has no answer for it.
        let start = guess.problem.groups[u.of].expected.start.rho_d.unwrap_or(Rgb::splat(UNSEEN));
        Prior { mean: Some(f64::from(start[channel(u)])), deviation: DEVIATION_UNSEEN }
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
        texture::set_mean(&mut guess.materials[u.of], channel(u), value as f32);
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
        linear.derivative / self.value(at, u).max(f64::from(texture::MEAN_MIN))
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
