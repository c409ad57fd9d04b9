//! Scores as aligned columns.

use super::{GroupScore, Worst};

/// One line a group under a line of headings, and a last line with the worst of all.
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
    aligned(&rows)
}

/// A row's cells; what is missing comes last.
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
    match score.status {
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

/// Text to the left, numbers to the right, two spaces between.
fn aligned(rows: &[[String; 9]]) -> String {
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 9] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(widths).enumerate().filter(|(_, (_, width))| *width > 0);
        let cells: Vec<String> = cells
            .map(|(column, (cell, width))| match column {
                3..=7 => format!("{cell:>width$}"),
                _ => format!("{cell:<width$}"),
            })
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}
