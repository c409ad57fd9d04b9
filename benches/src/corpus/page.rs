//! Writes `docs/validation/corpus.md`: how to run the corpus, the meaning of its numbers, and the
//! measurements.

use super::family::{Family, Renderer};
use super::relight::Case;
use super::result::Scored;
use super::score::{GroupScore, wilson};
use super::spoil::Dial;
use super::store::Format;
use super::summary;
use crate::Failure;
use crate::table::Table;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use unrender::formats::atomic;

/// The text above the measurements.
const HEAD: &str = include_str!("page_head.md");

/// Marks around the measurements of a family.
fn marks(family: Family) -> (String, String) {
    let name = family.name();
    (format!("<!-- {name} -->"), format!("<!-- end of {name} -->"))
}

/// Puts the measurements of `family` into the page at `path`; those of the other one stay.
///
/// # Errors
/// If the page cannot be written.
pub(crate) fn write(
    path: &Path,
    family: Family,
    runs: &[Scored],
    command: &str,
) -> Result<(), Failure> {
    let before = std::fs::read_to_string(path).unwrap_or_default();
    let mut text = HEAD.trim_end().to_owned() + "\n";
    for each in [Family::InModel, Family::Foreign] {
        let (start, end) = marks(each);
        let body = if each == family {
            section(family, runs, command)
        } else {
            match between(&before, &start, &end) {
                Some(old) => old.trim().to_owned(),
                None => continue,
            }
        };
        let _ = write!(text, "\n{start}\n\n{}\n\n{end}\n", body.trim());
    }
    Ok(atomic::write(path, text.as_bytes())?)
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(start)?;
    Some(rest.split_once(end)?.0)
}

/// The measurements of one family.
pub(crate) fn section(family: Family, runs: &[Scored], command: &str) -> String {
    let mut text = format!("## Measured: {}\n\n", family.name());
    let _ = writeln!(text, "By `{command}`, {}.\n", time::OffsetDateTime::now_utc().date());
    let failed = runs.iter().filter(|run| run.outcome.failure.is_some()).count();
    let seconds: Vec<f64> = runs.iter().map(|run| run.outcome.seconds).collect();
    let at = |share| wilson::quantile(&seconds, share).unwrap_or(0.0);
    let _ = writeln!(
        text,
        "{} runs, {failed} of them failed; {:.0} s in the median, {:.0} s the longest.\n",
        runs.len(),
        at(0.5),
        at(1.0)
    );
    text += &by_kind(runs);
    text += &by_cause(runs);
    text += &parameters(runs);
    text += &errors(runs);
    text += &relit(runs);
    let _ = writeln!(text, "`{}`", summary::line(family, runs));
    text
}

/// Which hypotheses were found for which truth.
fn by_kind(runs: &[Scored]) -> String {
    let mut kinds: BTreeMap<&str, Vec<&GroupScore>> = BTreeMap::new();
    for group in summary::groups(runs) {
        kinds.entry(&group.truth).or_default().push(group);
    }
    let mut table = Table::new([
        "truth",
        "right",
        "of these by a simpler hypothesis",
        "taken for, where wrong",
    ]);
    for (kind, groups) in kinds {
        let (right, all) = summary::right(groups.iter().copied());
        let simpler = groups.iter().filter(|g| g.verdict == super::score::Verdict::Simpler).count();
        let mut wrong: BTreeMap<&str, usize> = BTreeMap::new();
        for group in groups.iter().filter(|group| !group.verdict.is_right()) {
            *wrong.entry(&group.found).or_default() += 1;
        }
        let wrong: Vec<String> = wrong.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
        table.push([
            kind.to_owned(),
            wilson::text(right, all),
            simpler.to_string(),
            if wrong.is_empty() { "-".to_owned() } else { wrong.join(", ") },
        ]);
    }
    format!("### Hypotheses\n\n{}\n", table.text())
}

/// Shares of right groups by model error, format, renderer and lobe.
fn by_cause(runs: &[Scored]) -> String {
    let mut table =
        Table::new(["", "runs", "groups right", "rho_d median", "rho_d 95 %", "silent"]);
    let mut add = |name: String, chosen: &dyn Fn(&Scored) -> bool| {
        let runs: Vec<Scored> = runs.iter().filter(|run| chosen(run)).cloned().collect();
        if runs.is_empty() {
            return;
        }
        let (right, all) = summary::right(summary::groups(&runs));
        let rho_d = summary::rho_d(summary::groups(&runs));
        let silent = summary::groups(&runs).filter(|group| group.is_silent_failure()).count();
        table.push([
            name,
            runs.len().to_string(),
            wilson::text(right, all),
            number(wilson::quantile(&rho_d, 0.5)),
            number(wilson::quantile(&rho_d, 0.95)),
            silent.to_string(),
        ]);
    };
    for dial in Dial::ALL {
        add(format!("model: {}", dial.name()), &|run| run.dial == dial);
    }
    for format in Format::ALL {
        add(format!("photograph: {}", format.name()), &|run| run.format == format);
    }
    for renderer in [Renderer::Mitsuba, Renderer::Cycles, Renderer::Radiance] {
        for brdf in ["ward-gmd", "ggx"] {
            add(format!("{}, {brdf}", renderer.name()), &|run| {
                run.renderer == renderer && run.brdf == brdf
            });
        }
    }
    format!("### By cause\n\n{}\n", table.text())
}

