//! A scene while it is edited, and the record of what the edits changed.

use std::collections::BTreeSet;
use unrender_scene::{Scene, Warnings};

/// The relation of an edited scene to the original one.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Change {
    /// For each object of the edited scene the index of the same object, at the same place, in the
    /// original one; none for new and for moved objects. Groups keep their index; new ones are
    /// appended.
    pub origin: Vec<Option<usize>>,
    /// Warnings.
    pub warnings: Warnings,
}

/// A scene while it is edited.
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a mut Scene,
    pub(crate) change: Change,
    /// Kind and name of everything edited so far.
    edited: BTreeSet<(&'static str, String)>,
}

impl<'a> Stage<'a> {
    /// A scene without edits yet.
    pub(crate) fn new(scene: &'a mut Scene) -> Self {
        let origin = (0..scene.objects.len()).map(Some).collect();
        let change = Change { origin, warnings: Warnings::default() };
        Self { scene, change, edited: BTreeSet::new() }
    }

    /// Records that the `kind` called `name` is edited.
    ///
    /// # Errors
    /// If it was edited before: the result would depend on the order of the edits.
    pub(crate) fn claim(&mut self, kind: &'static str, name: &str) -> Result<(), String> {
        if self.edited.insert((kind, name.to_owned())) {
            return Ok(());
        }
        Err(format!("the {kind} \"{name}\" is edited twice; put both edits into one"))
    }

    /// Keeps the objects for which `keep` holds, by index.
    pub(crate) fn retain_objects(&mut self, keep: impl Fn(usize) -> bool) {
        let mut index = 0..self.scene.objects.len();
        self.scene.objects.retain(|_| index.next().is_some_and(&keep));
        let mut index = 0..self.change.origin.len();
        self.change.origin.retain(|_| index.next().is_some_and(&keep));
    }
}

/// Up to a dozen names for a message, each once; those that are like the `wanted` one, but for the case of its letters or a
/// part that one of them lacks, come first.
pub(crate) fn some_names<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let wanted = wanted.trim().to_lowercase();
    let is_like = |name: &str| {
        let name = name.to_lowercase();
        !wanted.is_empty() && (name.contains(&wanted) || wanted.contains(&name))
    };
    let names: BTreeSet<&str> = names.collect();
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_by_key(|name| !is_like(name));
    let shown: Vec<&str> = names.iter().take(SHOWN).copied().collect();
    match names.len() {
        0 => "none".to_owned(),
        count if count > SHOWN => format!("{} and {} more", shown.join(", "), count - SHOWN),
        _ => shown.join(", "),
    }
}
