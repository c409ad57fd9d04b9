//! The detail of groups, for formats in which it belongs to a material.

use std::sync::Arc;
use unrender_scene::{Detail, Mesh, Object, Scene};

/// The detail of `mesh` that has an effect: none without texture coordinates.
fn effective(mesh: &Mesh) -> Option<&Detail> {
    (!mesh.uvs.is_empty() && !mesh.triangles.is_empty()).then_some(&mesh.detail)
}

/// The detail of group `index`: of its meshes the first that have normals and holes.
pub(crate) fn of_group(scene: &Scene, index: usize) -> Detail {
    let own = scene.objects.iter().filter(|object| object.group == index);
    let details: Vec<&Detail> = own.filter_map(|object| effective(&object.mesh)).collect();
    Detail {
        normals: details.iter().find_map(|detail| detail.normals.clone()),
        coverage: details.iter().find_map(|detail| detail.coverage.clone()),
    }
}

/// Whether both are equal; those that are shared need not be compared.
fn is_same<T: PartialEq>(one: &Option<Arc<T>>, other: &Option<Arc<T>>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other) || one == other,
        _ => one.is_none() && other.is_none(),
    }
}

/// The names of the groups whose meshes differ in it.
pub(crate) fn mixed(scene: &Scene) -> Vec<&str> {
    let is_mixed = |index: usize| {
        let all = of_group(scene, index);
        let own = scene.objects.iter().filter(|object| object.group == index);
        own.filter_map(|object| effective(&object.mesh)).any(|detail| {
            !is_same(&detail.normals, &all.normals) || !is_same(&detail.coverage, &all.coverage)
        })
    };
    let groups = scene.groups.iter().enumerate();
    groups.filter(|(index, _)| is_mixed(*index)).map(|(_, group)| group.name.as_str()).collect()
}

/// The names of objects without texture coordinates in groups that have holes.
pub(crate) fn unplaced(scene: &Scene) -> Vec<&str> {
    let is_unplaced = |object: &&Object| {
        object.mesh.uvs.is_empty() && of_group(scene, object.group).coverage.is_some()
    };
    scene.objects.iter().filter(is_unplaced).map(|object| object.name.as_str()).collect()
}
