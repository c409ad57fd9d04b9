//! A gallery: pictures with captions on one page, two of them with a divider if requested.

use super::exhibit::{Exhibit, figure};
use super::{comparison, head};
use crate::Error;
use maud::html;
use std::path::Path;

/// The page called `title` that shows the `exhibits` in `folder` after `lead`, a sentence, and
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
