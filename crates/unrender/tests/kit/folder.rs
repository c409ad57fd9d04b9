//! A temporary folder of a test, the built command in it, and the messages expected from it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A temporary folder. It is removed with the value.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self(tempfile::Builder::new().prefix("unrender-").tempdir().unwrap())
    }

    /// Its path.
    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    /// The path of `name` in it.
    pub(crate) fn path(&self, name: &(impl AsRef<Path> + ?Sized)) -> PathBuf {
        self.root().join(name)
    }

    /// Writes `content` under `name`, and returns the path.
    pub(crate) fn write(&self, name: &str, content: &(impl AsRef<[u8]> + ?Sized)) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap_or_else(|error| panic!("{name}: {error}"));
        path
    }

    /// The bytes of the file `name`.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The text of the file `name`.
    pub(crate) fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The built command with `arguments`, to be run in this folder.
    pub(crate) fn command(&self, arguments: &[impl AsRef<OsStr>]) -> Command {
        let mut command = command(arguments);
        command.current_dir(self.root());
        command
    }

    /// Runs the built command with `arguments` in this folder.
    pub(crate) fn run(&self, arguments: &[impl AsRef<OsStr>]) -> Output {
        self.command(arguments).output().unwrap()
    }
}

/// The built command with `arguments`.
pub(crate) fn command(arguments: &[impl AsRef<OsStr>]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_unrender"));
    command.args(arguments);
    command
}

/// The output of a command on stderr.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts that a command succeeded. Returns what it printed on stdout.
#[track_caller]
pub(crate) fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Asserts that a command failed with exit code 1, with no output before an error with `problem`.
#[track_caller]
pub(crate) fn fails(output: &Output, problem: &str) {
    ends_in_error(output, problem);
    let said = stderr(output);
    assert!(said.starts_with("error: "), "{said}");
}

/// Asserts that a command failed with exit code 1 and an error with `problem`. It may have warned before.
#[track_caller]
pub(crate) fn ends_in_error(output: &Output, problem: &str) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("error: ") && said.contains(problem), "{problem}: {said}");
    assert!(!said.contains("panicked"), "{said}");
}

/// Asserts that a command failed, with any exit code, and reported `problem`. Returns its output on
/// stderr.
#[track_caller]
pub(crate) fn is_refused(output: &Output, problem: &str) -> String {
    let said = stderr(output);
    assert!(!output.status.success() && said.contains(problem), "{problem}: {said}");
    said
}
