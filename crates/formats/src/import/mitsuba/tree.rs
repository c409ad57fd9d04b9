//! A scene as a tree of plugins with their properties, which records what the reader asks for.
//!
//! A warning names every property that it did not ask for: see [`Tree::unread`]. It can ask only for those in the
//! table of [`plugins`].

use super::motion::Point;
use super::plugins;
use super::spectrum::Spectrum;
use crate::input::Scope;
use crate::record::Note;
use glam::{DAffine3, DVec3, Vec3};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The greatest depth of nested elements, includes and references counted. Scenes have up to ten
/// levels; each takes a kilobyte or two of the stack, which has 2 MiB in threads.
pub(super) const DEPTH: usize = 100;

/// Where something stands: a file of [`Tree::files`] and a line in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) file: usize,
    pub(super) line: u32,
}

/// A file of the scene.
#[derive(Debug)]
pub(super) struct File {
    /// The name in the file that includes it; empty for the file that the user names.
    pub(super) name: String,
    /// The folders in which it looks for files, the first one first.
    pub(super) folders: Vec<PathBuf>,
}

/// What a property is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Flag(bool),
    Text(String),
    Vector(DVec3),
    Color([f64; 3]),
    Spectrum(Spectrum),
    Motion(DAffine3),
    /// A plugin by its place in [`Tree::plugins`].
    Plugin(usize),
    /// A plugin by its `id`, until references are followed.
    Reference(String),
}

/// A property of a plugin; its name may be empty if it is a plugin itself.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) place: Place,
    pub(super) asked: Cell<bool>,
}

/// An element with a type, as `<bsdf type="diffuse" id="white">`, and what stands in it.
#[derive(Debug)]
pub(super) struct Plugin {
    pub(super) tag: String,
    pub(super) kind: String,
    /// Its row in the table of plugins, if it has one.
    pub(super) known: Option<&'static plugins::Plugin>,
    pub(super) id: String,
    /// The contents of our comment in front of it.
    pub(super) note: Note,
    pub(super) place: Place,
    /// Whether its file has the names and the defaults of Mitsuba 0.5 and 0.6.
    pub(super) is_old: bool,
    pub(super) properties: Vec<Property>,
    /// Whether the reader asked it for anything.
    pub(super) seen: Cell<bool>,
}

/// `an emitter of type "area"`.
fn of_type(tag: &str, kind: &str) -> String {
    let article = if tag.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {tag} of type \"{kind}\"")
}

/// All plugins of a scene; the first one is the scene.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) plugins: Vec<Plugin>,
    pub(super) files: Vec<File>,
    pub(super) ids: BTreeMap<String, usize>,
}

impl Tree {
    /// `problem` with its line, and with its file if that is not the one that the user names.
    pub(super) fn placed(&self, place: Place, problem: impl std::fmt::Display) -> String {
        match self.files.get(place.file).map(|file| file.name.as_str()) {
            None | Some("") => format!("line {}: {problem}", place.line),
            Some(name) => format!("line {} of \"{name}\": {problem}", place.line),
        }
    }

    /// The plugin at `index`.
    pub(super) fn node(&self, index: usize) -> Node<'_> {
        Node { tree: self, index }
    }

    /// The properties that the reader did not ask for, of plugins that it asked for others.
    pub(super) fn unread(&self) -> Vec<String> {
        let mut told = Vec::new();
        for plugin in self.plugins.iter().filter(|plugin| plugin.seen.get()) {
            for property in plugin.properties.iter().filter(|property| !property.asked.get()) {
                let tag = match &property.value {
                    Value::Plugin(index) => Some(self.plugins[*index].tag.as_str()),
                    _ => None,
                };
                if plugin.known.is_some_and(|known| known.passes(&property.name, tag)) {
                    continue;
                }
                let what = match &property.value {
                    Value::Plugin(index) if property.name.is_empty() => {
                        let inner = &self.plugins[*index];
                        of_type(&inner.tag, &inner.kind)
                    }
                    _ => format!("\"{}\"", property.name),
                };
                let owner = match plugin.kind.as_str() {
                    "" => "the scene".to_owned(),
                    kind => format!("the {} \"{kind}\"", plugin.tag),
                };
                let told_of = format!("{what} of {owner} is not read and was left out");
                told.push(self.placed(property.place, told_of));
            }
        }
        told
    }
}

/// One plugin of a tree.
#[derive(Clone, Copy)]
pub(super) struct Node<'t> {
    tree: &'t Tree,
    pub(super) index: usize,
}

