//! The edit file and the flags that stand for a line of it, understood.
//!
//! `sheet` is one file or flag: where that is, with the lines that errors name (`written`), and its tables (`raw`).
//! Each kind of edit (`remove`, `repaint`, `insert`, `view`) says in one file how it is written and
//! which edit of `unrender-restage` it is; lights and environments, which projects have too, do so
//! in `lighting`. `edits` collects them all. `start` reads the scene and the photograph (`developed`) that the edits
//! are made to.

mod composite;
mod developed;
mod edit_sheet;
mod edits;
mod insert;
mod raw;
mod remove;
mod repaint;
mod start;
mod view;
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

/// What to make of a scene, and from where to look at it.
#[derive(Debug)]
pub struct Restaging {
    /// The scene before, with the photograph if there is one.
    pub start: Start,
    /// The scene after its edits.
    pub after: Scene,
    /// What the edits did.
    pub change: Change,
    /// The cameras of the new pictures.
    pub view: View,
    /// What is doubtful.
    pub warnings: Warnings,
}

impl Restaging {
    /// Both scenes, to be rendered together.
    pub fn scenes(&self) -> Scenes<'_> {
        Scenes { before: &self.start.scene, after: &self.after, change: &self.change }
    }

    /// Reads what `sheets` name, and does their edits.
    ///
    /// # Errors
    /// If a file cannot be used, or an edit does not fit the scene; the message names the line.
    pub fn load(sheets: &[EditSheet]) -> Result<Self, Error> {
        let (start, mut warnings) = Start::load(sheets)?;
        let edits = edits::all(sheets, start.photograph.as_ref(), &mut warnings)?;
        let (places, edits): (Vec<String>, Vec<Edit>) = edits.into_iter().unzip();
        let mut after = start.scene.clone();
        let mut change = unrender_restage::apply(&mut after, &edits).map_err(|error| {
            Error::Request(format!("{}: {}", places[error.edit], error.problem))
        })?;
        warnings.extend(std::mem::take(&mut change.warnings));
        after.validate().map_err(|error| {
            Error::Request(format!("nothing can be rendered after the edits: {error}"))
        })?;
        let view = view::choose(sheets, &start)?;
        Ok(Self { start, after, change, view, warnings })
    }
}
