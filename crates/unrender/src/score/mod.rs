//! The errors of recovered materials relative to the truth, group by group.
//!
//! `compare` does the arithmetic of one group, `certainty` that of the standard deviations, `table`
//! prints both.

mod certainty;
mod compare;
mod lobe;
pub mod table;

pub use certainty::{Certainty, LightScore, ParameterScore, certainty, score_lights};

use serde::Serialize;
use std::path::Path;
use unrender_formats::FileError;
use unrender_formats::materials::{Hypothesis, MaterialsFile, StatusEntry};

/// The errors of one group; none where the truth has nothing to compare with.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct GroupScore {
    /// The group's name.
    pub group: String,
    /// True if the group counts: recovered, and not stated or assumed on either side.
    pub counted: bool,
    /// The status in the results; none for groups that the results leave out.
    pub status: Option<StatusEntry>,
    /// The selected hypothesis.
    pub hypothesis: Option<Hypothesis>,
    /// The true hypothesis.
    pub true_hypothesis: Option<Hypothesis>,
    /// Largest error of rho_d over the channels; of textures, the mean over the texels.
    pub rho_d: Option<f64>,
    /// Largest error of rho_s over the channels.
    pub rho_s: Option<f64>,
    /// Larger error of the two alphas, percent.
    pub alpha_percent: Option<f64>,
    /// Angle between the anisotropy directions, degrees.
    pub degrees: Option<f64>,
    /// The largest of these errors, in units of its stated standard deviation.
    pub in_std: Option<f64>,
    /// All these parameters, if the results state their standard deviations.
    pub parameters: Vec<ParameterScore>,
    /// Keys that the truth has and the results lack.
    pub missing: Vec<&'static str>,
}

impl GroupScore {
    /// True if the hypothesis is of the right rung of the ladder, or the truth has none.
    pub fn is_hypothesis_right(&self) -> bool {
        let rung = |hypothesis: Option<Hypothesis>| hypothesis.map(Hypothesis::of_paper);
        self.true_hypothesis.is_none() || rung(self.hypothesis) == rung(self.true_hypothesis)
    }
}

/// The largest errors of all groups that count.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct Worst {
    /// Groups that count.
    pub counted: usize,
    /// Those of them whose hypothesis is right.
    pub hypotheses_right: usize,
    /// Of rho_d.
    pub rho_d: Option<f64>,
    /// Of rho_s.
    pub rho_s: Option<f64>,
    /// Of the alphas, percent.
    pub alpha_percent: Option<f64>,
    /// Of the anisotropy direction, degrees.
    pub degrees: Option<f64>,
    /// In units of the standard deviation.
    pub in_std: Option<f64>,
}

/// The largest errors that are accepted; those without a limit are not checked.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Limits {
    /// For rho_d and rho_s.
    pub rho: Option<f64>,
    /// For the alphas, percent.
    pub alpha_percent: Option<f64>,
    /// For the anisotropy direction, degrees.
    pub degrees: Option<f64>,
}

/// Compares `results` with `truth`; textures are relative to the folders. The groups come in the order of the results, then
/// those that these leave out.
///
/// ```
/// use std::path::Path;
/// use unrender::formats::materials::{GroupEntry, MaterialsFile};
/// use unrender::score::score;
///
/// let file = |rho_d| {
///     let mut file = MaterialsFile::default();
///     let entry = GroupEntry { rho_d: Some([rho_d; 3]), ..GroupEntry::default() };
///     file.groups.insert("wall".into(), entry);
///     file
/// };
/// let here = Path::new(".");
/// let scores = score(&file(0.52), here, &file(0.5), here)?;
/// assert!((scores[0].rho_d.unwrap() - 0.02).abs() < 1e-6);
/// # Ok::<(), unrender::formats::FileError>(())
/// ```
///
/// # Errors
/// If a texture cannot be read.
pub fn score(
    results: &MaterialsFile,
    results_folder: &Path,
    truth: &MaterialsFile,
    truth_folder: &Path,
) -> Result<Vec<GroupScore>, FileError> {
    let left_out = truth.groups.keys().filter(|name| !results.groups.contains_key(*name));
    let names = results.groups.keys().chain(left_out);
    let pairs = names.filter_map(|name| truth.groups.get_key_value(name)).map(|(name, wanted)| {
        let counted = compare::counts(truth, wanted);
        let score = match results.groups.get(name) {
            Some(found) => GroupScore {
                counted: counted && compare::counts(results, found),
                ..compare::group(found, results_folder, wanted, truth_folder)?
            },
            None => GroupScore {
                counted,
                true_hypothesis: wanted.hypothesis,
                missing: vec!["group"],
                ..GroupScore::default()
            },
        };
        Ok(GroupScore { group: name.clone(), ..score })
    });
    pairs.collect()
}

/// The worst of the groups that count.
pub fn worst(scores: &[GroupScore]) -> Worst {
    let counted = || scores.iter().filter(|s| s.counted);
    let over = |f: fn(&GroupScore) -> Option<f64>| counted().filter_map(f).reduce(f64::max);
    Worst {
        counted: counted().count(),
        hypotheses_right: counted().filter(|s| s.is_hypothesis_right()).count(),
        rho_d: over(|s| s.rho_d),
        rho_s: over(|s| s.rho_s),
        alpha_percent: over(|s| s.alpha_percent),
        degrees: over(|s| s.degrees),
        in_std: over(|s| s.in_std),
    }
}

impl Limits {
    /// True if any limit is set.
    pub fn any(&self) -> bool {
        self.rho.or(self.alpha_percent).or(self.degrees).is_some()
    }

    /// The errors above their limits, a sentence each; empty if there are none.
    pub fn exceeded(&self, scores: &[GroupScore]) -> Vec<String> {
        let mut faults = Vec::new();
        for score in scores.iter().filter(|s| s.counted) {
            let name = &score.group;
            if !score.is_hypothesis_right() && !score.missing.contains(&"group") {
                faults.push(format!("{name}: the hypothesis is wrong"));
            }
            for key in &score.missing {
                faults.push(format!("{name}: the results have no {key}"));
            }
            for (what, error, limit) in [
                ("rho_d", score.rho_d, self.rho),
                ("rho_s", score.rho_s, self.rho),
                ("alpha (percent)", score.alpha_percent, self.alpha_percent),
                ("direction (degrees)", score.degrees, self.degrees),
            ] {
                if let (Some(error), Some(limit)) = (error, limit)
                    && error > limit
                {
                    faults.push(format!("{name}: {what} is {error:.4} off, above {limit}"));
                }
            }
        }
        if !scores.iter().any(|s| s.counted) {
            faults.push("no group was recovered, so nothing was compared".into());
        }
        faults
    }
}
