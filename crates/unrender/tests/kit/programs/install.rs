//! Packages of PyPI and npm, each set in its own folder beside the build's outputs. Tests use the
//! packages that `.ci/programs` has installed there; benchmarks and examples install those that
//! they lack.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// Tests of one binary run in parallel; only one of them installs at a time.
static INSTALLING: Mutex<()> = Mutex::new(());

/// The folder `name` of a program that `.ci/programs` has installed.
///
/// # Errors
/// If it has not.
pub(crate) fn installed(name: &str) -> Result<PathBuf, String> {
    let folder = folder(name);
    if folder.join("installed").exists() {
        return Ok(folder);
    }
    Err(format!("{} is not there; run .ci/programs {name}", folder.display()))
}

/// A Python that has `packages` (as pip names them); installs them if they are missing.
///
/// # Errors
/// If there is no Python, no registry, or no such package for this machine.
pub(crate) fn python(name: &str, packages: &[&str]) -> Result<PathBuf, String> {
    let folder = folder(name);
    let python = folder.join("bin/python");
    once(&folder, || {
        run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(packages))
    })?;
    Ok(python)
}

/// Runs `install` unless it has succeeded before.
fn once(folder: &Path, install: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    let _alone = INSTALLING.lock().unwrap_or_else(PoisonError::into_inner);
    let mark = folder.join("installed");
    if mark.exists() {
        return Ok(());
    }
    // An incomplete installation may be there.
    let _ = std::fs::remove_dir_all(folder);
    install()?;
    std::fs::write(mark, []).map_err(|error| error.to_string())
}

/// The folder `name` beside that of the profile in the build's outputs.
fn folder(name: &str) -> PathBuf {
    let this = std::env::current_exe().unwrap_or_default();
    let profile = this.ancestors().find(|a| a.ends_with("debug") || a.ends_with("release"));
    let target = profile.and_then(Path::parent).map_or_else(std::env::temp_dir, Path::to_owned);
    target.join("programs").join(name)
}

/// Runs `command`; returns an error if it fails.
pub(super) fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(format!("{command:?} failed: {}", said.trim()))
}
