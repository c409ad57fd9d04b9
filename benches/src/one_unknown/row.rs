//! The result of one group, as a line of the table.

use crate::corpus::score::Verdict;
use unrender::recover::Hypothesis;
use unrender::recover::record::CandidateRecord;
use unrender::score::GroupScore;

/// One recovery of a group.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// The group's name.
    pub(super) group: String,
    /// The seed of the renderings' noise.
    pub(super) seed: u64,
    /// The selected hypothesis.
    pub(super) found: Hypothesis,
    /// The true hypothesis.
    pub(super) truth: Hypothesis,
    /// Whether that is right; none for groups that no pixel shows.
    pub(super) verdict: Option<Verdict>,
    /// The relative error of the group's re-rendering with the result.
    pub(super) error: Option<f64>,
    /// The same with the true material.
    pub(super) error_at_truth: Option<f64>,
    /// The runner-up to the hypothesis that was found; none if nothing was compared with it.
    pub(super) runner_up: Option<RunnerUp>,
    /// The errors of the parameters.
    pub(super) numbers: Numbers,
    /// The time of the recovery.
    pub(super) seconds: f64,
}

/// The best hypothesis of those that were not chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RunnerUp {
    /// Which one.
    pub(super) hypothesis: Hypothesis,
    /// Its information criterion minus that of the chosen one. It is negative if a simpler one was kept,
    /// or if the re-rendering refuted the runner-up.
    pub(super) distance: f64,
}

/// The largest error of each kind of parameter, in units of its stated standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Numbers {
    /// Of the diffuse reflectance.
    pub(super) rho_d: Option<f64>,
    /// Of the specular reflectance.
    pub(super) rho_s: Option<f64>,
    /// Of the roughnesses.
    pub(super) alpha: Option<f64>,
    /// Of the anisotropy direction.
    pub(super) direction: Option<f64>,
}

impl Numbers {
    /// Those of a group that was compared with the truth.
    pub(super) fn of(score: &GroupScore) -> Self {
        let largest = |keys: &[&str]| {
            let parameters = score.parameters.iter().filter(|p| keys.contains(&p.parameter));
            parameters.flat_map(|p| &p.in_std).filter_map(|ratio| *ratio).reduce(f64::max)
        };
        Self {
            rho_d: largest(&["rho_d"]),
            rho_s: largest(&["rho_s"]),
            alpha: largest(&["alpha_x", "alpha_y"]),
            direction: largest(&["theta_deg"]),
        }
    }

    /// The largest of all.
    pub(super) fn worst(&self) -> Option<f64> {
        let all = [self.rho_d, self.rho_s, self.alpha, self.direction];
        all.into_iter().flatten().reduce(f64::max)
    }
}

/// A hypothesis in a selection log: the iteration in which it was tried, and its information criterion minus
/// that of the chosen one.
#[derive(Clone, Copy, Debug)]
struct Compared {
    iteration: usize,
    hypothesis: Hypothesis,
    criterion: f64,
}

/// The runner-up of the hypothesis `found` in the last comparison of `log` that has more than one; none if
/// `found` is not part of it, as for a texture.
pub(super) fn runner_up(log: &[CandidateRecord], found: Hypothesis) -> Option<RunnerUp> {
    let compared: Vec<Compared> = log
        .iter()
        .map(|record| Compared {
            iteration: record.iteration,
            hypothesis: record.hypothesis,
            criterion: record.criterion,
        })
        .collect();
    of_last(&compared, found)
}

fn of_last(log: &[Compared], found: Hypothesis) -> Option<RunnerUp> {
    // A comparison goes from simple to complex within one iteration.
    let is_same =
        |a: &Compared, b: &Compared| a.iteration == b.iteration && a.hypothesis < b.hypothesis;
    let last = log.chunk_by(is_same).rfind(|comparison| comparison.len() > 1)?;
    let own = last.iter().find(|compared| compared.hypothesis == found)?.criterion;
    let others = last.iter().filter(|compared| compared.hypothesis != found);
    let next = others.min_by(|a, b| a.criterion.total_cmp(&b.criterion))?;
    Some(RunnerUp { hypothesis: next.hypothesis, distance: next.criterion - own })
}

/// The lines of a table, which is printed line by line, so that the widths of columns are fixed
/// beforehand.
pub(super) struct Table {
    widths: [usize; COLUMNS],
}

const COLUMNS: usize = 13;
const HEAD: [&str; COLUMNS] = [
    "group",
    "seed",
    "found",
    "truth",
    "verdict",
    "error %",
    "at truth %",
    "ahead by",
    "of",
    "rho_d",
    "rho_s",
    "alpha",
    "direction",
];
/// The columns of text, which are aligned to the left.
const TEXT: [bool; COLUMNS] =
    [true, false, true, true, true, false, false, false, true, false, false, false, false];

