//! Where edits are written: a file or a flag, what messages call places in it, and where its paths start.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_formats::{LightUnits, Limits};
use unrender_scene::Scene;

/// An edit file or a flag, without its edits.
#[derive(Debug)]
pub(super) struct Written {
    /// What messages call it: the file, or the flag.
    name: String,
    /// Its text, where lines mean something.
    text: Option<String>,
    /// Where its paths start.
    folder: PathBuf,
    /// How far the reading of its files may go.
    pub(super) limits: Limits,
    /// The units of the lights of the scene to start from, where they are stated.
    pub(super) light_units: Option<LightUnits>,
    /// The scene that takes the place of the file that `scene` names.
    pub(super) scene: Option<Arc<Scene>>,
}

impl Written {
    /// The edit file at `path`, with its `text`.
    pub(super) fn of_file(path: &Path, text: String) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let flag = Self::of_flag(path.display().to_string());
        Self { text: Some(text), folder, ..flag }
    }

    /// A flag that messages call `name`.
    pub(super) fn of_flag(name: String) -> Self {
        let (folder, limits) = (PathBuf::new(), Limits::default());
        Self { name, text: None, folder, limits, light_units: None, scene: None }
    }

    /// The file itself, if it is one.
    pub(super) fn file(&self) -> Option<PathBuf> {
        self.text.as_ref().map(|_| PathBuf::from(&self.name))
    }

    /// What messages call the place of `span`.
    pub(super) fn place(&self, span: Range<usize>) -> String {
        match &self.text {
            Some(text) => format!("{}: line {}", self.name, line(text, span.start)),
            None => self.name.clone(),
        }
    }

    /// The file that a path of it means.
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
