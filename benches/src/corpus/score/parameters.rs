//! Errors of a group's parameters, absolute and in units of their stated standard deviations.

use super::entry::Entry;
use serde::{Deserialize, Serialize};

/// The errors of a group's parameters; none where there is nothing to compare.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// The largest over the channels; of textures, the mean over the pixels that show them.
    pub(crate) rho_d: Option<f64>,
    /// The largest over the channels.
    pub(crate) rho_s: Option<f64>,
    /// The larger difference of the logarithms of the roughnesses.
    pub(crate) ln_alpha: Option<f64>,
    /// The angle between the directions, degrees.
    pub(crate) theta_deg: Option<f64>,
    /// Every parameter's error over its standard deviation, where that is stated.
    pub(crate) in_std: Vec<f64>,
}

/// Compares `found` with `truth`; textures are compared elsewhere.
pub(crate) fn errors(found: &Entry, truth: &Entry) -> Errors {
    let (found, truth) = (found.smoother_first(), truth.smoother_first());
    let std = found.std.clone().unwrap_or_default();
    let mut errors = Errors::default();
    let mut in_std = Vec::new();
    let mut note = |error: f64, std: Option<f64>| {
        if let Some(std) = std.filter(|std| *std > 0.0) {
            in_std.push(error / std);
        }
    };
    if truth.texture.is_none() && found.texture.is_none() {
        errors.rho_d = triple(found.rho_d, truth.rho_d, std.rho_d, &mut note);
    }
    errors.rho_s = triple(found.rho_s, truth.rho_s, std.rho_s, &mut note);
    let is_rough = |entry: &Entry| entry.alpha_x.is_some_and(|alpha| alpha > 0.0);
    if is_rough(&found) && is_rough(&truth) {
        let brushed = |e: &Entry| e.alpha_y.unwrap_or(0.0) > 1.01 * e.alpha_x.unwrap_or(0.0);
        let pairs = [
            (found.alpha_x, truth.alpha_x, std.alpha_x),
            (found.alpha_y, truth.alpha_y, std.alpha_y),
        ];
        // The two roughnesses of a lobe without a direction are one parameter.
        let numbers = if brushed(&truth) || brushed(&found) { 2 } else { 1 };
        for (found, truth, std) in pairs.into_iter().take(numbers) {
            let (Some(found), Some(truth)) = (found, truth) else { continue };
            let error = (found / truth).ln().abs();
            errors.ln_alpha = Some(errors.ln_alpha.unwrap_or(0.0).max(error));
            note((found - truth).abs(), std);
        }
        if brushed(&truth)
            && let (Some(a), Some(b)) = (found.theta_deg, truth.theta_deg)
        {
            let turned = (a - b).rem_euclid(180.0);
            let error = turned.min(180.0 - turned);
            errors.theta_deg = Some(error);
            note(error, std.theta_deg);
        }
    }
    errors.in_std = in_std;
    errors
}

fn triple(
    found: Option<[f64; 3]>,
    truth: Option<[f64; 3]>,
    std: Option<[f64; 3]>,
    note: &mut impl FnMut(f64, Option<f64>),
) -> Option<f64> {
    let (found, truth) = (found?, truth?);
    let errors: [f64; 3] = std::array::from_fn(|c| (found[c] - truth[c]).abs());
    (0..3).for_each(|c| note(errors[c], std.map(|std| std[c])));
    errors.into_iter().reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::entry::Stds;
    use super::*;

    fn lobe(alpha_x: f64, alpha_y: f64, theta_deg: f64) -> Entry {
        Entry {
            rho_d: Some([0.1, 0.2, 0.3]),
            rho_s: Some([0.5; 3]),
            alpha_x: Some(alpha_x),
            alpha_y: Some(alpha_y),
            theta_deg: Some(theta_deg),
            ..Entry::default()
        }
    }

    #[test]
    fn a_lobe_said_the_other_way_round_is_the_same() {
        let errors = errors(&lobe(0.3, 0.1, 100.0), &lobe(0.1, 0.3, 10.0));
        assert_eq!(errors.ln_alpha, Some(0.0));
        assert!(errors.theta_deg.unwrap() < 1e-9, "{errors:?}");
        assert_eq!((errors.rho_d, errors.rho_s), (Some(0.0), Some(0.0)));
    }

    #[test]
    fn errors_count_in_their_standard_deviations() {
        let std = Stds { rho_d: Some([0.01, 0.02, 0.0]), alpha_x: Some(0.05), ..Stds::default() };
        let found = Entry { rho_d: Some([0.12, 0.2, 0.3]), std: Some(std), ..lobe(0.2, 0.2, 0.0) };
        let errors = errors(&found, &lobe(0.1, 0.1, 0.0));
        assert!((errors.rho_d.unwrap() - 0.02).abs() < 1e-9);
        assert!((errors.ln_alpha.unwrap() - 2f64.ln()).abs() < 1e-9);
        let expected = [2.0, 0.0, 2.0];
        assert_eq!(errors.in_std.len(), 3, "{errors:?}");
        for (found, expected) in errors.in_std.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{errors:?}");
        }
    }
}
