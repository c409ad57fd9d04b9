//! The table of groups.

use super::number::{Shown, count, number, percent};
use super::{Key, RunFolder, embed, parameters, selection_log, under};
use crate::Error;
use crate::run::{Run, RunGroup};
use maud::{Markup, html};
use unrender_formats::materials::{Status, StatusEntry};

/// The section. On narrow screens the script-less style makes a card of every row, so rows and cells
/// state their roles.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    let rows = source.run.groups.iter().map(|(name, group)| row(source, name, group));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    let heads = ["group", "hypothesis", "parameters", "error", "pixels", "why"];
    let content = html! {
        table class="groups" role="table" {
            caption { "Numbers with ± have a standard deviation. The error is the relative root \
                mean square of photograph minus re-rendering; in the first iteration without the \
                photograph's noise, in the end with it." }
            thead role="rowgroup" { tr role="row" {
                @for head in heads { th scope="col" role="columnheader" { (head) } }
            } }
            tbody role="rowgroup" { @for row in &rows { (row) } }
        }
    };
    Ok(under("groups", &content))
}

fn row(source: &RunFolder<'_>, name: &str, group: &RunGroup) -> Result<Markup, Error> {
    let key = source.key.at("groups").at(name);
    let entry = &group.entry;
    let failed = matches!(entry.status, Some(StatusEntry::Of(Status::Assumed | Status::Doubtful)));
    let hypothesis = entry.hypothesis.map_or("", |h| h.name());
    Ok(html! {
        tr role="row" class=[failed.then_some("failed")] data-group=(name) data-color=(group.map_color) {
            th scope="row" role="rowheader" {
                (picture(source, group, name)?)
                button type="button" class="pick" {
                    span class="chip" aria-hidden="true" style={ "background:" (group.map_color) } {}
                    span class="group-name" { (name) }
                }
            }
            (cell("hypothesis", &html! {
                (hypothesis)
                @match &entry.status {
                    None | Some(StatusEntry::Of(Status::Recovered)) => {}
                    Some(StatusEntry::Of(Status::Known)) => { " " span class="status" { "given" } }
                    Some(status) if failed => { " " span class="status bad" { (status) } }
                    Some(status) => { " " span class="status" { (status) } }
                }
            }))
            (cell("parameters", &parameters::list(&key, entry)))
            (cell("error", &errors(source, &key, name, group)))
            (cell("pixels", &pixels(&key, group)))
            (cell("why", &selection_log::of(source, &key, name, group)))
        }
    })
}

/// A cell; on narrow screens its head is shown before it.
fn cell(head: &str, content: &Markup) -> Markup {
    html! { td role="cell" data-head=(head) { div { (content) } } }
}

/// A ball of the material, or the texture.
fn picture(source: &RunFolder<'_>, group: &RunGroup, name: &str) -> Result<Markup, Error> {
    let (file, class) = match (&group.entry.texture, &group.ball) {
        (Some(texture), _) => (texture, "patch"),
        (None, Some(ball)) => (ball, "ball"),
        (None, None) => return Ok(html! { span class="ball none" aria-hidden="true" {} }),
    };
    let alt = match class {
        "patch" => format!("The texture of {name}"),
        _ => format!("A ball of the material of {name}"),
    };
    let picture = embed::photograph(source.folder, file)?;
    Ok(html! { img class=(class) src=(picture.src) alt=(alt); })
}

/// The error in the first iteration and in the end, and the group's share of all error.
fn errors(source: &RunFolder<'_>, key: &Key, name: &str, group: &RunGroup) -> Markup {
    let before = first_error(source.run, name);
    let iteration = source.key.at("iterations").at(0).at("groups").at(name).at("error");
    html! {
        @if let Some(before) = before { (percent(&iteration, Some(before))) " → " }
        (percent(&key.at("error"), group.entry.error))
        @if let Some(share) = group.error_share {
            div class="share" {
                "share of all error "
                span class="whole" {
                    (number(&key.at("error_share"), share, Shown::Percent(1))) " %"
                }
            }
        }
    }
}

/// The error of the group in the first iteration.
fn first_error(run: &Run, name: &str) -> Option<f64> {
    run.iterations.first()?.groups.get(name)?.error
}

fn pixels(key: &Key, group: &RunGroup) -> Markup {
    html! {
        @if let Some(pixels) = group.entry.pixels {
            (count(&key.at("pixels"), pixels))
            @if pixels > 0 {
                div class="share" {
                    (count(&key.at("counted").at("valid"), group.counted.valid)) " counted"
                }
            }
        }
    }
}
