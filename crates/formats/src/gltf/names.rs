//! Names for materials, so that each group has one of its own.

use super::document::Document;
use super::graph::Placed;
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

/// The name of a node that holds a light or a camera.
///
/// Blender's exporter, up to 2021, hung these below their object, in a node OBJECT_Orientation; they
/// are called as the object is.
pub(super) fn holder<'a>(document: &'a Document, placed: &Placed) -> Option<&'a str> {
    let of_node = |index: usize| given(document.nodes.get(index)?.name.as_ref());
    let name = of_node(placed.node)?;
    let parent = placed.parent.and_then(of_node);
    let is_of = |parent: &&str| name.strip_suffix("_Orientation") == Some(parent);
    Some(parent.filter(is_of).unwrap_or(name))
}

/// The name, if it is one.
pub(super) fn given(name: Option<&String>) -> Option<&str> {
    name.map(String::as_str).filter(|name| !name.is_empty())
}
