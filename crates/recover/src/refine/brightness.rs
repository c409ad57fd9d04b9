//! Whether all light is wrong by a factor: a lamp read in another unit, or an exposure that is not the photograph's.
//! Then no reflectances explain the photograph, and the search for them is long and in vain.
//!
//! Reflectances are fitted twice on the same few paths: those of the present hypotheses with the photograph's brightness as
//! it is given, and those of the first ones with a factor on it, one a channel. What is textured counts as uniform:
//! textures explain any light.

use super::passes::Passes;
use super::unknowns::Unknowns;
use crate::expected::ParameterBounds;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::problem::{ExposureRule, Options, RecoverError};
use unrender_scene::Rgb;

/// What a factor on the photograph's brightness would explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Brightness {
    /// How many times as bright as it is the light of the scene would have to be; infinite in a channel in which there is
    /// none.
    pub(crate) factor: Rgb,
    /// The share of the photograph that stays unexplained as it is, and with the factor.
    pub(crate) unexplained: [f64; 2],
}

impl From<Brightness> for RecoverError {
    fn from(Brightness { factor, unexplained }: Brightness) -> Self {
        Self::Unexplained { factor, unexplained, remedy: String::new() }
    }
}

/// The test is made if more than this share of the photograph is unexplained. At half of it 5 scenes more of 35 pay for
/// the test, at double a blue lamp that is four times too dim is missed.
const WORTH_ASKING: f64 = 0.1;
/// The factor has to explain so much of what is unexplained. In 30 of 31 right scenes it explains a tenth at most. At
/// double of it lamps that are four times too dim are missed in all of seven rooms; half of it was not tried.
const EXPLAINS: f64 = 0.4;
/// A factor between this and its reciprocal is not from a wrong unit. Other values were not tried: in right scenes
/// factors that explain nothing are up to 2.1.
const NEAR: f32 = 1.5;

/// The factor by which all light is wrong, if with it the hypotheses of `first`, the initial guess, explain far more
/// than the present ones do without.
pub(crate) fn find(guess: &Guess<'_>, options: &Options, first: &Guess<'_>) -> Option<Brightness> {
    let problem = guess.problem;
    let is_given = matches!(problem.exposure, ExposureRule::Fixed(_))
        && problem.unknown_lights.is_empty()
        && problem.photometric_parameters.is_empty();
    // The project's bounds may be wrong instead; the results say which are touched.
    let is_bounded = problem.groups.iter().any(|g| g.expected.bounds != ParameterBounds::default());
    let is_asked = Unknowns::of(guess).len() > 0;
    if !is_given || is_bounded || !is_asked || unexplained(guess) < WORTH_ASKING {
        return None;
    }
    let mut passes = Passes::new(options);
    let mut fit = |from: Guess<'_>, unknowns: &Unknowns, is_free: bool| {
        let (found, left) = passes.nearest(from, unknowns, is_free);
        (left, guess.exposure / found.exposure)
    };
    let present = uniform(guess);
    let free = Unknowns::of(&present);
    let (given, _) = fit(present, &free, false);
    let free = Unknowns::with_exposure(first);
    let other = (given >= WORTH_ASKING).then(|| fit(first.clone(), &free, true));
    let (free, factor) = other?;
    let is_near = factor.max(factor.recip()).max_element() < NEAR;
    let found = free < (1.0 - EXPLAINS) * given && !is_near;
    found.then_some(Brightness { factor, unexplained: [given, free] })
}

/// `guess` with each textured group as a diffuse one, as bright as its texture.
fn uniform<'a>(guess: &Guess<'a>) -> Guess<'a> {
    let mut guess = guess.clone();
    for group in 0..guess.groups.len() {
        if guess.groups[group].hypothesis == Hypothesis::Textured {
            guess.groups[group].hypothesis = Hypothesis::Diffuse;
            guess.materials[group] = guess.plain(group, guess.materials[group].rho_d);
        }
    }
    guess
}

/// The share of the photograph that the fits leave, root mean square over the pixels of the groups that were fitted;
/// infinite where some are textured, whose residual is not known.
fn unexplained(guess: &Guess<'_>) -> f64 {
    if guess.groups.iter().any(|of_group| of_group.hypothesis == Hypothesis::Textured) {
        return f64::INFINITY;
    }
    let pixels = guess.observation.pixels_of_group.iter();
    let fitted = guess.groups.iter().zip(pixels).filter_map(|(of_group, pixels)| {
        Some((of_group.residual?.squared.max(0.0), pixels.len() as f64))
    });
    let (sum, count) =
        fitted.fold((0.0, 0.0), |(sum, n), (s, pixels)| (sum + s * pixels, n + pixels));
    (sum / f64::max(count, 1.0)).sqrt()
}
