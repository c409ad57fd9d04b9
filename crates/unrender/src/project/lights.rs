//! The lights that a project names.

use super::{Project, some_names};
use unrender_scene::{Scene, Source};

/// Checks that the lights in `project` are lights of `scene`.
pub(super) fn check(project: &Project, scene: &Scene) -> Result<(), String> {
    for name in project.known_lights.iter().chain(&project.unknown_lights) {
        find(name, scene)?;
    }
    Ok(())
}

/// The source called `name`.
fn find<'a>(name: &str, scene: &'a Scene) -> Result<Source<'a>, String> {
    let mut of_this_name = scene.sources().filter(|source| source.name == name);
    let found = of_this_name.next();
    let others = of_this_name.count();
    if others > 0 {
        let count = others + 1;
        return Err(format!(
            "lights.{name}: the scene has {count} lights of this name; give each its own"
        ));
    }
    found.ok_or_else(|| {
        let there = some_names(scene.sources().map(|source| source.name));
        let dark = match scene.group_index(name) {
            Some(_) => "; the group of this name emits nothing: give it an emission",
            None => "",
        };
        format!("lights.{name}: the scene has no light \"{name}\"; it has {there}{dark}")
    })
}
