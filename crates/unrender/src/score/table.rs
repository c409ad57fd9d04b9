//! Scores as aligned columns.

use super::{Certainty, GroupScore, LightScore, ParameterScore, Worst};
use std::ops::Range;

/// One line per group under a line of headings, and a last line with the worst of all.
pub fn table(scores: &[GroupScore], worst: &Worst) -> String {
    let with_std = scores.iter().any(|s| s.in_std.is_some());
    let mut rows = vec![row(
        "group",
        "status",
        "hypothesis",
        "",
        ["rho_d", "rho_s", "alpha %", "degrees", "err/std"],
    )];
    for score in scores {
        rows.push(row(
            &score.group,
            &status(score),
            &hypothesis(score),
            &score.missing.join(", "),
            numbers([score.rho_d, score.rho_s, score.alpha_percent, score.degrees, score.in_std])
                .each_ref()
                .map(String::as_str),
        ));
    }
    let of_worst = [worst.rho_d, worst.rho_s, worst.alpha_percent, worst.degrees, worst.in_std];
    rows.push(row(
        "worst",
        &format!("{} counted", worst.counted),
        &format!("{} right", worst.hypotheses_right),
        "",
        numbers(of_worst).each_ref().map(String::as_str),
    ));
    if !with_std {
        rows.iter_mut().for_each(|cells| cells[7].clear());
    }
    aligned(&rows, 3..8)
}

/// One line per light under a line of headings; empty if no light was compared.
pub fn lights(scores: &[LightScore]) -> String {
    if scores.is_empty() {
        return String::new();
    }
    let mut rows = vec![["light", "error %"].map(str::to_owned)];
    let percent = |score: &LightScore| score.percent.map_or("-".into(), |p| format!("{p:.2}"));
    rows.extend(scores.iter().map(|score| [score.light.clone(), percent(score)]));
    aligned(&rows, 1..2)
}

/// One line per parameter, of the groups that count and of the lights, whose standard deviation the
/// results state, and a last line that sums them up.
pub fn parameters(groups: &[GroupScore], lights: &[LightScore], certainty: &Certainty) -> String {
    let mut rows = vec![["group", "parameter", "error", "std", "err/std"].map(str::to_owned)];
    for group in groups.iter().filter(|group| group.counted) {
        rows.extend(group.parameters.iter().map(|parameter| of_parameter(&group.group, parameter)));
    }
    for light in lights {
        rows.extend(light.parameters.iter().map(|parameter| of_parameter(&light.light, parameter)));
    }
    let Certainty { parameters, percent_within_one, percent_within_two, worst } = certainty;
    format!(
        "{}{parameters} parameters: {percent_within_one:.0} % within 1 std, \
         {percent_within_two:.0} % within 2 std, worst {worst:.1}\n",
        aligned(&rows, 2..5)
    )
}

fn of_parameter(owner: &str, score: &ParameterScore) -> [String; 5] {
    let ratio = |ratio: &Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
    let joined = |cells: Vec<String>| cells.join(" ");
    [
        owner.to_owned(),
        score.parameter.to_owned(),
        joined(score.error.iter().copied().map(significant).collect()),
        joined(score.std.iter().copied().map(significant).collect()),
        joined(score.in_std.iter().map(ratio).collect()),
    ]
}

/// `value` to two significant digits, but no more than six after the point.
fn significant(value: f64) -> String {
    let digits = if value > 0.0 { (1.0 - value.log10().floor()).clamp(0.0, 6.0) } else { 0.0 };
    format!("{value:.*}", digits as usize)
}

/// A row's cells; missing keys come last.
fn row(
    group: &str,
    status: &str,
    hypothesis: &str,
    missing: &str,
    errors: [&str; 5],
) -> [String; 9] {
    let missing = if missing.is_empty() { String::new() } else { format!("no {missing}") };
    let [a, b, c, d, e] = errors;
    [group, status, hypothesis, a, b, c, d, e, &missing].map(str::to_owned)
}

fn status(score: &GroupScore) -> String {
    match &score.status {
        Some(status) if score.counted => status.to_string(),
        Some(status) => format!("({status})"),
        None => "-".to_owned(),
    }
}

fn hypothesis(score: &GroupScore) -> String {
    let found = score.hypothesis.map_or("-", |h| h.name());
    match score.true_hypothesis {
        Some(truth) if score.hypothesis != Some(truth) => format!("{found}, is {truth}"),
        _ => found.to_owned(),
    }
}

fn numbers(errors: [Option<f64>; 5]) -> [String; 5] {
    let digits = [4, 4, 2, 2, 1];
    std::array::from_fn(|i| match errors[i] {
        Some(error) => format!("{error:.*}", digits[i]),
        None => "-".to_owned(),
    })
}

/// Text to the left, the columns of `numbers` to the right, two spaces between; empty columns are
/// left out.
fn aligned<const N: usize>(rows: &[[String; N]], numbers: Range<usize>) -> String {
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(widths).enumerate().filter(|(_, (_, width))| *width > 0);
        let cells: Vec<String> = cells
            .map(|(column, (cell, width))| match numbers.contains(&column) {
                true => format!("{cell:>width$}"),
                false => format!("{cell:<width$}"),
            })
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}
