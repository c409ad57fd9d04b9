//! The selection log of a group: which candidates were fitted, the error of each, and why one was
//! accepted.

use super::number::{count, percent};
use super::{Key, RunFolder, parameters};
use crate::run::{CandidateEntry, DecisionEntry, RunGroup};
use maud::{Markup, html};
use unrender_formats::materials::{Hypothesis, Status, StatusEntry};

/// The selection log, and the reason for the group's hypothesis.
pub(super) fn of(source: &RunFolder<'_>, key: &Key, name: &str, group: &RunGroup) -> Markup {
    html! {
        p class="why" { (reason(source, name, group)) }
        @if let Some(note) = &group.entry.note { p class="note" { (note) } }
        @if !group.selection_log.is_empty() {
            details {
                summary { "The rungs" span class="hidden" { " tried on " (name) } }
                (rungs(&key.at("selection_log"), &group.selection_log))
            }
        }
    }
}

/// The reason for the group's hypothesis, in words: that of the last change that was made.
fn reason(source: &RunFolder<'_>, name: &str, group: &RunGroup) -> Markup {
    let last = group.decisions.iter().rposition(|decision| decision.made);
    let hypothesis = group.entry.hypothesis.unwrap_or(Hypothesis::Diffuse);
    let paper = source.run.settings.ladder == "paper";
    let ladder = source.run.iterations.iter().rev().find(|iteration| !iteration.refining);
    let open =
        ladder.is_some_and(|iteration| iteration.open_groups.iter().any(|open| open == name));
    html! {
        @match (&group.entry.status, hypothesis, last) {
            (Some(StatusEntry::Ignored), ..) => "Left out by the project; it keeps the scene's material.",
            (Some(StatusEntry::SameAs(other)), ..) => { "One material with " (other) ", as the project states." }
            (Some(StatusEntry::Of(Status::Known)), ..) => "Given, not recovered.",
            (Some(StatusEntry::Of(Status::Assumed)), ..) => "Not determined by this photograph.",
            (_, textured, _) if textured.of_paper() == Hypothesis::Textured => "Texels from some of \
                its pixels predict the others better than any uniform reflectance does.",
            _ if paper => "The error fell below the rung's threshold, or the ladder ended.",
            (_, _, Some(last)) => (because(&group.decisions, last)),
            (_, _, None) if open => "No other hypothesis explains it better; but its error is \
                larger than noise and the threshold explain.",
            (_, _, None) => "No other rung was needed: in the end the error of the first one was \
                within noise and the threshold.",
        }
        @if last.is_some() && open && !paper { " Even its error is larger than noise and the threshold explain." }
    }
}

/// Why the change was made that the decision number `last` made.
fn because(decisions: &[DecisionEntry], last: usize) -> Markup {
    let DecisionEntry { from, to, rule, .. } = &decisions[last];
    // The whole picture has the last word over what another rule proposes.
    let before = last.checked_sub(1).map(|before| &decisions[before]);
    let before = before.filter(|before| before.to == *to && before.rule == "other groups");
    html! {
        @match before.map_or(rule, |before| &before.rule).as_str() {
            "other groups" => { "The other groups are explained better by its light as " (to) " than as " (from) "." }
            "branch" => { "The whole photograph is explained better with it as " (to) " than as " (from) "." }
            "simpler" => { "Its numbers as " (from) " are not significant: as " (to) " it explains the photograph as well." }
            "project" => { "The project allows no other." }
            _ => { "The simplest rung that explains as much as the best one, within noise and thresholds: " (to) "." }
        }
    }
}

/// The candidates, iteration by iteration.
fn rungs(key: &Key, selection_log: &[CandidateEntry]) -> Markup {
    let numbered: Vec<(usize, &CandidateEntry)> = selection_log.iter().enumerate().collect();
    html! {
        @for tried in numbered.chunk_by(|a, b| a.1.iteration == b.1.iteration) {
            p { "Iteration " (count(&key.at(tried[0].0).at("iteration"), tried[0].1.iteration)) ":" }
            ol class="rungs" {
                @for (index, candidate) in tried { (rung(&key.at(index), candidate, tried)) }
            }
        }
    }
}

/// One candidate among those of its iteration, which are ordered from simple to complex.
fn rung(key: &Key, candidate: &CandidateEntry, tried: &[(usize, &CandidateEntry)]) -> Markup {
    let accepted =
        tried.iter().find(|(_, other)| other.accepted).map(|(_, other)| other.hypothesis);
    let verdict = match accepted {
        _ if candidate.accepted => "accepted",
        Some(accepted) if candidate.hypothesis < accepted => "larger error than needed",
        Some(_) => "not needed",
        None => "not accepted",
    };
    html! {
        li class=[candidate.accepted.then_some("accepted")] {
            (parameters::swatch(candidate.rho_d)) (candidate.hypothesis) " left "
            (percent(&key.at("error"), candidate.error)) ": " (verdict)
        }
    }
}
