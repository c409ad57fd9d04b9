//! The files of a scene and its commands, in primitives.
//!
//! No program is ever run for a scene, since its author could run anything. The output of `xform`, `cat`
//! and the generators of `generators.rs` and `gensky.rs` is made here; other commands are refused.

use super::primitives::{Noted, Place, Primitive};
use super::shell::{Stage, pipelines};
use super::words::{Item, Words, decoded};
use super::{generators, gensky, xform};
use crate::entry::{Entry, Taken, find, read as row, refused};
use crate::input::Scope;
use crate::record::Note;
use glam::DVec3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use unrender_scene::Warnings;

/// The greatest depth of included files.
const DEPTH: usize = 16;

/// The most files that a scene may include, each counted as often as it is included. Buildings have
/// some hundreds. Each means opening a file: ten times as many are still read in a second.
const FILES: usize = 1000;

/// The primitives take at most this many times the memory of their text: `a ring b 0 0 0` is a primitive
/// of some 400 bytes.
const TEXT_TO_PRIMITIVES: u64 = 32;

/// What to do about a command that is not carried out.
const EXPAND: &str = "no program is run for a scene, which may come from anyone; let Radiance write \
                      what it prints into one file, by: xform -e SCENE.rad > FLAT.rad";

/// The programs whose output is made here; others are refused.
pub(super) const PROGRAMS: [Entry; 6] = [
    row("xform", "all of its options: names, motions, -a, -f and several files"),
    row("cat", "files, one after the other"),
    row("genbox", "with its options -i, -b and -r"),
    row(
        "genprism",
        "with its options -l, -c and -e; -r does not round its edges here, with a warning",
    ),
    row(
        "gensky",
        "the sun as a light of one direction, and the sky of its kind as the environment; a \
         warning if a clear one has no -t",
    ),
    refused(
        "others",
        "no program is run for a scene; let Radiance write what it prints into one file",
    ),
];

/// All primitives of the file at `path` and of the files it includes, each with our comment above it.
pub(super) fn read(
    scope: &Scope,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Vec<Noted>, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut reading = Reading { scope, folder, warnings, files: 0 };
    let text = text_of(scope, path)?;
    reading.text(&text, "", folder, DEPTH)
}

fn not_built_in(program: &str) -> String {
    format!("the program \"{program}\" is not built in; {EXPAND}")
}

/// The text of the file at `path`.
pub(super) fn text_of(scope: &Scope, path: &Path) -> Result<String, String> {
    let text = decoded(scope.read(path)?);
    if text.contains('\0') {
        return Err("is no text".into());
    }
    Ok(text)
}

/// The reading of a scene.
struct Reading<'a> {
    scope: &'a Scope,
    /// The scene's folder.
    folder: &'a Path,
    warnings: &'a mut Warnings,
    /// Files that were included so far.
    files: usize,
}

/// Where a command is given.
#[derive(Clone, Copy)]
struct Given<'a> {
    /// The folder that it is given in.
    folder: &'a Path,
    /// How many levels of included files are still allowed.
    depth: usize,
    place: &'a Place,
}

/// The lists of an `xform`.
struct Lists<'a, 'b> {
    reading: &'a mut Reading<'b>,
    given: Given<'a>,
}

impl xform::Source for Lists<'_, '_> {
    fn list(&mut self, name: &str) -> Result<String, String> {
        self.reading.file(name, self.given).map(|(_, text)| text)
    }

    fn charge(&self, bytes: u64) -> Result<(), String> {
        self.reading.scope.charge(bytes)
    }
}

