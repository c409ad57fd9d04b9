//! Removing objects, by name or by group.

use crate::stage::{Stage, some_names};

/// Removes objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Remove {
    /// The name of objects, or of a group or a glass, whose objects are all removed.
    pub name: String,
    /// What the name refers to.
    pub what: Bearer,
}

/// What a name refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bearer {
    /// Objects or a group, whichever there is.
    Any,
    /// Objects.
    Object,
    /// A group.
    Group,
}

pub(crate) fn apply(remove: &Remove, stage: &mut Stage<'_>) -> Result<(), String> {
    let name = remove.name.as_str();
    stage.claim("object or group", name)?;
    let objects = &stage.scene.objects;
    let of_name = |index: usize| objects[index].name == name;
    let group = stage.scene.group_index(name);
    let of_group = |index: usize| Some(objects[index].group) == group;
    let all = 0..objects.len();
    let there = |is: &dyn Fn(usize) -> bool| all.clone().any(is);
    let both = there(&of_name) && there(&of_group);
    if remove.what == Bearer::Any && both && !all.clone().all(|i| !of_name(i) || of_group(i)) {
        return Err(format!(
            "\"{name}\" is a group and the name of objects of other groups; say object = \"{name}\" \
             or group = \"{name}\""
        ));
    }
    let goes = |index: usize| match remove.what {
        Bearer::Any => of_name(index) || of_group(index),
        Bearer::Object => of_name(index),
        Bearer::Group => of_group(index),
    };
    let is_glass = |material: &str| remove.what != Bearer::Object && material == name;
    let glass = stage.scene.ungrouped.iter().any(|shape| is_glass(&shape.material));
    if !there(&goes) && !glass {
        let of_groups = stage.scene.groups.iter().map(|g| g.name.as_str());
        let groups = some_names(name, of_groups.chain(stage.scene.ungrouped_materials()));
        let names = some_names(name, objects.iter().map(|o| o.name.as_str()));
        return Err(format!(
            "the scene has no \"{name}\" to remove; its groups: {groups}; its objects: {names}"
        ));
    }
    let kept: Vec<bool> = all.clone().map(|index| !goes(index)).collect();
    stage.retain_objects(|index| kept[index]);
    stage.scene.ungrouped.retain(|shape| !is_glass(&shape.material));
    Ok(())
}
