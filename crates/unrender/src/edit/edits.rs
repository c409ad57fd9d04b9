//! Converts the tables of edit files to edits, in their order.

use super::edit_sheet::EditSheet;
use super::start::Start;
use super::written::Written;
use crate::Error;
use crate::lighting::{RawEnvironment, RawLight};
use toml::Spanned;
use unrender_restage::Edit;
use unrender_restage::environment::Surround;
use unrender_scene::Warnings;

/// An edit, and the name of its place in messages.
type Placed = (String, Edit);

/// The edits of `start` by all `sheets`: first removals, then repaints, lights and insertions.
pub(super) fn all(
    sheets: &[EditSheet],
    start: &Start,
    warnings: &mut Warnings,
) -> Result<Vec<Placed>, Error> {
    let mut edits = Vec::new();
    let mut notes = Warnings::default();
    for sheet in sheets {
        collect(sheet, &sheet.raw.remove, &mut edits, &mut |raw| raw.edit().map(Some))?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.repaint, &mut edits, &mut |raw| {
            raw.edit(&sheet.written, &mut notes).map(Some)
        })?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.lights, &mut edits, &mut |raw| {
            light(raw, start, &sheet.written, &mut notes)
        })?;
    }
    for sheet in sheets {
        collect(sheet, sheet.raw.environment.as_slice(), &mut edits, &mut |raw| {
            surround(raw, &sheet.written, &mut notes).map(Some)
        })?;
    }
    for sheet in sheets {
        collect(sheet, &sheet.raw.insert, &mut edits, &mut |raw| {
            raw.edit(&sheet.written, (&start.scene, start.photograph.as_ref()), &mut notes)
                .map(Some)
        })?;
    }
    warnings.extend(notes);
    Ok(edits)
}

fn collect<T>(
    sheet: &EditSheet,
    raw: &[Spanned<T>],
    edits: &mut Vec<Placed>,
    understand: &mut dyn FnMut(&T) -> Result<Option<Edit>, String>,
) -> Result<(), Error> {
    for written in raw {
        let place = sheet.written.place(written.span());
        let found = understand(written.get_ref())
            .map_err(|problem| Error::Request(format!("{place}: {problem}")))?;
        edits.extend(found.into_iter().map(|edit| (place.clone(), edit)));
    }
    Ok(())
}

/// None if it switches a light off that is off.
fn light(
    raw: &RawLight,
    start: &Start,
    written: &Written,
    notes: &mut Warnings,
) -> Result<Option<Edit>, String> {
    if raw.unknown.is_some() {
        return Err(
            "unknown is a key of project files only, where brightness can be recovered".into()
        );
    }
    if raw.color.is_some() && !raw.is_photometric() || raw.same_color_as.is_some() {
        return Err("color and same_color_as are keys of project files, for unknown lights; \
                    strength = [r, g, b] gives a light its colour, and color beside lumens, candela, lux or a profile"
            .into());
    }
    let edit = raw.edit(&|file| written.path(file), written.limits, notes)?;
    let is_off = raw.on == Some(false) && start.switched_off(&raw.name).is_some();
    Ok((!is_off).then_some(Edit::Light(edit)))
}

fn surround(raw: &RawEnvironment, written: &Written, notes: &mut Warnings) -> Result<Edit, String> {
    let (environment, warnings) = raw.stated(&|file| written.path(file), written.limits)?;
    notes.extend(warnings);
    Ok(Edit::Surround(Surround { environment }))
}
