//! Names for materials, so that each group has one of its own.

use super::document::Document;
use crate::names::{DEFAULT, unique};
use unrender_scene::Warnings;

/// The names of the groups: one for each material of the file, then one for primitives without.
///
/// Reader and writer both use these, so that a group finds its material again.
pub(super) fn group_names(document: &Document, warnings: &mut Warnings) -> Vec<String> {
    let mut wanted: Vec<String> = document.materials.iter().enumerate().map(wanted_name).collect();
    wanted.push(DEFAULT.into());
    unique(&wanted, warnings)
}

fn wanted_name((index, material): (usize, &super::document::Material)) -> String {
    given(material.name.as_ref()).map_or_else(|| format!("material {index}"), str::to_owned)
}

/// The name, if it is one.
pub(super) fn given(name: Option<&String>) -> Option<&str> {
    name.map(String::as_str).filter(|name| !name.is_empty())
}
