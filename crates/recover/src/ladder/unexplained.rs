//! Which groups stay unexplained, relative to the whole picture.

use crate::guess::Guess;
use crate::observe::model_error::ModelError;

/// The unknown groups that each leave more of the picture than all together would by the model error that is always
/// `allowed` for; those that leave most come first.
pub(super) fn groups(guess: &Guess<'_>, allowed: ModelError) -> Vec<usize> {
    let unknown = guess.visible_unknowns();
    let left = |group: usize, error: f64| {
        error * error * guess.observation.pixels_of_group[group].len() as f64
    };
    let least: f64 = unknown.iter().map(|group| left(*group, allowed.share)).sum();
    let leaves = |group: usize| {
        let error = guess.groups[group].likelihood?.error.share;
        Some((group, left(group, error))).filter(|(_, left)| *left > least)
    };
    let mut groups: Vec<(usize, f64)> = unknown.iter().filter_map(|group| leaves(*group)).collect();
    groups.sort_by(|a, b| b.1.total_cmp(&a.1));
    groups.into_iter().map(|(group, _)| group).collect()
}
