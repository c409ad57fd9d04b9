//! Edits, and what becomes of a scene by them.

use crate::environment::{self, Surround};
use crate::insert::{self, Insert};
use crate::light::{self, LightEdit};
use crate::remove::{self, Remove};
use crate::repaint::{self, Repaint};
use std::collections::BTreeSet;
use unrender_scene::{Scene, Warnings};

/// One edit.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Objects are taken away.
    Remove(Remove),
    /// A group reflects differently.
    Repaint(Repaint),
    /// A light is changed, added or removed.
    Light(LightEdit),
    /// Another panorama surrounds the scene.
    Surround(Surround),
    /// An object is added.
    Insert(Insert),
}

/// Why an edit cannot be done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
pub struct EditError {
    /// Which edit it is, by its place in the list.
    pub edit: usize,
    /// What is wrong with it and what to do.
    pub problem: String,
}

/// What edits have done to a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// For each object of the changed scene: which object of the unchanged one it is, at the same
    /// place; none for new and for moved ones. Groups keep their index; new ones are at the end.
    pub origin: Vec<Option<usize>>,
    /// What is doubtful.
    pub warnings: Warnings,
}

/// A scene on the way from edit to edit.
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a mut Scene,
    pub(crate) change: Change,
    /// The kind and the name of all that has been edited.
    edited: BTreeSet<(&'static str, String)>,
}

impl Stage<'_> {
    /// Notes that the `kind` called `name` is edited.
    ///
    /// # Errors
    /// If it was before: two edits of one thing do not say which of them counts.
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

/// Does `edits` to `scene`, one after the other.
///
/// # Errors
/// If an edit names what is not there, or what is there already; the scene is changed in part then.
pub fn apply(scene: &mut Scene, edits: &[Edit]) -> Result<Change, EditError> {
    let origin = (0..scene.objects.len()).map(Some).collect();
    let change = Change { origin, warnings: Warnings::default() };
    let mut stage = Stage { scene, change, edited: BTreeSet::new() };
    for (index, edit) in edits.iter().enumerate() {
        let done = match edit {
            Edit::Remove(remove) => remove::apply(remove, &mut stage),
            Edit::Repaint(repaint) => repaint::apply(repaint, &mut stage),
            Edit::Light(light) => light::apply(light, &mut stage),
            Edit::Surround(surround) => environment::apply(surround, &mut stage),
            Edit::Insert(insert) => insert::apply(insert, &mut stage),
        };
        done.map_err(|problem| EditError { edit: index, problem })?;
    }
    Ok(stage.change)
}

/// Up to a dozen names for a message, each once.
pub(crate) fn some_names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: BTreeSet<&str> = names.collect();
    let shown: Vec<&str> = names.iter().take(SHOWN).copied().collect();
    match names.len() {
        0 => "none".to_owned(),
        count if count > SHOWN => format!("{} and {} more", shown.join(", "), count - SHOWN),
        _ => shown.join(", "),
    }
}
