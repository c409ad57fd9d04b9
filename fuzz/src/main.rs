//! Mutated files for every reader, in watched processes: a panic, an abort, and a file that takes more
//! than ten seconds of processor time, two minutes of clock time, or too much memory are findings. The
//! file is kept, and the exit code is 1.
//!
//! A second family, `meaning`, mutates what scenes and projects mean and runs whole commands on them; `--family`
//! chooses one of the two. `faults` interrupts commands instead of mutating files; `bits` compares their results by all
//! code paths.
//!
//! To add a reader: write a function from a path in `targets.rs`, and seeds in `seeds.rs`. To keep a
//! finding: put its file into `crates/formats/tests/data/hostile`, where the tests always read it.

#[cfg(unix)]
mod bits;
#[cfg(unix)]
mod faults;
mod meaning;
mod mutate;
mod random;
mod seeds;
mod targets;
mod watch;
mod worker;

use clap::Parser;
use meaning::worker::{Plant, Runs};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use targets::{ALL, Target};

/// The longest lifetime of a worker that reads files, so that all targets get their turn. Half and double of it were not
/// tried.
const TURN: Duration = Duration::from_secs(3);
/// The share of the time in which scenes and projects are mutated by meaning, where files are mutated as well. Half and
/// double of it were not tried.
const MEANING: f64 = 1.0 / 3.0;

/// Reads mutated files of every kind, and runs commands on scenes and projects that are mutated by meaning.
#[derive(Debug, Parser)]
struct Args {
    /// The other commands.
    #[command(subcommand)]
    other: Option<Other>,
    /// The duration, minutes [default: 1; with --runs as long as these take].
    #[arg(long)]
    minutes: Option<f64>,
    /// The seed of the mutations; with 0 the seed files themselves come first.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Only this family [default: both, or the files if readers are named].
    #[arg(long, value_enum)]
    family: Option<Family>,
    /// Only these readers.
    #[arg(long, value_name = "NAME")]
    target: Vec<String>,
    /// The number of the first case.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// End after so many runs of the family meaning.
    #[arg(long, value_name = "N")]
    runs: Option<u64>,
    /// Tell how each run of the family meaning ended.
    #[arg(long)]
    tell: bool,
    /// The folder for the files of findings.
    #[arg(long, value_name = "DIR", default_value = "target/fuzz-findings")]
    keep: PathBuf,
    /// Run as the worker for this reader, or for the family meaning.
    #[arg(long, hide = true)]
    worker: Option<String>,
    /// Plant a fault into each run of the family meaning.
    #[arg(long, hide = true)]
    plant: Option<Plant>,
}

/// What is mutated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Family {
    /// Files, for their readers.
    Files,
    /// Scenes and projects, for whole commands.
    Meaning,
}

#[derive(Debug, clap::Subcommand)]
enum Other {
    /// Interrupts commands at random moments.
    #[cfg(unix)]
    Faults(faults::Args),
    /// Compares the results of all commands by every code path.
    #[cfg(unix)]
    Bits(bits::Args),
}

