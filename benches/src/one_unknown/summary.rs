//! The last lines: how many groups are right, whether the light is wrong, and the likely cause of wrong
//! groups.

use super::row::Row;
use crate::corpus::score::Verdict;

/// The photograph contradicts a true material whose error is this many times that of the result. At half of
/// it every fit contradicts the truth, since it follows the noise too; at double wrong light is not detected
/// by small groups.
const CONTRADICTED: f64 = 1.5;
/// Renderers agree to half a percent of a group's light: the true material contradicts the photograph from
/// twice that on. At half of it noise contradicts it, at double light that is wrong by 2 % passes.
const DISAGREEMENT: f64 = 0.01;

/// The lines below the table of `rows`, which took `seconds` in all.
pub(super) fn text(rows: &[Row], seconds: f64) -> String {
    let groups = names(rows.iter().filter(|row| row.verdict.is_some()));
    let wrong: Vec<&Row> = rows.iter().filter(|row| row.verdict == Some(Verdict::Wrong)).collect();
    let right = groups.len() - names(wrong.iter().copied()).len();
    let seeds = rows.iter().map(|row| row.seed + 1).max().unwrap_or(0);
    let of_seeds = if seeds > 1 { format!(" with each of {seeds} seeds") } else { String::new() };
    let mut lines = vec![format!(
        "{right} of {} groups right{of_seeds}{}; {seconds:.1} s",
        groups.len(),
        worst(rows)
    )];
    let contradicted = names(rows.iter().filter(|row| is_contradicted(row)));
    if !contradicted.is_empty() {
        lines.push(format!(
            "with their true materials these groups do not look like the photograph: {}; the light \
             or the model is wrong",
            contradicted.join(", ")
        ));
    }
    let because = if contradicted.is_empty() {
        "the true material explains the photograph about as well: the choice of the hypothesis is \
         wrong, or the photograph does not determine it"
    } else {
        "wrong light may be the cause"
    };
    let mut told: Vec<&str> = Vec::new();
    for Row { group, found, truth, .. } in wrong {
        if !told.contains(&group.as_str()) {
            told.push(group);
            lines.push(format!("{group} is {truth} and was found {found}: {because}"));
        }
    }
    if right > 0 && told.is_empty() && contradicted.is_empty() {
        lines.push(
            "all are right if their neighbours are: their errors in the whole recovery come from \
             their neighbours"
                .to_owned(),
        );
    }
    lines.join("\n")
}

/// The groups of `rows`, each once.
fn names<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.group.as_str()) {
            names.push(&row.group);
        }
    }
    names
}

/// Whether the group's true material does not look like the photograph, and another one does.
fn is_contradicted(row: &Row) -> bool {
    let (Some(error), Some(at_truth)) = (row.error, row.error_at_truth) else { return false };
    at_truth > DISAGREEMENT && at_truth > CONTRADICTED * error
}

/// The largest error of a parameter in all rows, as a part of a sentence.
fn worst(rows: &[Row]) -> String {
    let numbers = rows.iter().filter_map(|row| Some((row.numbers.worst()?, &row.group)));
    let worst = numbers.max_by(|a, b| a.0.total_cmp(&b.0));
    let said = |(error, group): (f64, &String)| {
        format!("; the worst parameter is {error:.1} standard deviations off (of {group})")
    };
    worst.map_or(String::new(), said)
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::example;
    use super::*;

    #[test]
    fn groups_that_are_right_with_every_seed_are_counted() {
        let rows = [
            example("floor", 0, Verdict::Right),
            example("floor", 1, Verdict::Wrong),
            example("floor", 2, Verdict::Wrong),
            example("table", 0, Verdict::Right),
            example("table", 1, Verdict::Simpler),
            Row { verdict: None, ..example("hidden", 0, Verdict::Right) },
        ];
        let text = text(&rows, 12.34);
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some(
                "1 of 2 groups right with each of 3 seeds; the worst parameter is 2.0 standard \
                 deviations off (of hidden); 12.3 s"
            )
        );
        let wrong = lines.next().unwrap();
        assert!(wrong.starts_with("floor is isotropic and was found diffuse: the true"), "{wrong}");
        assert_eq!(lines.next(), None);
    }

    #[test]
    fn right_groups_point_at_their_neighbours() {
        let text = text(&[example("floor", 0, Verdict::Right)], 1.0);
        assert!(text.starts_with("1 of 1 groups right; "), "{text}");
        assert!(text.contains("come from their neighbours"), "{text}");
    }

    #[test]
    fn a_truth_that_the_photograph_contradicts_points_at_the_light() {
        let right = example("wall", 0, Verdict::Right);
        let wrong = Row { error: Some(0.3), ..example("floor", 0, Verdict::Wrong) };
        let rows = [Row { error_at_truth: Some(0.1), ..right.clone() }, wrong];
        let text = text(&rows, 1.0);
        assert!(text.contains("like the photograph: wall; the light or"), "{text}");
        assert!(text.ends_with("found diffuse: wrong light may be the cause"), "{text}");
        let faint = Row { error: Some(0.001), error_at_truth: Some(0.005), ..right };
        assert!(!is_contradicted(&faint));
    }
}
