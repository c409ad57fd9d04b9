//! Groups that share one material: `[groups.NAME] same_as`.
//!
//! The objects of such a group belong to the other one during the recovery, so that the pixels of
//! both determine one material. The result is written for both.

use crate::Project;
use unrender_recover::GroupResult;
use unrender_scene::Scene;

/// Moves the objects of groups with `same_as` to the groups named there; the names must have passed
/// [`Project::check_against`]. Returns the group that every object had.
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

/// Copies the results of the groups that are named into those with `same_as`.
pub(crate) fn share(project: &Project, results: &mut [GroupResult]) {
    for (name, other) in &project.same_as {
        let index = |name: &String| results.iter().position(|result| result.name == *name);
        let (Some(to), Some(from)) = (index(name), index(other)) else { continue };
        let note = format!("one material with \"{other}\", as the project states");
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
            decisions: Vec::new(),
            ..results[from].clone()
        };
        results[to] = shared;
    }
}
