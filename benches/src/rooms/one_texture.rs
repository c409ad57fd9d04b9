//! One unknown texture in a room where all else is known: the three tasks of a published notebook, beside Mitsuba
//! at equal time.

use super::request::RoomsRequest;
use super::room::{Room, Rooms};
use super::studio::Studio;
use crate::Failure;
use crate::command::Unrender;
use crate::corpus::recover::{self, Subject};
use serde::Deserialize;
use serde_json::Value;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;
use unrender::formats::atomic;

/// A task of `rooms.json`.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Task {
    #[serde(skip)]
    name: String,
    file: String,
    /// The group whose texture is unknown.
    group: String,
    /// The most segments of a path, as Mitsuba counts them: 2 is direct light.
    max_depth: u32,
    /// The time of the publication.
    published: String,
}

/// Both programs' results.
pub(crate) struct Outcome {
    pub(crate) task: String,
    pub(crate) seconds: f64,
    /// The mean of (a - b)^2 / (b^2 + 0.01) over the texels, b the true ones.
    pub(crate) error: f64,
    /// The same of Mitsuba in the same time, and its iterations.
    pub(crate) mitsuba: (f64, u64),
    pub(crate) published: String,
}

/// The tasks of the list.
///
/// # Errors
/// If the list is damaged.
pub(crate) fn tasks(rooms: &Rooms) -> Result<Vec<Task>, Failure> {
    let listed = rooms.text["one_texture"].as_object().ok_or("rooms.json has no one_texture")?;
    let task = |(name, value): (&String, &Value)| {
        let task: Task = serde_json::from_value(value.clone())?;
        Ok(Task { name: name.clone(), ..task })
    };
    listed.iter().map(task).collect()
}

/// Runs the tasks whose files are there.
///
/// # Errors
/// If the list is damaged; a task that fails is reported.
pub(crate) fn measure(
    request: &RoomsRequest,
    rooms: &Rooms,
    studio: &Studio,
    command: &Unrender,
) -> Result<Vec<Outcome>, Failure> {
    let mut done = Vec::new();
    for task in tasks(rooms)? {
        if !Room::is_file_present(&task.name, &task.file, &request.folder) {
            continue;
        }
        match one(&task, request, studio, command) {
            Ok(outcome) => done.push(outcome),
            Err(problem) => eprintln!("{}: {problem}", task.name),
        }
    }
    Ok(done)
}

fn one(
    task: &Task,
    request: &RoomsRequest,
    studio: &Studio,
    command: &Unrender,
) -> Result<Outcome, Failure> {
    let folder = studio.one_texture(&task.name, &request.folder)?;
    let about: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("task.json"))?)?;
    let groups: Vec<&str> =
        about["groups"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let project = folder.join("project.toml");
    atomic::write(&project, project_text(task, request.brdf.as_deref(), &groups).as_bytes())?;
    let mut words = request.recover_words();
    words.extend(["--bounces".to_owned(), (task.max_depth - 1).to_string()]);
    let subject = Subject::new(command.path(), &words, Duration::from_secs(request.limit))?;
    let run: PathBuf = folder.join(format!("run_{}", subject.key));
    let outcome = recover::recover_at(&project, &run, &subject, request.again)?;
    if let Some(problem) = outcome.failure {
        return Err(problem.into());
    }
    let ours = studio.texture_error(&task.name, &folder, &run)?;
    let theirs = studio.texture_by_mitsuba(&task.name, &folder, outcome.seconds)?;
    let error = |value: &Value| value["error"].as_f64().ok_or("no error was written");
    Ok(Outcome {
        task: task.name.clone(),
        seconds: outcome.seconds,
        error: error(&ours)?,
        mitsuba: (error(&theirs)?, theirs["iterations"].as_u64().unwrap_or_default()),
        published: task.published.clone(),
    })
}

/// All groups keep their materials but the one with the texture.
fn project_text(task: &Task, brdf: Option<&str>, groups: &[&str]) -> String {
    let mut text =
        "scene = \"given.xml\"\nphoto = \"photo.exr\"\ncamera = \"photo\"\nresponse = \"linear\"\n\
                    exposure = 1.0\n"
            .to_owned();
    if let Some(brdf) = brdf {
        let _ = write!(text, "\n[recover]\nbrdf = \"{brdf}\"\n");
    }
    for group in groups.iter().filter(|group| !group.starts_with("lamp")) {
        let what = if *group == task.group { "rungs = [\"textured\"]" } else { "ignore = true" };
        let _ = write!(text, "\n[groups.\"{group}\"]\n{what}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_named_group_is_unknown() {
        let all = tasks(&Rooms::load(false).unwrap()).unwrap();
        assert_eq!(all.len(), 3);
        let task = all.iter().find(|task| task.name == "painting").unwrap();
        let text = project_text(task, Some("ggx"), &["lamp0", "Wall", "PaintingBSDF"]);
        assert!(!text.contains("lamp0"));
        assert!(text.contains("[groups.\"Wall\"]\nignore = true"));
        assert!(text.contains("[groups.\"PaintingBSDF\"]\nrungs = [\"textured\"]"));
    }
}
