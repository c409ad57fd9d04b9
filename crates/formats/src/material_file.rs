//! Materials for a scene by file extension: MaterialX (`.mtlx`), else `materials.json`.

use crate::{FileError, Input, materials, materialx};
use std::path::Path;
use unrender_scene::{Rgb, Scene, Warnings};

/// Whether the file at `path` is taken as MaterialX.
pub fn is_materialx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mtlx"))
}

/// Gives the groups of `scene` the materials of the file of `input`.
///
/// # Errors
/// As those of [`materials::apply_from`] and [`materialx::apply`].
pub fn apply<'a>(input: impl Into<Input<'a>>, scene: &mut Scene) -> Result<Warnings, FileError> {
    let input = input.into();
    if is_materialx(input.path) {
        materialx::apply(input, scene)
    } else {
        materials::apply_from(input, scene)
    }
}

/// The exposure that the file of `input` states, if it states one.
///
/// # Errors
/// If it cannot be read.
pub fn exposure<'a>(input: impl Into<Input<'a>>) -> Result<Option<Rgb>, FileError> {
    let input = input.into();
    if is_materialx(input.path) {
        return Ok(None);
    }
    Ok(materials::read(input)?.exposure.map(Rgb::from_array))
}
