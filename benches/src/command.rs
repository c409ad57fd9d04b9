//! Runs the built command as a user would.

use crate::{Failure, peers, root};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;
use unrender::run::Run;

/// The profile of this build, which names its folder: `dist` or `release`.
fn profile() -> String {
    let this = std::env::current_exe().unwrap_or_default();
    let folder = this.parent().and_then(|folder| folder.file_name()).unwrap_or_default();
    if folder == "dist" { "dist".into() } else { "release".into() }
}

/// The `unrender` command.
pub(crate) struct Unrender(PathBuf);

impl Unrender {
    /// Builds it by the profile of the benchmarks themselves, which takes no time if nothing changed.
    ///
    /// # Errors
    /// If cargo cannot.
    pub(crate) fn build() -> Result<Self, Failure> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut build = Command::new(cargo);
        let profile = profile();
        build.args(["build", "--profile", &profile, "--package", "unrender"]).current_dir(root());
        build.env("CARGO_TARGET_DIR", peers::target_folder());
        peers::said(&mut build)?;
        Ok(Self(peers::target_folder().join(profile).join("unrender")))
    }

    /// The one at `path`, already built.
    ///
    /// # Errors
    /// If nothing is there.
    pub(crate) fn at(path: &Path) -> Result<Self, Failure> {
        let path = path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self(path))
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Runs it; returns the seconds that it took.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn run(&self, arguments: &[OsString]) -> Result<f64, Failure> {
        let mut command = Command::new(&self.0);
        command.args(arguments).arg("--quiet").stdout(Stdio::null());
        let started = Instant::now();
        let ended = command.status()?;
        let seconds = started.elapsed().as_secs_f64();
        if ended.success() { Ok(seconds) } else { Err(format!("{command:?}: {ended}").into()) }
    }

    /// Recovers `project` into the folder `out`; the seconds of the whole command, and its `run.json`.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn recover(
        &self,
        project: &Path,
        out: &Path,
        flags: &[&str],
    ) -> Result<(f64, Run), Failure> {
        let mut arguments: Vec<OsString> =
            vec!["recover".into(), project.into(), "--out".into(), out.into()];
        arguments.extend(flags.iter().map(Into::into));
        let seconds = self.run(&arguments)?;
        Ok((seconds, Run::read(out)?))
    }

    /// Renders `scene` into the picture `out`; the seconds of the whole command.
    ///
    /// # Errors
    /// If it fails.
    pub(crate) fn render(
        &self,
        scene: &Path,
        (width, height): (usize, usize),
        spp: u32,
        out: &Path,
        flags: &[&str],
    ) -> Result<f64, Failure> {
        let mut arguments: Vec<OsString> =
            vec!["render".into(), scene.into(), "--out".into(), out.into()];
        for (name, value) in [("--width", width), ("--height", height), ("--spp", spp as usize)] {
            arguments.extend([name.into(), value.to_string().into()]);
        }
        arguments.extend(flags.iter().map(Into::into));
        self.run(&arguments)
    }
}
