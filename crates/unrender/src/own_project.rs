//! The project of a recovery whose scene and photograph are named on the command line: `project.toml` in the folder of the
//! results, where `restage`, `check` and the next recovery find it.

use crate::global::Global;
use crate::shell_word::quoted;
use crate::{Error, Project, proposed};
use std::fs;
use std::path::{Path, PathBuf};
use unrender_formats::FileError;
use unrender_scene::Warnings;

/// The project, before it is written.
pub(crate) struct OwnProject {
    path: PathBuf,
    text: String,
    /// Whether the file is there already, from an earlier run of the same command.
    is_there: bool,
}

/// A project file that this run has written.
pub(crate) struct Written(PathBuf);

impl OwnProject {
    /// Its name.
    pub(crate) const FILE: &str = "project.toml";

    /// The project of `scene` and `photo` for results in the folder `out`; what was guessed goes to the console.
    ///
    /// # Errors
    /// If one of them cannot be read, the scene has no camera, or another project lies in the folder.
    pub(crate) fn of(
        scene: &Path,
        photo: &Path,
        out: &Path,
        global: &Global,
    ) -> Result<Self, Error> {
        let path = out.join(Self::FILE);
        let proposed = proposed::propose(scene, photo, &path, global.limits())?;
        if proposed.checkup.is_none() {
            let why = proposed.guesses.join("; ");
            return Err(FileError::new(scene, why).into());
        }
        let is_there = path.exists();
        let is_same = || fs::read_to_string(&path).is_ok_and(|text| text == proposed.text);
        if is_there && !is_same() {
            let problem = format!(
                "is another project than --scene and --photo make: `unrender recover {} --out {}` recovers it, or name \
                 another folder by --out",
                quoted(&path.to_string_lossy()),
                quoted(&out.to_string_lossy())
            );
            return Err(FileError::new(&path, problem).into());
        }
        if !global.quiet {
            proposed
                .guesses
                .iter()
                .for_each(|guess| global.console.tell(&format!("guess: {guess}")));
        }
        Ok(Self { path, text: proposed.text, is_there })
    }

    /// The project itself.
    pub(crate) fn parsed(&self) -> Result<(Project, Warnings), FileError> {
        Project::parse(&self.path, &self.text)
    }

    /// Writes it, if it is not there.
    pub(crate) fn write(self) -> Result<Option<Written>, FileError> {
        if self.is_there {
            return Ok(None);
        }
        proposed::write(&self.text, &self.path)?;
        Ok(Some(Written(self.path)))
    }
}

impl Written {
    /// Removes it again.
    pub(crate) fn remove(self) {
        // That it stays does no harm.
        let _ = fs::remove_file(self.0);
    }
}
