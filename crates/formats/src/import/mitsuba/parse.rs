//! From XML to a [`Tree`]: elements, parameters, included files and references.

use super::elements::{PLUGINS, PROPERTIES};
use super::motion::{self, Attributes, attribute, number, vector};
use super::spectrum::Spectrum;
use super::tree::{DEPTH, File, Place, Plugin, Property, Tree, Value, find};
use super::{plugins, references, upgrade};
use crate::entry::find as find_entry;
use crate::input::Scope;
use crate::record::Note;
use glam::DAffine3;
use roxmltree::{Document, Node as Xml};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The tree takes at most this many times the memory of its XML text: `<a/>` becomes a node of 80
/// bytes, and `<rgb>` a property.
const TEXT_TO_TREE: u64 = 64;

/// The greatest depth of included files, as in Mitsuba.
const INCLUDES: usize = 15;

/// The most files of a scene. The largest published scenes have a few hundred.
const FILES: usize = 1000;

/// The longest text after parameters are replaced. Spectra have a few kilobytes.
const LONGEST: usize = 1 << 20;

/// Memory charged per byte of a replaced parameter: it is copied a few times, and endless growth ends
/// soon.
const PARAMETER_COST: u64 = 16;

/// The tree of the scene at `path`, references followed.
///
/// # Errors
/// With the line, if it is not a scene of Mitsuba's, or if a reference has no target.
pub(super) fn read(scope: &Scope, path: &Path) -> Result<Tree, String> {
    let mut parser = Parser {
        scope,
        tree: Tree::default(),
        parameters: Vec::new(),
        open: Vec::new(),
        named: BTreeSet::new(),
    };
    parser.file(path, "", &[], None, 0)?;
    references::resolve(&mut parser.tree)?;
    Ok(parser.tree)
}

struct Parser<'a> {
    scope: &'a Scope,
    tree: Tree,
    /// `$name` and its value, the longest name first: `$ab` is not `$a`, then `b`.
    parameters: Vec<(String, String)>,
    /// The files that are being read.
    open: Vec<PathBuf>,
    /// The names that the properties of each plugin have.
    named: BTreeSet<(usize, String)>,
}

/// A file that is being read.
struct Text {
    /// Its place in [`Tree::files`].
    file: usize,
    is_old: bool,
    /// Where its lines begin.
    lines: Vec<usize>,
}

impl Text {
    fn place(&self, xml: Xml) -> Place {
        let line = self.lines.partition_point(|&start| start <= xml.range().start);
        Place { file: self.file, line: line as u32 }
    }
}