/// Errors of the parameters.
fn parameters(runs: &[Scored]) -> String {
    let mut table = Table::new(["parameter", "groups", "median", "95th percentile"]);
    let mut add = |name: &str, of: &dyn Fn(&GroupScore) -> Option<f64>| {
        let values: Vec<f64> = summary::groups(runs).filter_map(of).collect();
        table.push([
            name.to_owned(),
            values.len().to_string(),
            number(wilson::quantile(&values, 0.5)),
            number(wilson::quantile(&values, 0.95)),
        ]);
    };
    let right = |group: &GroupScore| group.verdict.is_right();
    add("rho_d", &|group| group.errors.rho_d);
    add("rho_d, where the hypothesis is right", &|group| {
        group.errors.rho_d.filter(|_| right(group))
    });
    add("rho_s, where it is right", &|group| group.errors.rho_s.filter(|_| right(group)));
    add("ln alpha, where it is right", &|group| group.errors.ln_alpha.filter(|_| right(group)));
    add("direction, degrees, where it is right", &|group| {
        group.errors.theta_deg.filter(|_| right(group))
    });
    let (within, stated) = summary::covered(summary::groups(runs));
    format!(
        "### Numbers\n\n{}\nWithin two standard deviations: {} numbers.\n\n",
        table.text(),
        wilson::text(within, stated)
    )
}

/// The re-rendering's errors.
fn errors(runs: &[Scored]) -> String {
    let mut table = Table::new(["", "median", "95th percentile", "largest"]);
    let mut add = |name: &str, of: &dyn Fn(&GroupScore) -> f64| {
        let values: Vec<f64> = summary::groups(runs).map(of).collect();
        table.push([
            name.to_owned(),
            number(wilson::quantile(&values, 0.5)),
            number(wilson::quantile(&values, 0.95)),
            number(wilson::quantile(&values, 1.0)),
        ]);
    };
    add("error of the re-rendering", &|group| group.error);
    add("noise floor", &|group| group.floor);
    add("error over noise floor", &|group| group.error / group.floor.max(1e-9));
    let doubtful = summary::groups(runs).filter(|group| group.is_doubtful()).count();
    let silent = summary::groups(runs).filter(|group| group.is_silent_failure()).count();
    format!(
        "### Re-rendering, group by group\n\n{}\n{doubtful} groups are `doubtful`; {silent} are \
         silent failures.\n\n",
        table.text()
    )
}

/// New light and new viewpoint.
fn relit(runs: &[Scored]) -> String {
    let relit: Vec<_> = runs.iter().filter_map(|run| run.relit).collect();
    if relit.is_empty() {
        return String::new();
    }
    let mut table = Table::new([
        "",
        "scenes",
        "relative RMSE, median",
        "diffuse only, median",
        "ratio, median",
        "ratio, largest",
        "ratio below 0.8",
    ]);
    let mut add = |name: &str, of: fn(&super::relight::Relit) -> Case| {
        let cases: Vec<Case> = relit.iter().map(of).collect();
        let recovered: Vec<f64> = cases.iter().map(|case| case.recovered).collect();
        let diffuse: Vec<f64> = cases.iter().filter_map(|case| case.diffuse).collect();
        let ratios: Vec<f64> = cases.iter().filter_map(Case::ratio).collect();
        let low = ratios.iter().filter(|ratio| **ratio < 0.8).count();
        table.push([
            name.to_owned(),
            cases.len().to_string(),
            number(wilson::quantile(&recovered, 0.5)),
            number(wilson::quantile(&diffuse, 0.5)),
            number(wilson::quantile(&ratios, 0.5)),
            number(wilson::quantile(&ratios, 1.0)),
            wilson::text(low, ratios.len()),
        ]);
    };
    add("new viewpoint", |relit| relit.viewpoint);
    add("new light", |relit| relit.light);
    let note = if relit.iter().all(|relit| relit.light.diffuse.is_none()) {
        "The command under test has no `--max-rung`, so there is nothing to compare with.\n\n"
    } else {
        ""
    };
    format!("### New light and new viewpoint\n\n{}\n{note}", table.text())
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| {
        if value >= 0.1 { format!("{value:.3}") } else { format!("{value:.4}") }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_has_its_tables_and_ends_with_its_line() {
        let runs = [summary::tests::example()];
        let text = section(Family::InModel, &runs, "corpus");
        for heading in ["### Hypotheses", "### By cause", "### Numbers"] {
            assert!(text.contains(heading), "{heading}");
        }
        assert!(text.contains("| diffuse | 50.0 % ("), "{text}");
        let last = text.lines().last().unwrap();
        assert_eq!(last, format!("`{}`", summary::line(Family::InModel, &runs)));
    }
}
