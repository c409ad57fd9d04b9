//! What the photograph does not determine, in words.

use super::number::percent;
use super::{Key, RunFolder, parameters, under};
use crate::project::some_names;
use crate::run::RunGroup;
use maud::{Markup, html};
use unrender_formats::materials::{AlternativeEntry, GroupEntry};
use unrender_scene::Status;

/// The objects of a group that seem to be of one material each.
fn parts(group: &RunGroup) -> String {
    let names = |part: &Vec<String>| some_names(part.iter().map(String::as_str));
    group.parts.iter().map(names).collect::<Vec<_>>().join("; ")
}

/// The section.
pub(super) fn section(source: &RunFolder<'_>) -> Markup {
    let run = source.run;
    let groups = || run.groups.iter();
    let is_assumed =
        |g: &RunGroup| g.entry.status.as_ref().is_some_and(|status| status.is(Status::Assumed));
    let assumed = groups().filter(|(_, g)| is_assumed(g));
    let noted = groups().filter(|(_, g)| g.entry.note.is_some() && !is_assumed(g));
    let ambiguous: Vec<(&String, &RunGroup)> =
        groups().filter(|(_, g)| !g.entry.alternatives.is_empty()).collect();
    let (assumed, noted): (Vec<_>, Vec<_>) = (assumed.collect(), noted.collect());
    let alike: Vec<(&String, &RunGroup)> =
        groups().filter(|(_, g)| !g.agrees_with.is_empty()).collect();
    let nothing =
        assumed.is_empty() && noted.is_empty() && ambiguous.is_empty() && alike.is_empty();
    let apart: Vec<(&String, &RunGroup)> = groups().filter(|(_, g)| g.parts.len() > 1).collect();
    let nothing = nothing && apart.is_empty();
    let content = html! {
        @if nothing { p { "Nothing was found that the photograph leaves open." } }
        ul class="unknowable" {
            @for (name, group) in assumed {
                li { strong { (name) } " is not determined: "
                    (group.entry.note.as_deref().unwrap_or("its values are a guess")) }
            }
            @for (name, group) in noted {
                li { strong { (name) } ": " (group.entry.note.as_deref().unwrap_or_default()) }
            }
            @for (name, group) in apart {
                li { strong { (name) } " seems to have several materials, as one does not explain \
                    all its objects: "
                    (parts(group))
                    ". " code { "unrender split" } " splits it." }
            }
            @for (name, group) in alike {
                li { strong { (name) } " agrees with " (group.agrees_with.join(", "))
                    " within the standard deviations; they may be of one material." }
            }
            @for (name, group) in ambiguous {
                li { strong { (name) } " may also be this:"
                    @for (index, other) in group.entry.alternatives.iter().enumerate() {
                        (alternative(&source.key.at("groups").at(name).at("alternatives").at(index),
                            other))
                    }
                }
            }
        }
        @if !run.settings.refine {
            p { "The parameters were not refined together, so their uncertainty is unknown." }
        }
        p { "A standard deviation contains the noise and local errors of the model. It does not \
            contain errors that are the same everywhere, such as a lamp that is brighter than stated." }
    };
    under("unknowable", &content)
}

fn alternative(key: &Key, other: &AlternativeEntry) -> Markup {
    let entry = GroupEntry {
        hypothesis: other.hypothesis,
        rho_d: other.rho_d,
        rho_s: other.rho_s,
        alpha_x: other.alpha_x,
        alpha_y: other.alpha_y,
        theta_deg: other.theta_deg,
        ..GroupEntry::default()
    };
    html! {
        div class="alternative" {
            (other.hypothesis.map_or("", |h| h.name())) ", with an error of "
            (percent(&key.at("error"), other.error))
            (parameters::list(key, &entry))
        }
    }
}
