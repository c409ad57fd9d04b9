//! Names that every program takes: ASCII letters, digits and underscores, each given once.

use crate::glasses::Glasses;
use std::collections::BTreeSet;
use unrender_scene::Scene;

/// For each of `names` an identifier that starts with `prefix` and is like it; case counts for
/// nothing, so that they will do as file names too.
pub(super) fn identifiers<'a>(prefix: &str, names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut unique = |name: &str| {
        let stem: String = name.chars().map(plain).take(60).collect();
        let numbered = (2..).map(|number| format!("{prefix}{stem}_{number}"));
        let mut candidates = std::iter::once(format!("{prefix}{stem}")).chain(numbered);
        candidates.find(|id| taken.insert(id.to_ascii_lowercase())).unwrap_or_default()
    };
    names.map(&mut unique).collect()
}

/// The identifiers of a scene's groups, its objects, the kinds of its glass, and the shapes of these: those of groups and
/// kinds start alike and are told apart, and those of objects and shapes.
pub(super) struct Ids {
    /// Of the groups.
    pub(super) groups: Vec<String>,
    /// Of the objects.
    pub(super) objects: Vec<String>,
    /// Of the kinds of glass.
    pub(super) kinds: Vec<String>,
    /// Of the shapes of glass.
    pub(super) shapes: Vec<String>,
}

impl Ids {
    /// Those of `scene`, whose glass is `glasses`.
    pub(super) fn of(scene: &Scene, glasses: &Glasses) -> Self {
        let groups = scene.groups.iter().map(|group| group.name.as_str());
        let kinds = glasses.kinds.iter().map(|kind| kind.name.as_str());
        let mut groups = identifiers("m_", groups.chain(kinds));
        let kinds = groups.split_off(scene.groups.len());
        let objects = scene.objects.iter().map(|object| object.name.as_str());
        let shapes = glasses.shapes.iter().map(|shape| shape.name.as_str());
        let mut objects = identifiers("o_", objects.chain(shapes));
        let shapes = objects.split_off(scene.objects.len());
        Self { groups, objects, kinds, shapes }
    }
}

/// A name in double quotes on one line, for comments and strings: quotes, backslashes and control
/// characters escaped as JSON has them.
pub(super) fn quoted(name: &str) -> String {
    serde_json::Value::from(name).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_given_once() {
        let names = ["wall", "Wall", "wall_2", "wall", "große \"Tür\" 门", ""];
        let found = identifiers("m_", names.into_iter());
        assert_eq!(
            found,
            ["m_wall", "m_Wall_2", "m_wall_2_2", "m_wall_3", "m_gro_e__T_r___", "m_"]
        );
        assert_eq!(quoted("a \"b\"\n\\"), r#""a \"b\"\n\\""#);
    }
}
