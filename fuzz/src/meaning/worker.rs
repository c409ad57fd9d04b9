//! The process that runs the cases of the family, one after the other. It prints the number of each before it, so that
//! the watching process knows which one killed it, and then how it ended.

use super::case::{Case, make};
use super::judge;
use crate::worker::limit_resources;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use unrender::listener::Listener;
use unrender::recover::IterationRecord;

/// The limit of processor time for a command, seconds. On a machine with many times its load a draft took two in the
/// median, one of a hundred more than 13, and one 60, whose light from all around was unknown direction by direction. At a
/// third of the limit that one was found; double of it was not tried.
pub(super) const SECONDS: u32 = 120;

/// A fault that tests plant, to see whether it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Plant {
    /// A panic.
    Panic,
    /// A reflectance that is no number.
    Nan,
    /// A group that is called recovered, with a large error.
    Error,
    /// The warning that a picture had values that are no numbers.
    Picture,
}

/// The runs of a worker.
#[derive(Clone, Debug)]
pub(crate) struct Runs {
    pub(crate) seed: u64,
    pub(crate) first: u64,
    /// How many at most.
    pub(crate) count: u64,
    /// For how long at most; one is run in any case.
    pub(crate) time: Duration,
    /// The folder for the folders of runs; those of findings stay there.
    pub(crate) keep: PathBuf,
    pub(crate) plant: Option<Plant>,
}

/// Runs cases until one is a finding.
///
/// # Errors
/// If its folder or its output cannot be written.
pub(crate) fn run(runs: &Runs) -> io::Result<()> {
    let keep = std::path::absolute(&runs.keep)?;
    let started = Instant::now();
    let mut stdout = io::stdout().lock();
    for index in (runs.first..).take(runs.count as usize) {
        writeln!(stdout, "{index}")?;
        stdout.flush()?;
        let folder = super::folder(&keep, runs.seed, index);
        // What an earlier search has left.
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder)?;
        limit_resources(SECONDS)?;
        let (end, findings) = match make(&folder, runs.seed, index)? {
            None => ("scene not written".to_owned(), Vec::new()),
            Some(case) => one(&case, &folder, runs.plant)?,
        };
        for finding in &findings {
            writeln!(stdout, "{} {finding}", super::FINDING)?;
        }
        writeln!(stdout, "{} {end}", super::END)?;
        stdout.flush()?;
        if !findings.is_empty() {
            break;
        }
        fs::remove_dir_all(&folder)?;
        if started.elapsed() > runs.time {
            break;
        }
    }
    Ok(())
}

/// Runs the commands of `case` in its folder until one is refused; returns how far it came, and what was wrong.
fn one(case: &Case, folder: &Path, plant: Option<Plant>) -> io::Result<(String, Vec<String>)> {
    std::env::set_current_dir(folder)?;
    let mut findings = Vec::new();
    let mut end = "restaged:".to_owned();
    for words in &case.commands {
        limit_resources(SECONDS)?;
        let heard = Arc::new(Heard::default());
        match plant {
            Some(Plant::Panic) => panic!("as planted"),
            Some(Plant::Picture) => {
                heard.warning("3 value(s) were not finite numbers and were written as zero")
            }
            _ => {}
        }
        let before = processor_seconds();
        let result = unrender::cli::call(words.iter().map(Into::into), None, heard.clone());
        let seconds = processor_seconds() - before;
        let name = words[0].as_str();
        end += &format!(" {name} {seconds:.2} s");
        findings.extend(heard.judged().into_iter().map(|wrong| format!("{name} {wrong}")));
        if let Err(error) = result {
            let reason = in_words(&error);
            findings.extend(judge::text(&reason).map(|wrong| format!("{name} {wrong}")));
            end = format!("refused by {name}: {}", reason.replace('\n', " "));
            break;
        }
        if name == "recover" {
            let recovered = folder.join("recovered");
            plant.map_or(Ok(()), |plant| spoil(&recovered.join("materials.json"), plant))?;
            findings.extend(judge::materials(&recovered));
        }
    }
    if !findings.is_empty() {
        findings.push(format!("mutations: {}", case.mutations.join(", ")));
    }
    Ok((end, findings))
}

/// The error with its causes.
fn in_words(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// Plants a fault into a `materials.json`.
fn spoil(path: &Path, plant: Plant) -> io::Result<()> {
    let mut file: serde_json::Value = serde_json::from_slice(&fs::read(path)?)?;
    let groups = file["groups"].as_object_mut().into_iter().flatten();
    for (_, group) in groups {
        match plant {
            Plant::Nan => group["rho_d"] = serde_json::Value::Null,
            Plant::Error => (group["status"], group["error"]) = ("recovered".into(), 0.5.into()),
            Plant::Panic | Plant::Picture => {}
        }
    }
    fs::write(path, serde_json::to_vec(&file)?)
}

/// The processor time that this process has taken.
#[cfg(unix)]
fn processor_seconds() -> f64 {
    use nix::sys::resource::{UsageWho, getrusage};
    let seconds =
        |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64;
    getrusage(UsageWho::RUSAGE_SELF)
        .map_or(0.0, |u| seconds(u.user_time()) + seconds(u.system_time()))
}

/// Not known here, so that no command takes too long.
#[cfg(not(unix))]
fn processor_seconds() -> f64 {
    0.0
}

/// What a command said.
#[derive(Debug, Default)]
struct Heard(Mutex<Vec<String>>);

impl Heard {
    fn keep(&self, text: &str) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
    }

    /// What is wrong with it.
    fn judged(&self) -> Vec<String> {
        let said = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        said.iter().filter_map(|text| judge::text(text)).collect()
    }
}

impl Listener for Heard {
    fn warning(&self, sentence: &str) {
        self.keep(sentence);
    }

    fn progress(&self, _: Option<&str>, _: f64) {}

    fn result(&self, text: &str) {
        self.keep(text);
    }

    fn iteration(&self, _: &IterationRecord) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
