//! Two pictures in one frame, with a divider that is dragged or moved by keys.

use super::embed;
use super::exhibit::Exhibit;
use crate::Error;
use maud::{Markup, html};
use std::path::Path;

/// The first of two pictures in `folder` left of the divider, the second right of it.
pub(super) fn frame(folder: &Path, [left, right]: &[Exhibit; 2]) -> Result<Markup, Error> {
    let over = embed::photograph(folder, &left.file)?;
    let below = embed::photograph(folder, &right.file)?;
    Ok(html! {
        div class="frame" style=(below.aspect()) {
            div class="layer" {
                img src=(below.src) width=(below.width) height=(below.height) alt=(right.caption);
            }
            div class="layer over" {
                img src=(over.src) width=(over.width) height=(over.height) alt=(left.caption);
            }
            div class="line" aria-hidden="true" {}
            span class="tag left" aria-hidden="true" { (left.title) }
            span class="tag right" aria-hidden="true" { (right.title) }
            input class="divider" type="range" min="0" max="100" value="50" step="0.5"
                aria-label={ "How much of the " (left.title)
                    " is shown, from the left, percent" };
        }
    })
}

/// A button that shows one picture and the other in turn.
pub(super) fn flicker() -> Markup {
    html! { button type="button" class="flicker" aria-pressed="false" { "Flicker" } }
}

/// The frame with a caption and the button.
pub(super) fn figure(folder: &Path, pair: &[Exhibit; 2]) -> Result<Markup, Error> {
    let frame = frame(folder, pair)?;
    let [left, right] = pair;
    Ok(html! {
        figure class="compare wide-picture" {
            (frame)
            figcaption {
                (flicker()) " Drag the line, or move it with the arrow keys: " (left.title)
                " on its left, " (right.title) " on its right."
            }
        }
    })
}