impl Reading<'_> {
    /// The primitives of the `text` of `file`, whose commands are given in `folder`.
    fn text(
        &mut self,
        text: &str,
        file: &str,
        folder: &Path,
        depth: usize,
    ) -> Result<Vec<Noted>, String> {
        self.scope.charge(TEXT_TO_PRIMITIVES * text.len() as u64)?;
        let file: Rc<str> = file.into();
        let (mut found, mut words, mut note) = (Vec::new(), Words::new(text), None);
        while let Some(item) = words.item() {
            let place = Place { file: file.clone(), line: words.first_line() };
            match item {
                // Moved to the scene's origin when all motions are known.
                Item::Comment(comment) => note = Note::parse(comment, DVec3::ZERO),
                Item::Command(command) => {
                    note = None;
                    let given = Given { folder, depth, place: &place };
                    let printed = self.command(&command, given);
                    found.extend(printed.map_err(|problem| format!("{place}: {problem}"))?);
                }
                Item::Primitive => {
                    let read = Primitive::read(&mut words);
                    let mut primitive = read.map_err(|problem| format!("{place}: {problem}"))?;
                    primitive.place = place;
                    found.push(Noted { primitive, note: note.clone() });
                    if let Some(note) = &mut note {
                        note.is_first = false;
                    }
                }
            }
        }
        Ok(found)
    }

    /// What the command `line` would print.
    fn command(&mut self, line: &str, given: Given) -> Result<Vec<Noted>, String> {
        let refused = |problem: String| format!("the command \"{line}\" {problem}; {EXPAND}");
        let mut found = Vec::new();
        for pipeline in pipelines(line).map_err(refused)? {
            let mut printed = None;
            for stage in &pipeline {
                printed = Some(self.stage(stage, printed, given)?);
            }
            found.extend(printed.unwrap_or_default());
        }
        Ok(found)
    }

    /// What a program that reads `piped` would print.
    fn stage(
        &mut self,
        stage: &Stage,
        piped: Option<Vec<Noted>>,
        given: Given,
    ) -> Result<Vec<Noted>, String> {
        let piped = match &stage.input {
            Some(file) => Some(self.included(file, given, false)?),
            None => piped,
        };
        let [program, words @ ..] = stage.words.as_slice() else { return Ok(Vec::new()) };
        let name = program.rsplit(['/', '\\']).next().unwrap_or(program);
        let name = name.strip_suffix(".exe").unwrap_or(name);
        let is_built_in = find(&PROGRAMS, name).is_some_and(|entry| entry.taken == Taken::Read);
        let made = match name {
            _ if !is_built_in => return Err(not_built_in(program)),
            "xform" => return self.xform(words, piped, given),
            "cat" => return self.cat(words, piped, given),
            "genbox" => generators::genbox(words),
            "genprism" => {
                let corners = self.corners(words, given)?;
                generators::genprism(words, corners, given.place, self.warnings)
            }
            "gensky" => gensky::gensky(words, given.place, self.warnings),
            _ => return Err(not_built_in(program)),
        };
        let made = made.map_err(|problem| format!("{program} {problem}"))?;
        let noted = made.into_iter().map(|primitive| {
            let primitive = Primitive { place: given.place.clone(), ..primitive };
            Noted { primitive, note: None }
        });
        let noted: Vec<Noted> = noted.collect();
        self.charge(&noted)?;
        Ok(noted)
    }

    fn xform(
        &mut self,
        words: &[String],
        piped: Option<Vec<Noted>>,
        given: Given,
    ) -> Result<Vec<Noted>, String> {
        let made = xform::parse(words, &mut Lists { reading: self, given })?;
        // Each file is read once, however often it is moved.
        let mut read: BTreeMap<&String, Vec<Noted>> = BTreeMap::new();
        for file in made.iter().flat_map(|(_, files)| files) {
            if !read.contains_key(file) {
                read.insert(file, self.included(file, given, true)?);
            }
        }
        let mut found = Vec::new();
        for (change, files) in &made {
            let named = files.iter().filter_map(|file| read.get(file));
            let piped = piped.as_ref().filter(|_| files.is_empty());
            if files.is_empty() && piped.is_none() {
                return Err("xform names no file, and nothing is piped into it".into());
            }
            for all in named.chain(piped) {
                let moved: Vec<Noted> = all.iter().map(|noted| change.of(noted)).collect();
                self.charge(&moved)?;
                found.extend(moved);
            }
        }
        Ok(found)
    }

    fn cat(
        &mut self,
        words: &[String],
        piped: Option<Vec<Noted>>,
        given: Given,
    ) -> Result<Vec<Noted>, String> {
        if words.is_empty() {
            return piped.ok_or_else(|| "cat names no file, and nothing is piped into it".into());
        }
        let mut found = Vec::new();
        for file in words {
            if file.starts_with('-') {
                return Err(format!("cat has \"{file}\", which is not built in; {EXPAND}"));
            }
            found.extend(self.included(file, given, false)?);
        }
        Ok(found)
    }

    /// The primitives of the file `name`. `xform` carries out its commands in the file's folder, `cat`
    /// in the folder of the command.
    fn included(&mut self, name: &str, given: Given, enters: bool) -> Result<Vec<Noted>, String> {
        if given.depth == 0 {
            return Err(format!("includes \"{name}\", perhaps including itself"));
        }
        let (path, text) = self.file(name, given)?;
        let its_own = path.parent().unwrap_or(Path::new(""));
        let folder = if enters { its_own } else { given.folder };
        self.text(&text, &format!("{name}, "), folder, given.depth - 1)
    }

    /// The text of the file `name`, and where it lies.
    fn file(&mut self, name: &str, given: Given) -> Result<(PathBuf, String), String> {
        self.files += 1;
        if self.files > FILES {
            return Err(format!("includes more than {FILES} files, counting repetitions"));
        }
        // Radiance would search its library's folders; the first is the one in which it is started.
        let there = given.folder.join(name).exists() || !self.folder.join(name).exists();
        let folder = if there { given.folder } else { self.folder };
        let path = self.scope.beside(folder, name);
        path.and_then(|path| text_of(self.scope, &path).map(|text| (path, text)))
            .map_err(|problem| format!("includes \"{name}\", which {problem}"))
    }

    /// The numbers of the file with the corners of `genprism`, if it names one.
    fn corners(&mut self, words: &[String], given: Given) -> Result<Option<Vec<f64>>, String> {
        let Some(file) =
            words.get(2).filter(|word| !word.starts_with(|c: char| c.is_ascii_digit()))
        else {
            return Ok(None);
        };
        if file == "-" {
            return Err(format!("genprism reads corners from its input; {EXPAND}"));
        }
        let (_, text) = self.file(file, given)?;
        // The corners end where the numbers end, as with Radiance.
        let numbers = text.split_whitespace().map_while(|word| word.parse().ok());
        Ok(Some(numbers.collect()))
    }

    /// Counts the memory of `made`.
    fn charge(&self, made: &[Noted]) -> Result<(), String> {
        self.scope.charge(made.iter().map(|noted| noted.primitive.bytes()).sum())
    }
}
