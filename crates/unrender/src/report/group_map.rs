//! The group map: pointing at a pixel, or choosing a row of the groups' table, shows the group.

use super::{PhotographOf, RunFolder, embed, of_each};
use crate::Error;
use maud::{Markup, html};

/// The section. The script shows the group under the pointer, from the groups' table.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    of_each("map", source, |_, of| map(source, of))
}

fn map(source: &RunFolder<'_>, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let map = embed::exact(source.folder, &of.pictures.groups)?;
    Ok(html! {
        figure class="map" {
            div class="frame" style=(map.aspect()) {
                img class="groups" src=(map.src) width=(map.width) height=(map.height)
                    alt="Every pixel in the colour of its group; the table below lists the groups";
                canvas aria-hidden="true" {}
            }
            output class="readout" aria-live="polite" {
                "Point at the picture, or choose a group in the table."
            }
            figcaption { "Every pixel in the colour of its group, black where the model shows \
                nothing. Choosing a group in the table shows where it is." }
        }
    })
}
