//! What lies at a path, for messages about a path that is given where another kind of file is expected.

use crate::{picture, scene_file};
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A kind of input that is easily taken for another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A folder.
    Folder,
    /// A picture, also of a format that is not read.
    Picture,
    /// A scene, by its extension or as a binary glTF file.
    Scene,
}

/// Bytes at the beginning of a file by which pictures are recognised: the longest signature ends at the 16th.
const BEGINNING: u64 = 64;

impl Kind {
    /// What lies at `path`; none if it is nothing of these or cannot be read.
    ///
    /// ```
    /// use unrender_formats::Kind;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let photo = folder.path().join("photo");
    /// std::fs::write(&photo, b"\x89PNG\r\n\x1a\n")?;
    /// assert_eq!(Kind::of(folder.path()), Some(Kind::Folder));
    /// assert_eq!(Kind::of(&photo), Some(Kind::Picture));
    /// # Ok::<(), std::io::Error>(())
    /// ```
    pub fn of(path: &Path) -> Option<Self> {
        let meta = path.metadata().ok()?;
        if meta.is_dir() {
            return Some(Self::Folder);
        }
        // Opening a pipe would wait for its writer.
        if !meta.is_file() {
            return None;
        }
        if scene_file::is_scene(path) {
            return Some(Self::Scene);
        }
        let mut beginning = Vec::new();
        File::open(path).ok()?.take(BEGINNING).read_to_end(&mut beginning).ok()?;
        if beginning.starts_with(b"glTF") {
            return Some(Self::Scene);
        }
        picture::is_picture(&beginning).then_some(Self::Picture)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Folder => "a folder",
            Self::Picture => "a picture",
            Self::Scene => "a scene",
        })
    }
}
