//! The selection log of a group: which kinds of material were fitted, and the error of each.

use super::number::{count, percent};
use super::{Key, parameters};
use crate::run::{CandidateEntry, RunGroup};
use maud::{Markup, html};

/// The selection log, folded.
pub(super) fn of(key: &Key, name: &str, group: &RunGroup) -> Markup {
    html! {
        @if !group.selection_log.is_empty() {
            details {
                summary { "All that was tried" span class="hidden" { " on " (name) } }
                (rungs(&key.at("selection_log"), &group.selection_log))
            }
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
        _ if candidate.accepted => "chosen",
        Some(accepted) if candidate.hypothesis < accepted => "simpler, but fits worse",
        Some(_) => "fits no better for its parameters",
        None => "not chosen",
    };
    html! {
        li class=[candidate.accepted.then_some("accepted")] {
            (parameters::swatch(candidate.rho_d)) (candidate.hypothesis) " leaves "
            (percent(&key.at("error"), candidate.error)) ": " (verdict)
        }
    }
}