fn main() -> io::Result<ExitCode> {
    #[cfg(unix)]
    if std::env::var_os(faults::AS_COMMAND).is_some() {
        return Ok(unrender::cli::run());
    }
    let args = Args::parse();
    #[cfg(unix)]
    match &args.other {
        Some(Other::Faults(faults)) => return faults::run(faults),
        Some(Other::Bits(bits)) => return bits::run(bits),
        None => {}
    }
    if let Some(name) = &args.worker {
        args.work(name)?;
        return Ok(ExitCode::SUCCESS);
    }
    let findings = args.search()?;
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Args {
    /// Works as the worker called `name`.
    fn work(&self, name: &str) -> io::Result<()> {
        let time = Duration::from_secs_f64(60.0 * self.minutes.unwrap_or(1.0));
        if name == meaning::NAME {
            return meaning::worker::run(&self.runs_of_meaning(self.first, time));
        }
        let target = ALL.iter().find(|target| target.name == name);
        let target = target.ok_or_else(|| io::Error::other("there is no such reader"))?;
        worker::run(target, self.seed, self.first, time)
    }

    /// Whether this family is searched.
    fn has(&self, family: Family) -> bool {
        match self.family {
            Some(chosen) => chosen == family,
            None => family == Family::Files || self.target.is_empty(),
        }
    }

    /// The readers that are searched.
    fn readers(&self) -> io::Result<Vec<&'static Target>> {
        let is_named = |target: &&Target| self.target.iter().any(|name| name == target.name);
        let is_chosen = |target: &&Target| {
            self.has(Family::Files) && (self.target.is_empty() || is_named(target))
        };
        let chosen: Vec<&Target> = ALL.iter().filter(is_chosen).collect();
        if chosen.is_empty() && !self.has(Family::Meaning) {
            return Err(io::Error::other("there is no such reader"));
        }
        Ok(chosen)
    }

    /// How long is searched.
    fn duration(&self) -> io::Result<Duration> {
        if self.runs.is_some() && !self.has(Family::Meaning) {
            return Err(io::Error::other("--runs counts those of --family meaning"));
        }
        Ok(match (self.minutes, self.runs) {
            // A century, which can be added to any other time.
            (None, Some(_)) => Duration::from_secs(u64::from(u32::MAX)),
            (minutes, _) => Duration::from_secs_f64(60.0 * minutes.unwrap_or(1.0)),
        })
    }

    /// Lets all workers take turns until the time is over; returns the number of findings.
    fn search(&self) -> io::Result<usize> {
        let (readers, whole) = (self.readers()?, self.duration()?);
        let [turn, turn_of_meaning] = turns(whole, readers.len(), self.has(Family::Meaning));
        let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
        let mut findings = 0;
        let mut tally = meaning::Tally::telling(self.tell);
        let started = Instant::now();
        while started.elapsed() < whole && tally.runs < self.runs.unwrap_or(u64::MAX) {
            for target in &readers {
                let next = counts.entry(target.name).or_insert(self.first);
                findings += usize::from(self.read(target, next, turn)?);
            }
            if self.has(Family::Meaning) {
                let end = whole.min(started.elapsed() + turn_of_meaning);
                self.run_commands(&mut tally, &|| end.saturating_sub(started.elapsed()))?;
            }
        }
        if !counts.is_empty() {
            println!("{:10} {:>9}", "reader", "cases");
            counts.iter().for_each(|(name, count)| println!("{name:10} {count:>9}"));
            println!("{:10} {:>9}   {findings} finding(s)", "all", counts.values().sum::<u64>());
        }
        if self.has(Family::Meaning) {
            tally.print();
        }
        Ok(findings + tally.findings)
    }

    /// Runs commands on scenes and projects as long as there is `time_left`.
    fn run_commands(
        &self,
        tally: &mut meaning::Tally,
        time_left: &dyn Fn() -> Duration,
    ) -> io::Result<()> {
        loop {
            let (time, count) = (time_left(), self.runs.map_or(u64::MAX, |n| n - tally.runs));
            if time.is_zero() || count == 0 {
                return Ok(());
            }
            let runs = self.runs_of_meaning(self.first + tally.runs, time);
            tally.turn(&Runs { count, ..runs })?;
        }
    }

    /// The runs of a worker of the family meaning.
    fn runs_of_meaning(&self, first: u64, time: Duration) -> Runs {
        let (seed, keep, plant) = (self.seed, self.keep.clone(), self.plant);
        Runs { seed, first, count: self.runs.unwrap_or(u64::MAX), time, keep, plant }
    }

    /// Lets a worker read from case `next` on for the time `turn`, and moves `next` behind its last case; returns
    /// whether there was a finding.
    fn read(&self, target: &Target, next: &mut u64, turn: Duration) -> io::Result<bool> {
        let words = [
            ["--worker", target.name].map(str::to_owned),
            ["--seed".into(), self.seed.to_string()],
            ["--first".into(), next.to_string()],
            ["--minutes".into(), (turn.as_secs_f64() / 60.0).to_string()],
        ];
        let mut last = None;
        let problem = watch::watch(words.as_flattened(), worker::SECONDS, |line| {
            last = line.parse::<u64>().ok().or(last)
        })?;
        *next = last.map_or(*next, |last| last + 1);
        let (Some(problem), Some(index)) = (problem.clone(), last) else {
            return problem.map_or(Ok(false), |problem| Err(io::Error::other(problem)));
        };
        let file = worker::case(target, &seeds::of(target.name), self.seed, index);
        fs::create_dir_all(&self.keep)?;
        let path = self.keep.join(format!("{}-{}-{index}.{0}", target.name, self.seed));
        fs::write(&path, file)?;
        println!("{}: {problem}", path.display());
        Ok(true)
    }
}

/// The time of a turn of each of so many readers, and of the family meaning, if it is searched: all of them get one in
/// the `whole` time.
fn turns(whole: Duration, readers: usize, has_meaning: bool) -> [Duration; 2] {
    if readers == 0 {
        return [TURN, whole];
    }
    let share = if has_meaning { MEANING } else { 0.0 };
    let turn = TURN.min(whole.mul_f64((1.0 - share) / readers as f64));
    [turn, turn.mul_f64(readers as f64 * share / (1.0 - share))]
}

#[cfg(test)]
mod tests {
    use super::{TURN, turns};
    use std::time::Duration;

    #[test]
    fn a_round_of_turns_fits_into_the_time() {
        for (seconds, has_meaning) in [(30, true), (30, false), (600, true)] {
            let whole = Duration::from_secs(seconds);
            let [turn, of_meaning] = turns(whole, 24, has_meaning);
            assert!(24 * turn + of_meaning <= whole + Duration::from_millis(1));
            assert!(turn <= TURN && of_meaning.is_zero() != has_meaning);
        }
        assert_eq!(turns(Duration::from_secs(9), 0, true)[1], Duration::from_secs(9));
    }
}
