//! Whole commands: as functions with the arguments of a command line, as the program itself, and as
//! data.

use crate::error::request;
use crate::scene::Scene;
use crate::supervise::{Control, supervise};
use clap::{Arg, ArgAction, Command};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::process::ExitCode;
use unrender::cli;

/// Runs the command line `words`, without the program's name. Returns its output, and whether it
/// succeeded. A `scene` replaces the scene file that the words name.
#[pyfunction]
#[pyo3(signature = (words, control, scene=None))]
pub(crate) fn call(
    py: Python<'_>,
    words: Vec<OsString>,
    control: Control<'_>,
    scene: Option<Bound<'_, Scene>>,
) -> PyResult<(String, bool, bool)> {
    let scene = scene.map(|scene| scene.get().shared());
    let ended = supervise(py, &control, move |listener| cli::call(words, scene, listener))?;
    let succeeded = ended.result == Some(ExitCode::SUCCESS);
    Ok((ended.heard.text, succeeded, ended.signalled))
}

/// Runs the command line `words`, the first of which is the program's name, as the program does;
/// returns its exit code. From then on the program handles signals.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    let code = py.detach(|| cli::run_from(words));
    // An exit code does not give its number.
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}

/// The command line as JSON: for each subcommand its help and its flags.
#[pyfunction]
pub(crate) fn description() -> String {
    let mut whole = cli::command();
    whole.build();
    let about = |command: &Command| {
        let flags = command.get_arguments().map(flag);
        json!({
            "about": command.get_about().map(ToString::to_string),
            "flags": flags.collect::<Vec<_>>(),
        })
    };
    let commands = whole.get_subcommands().map(|c| (c.get_name().to_owned(), about(c)));
    Value::Object(commands.collect()).to_string()
}

fn flag(arg: &Arg) -> Value {
    let defaults: Vec<_> = arg.get_default_values().iter().map(|v| v.to_string_lossy()).collect();
    json!({
        "name": arg.get_id().as_str(),
        "long": arg.get_long(),
        "default": defaults.first(),
        "switch": matches!(arg.get_action(), ArgAction::SetTrue),
        "required": arg.is_required_set(),
        "help": arg.get_help().map(ToString::to_string),
    })
}

/// The TOML text of a JSON text.
#[pyfunction]
pub(crate) fn toml_text(json: &str) -> PyResult<String> {
    let value: Value = serde_json::from_str(json).map_err(|error| request(error.to_string()))?;
    toml::to_string(&value).map_err(|error| request(format!("a project cannot hold this: {error}")))
}
