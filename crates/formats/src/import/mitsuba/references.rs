//! References of a tree: followed once all of it is read, so that their targets may stand anywhere.

use super::tree::{DEPTH, Tree, Value};

/// Replaces references by their targets; circles and long chains are refused.
pub(super) fn resolve(tree: &mut Tree) -> Result<(), String> {
    let mut found = Vec::new();
    for (index, plugin) in tree.plugins.iter().enumerate() {
        for (at, property) in plugin.properties.iter().enumerate() {
            if let Value::Reference(id) = &property.value {
                let target = tree.ids.get(id).ok_or_else(|| {
                    let problem = format!("a reference to \"{id}\", which is not there");
                    tree.placed(property.place, problem)
                })?;
                found.push((index, at, *target));
            }
        }
    }
    for (index, at, target) in found {
        tree.plugins[index].properties[at].value = Value::Plugin(target);
    }
    check_depth(tree)
}

/// Refuses circles of references, and chains that are too long for recursion.
fn check_depth(tree: &Tree) -> Result<(), String> {
    /// The depth of the tree in a plugin.
    #[derive(Clone, Copy)]
    enum Depth {
        Unknown,
        Open,
        Known(usize),
    }
    let mut depths = vec![Depth::Unknown; tree.plugins.len()];
    for start in 0..tree.plugins.len() {
        let mut stack = vec![start];
        while let Some(&index) = stack.last() {
            let node = tree.node(index);
            if let Depth::Unknown = depths[index] {
                depths[index] = Depth::Open;
                for inner in node.inside() {
                    match depths[inner] {
                        Depth::Unknown => stack.push(inner),
                        Depth::Open => {
                            return Err(node.fail("a circle of references leads back here"));
                        }
                        Depth::Known(_) => {}
                    }
                }
                continue;
            }
            stack.pop();
            if let Depth::Open = depths[index] {
                let deepest = node.inside().map(|inner| match depths[inner] {
                    Depth::Known(depth) => depth + 1,
                    _ => 0,
                });
                let depth = deepest.max().unwrap_or(0);
                if depth > DEPTH {
                    return Err(node.fail(format!("has a chain of references {DEPTH} deep")));
                }
                depths[index] = Depth::Known(depth);
            }
        }
    }
    Ok(())
}
