//! Runs the command under test on one project, and keeps the outcome.

use super::spoil::Dial;
use super::store::{Folder, Format};
use crate::Failure;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use unrender::formats::atomic;

/// The command, its arguments, and a name for both.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    pub(crate) command: PathBuf,
    pub(crate) arguments: Vec<String>,
    /// A run longer than this is ended and counts as failed.
    pub(crate) limit: Duration,
    /// A key of the command's bytes and the arguments.
    pub(crate) key: String,
}

/// The steps for a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted<'a> {
    pub(crate) subject: &'a Subject,
    /// The command that recovers only diffuse materials, if it can, for the comparison.
    pub(crate) plain: Option<&'a Subject>,
    /// Recover even if there are results.
    pub(crate) again: bool,
    /// Test in new light and from a new viewpoint.
    pub(crate) relight: bool,
}

impl Subject {
    /// The command at `command` with further `arguments` of `recover`.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn new(
        command: &Path,
        arguments: &[String],
        limit: Duration,
    ) -> Result<Self, Failure> {
        let bytes = std::fs::read(command)
            .map_err(|error| format!("{}: cannot be read: {error}", command.display()))?;
        let mut hasher = DefaultHasher::new();
        (bytes, arguments).hash(&mut hasher);
        let key = format!("{:08x}", hasher.finish() >> 32);
        Ok(Self { command: command.to_owned(), arguments: arguments.to_vec(), limit, key })
    }

    /// The same command with other arguments.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn with(&self, arguments: &[&str]) -> Result<Self, Failure> {
        let arguments: Vec<String> = arguments.iter().map(|&word| word.to_owned()).collect();
        Self::new(&self.command, &arguments, self.limit)
    }

    /// Whether `recover` has a flag.
    pub(crate) fn knows(&self, flag: &str) -> bool {
        let help = Command::new(&self.command).args(["recover", "--help"]).output();
        help.is_ok_and(|help| String::from_utf8_lossy(&help.stdout).contains(flag))
    }
}

/// The outcome of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Outcome {
    /// Seconds of the whole command.
    pub(crate) seconds: f64,
    /// Why it failed, if it did.
    pub(crate) failure: Option<String>,
    /// Global re-renderings.
    pub(crate) iterations: usize,
    pub(crate) termination: String,
    /// The arguments that were added to the command.
    pub(crate) arguments: Vec<String>,
}

/// The folder of a run.
pub(crate) fn folder(scene: &Folder, subject: &Subject, format: Format, dial: Dial) -> PathBuf {
    let name = format!("{}_{}_{}", format.name(), dial.name(), subject.key);
    scene.path("runs").join(name)
}

/// Recovers the project of `scene`, or, unless `again` is set, reads the earlier outcome.
///
/// # Errors
/// If the command cannot be started; a run that fails is an outcome.
pub(crate) fn recover(
    scene: &Folder,
    subject: &Subject,
    (format, dial): (Format, Dial),
    again: bool,
) -> Result<(PathBuf, Outcome), Failure> {
    let folder = folder(scene, subject, format, dial);
    let outcome = recover_at(&scene.project(format, dial), &folder, subject, again)?;
    Ok((folder, outcome))
}

/// Recovers `project` into `folder`, or, unless `again` is set, reads the earlier outcome.
///
/// # Errors
/// As those of [`recover`].
pub(crate) fn recover_at(
    project: &Path,
    folder: &Path,
    subject: &Subject,
    again: bool,
) -> Result<Outcome, Failure> {
    let record = folder.join("outcome.json");
    if !again && let Ok(text) = std::fs::read_to_string(&record) {
        return Ok(serde_json::from_str(&text)?);
    }
    if folder.exists() {
        std::fs::remove_dir_all(folder)?;
    }
    std::fs::create_dir_all(folder)?;
    let mut command = Command::new(&subject.command);
    command.arg("recover").arg(project).arg("--out").arg(folder);
    command.arg("--quiet").args(&subject.arguments);
    let (seconds, failure) = timed(&mut command, subject.limit)?;
    let mut outcome =
        Outcome { seconds, failure, arguments: subject.arguments.clone(), ..Outcome::default() };
    if outcome.failure.is_none() {
        read_run(folder, &mut outcome);
    }
    atomic::write(&record, serde_json::to_string_pretty(&outcome)?.as_bytes())?;
    Ok(outcome)
}

/// Runs `command`; returns its seconds, and the failure, if there was one.
fn timed(command: &mut Command, limit: Duration) -> Result<(f64, Option<String>), Failure> {
    let started = Instant::now();
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if started.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            let problem = format!("took longer than {} s", limit.as_secs());
            return Ok((started.elapsed().as_secs_f64(), Some(problem)));
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let seconds = started.elapsed().as_secs_f64();
    if status.success() {
        return Ok((seconds, None));
    }
    let mut said = String::new();
    if let Some(mut stderr) = child.stderr.take() {
        // If it cannot be read, it stays empty.
        let _ = std::io::Read::read_to_string(&mut stderr, &mut said);
    }
    let last = said.lines().last().unwrap_or_default();
    Ok((seconds, Some(format!("{status}: {last}"))))
}

/// Iterations and termination, from any version of `run.json`.
fn read_run(folder: &Path, outcome: &mut Outcome) {
    let Ok(text) = std::fs::read_to_string(folder.join("run.json")) else { return };
    let Ok(run) = serde_json::from_str::<Value>(&text) else { return };
    let iterations = ["iterations", "turns"].iter().find_map(|key| run[key].as_array());
    outcome.iterations = iterations.map_or(0, Vec::len);
    outcome.termination = run["termination"].as_str().unwrap_or_default().to_owned();
}
