//! The other programs, from PyPI, each in its own folder beside the build's outputs.

pub(crate) mod cycles;
#[path = "../../../crates/unrender/tests/kit/programs/install.rs"]
#[allow(dead_code)]
mod install;
pub(crate) mod mitsuba;
pub(crate) mod radiance;
pub(crate) mod shot;
mod worker;

use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) use install::python;
pub(crate) use shot::Shot;
pub(crate) use worker::Worker;

/// The build's outputs.
pub(crate) fn target_folder() -> PathBuf {
    let this = std::env::current_exe().unwrap_or_default();
    let target = this.ancestors().nth(2).map(Path::to_owned);
    target.unwrap_or_else(std::env::temp_dir)
}

/// A folder for files that the programs exchange.
pub(crate) fn work_folder(name: &str) -> PathBuf {
    target_folder().join("performance/work").join(name)
}

/// The standard output of `program`, if it succeeds.
///
/// # Errors
/// If it fails, with its message.
pub(crate) fn said(program: &mut Command) -> Result<String, String> {
    let output = program.output().map_err(|error| format!("{program:?}: {error}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
    }
    let problem = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    Err(format!("{program:?} failed: {problem}"))
}
