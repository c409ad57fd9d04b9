//! The tables of an edit file. Each is read by the file of its kind of edit. Values are checked where
//! they are read (`toml_values`), so that an error has the line of the value; names are checked
//! against the scene later.

use super::insert::RawInsert;
use super::remove::RawRemove;
use super::repaint::RawPaint;
use super::sheet::Sheet;
use super::start::Start;
use crate::Error;
use crate::lighting::{RawEnvironment, RawLight};
use serde::Deserialize;
use std::path::PathBuf;
use toml::{Spanned, Value};
use unrender_restage::Edit;
use unrender_restage::environment::Surround;
use unrender_scene::Warnings;

/// All keys of an edit file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEdits {
    pub(super) recovered: Option<Spanned<PathBuf>>,
    pub(super) project: Option<Spanned<PathBuf>>,
    pub(super) scene: Option<Spanned<PathBuf>>,
    pub(super) materials: Option<Spanned<PathBuf>>,
    pub(super) camera: Option<Spanned<Value>>,
    pub(super) environment: Option<Spanned<RawEnvironment>>,
    #[serde(default)]
    pub(super) remove: Vec<Spanned<RawRemove>>,
    #[serde(default)]
    pub(super) repaint: Vec<Spanned<RawPaint>>,
    #[serde(default)]
    pub(super) lights: Vec<Spanned<RawLight>>,
    #[serde(default)]
    pub(super) insert: Vec<Spanned<RawInsert>>,
}

/// An edit, and what messages call its place.
type Placed = (String, Edit);

/// The edits of all `sheets`: first all that is removed, then repainted, lit and inserted.
pub(super) fn edits(
    sheets: &[Sheet],
    start: &Start,
    warnings: &mut Warnings,
) -> Result<Vec<Placed>, Error> {
    let mut edits = Vec::new();
    let mut notes = Warnings::default();
    for sheet in sheets {
        collect(sheet, &sheet.raw.remove, &mut edits, &mut RawRemove::edit)?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.repaint, &mut edits, &mut |raw| raw.edit(sheet, &mut notes))?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.lights, &mut edits, &mut light)?;
    }
    for sheet in sheets {
        collect(sheet, sheet.raw.environment.as_slice(), &mut edits, &mut |raw| {
            surround(raw, sheet, &mut notes)
        })?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.insert, &mut edits, &mut |raw| {
            raw.edit(sheet, start, &mut notes)
        })?;
    }
    warnings.extend(notes);
    Ok(edits)
}

fn collect<T>(
    sheet: &Sheet,
    raw: &[toml::Spanned<T>],
    edits: &mut Vec<Placed>,
    understand: &mut dyn FnMut(&T) -> Result<Edit, String>,
) -> Result<(), Error> {
    for written in raw {
        let place = sheet.place(written.span());
        let edit = understand(written.get_ref())
            .map_err(|problem| Error::Request(format!("{place}: {problem}")))?;
        edits.push((place, edit));
    }
    Ok(())
}

fn light(raw: &RawLight) -> Result<Edit, String> {
    if raw.unknown.is_some() {
        return Err("unknown is a key of project files, where brightness can be asked for".into());
    }
    if raw.color.is_some() || raw.same_color_as.is_some() {
        return Err("color and same_color_as are keys of project files, for unknown lights; \
                    strength = [r, g, b] gives a light its colour"
            .into());
    }
    Ok(Edit::Light(raw.edit()?))
}

fn surround(raw: &RawEnvironment, sheet: &Sheet, notes: &mut Warnings) -> Result<Edit, String> {
    if raw.unknown.is_some() {
        return Err(
            "environment: unknown is a key of project files: what is edited is known".into()
        );
    }
    let read = raw.choice(&|file| sheet.path(file))?.read(sheet.limits());
    let (environment, warnings) = read.map_err(|error| error.to_string())?;
    notes.extend(warnings);
    Ok(Edit::Surround(Surround { environment }))
}
