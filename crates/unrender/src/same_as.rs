//! Groups of one material: `[groups.NAME] same_as`.
//!
//! The objects of such a group are counted to the other one while materials are looked for, so that
//! all its pixels speak for one material. What comes out is written for both.

use crate::Project;
use unrender_recover::GroupResult;
use unrender_scene::Scene;

/// Gives the objects of groups with `same_as` to the groups that are named there; the names must have
/// passed [`Project::check_against`]. Returns the group that every object had.
pub(crate) fn merge(project: &Project, scene: &mut Scene) -> Vec<usize> {
    let own_groups = scene.objects.iter().map(|object| object.group).collect();
    for (name, other) in &project.same_as {
        let (Some(from), Some(to)) = (scene.group_index(name), scene.group_index(other)) else {
            continue;
        };
        scene.groups[from].material = scene.groups[to].material.clone();
        for object in scene.objects.iter_mut().filter(|object| object.group == from) {
            object.group = to;
        }
    }
    own_groups
}

/// Writes what came out for the groups that are named into those with `same_as`.
pub(crate) fn share(project: &Project, results: &mut [GroupResult]) {
    for (name, other) in &project.same_as {
        let index = |name: &String| results.iter().position(|result| result.name == *name);
        let (Some(to), Some(from)) = (index(name), index(other)) else { continue };
        let note = format!("one material with \"{other}\", as the project says");
        let note = match &results[from].note {
            Some(of_other) => format!("{note}; {of_other}"),
            None => note,
        };
        let shared = GroupResult {
            name: name.clone(),
            note: Some(note),
            // Its pixels and its error are counted there.
            pixels: 0,
            valid_pixels: 0,
            error: None,
            error_share: None,
            selection_log: Vec::new(),
            ..results[from].clone()
        };
        results[to] = shared;
    }
}
