//! A picture on a page, with its texts.

use super::embed;
use crate::Error;
use maud::{Markup, html};
use std::path::Path;

/// A picture with its texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exhibit {
    /// The file, relative to the page's folder.
    pub file: String,
    /// Its title, a few words.
    pub title: String,
    /// A description in a sentence or two; it is also the picture's alternative text.
    pub caption: String,
}

/// One picture with its texts.
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
