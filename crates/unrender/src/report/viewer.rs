//! The viewer: photograph and re-rendering under a divider beside the map of their difference, with one zoom, one
//! exposure, and the values under the pointer.
//!
//! The script reads the values from the pictures in the page: the photograph and the re-rendering, the picture of error
//! values, and the group map. Without it the pictures are there.

use super::exhibit::Exhibit;
use super::{PhotographOf, RunFolder, comparison, embed, errors, of_each};
use crate::Error;
use crate::run::Pictures;
use maud::{Markup, html};

/// The section: each photograph and its re-rendering.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    of_each("comparison", source, |k, of| viewer(source, k, of))
}

/// The viewer of the photograph `of`, which is number `k`.
fn viewer(source: &RunFolder<'_>, k: usize, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let pictures = of.pictures;
    let frame = comparison::frame(source.folder, &pair(pictures))?;
    let filter = format!("exposure-{k}");
    let main = errors::main(source, of)?;
    let others = errors::others(source, of)?;
    let values = match &pictures.difference {
        Some(difference) => Some(embed::values(source.folder, &difference.values)?),
        None => None,
    };
    Ok(html! {
        figure class="viewer" id={ "viewer-" (k) } data-filter=(filter) {
            (exposure_filter(&filter))
            (tools())
            div class="panes" {
                div class="pane compare" { (frame) (caption(pictures)) }
                div class="pane" { (main) }
            }
            output class="probe" aria-live="off" { "Point at a picture to read its values." }
            @if let Some(values) = &values {
                img class="values" src=(values.src) alt="" hidden;
            }
        }
        (others)
    })
}

fn pair(pictures: &Pictures) -> [Exhibit; 2] {
    let exhibit = |file: &str, title: &str, caption: &str| {
        let [file, title, caption] = [file, title, caption].map(str::to_owned);
        Exhibit { file, title, caption }
    };
    [
        exhibit(&pictures.photo, "photograph", "The photograph, developed"),
        exhibit(
            &pictures.rerendered,
            "re-rendering",
            "The scene rendered with the recovered materials",
        ),
    ]
}

fn caption(pictures: &Pictures) -> Markup {
    html! {
        figcaption {
            "Photograph left of the line, re-rendering right of it. Drag the line, or move it with the arrow keys. "
            @if pictures.denoised { "The re-rendering is denoised here; the EXR and the difference are not." }
            @else { "The grain of the re-rendering is the noise of its few paths." }
        }
    }
}

/// Zoom, exposure and flicker.
fn tools() -> Markup {
    html! {
        div class="tools" role="group" aria-label="View of the pictures" {
            span class="tool" {
                button type="button" class="zoom-out" aria-label="Zoom out" { "−" }
                output class="zoom" aria-label="Zoom" {}
                button type="button" class="zoom-in" aria-label="Zoom in" { "+" }
                button type="button" class="zoom-fit" { "Fit" }
            }
            label class="tool" {
                "Exposure "
                input class="exposure" type="range" min="-4" max="4" step="0.25" value="0";
                output class="stops" {}
            }
            (comparison::flicker())
            span class="hint" {
                "Zoom: the buttons, the keys + and −, or the wheel after a click. Move: drag the map, or arrow keys on it."
            }
        }
    }
}

/// The exposure as a factor of linear values.
fn exposure_filter(id: &str) -> Markup {
    html! {
        svg class="filter" width="0" height="0" aria-hidden="true" {
            filter id=(id) color-interpolation-filters="linearRGB" {
                feComponentTransfer {
                    feFuncR type="linear" slope="1" {}
                    feFuncG type="linear" slope="1" {}
                    feFuncB type="linear" slope="1" {}
                }
            }
        }
    }
}