impl<'t> Node<'t> {
    fn plugin(self) -> &'t Plugin {
        &self.tree.plugins[self.index]
    }

    pub(super) fn tag(self) -> &'t str {
        &self.plugin().tag
    }

    pub(super) fn kind(self) -> &'t str {
        &self.plugin().kind
    }

    pub(super) fn id(self) -> &'t str {
        &self.plugin().id
    }

    pub(super) fn note(self) -> &'t Note {
        &self.plugin().note
    }

    /// Whether its file is of Mitsuba 0.5 or 0.6.
    pub(super) fn is_old(self) -> bool {
        self.plugin().is_old
    }

    /// `rectangle at line 12`, with the file if that is not the one that the user names.
    pub(super) fn at_line(self) -> String {
        let Plugin { kind, place, .. } = self.plugin();
        match self.tree.files.get(place.file).map(|file| file.name.as_str()) {
            None | Some("") => format!("{kind} at line {}", place.line),
            Some(name) => format!("{kind} at line {} of {name}", place.line),
        }
    }

    /// The name of a shape: its own, its file's, or its line's.
    pub(super) fn shape_name(self) -> String {
        let own = || Some(self.id().to_owned()).filter(|id| !id.is_empty());
        // What our export notes is exact, even if it is no name.
        self.note()
            .name
            .clone()
            .or_else(own)
            .or_else(|| self.mesh_name())
            .unwrap_or_else(|| self.at_line())
    }

    /// The name of the file of a shape, without its folders.
    fn mesh_name(self) -> Option<String> {
        let text = |name: &str| self.plugin().properties.iter().find(|p| p.name == name);
        let Some(Value::Text(path)) = text("filename").map(|p| &p.value) else { return None };
        let name = path.rsplit(['/', '\\']).next().filter(|name| !name.is_empty())?;
        Some(match text("shape_index").map(|p| &p.value) {
            Some(Value::Number(index)) => format!("{name}, shape {index}"),
            _ => name.to_owned(),
        })
    }

    /// Whether it has a name of its own.
    pub(super) fn is_named(self) -> bool {
        !self.id().is_empty() || self.note().name.as_ref().is_some_and(|name| !name.is_empty())
    }

    fn is_at_root(self) -> bool {
        self.other(0).inside().any(|index| index == self.index)
    }

    /// The name of a BSDF: its own, that of the only one in it, that of the `shape` that has it, or its line's.
    pub(super) fn material_name(self, shape: Option<Self>) -> String {
        let mut node = self;
        loop {
            if let Some(name) = node.note().name.as_ref().filter(|name| !name.is_empty()) {
                return name.clone();
            }
            if !node.id().is_empty() {
                return node.id().to_owned();
            }
            let inside = node.inside().map(|index| node.other(index));
            let mut inside = inside.filter(|inner| inner.tag() == "bsdf");
            match (inside.next(), inside.next()) {
                // What stands at the root is a group of its own.
                (Some(inner), None) if !inner.is_at_root() => node = inner,
                _ => break,
            }
        }
        shape.map_or_else(|| self.at_line(), Self::shape_name)
    }

    /// `problem` with the line at which the plugin begins.
    pub(super) fn fail(self, problem: impl std::fmt::Display) -> String {
        self.tree.placed(self.plugin().place, problem)
    }

    /// The error that plugins of its type are not read, and `why`.
    pub(super) fn refused(self, why: &str) -> String {
        self.fail(format!("{} is not read: {why}", of_type(self.tag(), self.kind())))
    }

    fn property(self, name: &str) -> Option<&'t Property> {
        self.plugin().seen.set(true);
        self.plugin().known?.property(name)?;
        let found = self.plugin().properties.iter().find(|p| p.name == name)?;
        found.asked.set(true);
        Some(found)
    }

    /// The property called `name`, of any kind.
    pub(super) fn value(self, name: &str) -> Option<&'t Value> {
        self.property(name).map(|property| &property.value)
    }

    /// Whether there is a property called `name`; this does not count as asking for it.
    pub(super) fn has(self, name: &str) -> bool {
        self.plugin().properties.iter().any(|p| p.name == name)
    }

    /// Marks all its properties as read, since it is left out.
    pub(super) fn pass_all(self) {
        self.plugin().properties.iter().for_each(|property| property.asked.set(true));
    }

    /// The error that the property `name` is not what is `wanted`.
    pub(super) fn wrong(self, name: &str, wanted: &str) -> String {
        let property = self.plugin().properties.iter().find(|p| p.name == name);
        let place = property.map_or(self.plugin().place, |property| property.place);
        self.tree.placed(place, format!("\"{name}\" is not {wanted}"))
    }

    /// A number.
    pub(super) fn number(self, name: &str, default: f32) -> Result<f32, String> {
        match self.value(name) {
            None => Ok(default),
            Some(Value::Number(number)) => Ok(*number as f32),
            Some(_) => Err(self.wrong(name, "a number; give a <float>")),
        }
    }

    /// A number that is above zero.
    pub(super) fn positive(self, name: &str, default: f32) -> Result<f32, String> {
        let number = self.number(name, default)?;
        if number > 0.0 { Ok(number) } else { Err(self.wrong(name, "above zero")) }
    }

    /// A boolean.
    pub(super) fn flag(self, name: &str, default: bool) -> Result<bool, String> {
        match self.value(name) {
            None => Ok(default),
            Some(Value::Flag(flag)) => Ok(*flag),
            Some(_) => Err(self.wrong(name, "a <boolean>")),
        }
    }

    /// A text.
    pub(super) fn text(self, name: &str) -> Result<Option<&'t str>, String> {
        match self.value(name) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(self.wrong(name, "a <string>")),
        }
    }

    /// A vector.
    pub(super) fn vector(self, name: &str) -> Result<Option<Vec3>, String> {
        Ok(self.point(name)?.map(|vector| vector.as_vec3()))
    }

    /// A point, in double precision: it may be far from zero.
    pub(super) fn point(self, name: &str) -> Result<Option<Point>, String> {
        match self.value(name) {
            None => Ok(None),
            Some(Value::Vector(vector)) => Ok(Some(*vector)),
            Some(_) => Err(self.wrong(name, "a <point> or <vector>")),
        }
    }

    /// A transform; the identity by default.
    pub(super) fn motion(self, name: &str) -> Result<DAffine3, String> {
        match self.value(name) {
            None => Ok(DAffine3::IDENTITY),
            Some(Value::Motion(motion)) => Ok(*motion),
            Some(_) => Err(self.wrong(name, "a <transform>")),
        }
    }

    /// The position to which a transform takes zero.
    pub(super) fn place(self, name: &str) -> Result<Point, String> {
        Ok(self.motion(name)?.translation)
    }

    /// The plugins in it with the element `tag`, of any name.
    pub(super) fn children(self, tag: &str) -> Vec<Self> {
        self.plugin().seen.set(true);
        let mut found = Vec::new();
        if self.plugin().known.and_then(|known| known.inner(tag)).is_none() {
            return found;
        }
        for property in &self.plugin().properties {
            if let Value::Plugin(index) = property.value
                && self.tree.plugins[index].tag == tag
            {
                property.asked.set(true);
                found.push(self.tree.node(index));
            }
        }
        found
    }

    /// The only plugin in it with the element `tag`, if there is one.
    pub(super) fn child(self, tag: &str) -> Result<Option<Self>, String> {
        match self.children(tag)[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            _ => Err(self.fail(format!("there is more than one <{tag}> in this {}", self.tag()))),
        }
    }

    /// The indices of all plugins in it.
    pub(super) fn inside(self) -> impl Iterator<Item = usize> + 't {
        self.plugin().properties.iter().filter_map(|property| match property.value {
            Value::Plugin(index) => Some(index),
            _ => None,
        })
    }

    /// The plugin at `index` of the same tree.
    pub(super) fn other(self, index: usize) -> Self {
        self.tree.node(index)
    }

    /// The path of the file that the property `name` names; none if it is missing, which the scope notes.
    pub(super) fn file(self, scope: &Scope, name: &str) -> Result<Option<PathBuf>, String> {
        let file = self.text(name)?;
        let file = file.ok_or_else(|| self.fail(format!("this {} has no {name}", self.tag())))?;
        // The folders of the first file count for all plugins; Mitsuba searches no others.
        let places = [0, self.plugin().place.file].map(|index| &self.tree.files[index].folders);
        let folder = folder_of(places.into_iter().flatten(), file);
        scope.find(&folder, file).map_err(|problem| self.fail(format!("\"{file}\" {problem}")))
    }
}

/// The file `name` in the first of `folders` that has it.
pub(super) fn find<'a>(
    scope: &Scope,
    folders: impl Iterator<Item = &'a PathBuf> + Clone,
    name: &str,
) -> Result<PathBuf, String> {
    scope.beside(&folder_of(folders, name), name)
}

/// The first of `folders` that has the file `name`; if none has it, the first one.
fn folder_of<'a>(mut folders: impl Iterator<Item = &'a PathBuf> + Clone, name: &str) -> PathBuf {
    let first = folders.clone().next();
    let there = folders.find(|folder| folder.join(name).exists());
    there.or(first).cloned().unwrap_or_default()
}
