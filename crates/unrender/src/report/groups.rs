//! The table of groups.

use super::number::{Shown, count, number, percent};
use super::{Key, RunFolder, artist, embed, parameters, selection_log, under, why};
use crate::Error;
use crate::run::RunGroup;
use maud::{Markup, html};
use unrender_formats::materials::{Status, StatusEntry};

/// The section. On narrow screens the script-less style makes a card of every row, so rows and cells
/// state their roles.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    let groups = source.run.groups.iter().enumerate();
    let rows = groups.map(|(index, (name, group))| row(source, index, (name, group)));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    let heads = ["group", "material", "parameters", "in Blender", "error", "why"];
    let content = html! {
        table class="groups" role="table" {
            caption { "A number after ± is a standard deviation. The error is the root mean square of photograph minus \
                re-rendering, relative to the light of the group, without noise. Doubtful: the error is certainly above \
                3 %, or may be above 15 %, or two kinds of material fit equally well. Assumed: the photograph does not \
                determine it." }
            thead role="rowgroup" { tr role="row" {
                @for head in heads { th scope="col" role="columnheader" { (head) } }
            } }
            tbody role="rowgroup" { @for row in &rows { (row) } }
        }
    };
    Ok(under("groups", &content))
}

fn row(
    source: &RunFolder<'_>,
    index: usize,
    (name, group): (&str, &RunGroup),
) -> Result<Markup, Error> {
    let key = source.key.at("groups").at(name);
    let entry = &group.entry;
    let failed = matches!(entry.status, Some(StatusEntry::Of(Status::Assumed | Status::Doubtful)));
    let hypothesis = entry.hypothesis.map_or("", |h| h.name());
    Ok(html! {
        tr id={ "group-" (index) } role="row" class=[failed.then_some("failed")] data-group=(name) data-color=(group.map_color) {
            th scope="row" role="rowheader" {
                (picture(source, group, name)?)
                button type="button" class="pick" {
                    span class="chip" aria-hidden="true" style={ "background:" (group.map_color) } {}
                    span class="group-name" { (name) }
                }
            }
            (cell("material", &html! {
                (hypothesis)
                @match &entry.status {
                    None | Some(StatusEntry::Of(Status::Recovered)) => {}
                    Some(StatusEntry::Of(Status::Known)) => { " " span class="status" { "given" } }
                    Some(status) if failed => { " " span class="status bad" { (status) } }
                    Some(status) => { " " span class="status" { (status) } }
                }
            }))
            (cell("parameters", &parameters::list(&key, entry)))
            (cell("in Blender", &artist::cell(&key, name, group)))
            (cell("error", &errors(&key, group)))
            (cell("why", &html! {
                p class="why" { (why::reason(source, name, group)) }
                @if let Some(miss) = &group.miss { p class="why" { (why::miss(&key.at("miss"), name, (miss, is(group, Status::Doubtful)))) } }
                @if let Some(note) = &entry.note { p class="note" { (note) } }
                (selection_log::of(&key, name, group))
            }))
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

/// The error, its share of all error, and the pixels that it rests on.
fn errors(key: &Key, group: &RunGroup) -> Markup {
    html! {
        (percent(&key.at("error"), group.entry.error))
        @if let Some(share) = group.error_share {
            div class="share" {
                @if share > 0.0 {
                    span class="whole" { (number(&key.at("error_share"), share, Shown::Share)) " %" }
                    " of all error"
                } @else { "within noise" }
            }
        }
        @if let Some(pixels) = group.entry.pixels {
            div class="share" {
                @if pixels > 0 {
                    (count(&key.at("counted").at("valid"), group.counted.valid)) " of "
                    span class="whole" { (count(&key.at("pixels"), pixels)) " pixels" }
                } @else { "out of view" }
            }
        }
    }
}

/// Whether a group has this status.
pub(super) fn is(group: &RunGroup, status: Status) -> bool {
    group.entry.status.as_ref().is_some_and(|of| of.is(status))
}
