//! Photograph and re-rendering in one frame: a divider that is dragged or moved by keys, and a
//! flicker between the two.

use super::{Told, embed, under};
use crate::Error;
use maud::{Markup, html};

/// The section.
pub(super) fn section(told: &Told<'_>) -> Result<Markup, Error> {
    let pictures = &told.run.pictures;
    let photo = embed::photograph(told.folder, &pictures.photo)?;
    let rerendered = embed::photograph(told.folder, &pictures.rerendered)?;
    let content = html! {
        figure class="compare" {
            div class="frame" {
                img src=(rerendered.src) width=(rerendered.width) height=(rerendered.height)
                    alt="The scene rendered with the recovered materials";
                img class="over" src=(photo.src) width=(photo.width) height=(photo.height)
                    alt="The photograph, developed";
                div class="line" aria-hidden="true" {}
                span class="tag left" aria-hidden="true" { "photograph" }
                span class="tag right" aria-hidden="true" { "re-rendering" }
                input class="divider" type="range" min="0" max="100" value="50" step="0.5"
                    aria-label="How much of the photograph is shown, from the left, percent";
            }
            figcaption {
                button type="button" class="flicker" aria-pressed="false" { "Flicker" }
                " Drag the line, or move it with the arrow keys: photograph on its left, \
                 re-rendering on its right."
            }
        }
    };
    Ok(under("comparison", &content))
}
