//! Unique names of the objects of a scene.

use std::collections::BTreeMap;
use unrender_scene::Scene;

/// Unique names of the objects of `scene`: the second and later uses of a name get a number.
pub(crate) fn labels(scene: &Scene) -> Vec<String> {
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    let mut labels = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let count = uses.entry(&object.name).or_default();
        *count += 1;
        let name = &object.name;
        labels.push(if *count == 1 { name.clone() } else { format!("{name} ({count})") });
    }
    labels
}
