//! The node hierarchy, flattened: which nodes are shown and where they stand in the world.

use super::Problem;
use super::document::{Document, Node};
use super::source::get;
use glam::{DAffine3, DMat4, DQuat, DVec3};

/// A node of the default scene in world space.
pub(super) struct Placed {
    /// Index of the node.
    pub(super) node: usize,
    /// Index of its parent, if it has one.
    pub(super) parent: Option<usize>,
    /// Takes the node's own coordinates to the world.
    pub(super) world_from_node: DAffine3,
}

/// All nodes of the default scene that are shown, parents before children, in the order of the file.
///
/// Without a default scene the first one counts, and without scenes all nodes count.
pub(super) fn placed_nodes(document: &Document) -> Result<Vec<Placed>, Problem> {
    let mut seen = vec![false; document.nodes.len()];
    let mut open: Vec<(usize, Option<usize>, DAffine3)> = Vec::new();
    let roots = roots(document)?;
    open.extend(roots.iter().rev().map(|&node| (node, None, DAffine3::IDENTITY)));
    let mut placed = Vec::new();
    while let Some((index, parent, world_from_parent)) = open.pop() {
        let node = get(&document.nodes, index, "node")?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!(
                "node {index} is reached twice: it has two parents or is its own descendant; \
                 export the scene again"
            ));
        }
        // It hides its children, too.
        if node.extensions.visibility.as_ref().is_some_and(|visibility| !visibility.visible) {
            continue;
        }
        let local = parent_from_node(node).map_err(|p| format!("node {index} {p}"))?;
        let world_from_node = world_from_parent * local;
        open.extend(node.children.iter().rev().map(|&child| (child, Some(index), world_from_node)));
        placed.push(Placed { node: index, parent, world_from_node });
    }
    Ok(placed)
}

fn roots(document: &Document) -> Result<Vec<usize>, Problem> {
    if document.scene.is_none() && document.scenes.is_empty() {
        let mut is_child = vec![false; document.nodes.len()];
        for child in document.nodes.iter().flat_map(|node| &node.children) {
            get(&document.nodes, *child, "node")?;
            is_child[*child] = true;
        }
        let roots: Vec<usize> = (0..is_child.len()).filter(|&node| !is_child[node]).collect();
        if roots.is_empty() && !is_child.is_empty() {
            return Err("every node is the child of another; export the scene again".into());
        }
        return Ok(roots);
    }
    Ok(get(&document.scenes, document.scene.unwrap_or(0), "scene")?.nodes.clone())
}

fn parent_from_node(node: &Node) -> Result<DAffine3, Problem> {
    if let Some(matrix) = &node.matrix {
        return Ok(DAffine3::from_mat4(DMat4::from_cols_array(matrix)));
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    if rotation.length_squared() <= 0.0 {
        return Err("has a rotation of length zero; export the scene again".into());
    }
    Ok(DAffine3::from_scale_rotation_translation(
        DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
        if rotation.is_normalized() { rotation } else { rotation.normalize() },
        DVec3::from_array(node.translation.unwrap_or_default()),
    ))
}
