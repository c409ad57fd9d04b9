//! The brightness of a source of light, as a multiple of what the scene says: a number a channel, or one
//! for a source whose colour is known.

use super::{At, Linear, ParameterKind, Prior, Range, Start};
use crate::guess::Guess;
use crate::unknown::Unknown;
use unrender_render::Parameter;

/// The factor on a source.
pub(super) struct Light;

/// The standard deviation of the prior, of a factor that starts at about one. Half of it pulls lamps that
/// the scene has three times too dark towards the start; double of it changes nothing that was measured.
pub(super) const DEVIATION: f64 = 2.0;
/// No step changes it by more than this share of itself, so that it stays positive. Half of it takes more
/// passes, one would allow darkness.
pub(super) const STEP: f64 = 0.7;
/// The standard deviation that is small enough. Half of it takes four times the paths; double of it is half a pixel
/// value of 8 bits.
pub(super) const PRECISE: f64 = 1e-3;

impl ParameterKind for Light {
    fn name(&self) -> &'static str {
        "light"
    }

    fn is_nuisance(&self) -> bool {
        true
    }

    fn prior(&self, _: &Guess<'_>, _: &Unknown) -> Prior {
        Prior { mean: None, deviation: DEVIATION }
    }

    fn precise_enough(&self, _: &Guess<'_>, _: &Unknown) -> f64 {
        PRECISE
    }

    fn value(&self, at: At<'_>, u: &Unknown) -> f64 {
        f64::from(at.guess.appearance().light(u.of as u32)[u.channel.unwrap_or(0)])
    }

    fn set(&self, guess: &mut Guess<'_>, _: &Start, u: &Unknown, value: f64) {
        match u.channel {
            Some(channel) => guess.set_light(u.of, channel, value as f32),
            None => (0..3).for_each(|channel| guess.set_light(u.of, channel, value as f32)),
        }
    }

    fn range(&self, _: &Guess<'_>, _: &Unknown, value: f64) -> Range {
        Range { low: 0.0, high: f64::INFINITY, step: STEP * value }
    }

    fn parameters(&self, of: u32) -> [Parameter; 2] {
        [Parameter::Light(of); 2]
    }

    fn derivative(&self, _: At<'_>, _: &Unknown, linear: &Linear<'_>) -> f64 {
        linear.derivative
    }
}
