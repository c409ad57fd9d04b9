//! What a glTF element has and no field of `document` reads: collected with the element, for warnings.

use super::elements::{self, ANIMATIONS};
use super::extensions;
use crate::entry::Taken;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use unrender_scene::Warnings;

/// The parts of an element that are not read.
#[derive(Deserialize, Default)]
pub(super) struct Unread {
    /// Its extensions; empty where the element has a field for those that are read.
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, IgnoredAny>,
    /// Its other properties; for a list of extensions, their names.
    #[serde(flatten)]
    pub(super) properties: BTreeMap<String, IgnoredAny>,
}

impl Unread {
    /// Warns of what is not read in an element of `kind`.
    pub(super) fn tell(&self, kind: &str, warnings: &mut Warnings) {
        self.tell_as(kind, &format!("glTF {kind}"), warnings);
    }

    /// As [`Unread::tell`], where `which` names the element.
    pub(super) fn tell_as(&self, kind: &str, which: &str, warnings: &mut Warnings) {
        self.extensions.keys().for_each(|name| tell_extension(name, warnings));
        for key in self.properties.keys() {
            let known = elements::property(kind, key);
            if known.is_some_and(|row| row.taken == Taken::PassedOver) {
                continue;
            }
            if kind == "file" && key == ANIMATIONS.name {
                warnings.push(format!("{}.", ANIMATIONS.done));
            } else {
                warnings.push(format!("{which}: the property {key} is not read; it was ignored."));
            }
        }
    }

    /// Warns of the extensions in a list of them that are not read.
    pub(super) fn tell_extensions(&self, warnings: &mut Warnings) {
        let names = self.properties.keys().chain(self.extensions.keys());
        names.for_each(|name| tell_extension(name, warnings));
    }
}

/// Warns of the extension `name` if it is not read.
pub(super) fn tell_extension(name: &str, warnings: &mut Warnings) {
    if !extensions::is_read(name) {
        warnings.push(extensions::ignored(name));
    }
}
