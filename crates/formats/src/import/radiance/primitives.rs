//! The words of a `.rad` file, in primitives.

use crate::input::Scope;
use crate::record::Note;
use glam::DVec3;
use std::path::{Path, PathBuf};
use unrender_scene::Warnings;

/// How many files may include one another.
const DEPTH: usize = 16;

/// How many files a scene may include, each counted as often as it is included. Buildings have some
/// hundreds; each costs an opened file, so that ten times as many are still read in a second.
const FILES: usize = 1000;

/// What is kept of a text takes at most so many times its memory: `a b c 0 0 0` is a primitive of 200
/// bytes.
const TEXT_TO_PRIMITIVES: u64 = 32;

/// A primitive: `modifier kind id`, and its arguments.
#[derive(Clone, Debug, Default)]
pub(super) struct Primitive {
    pub(super) modifier: String,
    pub(super) kind: String,
    pub(super) id: String,
    pub(super) strings: Vec<String>,
    /// Positions among them count from where the scene does.
    pub(super) reals: Vec<f32>,
    /// The line that it starts in, with the file's name if that is an included one.
    pub(super) place: String,
}

impl Primitive {
    /// Exactly this many numbers.
    pub(super) fn reals<const N: usize>(&self) -> Result<[f32; N], String> {
        let count = self.reals.len();
        self.reals.clone().try_into().map_err(|_| {
            format!("the {} \"{}\" has {count} numbers instead of {N}", self.kind, self.id)
        })
    }
}

/// All primitives of the file at `path` and of those that it includes by `!xform`, each with the
/// comment of ours that it stands under.
pub(super) fn read(
    scope: &Scope,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Vec<Noted>, String> {
    let mut reading = Reading { scope, found: Vec::new(), warnings, files: 0 };
    let text = scope.text(path)?;
    reading.file(path, &text, "", DEPTH)?;
    Ok(reading.found)
}

/// A primitive, and the comment of ours that it stands under.
type Noted = (Primitive, Option<Note>);

/// The reading of a scene.
struct Reading<'a> {
    scope: &'a Scope,
    found: Vec<Noted>,
    warnings: &'a mut Warnings,
    /// Files that were included so far.
    files: usize,
}

impl Reading<'_> {
    /// The text of the file that the one at `path` includes as `name`, and where it lies.
    fn included(&mut self, path: &Path, name: &str) -> Result<(PathBuf, String), String> {
        self.files += 1;
        if self.files > FILES {
            return Err(format!("includes more than {FILES} files, counting repetitions"));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let path = self.scope.beside(folder, name);
        path.and_then(|path| self.scope.text(&path).map(|text| (path, text)))
            .map_err(|problem| format!("includes \"{name}\", which {problem}"))
    }

    fn file(&mut self, path: &Path, text: &str, shown: &str, depth: usize) -> Result<(), String> {
        self.scope.charge(TEXT_TO_PRIMITIVES * text.len() as u64)?;
        let mut words: Vec<Word> = Vec::new();
        let mut note: Option<Note> = None;
        for (index, line) in text.lines().enumerate() {
            let place = format!("{shown}line {}", index + 1);
            if let Some(comment) = line.strip_prefix('#') {
                self.flush(&mut words, &mut note)?;
                note = Note::parse(comment, self.scope.origin());
            } else if let Some(command) = line.strip_prefix('!') {
                self.flush(&mut words, &mut note)?;
                match command.split_whitespace().collect::<Vec<_>>()[..] {
                    ["xform", name] if depth == 0 => {
                        return Err(format!("includes \"{name}\", perhaps including itself"));
                    }
                    ["xform", name] => {
                        let (included, text) =
                            self.included(path, name).map_err(|p| format!("{place}: {p}"))?;
                        self.file(&included, &text, &format!("{name}, "), depth - 1)?;
                    }
                    _ => self.warnings.push(format!(
                        "{place}: the command \"{command}\" was left out; write what it prints \
                         into a file, and !xform that file"
                    )),
                }
            } else {
                let before = line.split('#').next().unwrap_or("").split_whitespace();
                words.extend(before.map(|text| Word { text, shown, line: index + 1 }));
            }
        }
        self.flush(&mut words, &mut note)
    }

    /// Turns the words so far into primitives.
    fn flush(&mut self, words: &mut Vec<Word>, note: &mut Option<Note>) -> Result<(), String> {
        let texts: Vec<&str> = words.iter().map(|word| word.text).collect();
        let mut rest = texts.as_slice();
        while !rest.is_empty() {
            let first = words[texts.len() - rest.len()];
            let place = format!("{}line {}", first.shown, first.line);
            let (primitive, after) =
                next(rest, self.scope.origin()).map_err(|problem| format!("{place}: {problem}"))?;
            self.found.push((Primitive { place, ..primitive }, note.clone()));
            if let Some(note) = note {
                note.is_first = false;
            }
            rest = after;
        }
        words.clear();
        Ok(())
    }
}

/// A word and where it stands.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    shown: &'a str,
    line: usize,
}

/// The places in the world among the arguments of a primitive of this kind, of three numbers each.
fn places(kind: &str) -> usize {
    match kind {
        "polygon" => usize::MAX,
        "sphere" | "bubble" | "ring" => 1,
        "cylinder" | "tube" | "cone" | "cup" => 2,
        _ => 0,
    }
}

/// `reals` in single precision, the places among them counted from `origin`.
fn counted_from(origin: DVec3, kind: &str, mut reals: Vec<f64>) -> Vec<f32> {
    for place in reals.chunks_exact_mut(3).take(places(kind)) {
        place.copy_from_slice(&(DVec3::from_slice(place) - origin).to_array());
    }
    reals.into_iter().map(|v| v as f32).collect()
}

/// The first primitive of `words`, and the words after it.
fn next<'a>(words: &'a [&'a str], origin: DVec3) -> Result<(Primitive, &'a [&'a str]), String> {
    let cut = || format!("ends in the middle of \"{}\"", words.join(" "));
    let [modifier, kind, id, rest @ ..] = words else { return Err(cut()) };
    let [modifier, kind, id] = [modifier, kind, id].map(|word| (*word).to_owned());
    let empty = Primitive { modifier, kind, id, ..Primitive::default() };
    if empty.kind == "alias" {
        let [real, rest @ ..] = rest else { return Err(cut()) };
        return Ok((Primitive { strings: vec![(*real).to_owned()], ..empty }, rest));
    }
    let mut rest = rest;
    let mut list = || -> Result<Vec<&str>, String> {
        let count = rest.first().and_then(|n| n.parse::<usize>().ok());
        let count = count.filter(|n| *n < rest.len()).ok_or_else(|| {
            format!("the {} \"{}\" does not say how many arguments it has", empty.kind, empty.id)
        })?;
        let (these, others) = rest[1..].split_at(count);
        rest = others;
        Ok(these.to_vec())
    };
    let (strings, _integers, reals) = (list()?, list()?, list()?);
    let number = |word: &&str| word.parse::<f64>().ok().filter(|v| (*v as f32).is_finite());
    let reals: Option<Vec<f64>> = reals.iter().map(number).collect();
    let reals =
        reals.ok_or_else(|| format!("\"{}\" has an argument that is no number", empty.id))?;
    let reals = counted_from(origin, &empty.kind, reals);
    let strings = strings.into_iter().map(str::to_owned).collect();
    Ok((Primitive { strings, reals, ..empty }, rest))
}
