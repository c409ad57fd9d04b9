//! A job template of Open Job Description 2023-09.
//! [Open Job Description, Template Schemas 2023-09]
//!
//! Files are `PATH` parameters, so that a scheduler may map them onto the disks of its machines, and a
//! user may replace them; files below the template's folder are named relative to it.

use super::{Job, Word, text};
use crate::Error;
use serde_json::{Value, json};
use std::path::Path;

/// Each task's parameter.
const SAMPLES: &str = "{{Task.Param.Samples}}";

/// The template of `job`, as JSON.
///
/// # Errors
/// If a word of it has two braces.
pub(crate) fn template(job: &Job) -> Result<String, Error> {
    let mut parameters = vec![json!({
        "name": "Unrender",
        "type": "STRING",
        "default": "unrender",
        "description": "The command unrender, or its path on the machines.",
    })];
    let mut render = vec![json!("render")];
    for word in &job.words {
        match word {
            Word::Plain(word) => render.push(json!(unbraced(word)?)),
            Word::Input(name, path) => {
                parameters.push(path_parameter(name, "FILE", "IN", &relative(job, path)));
                render.push(json!(format!("{{{{Param.{name}}}}}")));
            }
        }
    }
    parameters.push(path_parameter("Parts", "DIRECTORY", "INOUT", "."));
    parameters.push(path_parameter("Picture", "FILE", "OUT", &relative(job, &job.out)));
    let file = |name: String| json!(format!("{{{{Param.Parts}}}}/{name}"));
    render.extend([json!("--quiet"), json!("--samples"), json!(SAMPLES)]);
    render.extend([json!("--checkpoint"), file(Job::checkpoint(SAMPLES))]);
    render.extend([json!("--out"), file(Job::part(SAMPLES))]);
    let samples: Vec<String> = job.samples.iter().map(|range| format!("{range:?}")).collect();
    let mut merge =
        vec![json!("merge"), json!("--quiet"), json!("--out"), json!("{{Param.Picture}}")];
    merge.extend(samples.iter().map(|range| file(Job::part(range))));
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": unbraced(&format!("unrender {}", job.name))?,
        "parameterDefinitions": parameters,
        "steps": [
            {
                "name": "Render",
                "parameterSpace": { "taskParameterDefinitions": [
                    { "name": "Samples", "type": "STRING", "range": samples },
                ] },
                "script": script(render),
            },
            {
                "name": "Merge",
                "dependencies": [{ "dependsOn": "Render" }],
                "script": script(merge),
            },
        ],
    });
    Ok(format!("{template:#}\n"))
}

fn script(words: Vec<Value>) -> Value {
    json!({ "actions": { "onRun": { "command": "{{Param.Unrender}}", "args": words } } })
}

fn path_parameter(name: &str, kind: &str, flow: &str, default: &str) -> Value {
    json!({
        "name": name, "type": "PATH", "objectType": kind, "dataFlow": flow, "default": default,
    })
}

/// `path` as seen from the template, if it lies beneath its folder; a template may not name others
/// relatively.
fn relative(job: &Job, path: &Path) -> String {
    text(path.strip_prefix(&job.folder).unwrap_or(path))
}

/// `text`, which stands in a template for itself.
fn unbraced(text: &str) -> Result<&str, Error> {
    if text.contains("{{") {
        return Err(Error::Request(format!(
            "\"{text}\" has two braces, which mean a parameter in a job template; rename it"
        )));
    }
    Ok(text)
}
