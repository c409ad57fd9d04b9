//! report.html: the pictures and the table of a recovery on one page that opens anywhere.
//!
//! Everything is inside the file; it asks no network for anything. Names are text, whatever they
//! contain. The page computes nothing: its numbers are those of materials.json and run.json.

use crate::engine::Recovered;
use crate::{Error, Job};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::path::Path;
use unrender_formats::{FileError, atomic};

const STYLE: &str = "
:root { color-scheme: light dark; font: 15px/1.5 system-ui, sans-serif; }
body { max-width: 80rem; margin: 2rem auto; padding: 0 1rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr)); gap: 1rem; }
figure { margin: 0; } img { width: 100%; height: auto; }
.wide { overflow-x: auto; } table { border-collapse: collapse; }
th, td { text-align: left; padding: .25rem .75rem; border-bottom: 1px solid #8886; white-space: nowrap; }
";

/// Writes the report of a recovery whose other files are in `folder` already.
pub(super) fn write(job: &Job, recovered: &Recovered, folder: &Path) -> Result<(), Error> {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "unrender: " (job.project.path.display()) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Recovered materials" }
                p { (job.project.path.display()) ", " (job.scene.brdf) ", "
                    (format!("{:.1} s, ", recovered.seconds))
                    (recovered.recovery.termination.message(recovered.recovery.turns.len())) }
                div class="pictures" {
                    (picture(folder, "photo.png", "The photograph, developed")?)
                    (picture(folder, "rerendered.png", "Rendered with what was recovered")?)
                    (picture(folder, "error.png",
                        "Their difference relative to the photograph's mean: \
                         red too bright, blue too dark")?)
                }
                (table(recovered))
                @if !job.warnings.0.is_empty() {
                    h2 { "Warnings" }
                    ul { @for warning in &job.warnings.0 { li { (warning) } } }
                }
            }
        }
    };
    Ok(atomic::write(&folder.join("report.html"), page.into_string().as_bytes())?)
}

fn picture(folder: &Path, name: &str, caption: &str) -> Result<Markup, Error> {
    let path = folder.join(name);
    let bytes = std::fs::read(&path).map_err(|error| FileError::new(&path, error))?;
    let data = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(bytes));
    Ok(html! { figure { img src=(data) alt=(caption); figcaption { (caption) } } })
}

fn table(recovered: &Recovered) -> Markup {
    let (header, rows) = super::summary::rows(&recovered.recovery);
    html! {
        h2 { "Groups" }
        div class="wide" { table {
            thead { tr { @for cell in header { th scope="col" { (cell) } } } }
            tbody { @for row in rows { tr { @for cell in row { td { (cell) } } } } }
        } }
        ul { @for group in &recovered.recovery.groups {
            @if let Some(note) = &group.note { li { (group.name) ": " (note) } }
        } }
    }
}
