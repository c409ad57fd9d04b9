//! The verdict at the top of the page: how it came out, in words, and what to look at first.

use super::number::{Shown, count, number};
use super::{Key, RunFolder, groups};
use crate::run::{DifferenceEntry, Ended, RunGroup};
use maud::{Markup, html};
use unrender_formats::materials::Status;

/// How many things to look at are listed: more are not read above the fold, and at half of it a doubtful group and a
/// warning do not fit.
const LISTED: usize = 3;

/// The sentences, and the list.
pub(super) fn verdict(source: &RunFolder<'_>) -> Markup {
    html! {
        p class="verdict" { (statuses(source)) " " (differences(source)) " " (ended(source)) }
        (first(source))
    }
}

/// "6 groups recovered, none doubtful."
fn statuses(source: &RunFolder<'_>) -> Markup {
    let (verdict, key) = (source.run.verdict, source.key.at("verdict"));
    html! {
        strong {
            @match verdict.recovered {
                0 => "No group recovered",
                1 => { (count(&key.at("recovered"), verdict.recovered)) " group recovered" }
                _ => { (count(&key.at("recovered"), verdict.recovered)) " groups recovered" }
            }
            @match verdict.doubtful {
                0 => ", none doubtful",
                _ => { ", " (count(&key.at("doubtful"), verdict.doubtful)) " doubtful" }
            }
            @if verdict.assumed > 0 {
                ", " (count(&key.at("assumed"), verdict.assumed)) " assumed"
            }
            "."
        }
    }
}

/// How far the re-renderings are from their photographs.
fn differences(source: &RunFolder<'_>) -> Markup {
    let photographs = source.photographs();
    let all = photographs.iter().filter_map(|of| {
        let key = of.key.at("pictures").at("difference");
        Some((key, of.pictures.difference.as_ref()?))
    });
    let all: Vec<_> = all.collect();
    html! {
        @match &all[..] {
            [] => {}
            [(key, only)] => (difference(key, only, source.run.verdict.doubtful > 0)),
            [..] => {
                "The re-renderings differ from their photographs by "
                @for (index, (key, of)) in all.iter().enumerate() {
                    @if index > 0 { ", " }
                    (number(&key.at("beyond_noise"), of.beyond_noise, Shown::Share)) " %"
                }
                "."
            }
        }
    }
}

/// "The re-rendering differs from the photograph by 0.4 %, beside noise of 1.5 %."
/// All pixels together may match where groups are doubtful.
fn difference(key: &Key, of: &DifferenceEntry, is_doubtful: bool) -> Markup {
    let subject =
        if is_doubtful { "Over all pixels, the re-rendering" } else { "The re-rendering" };
    let share = |part: &str, value: f64| {
        html! { span class="whole" { (number(&key.at(part), value, Shown::Share)) " %" } }
    };
    let noise = share("noise", of.noise);
    html! {
        @if of.beyond_noise > 0.0 {
            (subject) " differs from the photograph by "
            (share("beyond_noise", of.beyond_noise)) ", beside noise of " (noise) "."
        } @else {
            (subject) " matches the photograph within noise of " (noise) "."
        }
    }
}

/// "(Converged after 26 passes, 35 s.)"
fn ended(source: &RunFolder<'_>) -> Markup {
    let (run, key) = (source.run, &source.key);
    let last = run.iterations.len().saturating_sub(1);
    let passes = html! {
        @if let Some(pass) = run.iterations.last() {
            (count(&key.at("iterations").at(last).at("iteration"), pass.iteration))
            @if pass.iteration == 1 { " pass" } @else { " passes" }
        } @else { "no pass" }
    };
    let seconds = html! { (number(&key.at("seconds"), run.seconds, Shown::Fixed(0))) " s" };
    html! {
        @match run.ended {
            Some(Ended::Converged) => { "(Converged after " (passes) ", " (seconds) ".)" }
            Some(Ended::Limit) => {
                "(Stopped after " (passes) ", " (seconds)
                ", before all parameters had settled: some still moved by more than their standard \
                deviation.)"
            }
            Some(Ended::Failed) => {
                "(Stopped after " (passes) ", " (seconds) ": a step could not be solved. The results are those before it.)"
            }
            Some(Ended::Interrupted) => {
                strong class="warn" { "Interrupted after " (passes) ", " (seconds) ":" }
                " the results are as far as it had come."
            }
            None => { "(" (run.termination) ", " (seconds) ".)" }
        }
    }
}

/// A thing to look at.
enum Look<'a> {
    /// A doubtful group: its place in the table, its name, itself.
    Group(usize, &'a str, &'a RunGroup),
    /// A warning, by its number.
    Warning(usize),
}

/// The gravest warnings and doubtful groups, each a link.
fn first(source: &RunFolder<'_>) -> Markup {
    let looks = looks(source);
    html! {
        @if looks.is_empty() {
            p class="first" { "No warnings, and no doubtful groups to check." }
        } @else {
            p class="first" { "Look at these first:" }
            ol class="first" { @for look in &looks { li { (item(source, look)) } } }
        }
    }
}

/// Doubtful groups by their share of the error, with a place for a warning if there is one: the gravest come first in
/// run.json.
fn looks<'a>(source: &RunFolder<'a>) -> Vec<Look<'a>> {
    let run = source.run;
    let mut doubtful: Vec<Look<'a>> = run
        .groups
        .iter()
        .enumerate()
        .filter(|(_, (_, group))| groups::is(group, Status::Doubtful))
        .map(|(index, (name, group))| Look::Group(index, name, group))
        .collect();
    let share = |look: &Look<'_>| match look {
        Look::Group(_, _, group) => group.error_share.unwrap_or(0.0),
        Look::Warning(_) => 0.0,
    };
    doubtful.sort_by(|a, b| share(b).total_cmp(&share(a)));
    doubtful.truncate(LISTED - usize::from(!run.warnings.is_empty()));
    let room = LISTED - doubtful.len();
    doubtful.extend((0..run.warnings.len()).take(room).map(Look::Warning));
    doubtful
}

fn item(source: &RunFolder<'_>, look: &Look<'_>) -> Markup {
    match look {
        Look::Group(index, name, group) => html! {
            a href={ "#group-" (index) } { (name) } " is doubtful"
            @if let Some(share) = group.error_share {
                @let key = source.key.at("groups").at(name).at("error_share");
                ": " (number(&key, share, Shown::Share)) " % of the remaining error"
            }
            "."
        },
        Look::Warning(index) => html! {
            a href={ "#warning-" (index) } { "Warning" } ": " (source.run.warnings[*index]) "."
        },
    }
}