impl Table {
    /// For groups of these names.
    pub(super) fn new<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        let longest = |names: &mut dyn Iterator<Item = &str>| {
            names.map(|name| name.chars().count()).max().unwrap_or(0)
        };
        let hypothesis = longest(&mut Hypothesis::ALL.iter().map(|h| h.name()));
        let mut names = names;
        let mut widths = HEAD.map(str::len);
        widths[0] = widths[0].max(longest(&mut names));
        for column in [2, 3, 8] {
            widths[column] = hypothesis;
        }
        Self { widths }
    }

    /// The headings.
    pub(super) fn head(&self) -> String {
        self.aligned(&HEAD.map(str::to_owned), "s")
    }

    /// The line of a group.
    pub(super) fn line(&self, row: &Row) -> String {
        let percent = |error: Option<f64>| number(error.map(|error| 100.0 * error), 2);
        let Numbers { rho_d, rho_s, alpha, direction } = row.numbers;
        let cells = [
            row.group.clone(),
            row.seed.to_string(),
            row.found.to_string(),
            row.truth.to_string(),
            verdict(row.verdict).to_owned(),
            percent(row.error),
            percent(row.error_at_truth),
            number(row.runner_up.map(|next| next.distance), 1),
            row.runner_up.map_or("-".to_owned(), |next| next.hypothesis.to_string()),
            number(rho_d, 1),
            number(rho_s, 1),
            number(alpha, 1),
            number(direction, 1),
        ];
        self.aligned(&cells, &format!("{:.1}", row.seconds))
    }

    fn aligned(&self, cells: &[String; COLUMNS], seconds: &str) -> String {
        let cell = |column: usize| {
            let (cell, width) = (&cells[column], self.widths[column]);
            if TEXT[column] { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        };
        let cells: Vec<String> = (0..COLUMNS).map(cell).collect();
        format!("{}  {seconds:>5}", cells.join("  "))
    }
}

fn verdict(verdict: Option<Verdict>) -> &'static str {
    match verdict {
        Some(Verdict::Right) => "right",
        Some(Verdict::Simpler) => "simpler",
        Some(Verdict::Wrong) => "wrong",
        None => "unseen",
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A group with the right hypothesis.
    pub(in super::super) fn example(group: &str, seed: u64, verdict: Verdict) -> Row {
        Row {
            group: group.to_owned(),
            seed,
            found: if verdict == Verdict::Right {
                Hypothesis::Isotropic
            } else {
                Hypothesis::Diffuse
            },
            truth: Hypothesis::Isotropic,
            verdict: Some(verdict),
            error: Some(0.0123),
            error_at_truth: Some(0.0131),
            runner_up: Some(RunnerUp { hypothesis: Hypothesis::Anisotropic, distance: 14.26 }),
            numbers: Numbers { rho_d: Some(0.84), rho_s: Some(1.96), ..Numbers::default() },
            seconds: 4.04,
        }
    }

    #[test]
    fn lines_stand_below_their_headings() {
        let table = Table::new(["floor", "group_11"].into_iter());
        let row = example("floor", 2, Verdict::Right);
        assert_eq!(
            [table.head(), table.line(&row)],
            [
                "group     seed  found             truth             verdict  error %  at truth %  \
                 ahead by  of                rho_d  rho_s  alpha  direction      s",
                "floor        2  isotropic         isotropic         right       1.23        1.31  \
                 \u{20}   14.3  anisotropic         0.8    2.0      -          -    4.0",
            ]
        );
    }

    #[test]
    fn what_was_not_compared_is_a_dash() {
        let table = Table::new(["floor"].into_iter());
        let numbers = Numbers::default();
        let row = Row {
            verdict: None,
            error: None,
            runner_up: None,
            numbers,
            ..example("floor", 0, Verdict::Right)
        };
        let line = table.line(&row);
        let cells: Vec<&str> = line.split_whitespace().collect();
        let expected =
            ["floor", "0", "isotropic", "isotropic", "unseen", "-", "1.31", "-", "-", "-"];
        assert_eq!(cells[..10], expected);
    }

    fn compared(iteration: usize, of: &[(Hypothesis, f64)]) -> Vec<Compared> {
        let one = |&(hypothesis, criterion)| Compared { iteration, hypothesis, criterion };
        of.iter().map(one).collect()
    }

    #[test]
    fn the_last_comparison_of_several_hypotheses_says_who_is_next() {
        use Hypothesis::{Diffuse, Isotropic, Textured};
        let of = |hypothesis, distance| Some(RunnerUp { hypothesis, distance });
        let log = [
            compared(1, &[(Diffuse, 90.0), (Isotropic, 0.0)]),
            // The same iteration, another comparison.
            compared(1, &[(Diffuse, 20.0), (Isotropic, 0.0)]),
            compared(3, &[(Diffuse, 0.0)]),
        ]
        .concat();
        assert_eq!(of_last(&log, Isotropic), of(Diffuse, 20.0));
        // The choice was not kept: the runner-up is ahead.
        assert_eq!(of_last(&log, Diffuse), of(Isotropic, -20.0));
        assert_eq!(of_last(&log, Textured), None);
        assert_eq!(of_last(&log[4..], Diffuse), None);
        assert_eq!(of_last(&[], Diffuse), None);
    }
}
