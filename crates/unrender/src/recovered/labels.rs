//! What objects are called where each needs a name of its own.

use std::collections::BTreeMap;
use unrender_scene::Scene;

/// The objects of `scene` by names that are given once: behind the second and later uses of a name stands
/// which of them it is.
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
