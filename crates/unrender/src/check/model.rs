//! Checks of the model: surfaces that exist twice.

use super::{Subject, some};
use glam::Vec3;
use std::collections::BTreeMap;
use unrender_scene::Warnings;

/// A triangle by its corners, to the bit, whatever their order.
type Key = [[u32; 3]; 3];

/// Warnings of the meshes.
pub(super) fn warnings(subject: &Subject<'_>) -> Warnings {
    let mut warnings = Warnings::default();
    let objects = &subject.job.scene.objects;
    let mut first: BTreeMap<Key, usize> = BTreeMap::new();
    let mut twice: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (index, object) in objects.iter().enumerate() {
        for triangle in 0..object.mesh.triangles.len() {
            let earlier = *first.entry(key(object.mesh.corners(triangle))).or_insert(index);
            if objects[earlier].group != object.group {
                *twice.entry((earlier, index)).or_default() += 1;
            }
        }
    }
    for ((one, other), count) in twice {
        warnings.push(format!(
            "{count} triangle(s) of {} lie in the same place, in two groups: which one is seen is \
             random. Delete one",
            some(&[&objects[one].name, &objects[other].name])
        ));
    }
    warnings
}

fn key(corners: [Vec3; 3]) -> Key {
    // Zero has two signs.
    let mut key = corners.map(|corner| (corner + 0.0).to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}
