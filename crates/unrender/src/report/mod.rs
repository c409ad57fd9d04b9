//! Pages that open anywhere: `report.html` of one recovery, several recoveries side by side, and
//! galleries.
//!
//! A page is one file. Its pictures, its style and its script are inside, and it loads nothing from
//! a network. Names are always escaped. The pages compute nothing: a number on them is a field of
//! run.json, is marked up as such (`Key`), and is rounded at most.
//!
//! One section of the page is one file here.

mod artist;
mod comparison;
mod convergence;
mod embed;
mod errors;
mod exhibit;
mod facts;
mod files;
mod gallery;
mod group_map;
mod groups;
mod head;
mod number;
mod parameters;
#[cfg(feature = "cli")]
mod play;
mod plot;
mod selection_log;
mod side_by_side;
mod unknowable;
mod valid;
mod verdict;
mod viewer;
mod why;

pub use exhibit::Exhibit;
pub(crate) use files::VIEW;
pub use gallery::{Gallery, gallery};
#[cfg(feature = "cli")]
pub(crate) use play::{ExactCommand, page as view};

use crate::Error;
use crate::run::{LeftOut, PhotographRun, Pictures, Run};
use maud::{Markup, html};
use number::Key;
use std::path::{Path, PathBuf};
use unrender_formats::atomic;

/// The name of the page in a folder of results.
pub const FILE: &str = "report.html";

/// A run and its folder of results.
struct RunFolder<'a> {
    run: &'a Run,
    folder: &'a Path,
    /// The place of the run's numbers.
    key: Key,
}

/// One photograph of a run.
struct PhotographOf<'a> {
    /// Its number and its file, if there are several.
    heading: Option<String>,
    pictures: &'a Pictures,
    pixels: &'a LeftOut,
    /// The place of its numbers.
    key: Key,
}

impl<'a> RunFolder<'a> {
    /// The photographs of the run.
    fn photographs(&self) -> Vec<PhotographOf<'a>> {
        let (run, key) = (self.run, &self.key);
        if run.photographs.is_empty() {
            let (pictures, pixels) = (&run.pictures, &run.pixels);
            return vec![PhotographOf { heading: None, pictures, pixels, key: key.clone() }];
        }
        let one = |(k, of): (usize, &'a PhotographRun)| {
            let name = of.photo.file_name().unwrap_or(of.photo.as_os_str()).to_string_lossy();
            let mut heading = format!("Photograph {}: {name}", k + 1);
            if !of.lights_off.is_empty() {
                heading.push_str(&format!(" (off: {})", of.lights_off.join(", ")));
            }
            PhotographOf {
                heading: Some(heading),
                pictures: &of.pictures,
                pixels: &of.pixels,
                key: key.at("photographs").at(k),
            }
        };
        run.photographs.iter().enumerate().map(one).collect()
    }
}

/// The section `id` with the `figure` of each photograph and its number, below the photograph's heading if there are
/// several.
fn of_each(
    id: &str,
    source: &RunFolder<'_>,
    figure: impl Fn(usize, &PhotographOf<'_>) -> Result<Markup, Error>,
) -> Result<Markup, Error> {
    let each = source.photographs();
    let figures = each.iter().enumerate().map(|(k, of)| figure(k, of));
    let figures = figures.collect::<Result<Vec<_>, _>>()?;
    let content = html! {
        @for (of, figure) in each.iter().zip(&figures) {
            @if let Some(heading) = &of.heading { h3 { (heading) } }
            (figure)
        }
    };
    Ok(under(id, &content))
}

/// Writes the page of the recovery in `folder` beside its other files.
///
/// # Errors
/// If a file is missing or broken, or the page cannot be written.
pub fn write(folder: &Path) -> Result<(), Error> {
    Ok(atomic::write(&folder.join(FILE), page(folder)?.as_bytes())?)
}

/// The page of the recovery in `folder`.
///
/// # Errors
/// If run.json or a picture that it names is missing or broken.
pub fn page(folder: &Path) -> Result<String, Error> {
    let run = Run::read(folder)?;
    let source = RunFolder { run: &run, folder, key: Key::root() };
    let body = html! {
        (header(&source))
        main {
            (viewer::section(&source)?)
            (group_map::section(&source)?)
            (groups::section(&source)?)
            (unknowable::section(&source))
            (valid::section(&source)?)
            (convergence::section(&source))
            (facts::section(&source))
        }
    };
    let title = format!("unrender: {}", run.input.project.display());
    Ok(head::page(&title, &body))
}

/// The page that compares the recoveries in `folders`.
///
/// # Errors
/// As [`page`].
pub fn comparison(folders: &[PathBuf]) -> Result<String, Error> {
    let runs = folders.iter().map(|folder| Run::read(folder)).collect::<Result<Vec<_>, _>>()?;
    let source: Vec<RunFolder<'_>> = runs
        .iter()
        .zip(folders)
        .enumerate()
        .map(|(index, (run, folder))| RunFolder { run, folder, key: Key::root().at(index) })
        .collect();
    side_by_side::page(&source)
}

/// The subject of the page and how it came out.
fn header(source: &RunFolder<'_>) -> Markup {
    let run = source.run;
    html! {
        header {
            h1 { "Recovered materials" }
            p class="lead" { (run.input.project.display()) ", " (run.input.photo.display()) }
            (verdict::verdict(source))
            nav aria-label="Sections" { ul {
                @for (id, name) in SECTIONS { li { a href={ "#" (id) } { (name) } } }
            } }
            (files::links(source))
        }
    }
}

/// The sections of a recovery's page: id and heading.
const SECTIONS: [(&str, &str); 7] = [
    ("comparison", "Photograph, re-rendering and difference"),
    ("map", "Group map"),
    ("groups", "Groups"),
    ("unknowable", "What the photograph does not determine"),
    ("valid", "Which pixels counted"),
    ("convergence", "Convergence"),
    ("facts", "How it was made"),
];

/// A section with one of the headings of [`SECTIONS`].
fn under(id: &str, content: &Markup) -> Markup {
    let name = SECTIONS.iter().find(|s| s.0 == id).map_or(id, |s| s.1);
    html! {
        section id=(id) aria-labelledby={ "h-" (id) } {
            h2 id={ "h-" (id) } { (name) }
            (content)
        }
    }
}
