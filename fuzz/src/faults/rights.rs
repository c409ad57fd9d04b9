//! Uses the rights of root: runs commands as another user, whom write protection stops, and on a file
//! system of a few kilobytes.

use super::AS_COMMAND;
use super::state::files_of;
use std::fs;
use std::io;
use std::os::unix::fs::{MetadataExt, chown};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};

/// A user without rights, who need not have a name.
const NOBODY: u32 = 65534;
/// tmpfs counts in pages, bytes.
const PAGE: u64 = 4096;

/// The user who runs the commands: nobody, if that can be chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct User {
    other: Option<u32>,
    is_root: bool,
}

impl User {
    /// Nobody, if we are root and nobody can run `program`; otherwise ourselves, the owner of
    /// `ours`.
    ///
    /// # Errors
    /// If the owner of `ours` cannot be read.
    pub(crate) fn choose(program: &Path, ours: &Path) -> io::Result<Self> {
        let is_root = fs::metadata(ours)?.uid() == 0;
        if !is_root {
            return Ok(Self { other: None, is_root });
        }
        let mut trial = Command::new(program);
        trial.arg("--version").env(AS_COMMAND, "1").uid(NOBODY).gid(NOBODY);
        trial.stdout(Stdio::null()).stderr(Stdio::null());
        let can_run = trial.status().is_ok_and(|status| status.success());
        Ok(Self { other: can_run.then_some(NOBODY), is_root })
    }

    /// Whether write protection stops this user.
    pub(crate) fn is_held_back(self) -> bool {
        self.other.is_some() || !self.is_root
    }

    /// Makes this user run `command`.
    pub(crate) fn runs(self, command: &mut Command) {
        if let Some(id) = self.other {
            command.uid(id).gid(id);
        }
    }

    /// Gives this user the file or folder at `path`, with its contents.
    ///
    /// # Errors
    /// If the owner cannot be changed.
    pub(crate) fn owns(self, path: &Path) -> io::Result<()> {
        let Some(id) = self.other else { return Ok(()) };
        chown(path, Some(id), Some(id))?;
        if path.is_dir() {
            for entry in fs::read_dir(path)? {
                self.owns(&entry?.path())?;
            }
        }
        Ok(())
    }
}

/// A file system in memory, until it is dropped. Only root can make one.
#[derive(Debug)]
pub(crate) struct Disk<'a>(&'a Path);

impl<'a> Disk<'a> {
    /// Mounts one at the folder `at`, with enough room.
    ///
    /// # Errors
    /// If it cannot be mounted.
    pub(crate) fn at(at: &'a Path) -> io::Result<Self> {
        must(Command::new("mount").args(["-t", "tmpfs", "tmpfs"]).arg(at))?;
        Ok(Self(at))
    }

    /// Leaves `free` bytes free, rounded up.
    ///
    /// # Errors
    /// If the size cannot be changed.
    pub(crate) fn leave(&self, free: u64) -> io::Result<()> {
        let used: u64 = files_of(self.0)?
            .iter()
            .map(|(_, bytes)| bytes.len().div_ceil(PAGE as usize) as u64)
            .sum();
        // A size of zero means no limit.
        let pages = used + free.div_ceil(PAGE).max(1);
        let size = format!("remount,size={}", pages * PAGE);
        must(Command::new("mount").args(["-o", &size]).arg(self.0))
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        // If this fails, removing the folder fails and reports it.
        let _ = must(Command::new("umount").arg(self.0));
    }
}

fn must(command: &mut Command) -> io::Result<()> {
    let output = command.stdin(Stdio::null()).output()?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(io::Error::other(said.trim().to_owned())) }
}
