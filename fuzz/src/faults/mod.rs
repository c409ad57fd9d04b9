//! Faults at random moments of the commands that write: a kill, a request to end, a full disk,
//! write-protected files, closed output, a second process, no terminal.
//!
//! After each fault, three things are checked. Are the inputs unchanged? Is there one complete result,
//! of this run or of the one before, or none, or one that the commands that read it refuse? And does the
//! same command, or `recover --resume`, then give the bits of a run without a fault?
//!
//! Write protection does not stop root, so root runs the commands as another user. A full disk is a file
//! system in memory, which only root may make; a limit on the size of files (`RLIMIT_FSIZE`) needs no
//! rights. Faults that a machine cannot have are left out, with a message.

mod fault;
mod rights;
pub(crate) mod state;
pub(crate) mod work;

use crate::random::Random;
use fault::Fault;
use rights::Disk;
use state::{State, files_of, is_hidden};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;
use work::{Bench, Work};

/// With this variable set, the fuzzer is the command `unrender`.
pub(crate) const AS_COMMAND: &str = "UNRENDER_FUZZ_IS_UNRENDER";

/// Interrupts commands at random moments and checks what remains.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The number of faults.
    #[arg(long, default_value_t = 200)]
    count: u64,
    /// The seed of commands, faults and moments.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Only this command: recover, restage, render, merge, export or export-folder.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

/// The room for a command after a disk was full, bytes: a hundred times what any writes here.
const ROOM: u64 = 64 << 20;

/// The state after a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Left {
    /// The complete result.
    New,
    /// The complete result of the run before.
    Old,
    /// The complete result of a recovery that was asked to end.
    Interrupted,
    /// Nothing.
    None,
    /// A result that the commands that read it refuse.
    Refused,
}

/// Runs the faults; the exit code is 1 if there were findings.
///
/// # Errors
/// If the commands cannot be run at all.
pub(crate) fn run(args: &Args) -> io::Result<ExitCode> {
    let folder = tempfile::tempdir()?;
    let bench = Bench::new(folder.path())?;
    let works: Vec<Work> = work::all()
        .into_iter()
        .filter(|work| args.only.as_ref().is_none_or(|only| only == work.name))
        .map(|work| bench.prepared(work))
        .collect::<io::Result<_>>()?;
    if works.is_empty() {
        return Err(io::Error::other("there is no such command"));
    }
    let faults: Vec<Fault> =
        Fault::ALL.into_iter().filter(|fault| fault.missing(&bench).is_none()).collect();
    for (fault, reason) in Fault::ALL.iter().filter_map(|f| f.missing(&bench).map(|r| (f, r))) {
        println!("left out: {fault:?}, as {reason}");
    }
    let inputs = files_of(&bench.inputs())?;
    let mut counts: BTreeMap<(&str, Fault, Left), u64> = BTreeMap::new();
    let mut findings = 0;
    for number in 0..args.count {
        let mut random = Random::new(args.seed, number);
        let work = &works[(number % works.len() as u64) as usize];
        let fault = *random.one(&faults);
        let (found, problems) = one(&bench, work, fault, &mut random)?;
        *counts.entry((work.name, fault, found)).or_default() += 1;
        let mut problems: Vec<String> = problems;
        if files_of(&bench.inputs())? != inputs {
            problems.push("inputs were changed".into());
        }
        for problem in &problems {
            println!("fault {number} of seed {}, {} {fault:?}: {problem}", args.seed, work.name);
        }
        findings += usize::from(!problems.is_empty());
    }
    println!("{:14} {:14} {:12} {:>6}", "command", "fault", "left", "faults");
    for ((name, fault, left), count) in &counts {
        println!("{name:14} {:14} {:12} {count:>6}", format!("{fault:?}"), format!("{left:?}"));
    }
    println!("{} faults   {findings} finding(s)", args.count);
    Ok(if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs one fault; returns the state after it, and the problems.
fn one(
    bench: &Bench,
    work: &Work,
    fault: Fault,
    random: &mut Random,
) -> io::Result<(Left, Vec<String>)> {
    let had_old = work.old.is_some() && random.below(2) == 0;
    let folder = bench.case()?;
    let disk = (fault == Fault::Full).then(|| Disk::at(&folder)).transpose()?;
    bench.fill(&folder, work, had_old)?;
    // Half of them are at the end, where results are written.
    let share = random.below(1000) as f64 / 1000.0;
    let share = if random.below(2) == 0 { 1.1 * share } else { 0.8 + 0.3 * share };
    let moment = Duration::from_secs_f64(share * work.seconds);
    if let Some(disk) = &disk {
        disk.leave(random.below(2 * work.bytes as usize) as u64)?;
    }
    let told = fault.strike(bench, work, &folder, moment, random)?;
    if let Some(disk) = &disk {
        disk.leave(ROOM)?;
    }
    let mut problems = told.problems;
    let state = State::of(&folder, work.out)?;
    let left = left_by(work, fault, had_old, &folder.join(work.out), &state);
    let left = left.unwrap_or_else(|| {
        problems
            .push(format!("what remains is not a complete result: {}", work.difference(&state)));
        Left::Refused
    });
    if told.succeeded && left != Left::New {
        problems.push(format!("the command succeeded and left {left:?}"));
    }
    // Folders of exports are never replaced.
    if !(work.name == "export-folder" && left == Left::New) {
        let again = bench.command(&folder, &work.again).output()?;
        let said = String::from_utf8_lossy(&again.stderr).into_owned();
        if !again.status.success() {
            problems.push(format!("the command does not continue: {}", said.trim()));
        }
        let after = State::of(&folder, work.out)?;
        if after != work.new {
            let what = work.difference(&after);
            problems.push(format!("continuing gives other bits: {what}; {}", said.trim()));
        }
    }
    // A killed process may leave its temporary file beside a file or an export; in a folder of
    // results, the next process removes it.
    if matches!(work.name, "recover" | "restage") {
        let left_over = hidden(&folder.join(work.out))?;
        if !left_over.is_empty() {
            problems.push(format!("left over: {left_over:?}"));
        }
    }
    drop(disk);
    fs::remove_dir_all(folder)?;
    Ok((left, problems))
}

/// The meaning of `state`; none if it is a mixture.
fn left_by(work: &Work, fault: Fault, had_old: bool, out: &Path, state: &State) -> Option<Left> {
    if *state == work.new {
        return Some(Left::New);
    }
    if work.old.as_ref().is_some_and(|old| had_old && state == old) {
        return Some(Left::Old);
    }
    if state.is_empty() && !had_old {
        return Some(Left::None);
    }
    if !out.join("manifest.json").exists() {
        return None;
    }
    if unrender::result_folder::check(out).is_err() {
        return Some(Left::Refused);
    }
    let was_asked = matches!(fault, Fault::Terminate | Fault::Interrupt) && work.name == "recover";
    let run = unrender::run::Run::read(out).ok()?;
    (was_asked && run.termination.starts_with("interrupted")).then_some(Left::Interrupted)
}

/// Our temporary files in `folder`.
fn hidden(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    if folder.is_dir() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if is_hidden(&path) {
                found.push(path);
            }
        }
    }
    Ok(found)
}
