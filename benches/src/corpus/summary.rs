//! The summary of a family: the numbers in its last line.

use super::family::Family;
use super::result::Scored;
use super::score::{GroupScore, wilson};

/// All groups of the runs.
pub(crate) fn groups(runs: &[Scored]) -> impl Iterator<Item = &GroupScore> {
    runs.iter().flat_map(|run| &run.groups)
}

/// How many of `groups` have a right hypothesis, and how many there are.
pub(crate) fn right<'a>(groups: impl Iterator<Item = &'a GroupScore>) -> (usize, usize) {
    groups.fold((0, 0), |(right, all), group| {
        (right + usize::from(group.verdict.is_right()), all + 1)
    })
}

/// How many parameters are within two of their standard deviations, and how many have one.
pub(crate) fn covered<'a>(groups: impl Iterator<Item = &'a GroupScore>) -> (usize, usize) {
    groups
        .flat_map(|group| &group.errors.in_std)
        .fold((0, 0), |(within, all), ratio| (within + usize::from(*ratio <= 2.0), all + 1))
}

/// The errors of rho_d.
pub(crate) fn rho_d<'a>(groups: impl Iterator<Item = &'a GroupScore>) -> Vec<f64> {
    groups.filter_map(|group| group.errors.rho_d).collect()
}

/// The last line of a family.
pub(crate) fn line(family: Family, runs: &[Scored]) -> String {
    let (right, all) = right(groups(runs));
    let rho_d = rho_d(groups(runs));
    let (within, stated) = covered(groups(runs));
    let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
    let silent = groups(runs).filter(|group| group.is_silent_failure()).count();
    format!(
        "{}: {:.1} % of {all} groups right, rho_d median {:.4}, 95th percentile {:.3}, \
         coverage {:.1} %, silent failures {silent}",
        family.name(),
        percent(right, all),
        wilson::quantile(&rho_d, 0.5).unwrap_or(0.0),
        wilson::quantile(&rho_d, 0.95).unwrap_or(0.0),
        percent(within, stated),
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::family::Renderer;
    use super::super::recover::Outcome;
    use super::super::score::{Errors, Verdict};
    use super::super::spoil::Dial;
    use super::super::store::Format;
    use super::*;

    /// A run with right and wrong groups.
    pub(crate) fn example() -> Scored {
        let group = |verdict, rho_d: f64, error: f64, status: &str| GroupScore {
            group: "wall".to_owned(),
            pixels: 900,
            truth: "diffuse".to_owned(),
            found: "diffuse".to_owned(),
            status: status.to_owned(),
            verdict,
            errors: Errors { rho_d: Some(rho_d), in_std: vec![1.0, 3.0], ..Errors::default() },
            error,
            floor: 0.02,
        };
        Scored::example(
            (1, Renderer::Mitsuba, Format::Png, Dial::Exact),
            Outcome::default(),
            vec![
                group(Verdict::Right, 0.002, 0.02, "recovered"),
                group(Verdict::Wrong, 0.2, 0.5, "recovered"),
                group(Verdict::Wrong, 0.3, 0.5, "doubtful"),
                group(Verdict::Simpler, 0.004, 0.03, "recovered"),
            ],
        )
    }

    #[test]
    fn the_last_line_counts() {
        let line = line(Family::InModel, &[example()]);
        assert_eq!(
            line,
            "in-model: 50.0 % of 4 groups right, rho_d median 0.0040, 95th percentile 0.300, \
             coverage 50.0 %, silent failures 1"
        );
    }
}
