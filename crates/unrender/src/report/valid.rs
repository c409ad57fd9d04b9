//! The valid mask: which pixels were used, and why the others were not.

use super::number::count;
use super::{PhotographOf, RunFolder, embed, of_each};
use crate::Error;
use crate::run::LeftOut;
use maud::{Markup, html};

/// The section, with the colours of trust.png as the legend.
pub(super) fn section(source: &RunFolder<'_>) -> Result<Markup, Error> {
    of_each("valid", source, |_, of| mask(source, of))
}

fn mask(source: &RunFolder<'_>, of: &PhotographOf<'_>) -> Result<Markup, Error> {
    let picture = embed::photograph(source.folder, &of.pictures.trust)?;
    Ok(html! {
        div class="beside" {
            figure {
                img src=(picture.src) width=(picture.width) height=(picture.height)
                    alt="The photograph in grey where it was used, and coloured by the reason \
                    elsewhere";
            }
            table {
                caption { "Pixels, by the reason why they were not used." }
                thead { tr { th scope="col" { "colour" } th scope="col" { "why" }
                    th scope="col" class="n" { "pixels" } } }
                tbody { @for (field, color, why, pixels) in reasons(of.pixels) {
                    tr {
                        td { span class="swatch" style={ "background:" (color) } {} }
                        td { (why) }
                        td class="n" { (count(&of.key.at("pixels").at(field), pixels)) }
                    }
                } }
            }
        }
    })
}

/// For each reason: field of run.json, colour in trust.png, words, number of pixels.
fn reasons(pixels: &LeftOut) -> [(&'static str, &'static str, &'static str, usize); 6] {
    [
        ("valid", "linear-gradient(to right,#222,#ddd)", "used", pixels.valid),
        ("edge", "rgb(51 115 191)", "an edge is too close", pixels.edge),
        ("clipped", "rgb(153 77 166)", "clipped, too dark or broken", pixels.clipped),
        ("spike", "rgb(242 217 64)", "a single bright pixel", pixels.spike),
        ("outlier", "rgb(230 128 38)", "shows something that is not in the model", pixels.outlier),
        ("nothing", "#000", "the model shows nothing there", pixels.nothing),
    ]
}
