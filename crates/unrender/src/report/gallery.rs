//! A gallery: pictures with captions on one page, two of them under a divider if that tells more.

use super::{comparison, embed, head};
use crate::Error;
use maud::{Markup, html};
use std::path::Path;

/// A picture of a gallery.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exhibit {
    /// The file, relative to the gallery's folder.
    pub file: String,
    /// Its title, a few words.
    pub title: String,
    /// What there is to see, a sentence or two; it also stands in for the picture.
    pub caption: String,
}

/// The page called `title` that shows the `exhibits` in `folder` under `lead`, a sentence, and
/// before them the two of `pair` in one frame, the first on the left.
///
/// # Errors
/// If a picture is missing or broken.
pub fn gallery(
    title: &str,
    lead: &str,
    folder: &Path,
    pair: Option<&[Exhibit; 2]>,
    exhibits: &[Exhibit],
) -> Result<String, Error> {
    let compared = pair.map(|pair| comparison::figure(folder, pair)).transpose()?;
    let figures = exhibits.iter().map(|exhibit| figure(folder, exhibit));
    let figures = figures.collect::<Result<Vec<_>, _>>()?;
    let body = html! {
        header { h1 { (title) } p class="lead" { (lead) } }
        main {
            @if let Some(compared) = compared { (compared) }
            div class="gallery" { @for figure in &figures { (figure) } }
        }
    };
    Ok(head::page(title, &body))
}

/// One picture with its words.
pub(super) fn figure(folder: &Path, exhibit: &Exhibit) -> Result<Markup, Error> {
    let picture = embed::photograph(folder, &exhibit.file)?;
    Ok(html! {
        figure {
            img src=(picture.src) width=(picture.width) height=(picture.height)
                alt=(exhibit.caption);
            figcaption { strong { (exhibit.title) } " " (exhibit.caption) }
        }
    })
}