impl Parser<'_> {
    fn fail(&self, place: Place, problem: impl std::fmt::Display) -> String {
        self.tree.placed(place, problem)
    }

    /// Reads the file at `path` that the scene calls `name`; what is in it becomes part of `parent`.
    fn file(
        &mut self,
        path: &Path,
        name: &str,
        around: &[PathBuf],
        parent: Option<usize>,
        depth: usize,
    ) -> Result<(), String> {
        let within = |problem: String| match name {
            "" => problem,
            name => format!("the included file \"{name}\" {problem}"),
        };
        let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if self.open.contains(&real) {
            return Err(within("includes itself".into()));
        }
        if self.open.len() > INCLUDES || self.tree.files.len() >= FILES {
            let bounds = format!(
                "more than {FILES} files, or files more than {INCLUDES} deep in one another"
            );
            return Err(within(format!("is one too many: a scene has {bounds}")));
        }
        let text = self.scope.text(path).map_err(within)?;
        self.scope.charge(TEXT_TO_TREE * text.len() as u64).map_err(within)?;
        let document =
            Document::parse(&text).map_err(|error| within(format!("is no XML: {error}")))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let folders = std::iter::once(folder).chain(around.iter().cloned()).collect();
        let starts = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = std::iter::once(0).chain(starts.map(|(at, _)| at + 1)).collect();
        let mut file = Text { file: self.tree.files.len(), is_old: false, lines };
        self.tree.files.push(File { name: name.to_owned(), folders });
        let root = document.root_element();
        let place = file.place(root);
        let version = root.attribute("version").ok_or_else(|| {
            let what = "has no version; write <scene version=\"3.0.0\">";
            self.fail(place, format!("<{}> {what}", root.tag_name().name()))
        })?;
        file.is_old = upgrade::is_old(version).map_err(|problem| self.fail(place, problem))?;
        self.open.push(real);
        match (root.has_tag_name("scene"), parent) {
            (true, Some(parent)) => self.children(root, parent, &file, depth)?,
            (true, None) => {
                let scene = self.push("scene", "", "", Note::default(), place);
                self.children(root, scene, &file, depth)?;
            }
            (false, Some(parent)) => {
                self.element(root, parent, &file, depth, Note::default())?;
            }
            (false, None) => {
                let tag = root.tag_name().name();
                return Err(self.fail(place, format!("begins with <{tag}>, not with <scene>")));
            }
        }
        self.open.pop();
        Ok(())
    }

    fn push(&mut self, tag: &str, kind: &str, id: &str, note: Note, place: Place) -> usize {
        let known = plugins::find(tag, kind);
        let (tag, kind, id) = (tag.to_owned(), kind.to_owned(), id.to_owned());
        let (properties, seen) = (Vec::new(), Cell::new(false));
        let is_old = false;
        self.tree.plugins.push(Plugin {
            tag,
            kind,
            known,
            id,
            note,
            place,
            is_old,
            properties,
            seen,
        });
        self.tree.plugins.len() - 1
    }

    fn children(
        &mut self,
        xml: Xml,
        parent: usize,
        text: &Text,
        depth: usize,
    ) -> Result<(), String> {
        if depth >= DEPTH {
            let problem = format!("has elements within elements, {DEPTH} deep and deeper");
            return Err(self.fail(text.place(xml), problem));
        }
        let mut note = Note::default();
        for child in xml.children() {
            if child.is_comment() {
                let origin = self.scope.origin();
                let parsed = child.text().and_then(|text| Note::parse(text, origin));
                note = parsed.unwrap_or_default();
            } else if child.is_element() {
                self.element(child, parent, text, depth + 1, std::mem::take(&mut note))?;
            }
        }
        Ok(())
    }

    /// The attributes of an element, `$name` replaced by its parameter.
    fn attributes(&self, xml: Xml, place: Place) -> Result<Attributes, String> {
        let mut all = Vec::new();
        for read in xml.attributes() {
            let value = self.replaced(read.value()).map_err(|problem| self.fail(place, problem))?;
            all.push((read.name().to_owned(), value));
        }
        Ok(all)
    }

    fn replaced(&self, text: &str) -> Result<String, String> {
        if !text.contains('$') {
            return Ok(text.to_owned());
        }
        let mut text = text.to_owned();
        for (key, value) in &self.parameters {
            let mut rest = text.as_str();
            let mut whole = String::new();
            while let Some(at) = rest.find(key.as_str()) {
                let is_escaped = rest[..at].ends_with('\\');
                whole.push_str(&rest[..at]);
                let piece = if is_escaped { key } else { value };
                // Parameters in parameters may grow without bounds.
                self.scope.charge(PARAMETER_COST * piece.len() as u64)?;
                if whole.len() + piece.len() > LONGEST {
                    return Err(format!("{key} makes a text of more than {LONGEST} bytes"));
                }
                whole.push_str(piece);
                rest = &rest[at + key.len()..];
            }
            whole.push_str(rest);
            text = whole;
        }
        let mut before = ' ';
        for (at, letter) in text.char_indices() {
            if letter == '$' && before != '\\' {
                let name: String = text[at + 1..]
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                return Err(format!(
                    "${name} is not defined; put <default name=\"{name}\" value=\"...\"/> before it"
                ));
            }
            before = letter;
        }
        Ok(text.replace("\\$", "$"))
    }

    fn check(
        &self,
        tag: &str,
        attributes: &Attributes,
        (needed, others): (&[&str], &[&str]),
        place: Place,
    ) -> Result<(), String> {
        for name in needed {
            if attribute(attributes, name).is_none() {
                return Err(self.fail(place, format!("<{tag}> has no {name}")));
            }
        }
        for (name, _) in attributes {
            if !needed.contains(&name.as_str()) && !others.contains(&name.as_str()) {
                let problem = format!("<{tag}> has an attribute {name}, which it cannot have");
                return Err(self.fail(place, problem));
            }
        }
        Ok(())
    }

    fn element(
        &mut self,
        xml: Xml,
        parent: usize,
        text: &Text,
        depth: usize,
        note: Note,
    ) -> Result<(), String> {
        let place = text.place(xml);
        let tag = xml.tag_name().name();
        let attributes = self.attributes(xml, place)?;
        let get = |name: &str| attribute(&attributes, name).unwrap_or_default();
        let is_spectrum_plugin = tag == "spectrum" && attribute(&attributes, "type").is_some();
        if find_entry(&PLUGINS, tag).is_some() || is_spectrum_plugin {
            self.check(tag, &attributes, (&["type"], &["id", "name", "version"]), place)?;
            let kind = if is_spectrum_plugin { "texture" } else { tag };
            let index = self.push(kind, get("type"), get("id"), note, place);
            self.name(get("id"), index, place)?;
            self.set(parent, get("name"), Value::Plugin(index), text, place)?;
            self.children(xml, index, text, depth)?;
            if text.is_old {
                self.tree.plugins[index].is_old = true;
                upgrade::plugin(&mut self.tree.plugins[index]);
            }
            return Ok(());
        }
        match tag {
            "include" => return self.include(&attributes, parent, text, depth, place),
            "transform" => {
                self.check(tag, &attributes, (&["name"], &[]), place)?;
                let motion = self.transform(xml, text)?;
                return self.set(parent, get("name"), Value::Motion(motion), text, place);
            }
            _ => {}
        }
        if let Some(child) = xml.children().find(Xml::is_element) {
            let problem = format!("<{}> cannot stand in <{tag}>", child.tag_name().name());
            return Err(self.fail(text.place(child), problem));
        }
        match tag {
            "default" => self.default(&attributes, place),
            "path" => self.path(&attributes, parent, text, place),
            "alias" => {
                self.check(tag, &attributes, (&["id", "as"], &[]), place)?;
                let found = self.tree.ids.get(get("id")).copied();
                let index = found.ok_or_else(|| {
                    let problem =
                        format!("an alias of \"{}\", which is not there before it", get("id"));
                    self.fail(place, problem)
                })?;
                self.name(get("as"), index, place)
            }
            "ref" => {
                self.check(tag, &attributes, (&["id"], &["name"]), place)?;
                let value = Value::Reference(get("id").to_owned());
                self.set(parent, get("name"), value, text, place)
            }
            _ => {
                let value = self.property(tag, &attributes, text, place)?;
                self.set(parent, get("name"), value, text, place)
            }
        }
    }

    /// The value of an element that is a property.
    fn property(
        &self,
        tag: &str,
        attributes: &Attributes,
        text: &Text,
        place: Place,
    ) -> Result<Value, String> {
        let known = find_entry(&PROPERTIES, tag).map_or("", |entry| entry.name);
        let others: (&[&str], &[&str]) = match known {
            "float" | "integer" | "boolean" | "string" | "rgb" | "srgb" => {
                (&["name", "value"], &[])
            }
            "point" | "vector" => (&["name"], &["value", "x", "y", "z"]),
            "spectrum" => (&["name"], &["value", "filename"]),
            _ => {
                let problem = format!("there is no element <{tag}> in scenes of Mitsuba 3");
                return Err(self.fail(place, problem));
            }
        };
        self.check(tag, attributes, others, place)?;
        let value = attribute(attributes, "value").unwrap_or_default();
        let found = match tag {
            "float" => number(value).map(Value::Number),
            "integer" => match value.trim().parse::<i64>() {
                Ok(whole) => Ok(Value::Number(whole as f64)),
                Err(_) => Err(format!("\"{value}\" is no whole number")),
            },
            "boolean" => motion::flag(value).map(Value::Flag),
            "string" => Ok(Value::Text(value.to_owned())),
            "point" | "vector" => vector(attributes, None).map(Value::Vector),
            // Mitsuba 0.5 and 0.6 take both for linear sRGB.
            "rgb" if text.is_old && motion::hexadecimal(value).is_some() => {
                Ok(Value::Color(motion::hexadecimal(value).unwrap_or_default()))
            }
            "spectrum"
                if text.is_old && motion::words(value).count() == 3 && !value.contains(':') =>
            {
                motion::triple(value).map(|color| Value::Color(color.unwrap_or_default()))
            }
            "rgb" => match motion::triple(value) {
                Ok(Some(color)) => Ok(Value::Color(color)),
                Ok(None) => Err(format!("\"{value}\" is no colour; give one number or three")),
                Err(problem) => Err(problem),
            },
            "srgb" => motion::encoded(value).map(Value::Color),
            _ => self.spectrum(attributes, text).map(Value::Spectrum),
        };
        let name = attribute(attributes, "name").unwrap_or_default();
        found.map_err(|problem| self.fail(place, format!("in {name}, {problem}")))
    }

    fn spectrum(&self, attributes: &Attributes, text: &Text) -> Result<Spectrum, String> {
        match (attribute(attributes, "value"), attribute(attributes, "filename")) {
            (Some(value), None) => Spectrum::parse(value),
            (None, Some(name)) => {
                let within = |problem: String| format!("the file \"{name}\": {problem}");
                let folders = &self.tree.files[text.file].folders;
                let path = find(self.scope, folders.iter(), name).map_err(within)?;
                let text = self.scope.text(&path).map_err(within)?;
                self.scope.charge(TEXT_TO_TREE * text.len() as u64).map_err(within)?;
                Spectrum::of_file(&text).map_err(within)
            }
            _ => Err("a spectrum has either a value or a filename".into()),
        }
    }

    fn transform(&self, xml: Xml, text: &Text) -> Result<DAffine3, String> {
        let mut world = DAffine3::IDENTITY;
        for child in xml.children().filter(Xml::is_element) {
            let place = text.place(child);
            let attributes = self.attributes(child, place)?;
            let tag = match child.tag_name().name() {
                "lookAt" if text.is_old => "lookat",
                tag => tag,
            };
            let step = motion::step(tag, &attributes).map_err(|p| self.fail(place, p))?;
            world = step * world;
        }
        if world.is_finite() {
            return Ok(world);
        }
        Err(self.fail(text.place(xml), "a transform is not finite"))
    }

    fn include(
        &mut self,
        attributes: &Attributes,
        parent: usize,
        text: &Text,
        depth: usize,
        place: Place,
    ) -> Result<(), String> {
        self.check("include", attributes, (&["filename"], &["name"]), place)?;
        let name = attribute(attributes, "filename").unwrap_or_default();
        let folders = self.tree.files[text.file].folders.clone();
        let path = find(self.scope, folders.iter(), name).map_err(|problem| {
            self.fail(place, format!("the included file \"{name}\" {problem}"))
        })?;
        let before = self.tree.files.len();
        let read = self.file(&path, name, &folders, Some(parent), depth);
        // An error within the file states its place already; an error about the file does not.
        let is_placed = self.tree.files.len() > before;
        read.map_err(|problem| if is_placed { problem } else { self.fail(place, problem) })
    }

    fn default(&mut self, attributes: &Attributes, place: Place) -> Result<(), String> {
        self.check("default", attributes, (&["name", "value"], &[]), place)?;
        let get = |name: &str| attribute(attributes, name).unwrap_or_default().to_owned();
        if get("name").is_empty() {
            return Err(self.fail(place, "a <default> has an empty name"));
        }
        let key = format!("${}", get("name"));
        // The first one counts, so that a scene can set parameters of a file that it includes.
        if !self.parameters.iter().any(|(known, _)| *known == key) {
            let at = self.parameters.partition_point(|(known, _)| known.len() >= key.len());
            self.parameters.insert(at, (key, get("value")));
        }
        Ok(())
    }

    fn path(
        &mut self,
        attributes: &Attributes,
        parent: usize,
        text: &Text,
        place: Place,
    ) -> Result<(), String> {
        self.check("path", attributes, (&["value"], &[]), place)?;
        if parent != 0 {
            return Err(self.fail(place, "a <path> stands within another element than <scene>"));
        }
        let name = attribute(attributes, "value").unwrap_or_default();
        let folders = &mut self.tree.files[text.file].folders;
        let found = folders.iter().map(|folder| folder.join(name)).find(|path| path.is_dir());
        match found {
            Some(folder) => {
                folders.insert(0, folder);
                Ok(())
            }
            None => {
                Err(self.fail(place, format!("the folder \"{name}\" of a <path> is not there")))
            }
        }
    }

    fn name(&mut self, id: &str, index: usize, place: Place) -> Result<(), String> {
        if !id.is_empty() && self.tree.ids.insert(id.to_owned(), index).is_some() {
            return Err(self.fail(place, format!("the id \"{id}\" is given twice")));
        }
        Ok(())
    }

    fn set(
        &mut self,
        parent: usize,
        name: &str,
        value: Value,
        text: &Text,
        place: Place,
    ) -> Result<(), String> {
        let name = if text.is_old { upgrade::snake_case(name) } else { name.to_owned() };
        if !name.is_empty() && !self.named.insert((parent, name.clone())) {
            // Mitsuba 0.6 takes the last one. Published files repeat lines, which changes nothing.
            let before = self.tree.plugins[parent].properties.iter().find(|of| of.name == name);
            if before.is_some_and(|before| before.value == value) {
                return Ok(());
            }
            return Err(self.fail(place, format!("\"{name}\" is given twice, with two values")));
        }
        let asked = Cell::new(false);
        self.tree.plugins[parent].properties.push(Property { name, value, place, asked });
        Ok(())
    }
}
