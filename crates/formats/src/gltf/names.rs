//! Names for materials, so that each group has one of its own.

use super::document::Document;
use super::graph::Placed;
use crate::names::{DEFAULT, unique};
use std::collections::BTreeMap;
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

/// The names of objects: those of their nodes, or of the meshes in them.
pub(super) struct ObjectNames<'a> {
    document: &'a Document,
    /// How many nodes without names have a mesh of this name.
    users: BTreeMap<&'a str, usize>,
}

impl<'a> ObjectNames<'a> {
    /// Of the nodes that `placed` lists.
    pub(super) fn of(document: &'a Document, placed: &[Placed]) -> Self {
        let mut names = Self { document, users: BTreeMap::new() };
        for placed in placed {
            if let (None, Some(mesh)) = names.given_to(placed) {
                *names.users.entry(mesh).or_default() += 1;
            }
        }
        names
    }

    /// The name of the node, and of its mesh.
    fn given_to(&self, placed: &Placed) -> (Option<&'a str>, Option<&'a str>) {
        let node = self.document.nodes.get(placed.node);
        let mesh = node.and_then(|node| self.document.meshes.get(node.mesh?));
        (
            node.and_then(|node| given(node.name.as_ref())),
            mesh.and_then(|mesh| given(mesh.name.as_ref())),
        )
    }

    /// The name of what the node has; nodes without names that share a mesh are told apart by their number in the file.
    pub(super) fn name(&self, placed: &Placed) -> String {
        match self.given_to(placed) {
            (Some(name), _) => name.to_owned(),
            (None, Some(mesh)) if self.users.get(mesh).is_none_or(|users| *users == 1) => {
                mesh.to_owned()
            }
            (None, Some(mesh)) => format!("{mesh} (node {})", placed.node),
            (None, None) => format!("object {}", placed.node),
        }
    }
}

/// The name, if it is one.
pub(super) fn given(name: Option<&String>) -> Option<&str> {
    name.map(String::as_str).filter(|name| !name.is_empty())
}
