//! Mutated files for every reader, in watched processes: a panic, an abort, and a file that takes more
//! than ten seconds of processor time, two minutes of clock time, or too much memory are findings. The
//! file is kept, and the exit code is 1.
//!
//! `faults` interrupts commands instead of mutating files; `bits` compares their results by all code
//! paths.
//!
//! To add a reader: write a function from a path in `targets.rs`, and seeds in `seeds.rs`. To keep a
//! finding: put its file into `crates/formats/tests/data/hostile`, where the tests always read it.

#[cfg(unix)]
mod bits;
#[cfg(unix)]
mod faults;
mod mutate;
mod random;
mod seeds;
mod targets;
mod worker;

use clap::Parser;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};
use targets::{ALL, Target};

/// The most clock time of a file: ten seconds of processor time on a machine with ten times the load.
/// With half of it, such machines report false findings; with double, a reader that waits without end
/// costs four minutes.
const PATIENCE: Duration = Duration::from_secs(120);
/// The lifetime of a worker, so that all targets get their turn.
const TURN: Duration = Duration::from_secs(3);

/// Reads mutated files of every kind.
#[derive(Debug, Parser)]
struct Args {
    /// The other commands.
    #[command(subcommand)]
    other: Option<Other>,
    /// The duration, minutes.
    #[arg(long, default_value_t = 1.0)]
    minutes: f64,
    /// The seed of the mutations; with 0 the seed files themselves come first.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Only these readers.
    #[arg(long, value_name = "NAME")]
    target: Vec<String>,
    /// The folder for the files of findings.
    #[arg(long, value_name = "DIR", default_value = "target/fuzz-findings")]
    keep: PathBuf,
    /// Run as the worker for this reader.
    #[arg(long, hide = true)]
    worker: Option<String>,
    /// The first case of the worker.
    #[arg(long, hide = true, default_value_t = 0)]
    first: u64,
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
        let target = ALL.iter().find(|target| target.name == name);
        let target = target.ok_or_else(|| io::Error::other("there is no such reader"))?;
        worker::run(target, args.seed, args.first, TURN)?;
        return Ok(ExitCode::SUCCESS);
    }
    let chosen = |target: &&Target| {
        args.target.is_empty() || args.target.iter().any(|name| name == target.name)
    };
    let targets: Vec<&Target> = ALL.iter().filter(chosen).collect();
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    let mut findings = 0;
    let end = Instant::now() + Duration::from_secs_f64(60.0 * args.minutes);
    while Instant::now() < end {
        for target in &targets {
            let next = counts.entry(target.name).or_default();
            findings += usize::from(turn(&args, target, next)?);
        }
    }
    println!("{:10} {:>9}", "reader", "cases");
    counts.iter().for_each(|(name, count)| println!("{name:10} {count:>9}"));
    println!("{:10} {:>9}   {findings} finding(s)", "all", counts.values().sum::<u64>());
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Lets a worker read from case `next` on, and moves `next` behind its last case; returns whether
/// there was a finding.
fn turn(args: &Args, target: &Target, next: &mut u64) -> io::Result<bool> {
    let mut running = Command::new(std::env::current_exe()?)
        .args(["--worker", target.name, "--seed", &args.seed.to_string()])
        .args(["--first", &next.to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (sender, receiver) = mpsc::channel();
    let lines = running.stdout.take().map(BufReader::new);
    let reader = std::thread::spawn(move || {
        for line in lines.into_iter().flat_map(BufRead::lines).map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let said = running.stderr.take().map(|stderr| std::thread::spawn(|| told(stderr)));
    let mut last = None;
    let mut problem = None;
    loop {
        match receiver.recv_timeout(PATIENCE) {
            Ok(line) => last = line.parse::<u64>().ok().or(last),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                running.kill()?;
                problem = Some(format!("took more than {} s", PATIENCE.as_secs()));
                break;
            }
        }
    }
    let status = running.wait()?;
    // It ends with the pipe.
    let _ = reader.join();
    let said = said.and_then(|said| said.join().ok()).unwrap_or_default();
    if problem.is_none() && !status.success() {
        let line = said.lines().find(|line| line.contains("panicked") || line.contains("memory"));
        let ended = status.to_string();
        problem = Some(if ended.contains("SIGXCPU") {
            format!("took more than {} s of a processor", worker::SECONDS)
        } else {
            format!("{ended}: {}", line.unwrap_or(said.trim()))
        });
    }
    *next = last.map_or(*next, |last| last + 1);
    let (Some(problem), Some(index)) = (problem.clone(), last) else {
        return problem.map_or(Ok(false), |problem| Err(io::Error::other(problem)));
    };
    let file = worker::case(target, &seeds::of(target.name), args.seed, index);
    fs::create_dir_all(&args.keep)?;
    let path = args.keep.join(format!("{}-{}-{index}.{0}", target.name, args.seed));
    fs::write(&path, file)?;
    println!("{}: {problem}", path.display());
    Ok(true)
}

/// The output on `stderr` without warnings, of which there may be many. It need not be text.
fn told(stderr: impl Read) -> String {
    let lines = BufReader::new(stderr).split(b'\n').map_while(Result::ok);
    let lines = lines.map(|line| String::from_utf8_lossy(&line).into_owned());
    lines.filter(|line| !line.starts_with("warning:")).collect::<Vec<_>>().join("\n")
}
