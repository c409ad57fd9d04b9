//! Two pictures in one frame: with a divider that is dragged or moved by keys, or flickering
//! between the two.

use super::exhibit::Exhibit;
use super::{PhotographOf, RunFolder, embed, of_each};
use crate::Error;
use maud::{Markup, html};
use std::path::Path;

/// The section: each photograph and its re-rendering.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    of_each("comparison", source, |_, of| pair(source, of))
}

fn pair(source: &RunFolder<'_>, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let pictures = of.pictures;
    let photo = Exhibit {
        file: pictures.photo.clone(),
        title: "photograph".to_owned(),
        caption: "The photograph, developed".to_owned(),
    };
    let rerendered = Exhibit {
        file: pictures.rerendered.clone(),
        title: "re-rendering".to_owned(),
        caption: "The scene rendered with the recovered materials".to_owned(),
    };
    figure(source.folder, &[photo, rerendered])
}

/// The first of two pictures in `folder` left of the divider, the second right of it.
pub(super) fn figure(folder: &Path, [left, right]: &[Exhibit; 2]) -> Result<Markup, Error> {
    let over = embed::photograph(folder, &left.file)?;
    let below = embed::photograph(folder, &right.file)?;
    Ok(html! {
        figure class="compare" {
            div class="frame" {
                img src=(below.src) width=(below.width) height=(below.height) alt=(right.caption);
                img class="over" src=(over.src) width=(over.width) height=(over.height)
                    alt=(left.caption);
                div class="line" aria-hidden="true" {}
                span class="tag left" aria-hidden="true" { (left.title) }
                span class="tag right" aria-hidden="true" { (right.title) }
                input class="divider" type="range" min="0" max="100" value="50" step="0.5"
                    aria-label={ "How much of the " (left.title)
                        " is shown, from the left, percent" };
            }
            figcaption {
                button type="button" class="flicker" aria-pressed="false" { "Flicker" }
                " Drag the line, or move it with the arrow keys: " (left.title) " on its left, "
                (right.title) " on its right."
            }
        }
    })
}
