//! Where edits are written: a file or a flag, its name in messages, and the folder of its paths.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_formats::{LightUnits, Limits};
use unrender_scene::Scene;

/// An edit file or a flag, without its edits.
#[derive(Debug)]
pub(super) struct Written {
    /// Its name in messages: the file, or the flag.
    name: String,
    /// Its text, if it has lines.
    text: Option<String>,
    /// The folder of its relative paths.
    folder: PathBuf,
    /// The limits of reading its files.
    pub(super) limits: Limits,
    /// The units of the scene's lights, if they are stated.
    pub(super) light_units: Option<LightUnits>,
    /// The scene instead of the file that `scene` names.
    pub(super) scene: Option<Arc<Scene>>,
}

impl Written {
    /// The edit file at `path`, with its `text`.
    pub(super) fn of_file(path: &Path, text: String) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let flag = Self::of_flag(path.display().to_string());
        Self { text: Some(text), folder, ..flag }
    }

    /// A flag with this `name` in messages.
    pub(super) fn of_flag(name: String) -> Self {
        let (folder, limits) = (PathBuf::new(), Limits::default());
        Self { name, text: None, folder, limits, light_units: None, scene: None }
    }

    /// The file itself, if it is one.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.text.as_ref().map(|_| PathBuf::from(&self.name))
    }

    /// The name of the place of `span` in messages.
    pub(super) fn place(&self, span: Range<usize>) -> String {
        match &self.text {
            Some(text) => format!("{}: line {}", self.name, line(text, span.start)),
            None => self.name.clone(),
        }
    }

    /// The file of a path in it.
    pub(super) fn path(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }
}

fn line(text: &str, offset: usize) -> usize {
    text.get(..offset).map_or(1, |before| before.matches('\n').count() + 1)
}

/// `message` with the line of `span` in `text`.
pub(super) fn with_line(text: &str, span: Option<Range<usize>>, message: &str) -> String {
    let Some(span) = span else { return message.to_owned() };
    let number = line(text, span.start);
    let shown = text.lines().nth(number - 1).unwrap_or_default().trim();
    format!("line {number}, `{shown}`: {message}")
}
