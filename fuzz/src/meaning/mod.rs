//! Fuzzing by meaning: small scenes and projects whose files are well-formed, while what they mean is changed at random.
//! Cameras and lamps stand anywhere, groups are ignored or known, exposures, masks, units and axes are other ones.
//!
//! A run makes a photograph, in half of the runs of the scene that it gives to the commands, in the others of that scene
//! before its mutations; then it runs `check`, a draft of `recover`, and `restage`. A refusal ends a run. Findings are a
//! panic, a command that takes too long, a number that is not finite, and a group that is called recovered with an error
//! that is large.

mod case;
mod judge;
mod photographs;
mod projects;
mod rooms;
mod scenes;
pub(crate) mod worker;

use crate::watch::watch;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use worker::Runs;

/// The name of the worker.
pub(crate) const NAME: &str = "meaning";
/// How the lines of a worker begin that name a finding of the last run, and the end of it.
const FINDING: &str = "finding";
const END: &str = "end";

/// What has been run so far.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) runs: u64,
    pub(crate) findings: usize,
    /// How many runs ended where.
    ends: BTreeMap<String, u64>,
    /// Whether the end of each is told.
    is_told: bool,
}

/// The folder of run `index`.
fn folder(keep: &Path, seed: u64, index: u64) -> PathBuf {
    keep.join(format!("{NAME}-{seed}-{index}"))
}

impl Tally {
    /// Nothing has been run; the end of each run `is_told`.
    pub(crate) fn telling(is_told: bool) -> Self {
        Self { is_told, ..Self::default() }
    }

    /// Lets a worker make `runs`, and counts them; prints its findings, each with the command that runs it again.
    ///
    /// # Errors
    /// If the worker cannot be run.
    pub(crate) fn turn(&mut self, runs: &Runs) -> io::Result<()> {
        let mut last = None;
        let mut findings = Vec::new();
        let problem = watch(&words(runs), worker::SECONDS, |line| match line.split_once(' ') {
            Some((FINDING, text)) => findings.push(text.to_owned()),
            Some((END, text)) => self.ended(text, last),
            _ => last = line.parse::<u64>().ok().or(last),
        })?;
        if problem.is_some() {
            *self.ends.entry("killed".to_owned()).or_default() += 1;
        }
        findings.extend(problem.clone());
        let Some(index) = last else {
            return problem.map_or(Ok(()), |problem| Err(io::Error::other(problem)));
        };
        self.runs += index + 1 - runs.first;
        if !findings.is_empty() {
            self.findings += 1;
            println!("{}:", folder(&runs.keep, runs.seed, index).display());
            findings.iter().for_each(|finding| println!("  {finding}"));
            println!(
                "  again: cargo run --release --bin unrender-fuzz -- --family {NAME} --seed {} --first {index} --runs 1",
                runs.seed
            );
        }
        Ok(())
    }

    /// Counts the end of run `index`: where it was, and after a colon why.
    fn ended(&mut self, text: &str, index: Option<u64>) {
        let place = text.split(':').next().unwrap_or(text);
        *self.ends.entry(place.to_owned()).or_default() += 1;
        if self.is_told {
            println!("{}: {text}", index.unwrap_or_default());
        }
    }

    /// Prints how many runs ended where.
    pub(crate) fn print(&self) {
        println!("{:20} {:>9}", "end of a run", "runs");
        self.ends.iter().for_each(|(end, count)| println!("{end:20} {count:>9}"));
        println!("{:20} {:>9}   {} finding(s)", "all", self.runs, self.findings);
    }
}

/// The arguments of the worker for `runs`.
fn words(runs: &Runs) -> Vec<String> {
    let mut words: Vec<String> = ["--worker", NAME].map(str::to_owned).to_vec();
    let mut add = |key: &str, value: String| words.extend([key.to_owned(), value]);
    add("--seed", runs.seed.to_string());
    add("--first", runs.first.to_string());
    add("--runs", runs.count.to_string());
    add("--minutes", (runs.time.as_secs_f64() / 60.0).to_string());
    add("--keep", runs.keep.display().to_string());
    if let Some(plant) = runs.plant {
        add("--plant", format!("{plant:?}").to_lowercase());
    }
    words
}
