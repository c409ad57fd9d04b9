//! A job template of Open Job Description 2023-09.
//! [Open Job Description, Template Schemas 2023-09]
//!
//! Files are `PATH` parameters, so that a scheduler may map them onto the disks of its machines, and a
//! user may replace them. A template names only files in its own folder, relative to it; the others
//! are values in a file beside it.

use super::job::{Job, Word, text};
use crate::Error;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Each task's parameter.
const SAMPLES: &str = "{{Task.Param.Samples}}";

/// The template of `job` and the values of its parameters, as JSON.
///
/// # Errors
/// If a word of it has two braces.
pub(super) fn template(job: &Job) -> Result<(String, String), Error> {
    let mut values = Map::new();
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
                parameters.push(file_parameter(job, name, "IN", path, &mut values));
                render.push(json!(format!("{{{{Param.{name}}}}}")));
            }
        }
    }
    parameters.push(json!({
        "name": "Parts", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT",
        "default": ".",
    }));
    parameters.push(file_parameter(job, "Picture", "OUT", &job.out, &mut values));
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
    Ok((format!("{template:#}\n"), format!("{:#}\n", Value::Object(values))))
}

fn script(words: Vec<Value>) -> Value {
    json!({ "actions": { "onRun": { "command": "{{Param.Unrender}}", "args": words } } })
}

/// The parameter of the file `path`: with a default, if it lies in the job's folder, else with a value.
fn file_parameter(
    job: &Job,
    name: &str,
    flow: &str,
    path: &Path,
    values: &mut Map<String, Value>,
) -> Value {
    let mut parameter =
        json!({ "name": name, "type": "PATH", "objectType": "FILE", "dataFlow": flow });
    match path.strip_prefix(&job.folder) {
        Ok(inside) => parameter["default"] = json!(text(inside)),
        Err(_) => {
            values.insert(name.to_owned(), json!(text(path)));
        }
    }
    parameter
}

/// `text`, checked to have no braces that a template would replace.
fn unbraced(text: &str) -> Result<&str, Error> {
    if text.contains("{{") {
        return Err(Error::Request(format!(
            "\"{text}\" has two braces, which mean a parameter in a job template; rename it"
        )));
    }
    Ok(text)
}
