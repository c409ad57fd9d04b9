//! A picture on a page, with its words.

use super::embed;
use crate::Error;
use maud::{Markup, html};
use std::path::Path;

/// A picture with its words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exhibit {
    /// The file, relative to the page's folder.
    pub file: String,
    /// Its title, a few words.
    pub title: String,
    /// What there is to see, a sentence or two; it also stands in for the picture.
    pub caption: String,
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
