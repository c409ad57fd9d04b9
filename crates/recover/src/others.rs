//! What the other groups say of one: how wrong the model and the incident light usually are in this scene.

use crate::guess::{GroupGuess, Guess};
use crate::observe::model_error::LightError;

/// Candidates are distinguished down to the median model error of the other groups. At the lower quartile, the errors
/// of lamps that are only roughly modelled pass for lobes in real scenes; at the upper one, faint lobes are found only
/// once every other group is right.
pub(crate) const MIDDLE: f64 = 0.5;
/// The incident light of a group is wrong by at most so many times the median error of the other groups' light: it
/// comes from the same lamps and walls. At half of it the group beside a wrong one gets a lobe, at double broad faint
/// lobes pass for errors of the light.
const LIKE_OTHERS: f64 = 2.0;

/// The quantile at `share` of the model errors of the groups other than `group`; zero without others.
pub(crate) fn error_of_others(guess: &Guess<'_>, group: usize, share: f64) -> f64 {
    of_others(guess, group, share, |of| Some(of.likelihood?.error.share)).unwrap_or(0.0)
}

/// The quantile at `share` of the relative residuals, without noise, of the groups other than `group`; zero without
/// others, and where it is negative, as it may be by noise that is larger than the residual.
pub(crate) fn left_by_others(guess: &Guess<'_>, group: usize, share: f64) -> f64 {
    let left = |of_group: &GroupGuess| of_group.residual.map(|residual| residual.squared);
    of_others(guess, group, share, left).unwrap_or(0.0).max(0.0).sqrt()
}

/// The quantile at `share` of the values `of` the other groups; none without others.
fn of_others(
    guess: &Guess<'_>,
    group: usize,
    share: f64,
    of: impl Fn(&GroupGuess) -> Option<f64>,
) -> Option<f64> {
    // Known groups have no error, and nothing is noted of those with a texture.
    let others = (0..guess.groups.len()).filter(|g| *g != group);
    let mut values: Vec<f64> = others.filter_map(|g| of(&guess.groups[g])).collect();
    values.sort_by(f64::total_cmp);
    values.get((share * values.len() as f64) as usize).copied()
}

/// The largest error of the incident light that fits of `group` may assume; no limit without
/// others.
pub(crate) fn light_of_others(guess: &Guess<'_>, group: usize) -> LightError {
    let others = of_others(guess, group, MIDDLE, |of| Some(of.likelihood?.light.share));
    LightError { share: others.map_or(f64::INFINITY, |share| LIKE_OTHERS * share) }
}
