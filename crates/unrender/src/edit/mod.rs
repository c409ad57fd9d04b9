//! Reads the edit file and the flags that stand for a line of it.
//!
//! `sheet` is one file or flag: its place, with the lines that errors name (`written`), and its tables (`raw`). Each
//! kind of edit (`remove`, `repaint`, `insert`, `view`) has one file that defines its syntax and the edit of
//! `unrender-restage` for it; lights and environments, which projects have too, are in `lighting`. `edits` collects
//! them all, and `words` puts them into words. `start` reads the scene and the photograph (`developed`) to which the edits are applied.

mod composite;
mod developed;
mod edit_sheet;
mod edits;
mod insert;
mod raw;
mod raw_camera;
mod remove;
mod repaint;
mod start;
mod view;
mod words;
mod written;

pub use composite::Composite;
pub use developed::Photograph;
pub use edit_sheet::{EditSheet, Flag};
pub use start::Start;
pub use view::View;

use crate::Error;
use unrender_restage::pair::Scenes;
use unrender_restage::{Change, Edit};
use unrender_scene::{Scene, Warnings};

/// A scene with its edits, and the cameras of its pictures.
#[derive(Debug)]
pub struct Restaging {
    /// The scene before, with the photograph if there is one.
    pub start: Start,
    /// The scene after its edits.
    pub after: Scene,
    /// The edits, a sentence each.
    pub sentences: Vec<String>,
    /// The record of the changes.
    pub change: Change,
    /// The cameras of the new pictures.
    pub view: View,
    /// Warnings.
    pub warnings: Warnings,
}

impl Restaging {
    /// Both scenes, to be rendered together.
    pub fn scenes(&self) -> Scenes<'_> {
        Scenes { before: &self.start.scene, after: &self.after, change: &self.change }
    }

    /// Reads the files that `sheets` name, and applies their edits.
    ///
    /// # Errors
    /// If a file cannot be used, or an edit does not fit the scene; the message names the line.
    pub fn load(sheets: Vec<EditSheet>) -> Result<Self, Error> {
        let (start, mut warnings) = Start::load(&sheets)?;
        let named = sheets.into_iter().map(|sheet| sheet.with_names_of(&start.scene));
        let sheets = &named.collect::<Result<Vec<_>, Error>>()?[..];
        let edits = edits::all(sheets, &start, &mut warnings)?;
        let (places, edits): (Vec<String>, Vec<Edit>) = edits.into_iter().unzip();
        let mut after = start.switched(sheets);
        let mut change = unrender_restage::apply(&mut after, &edits).map_err(|error| {
            Error::Request(format!("{}: {}", places[error.edit], error.problem))
        })?;
        warnings.extend(std::mem::take(&mut change.warnings));
        after.validate().map_err(|error| {
            Error::Request(format!("nothing can be rendered after the edits: {error}"))
        })?;
        let view = view::choose(sheets, &start)?;
        warnings.extend(view.doubts(&after));
        let sentences = words::sentences(&edits);
        Ok(Self { start, after, sentences, change, view, warnings })
    }
}
