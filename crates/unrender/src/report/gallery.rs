//! A gallery: pictures with captions on one page, two of them under a divider if requested.

use super::exhibit::{Exhibit, figure};
use super::{comparison, head};
use crate::Error;
use maud::html;
use std::path::Path;

/// What a gallery shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gallery<'a> {
    /// The title of the page.
    pub title: &'a str,
    /// A sentence.
    pub lead: &'a str,
    /// What was done, a sentence each.
    pub edits: &'a [String],
    /// Two pictures in one frame, the first on the left; they have the same size.
    pub pair: Option<&'a [Exhibit; 2]>,
    /// The pictures below.
    pub exhibits: &'a [Exhibit],
}

/// The page with the pictures in `folder`.
///
/// # Errors
/// If a picture is missing or broken.
pub fn gallery(folder: &Path, gallery: &Gallery<'_>) -> Result<String, Error> {
    let compared = gallery.pair.map(|pair| comparison::figure(folder, pair)).transpose()?;
    let figures = gallery.exhibits.iter().map(|exhibit| figure(folder, exhibit));
    let figures = figures.collect::<Result<Vec<_>, _>>()?;
    let body = html! {
        header { h1 { (gallery.title) } p class="lead" { (gallery.lead) } }
        main {
            @if !gallery.edits.is_empty() {
                ul class="edits" { @for edit in gallery.edits { li { (edit) } } }
            }
            @if let Some(compared) = compared { (compared) }
            div class="gallery" { @for figure in &figures { (figure) } }
        }
    };
    Ok(head::page(gallery.title, &body))
}
