//! Checks for equal bits in every mode: each command that writes, on 1, 2 and 7 threads, with AVX2 and
//! without. The digests are written to a file, with which another build (release, or for another
//! system) is compared.
//!
//! The mathematical functions of the C library choose instructions by the processor, too. With glibc,
//! AVX2 and FMA are switched off for them; whether that changes bits is reported, and is not an error of
//! ours: see `docs/validation/same-bits.md`.

use crate::faults::state::State;
use crate::faults::work::{self, Bench, Work};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Compares the results of all commands by every code path.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Write the digests to this file.
    #[arg(long, value_name = "FILE.json")]
    write: Option<PathBuf>,
    /// Compare the digests with those in this file, which another build wrote.
    #[arg(long, value_name = "FILE.json")]
    against: Option<PathBuf>,
}

/// The modes of a command: its threads, and a variable in its environment.
const WAYS: [(&str, Option<(&str, &str)>); 4] =
    [("1", None), ("7", None), ("2", NO_AVX2), ("2", NO_FMA)];
const NO_AVX2: Option<(&str, &str)> = Some(("UNRENDER_AVX2", "0"));
const NO_FMA: Option<(&str, &str)> =
    Some(("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"));

/// Runs all; the exit code is 1 if bits differ that may not.
///
/// # Errors
/// If a command fails, or files cannot be read or written.
pub(crate) fn run(args: &Args) -> io::Result<ExitCode> {
    let folder = tempfile::tempdir()?;
    let bench = Bench::new(folder.path())?;
    let mut digests = BTreeMap::new();
    let mut equal = true;
    for work in work::all() {
        let mut first: Option<State> = None;
        for (threads, variable) in WAYS {
            let state = state(&bench, &work, folder.path(), threads, variable)?;
            let is_first = first.get_or_insert_with(|| state.clone());
            let (is_same, promised) = (*is_first == state, variable != NO_FMA);
            equal &= is_same || !promised;
            let way = variable.map_or(String::new(), |(name, value)| format!("{name}={value}"));
            let says = match (is_same, promised) {
                (true, _) => "same bits",
                (false, true) => "OTHER BITS",
                (false, false) => "other bits (not promised)",
            };
            println!("{:14} {threads} thread(s) {way:60} {says}", work.name);
        }
        digests.insert(work.name, first.unwrap_or_default().digest());
    }
    if let Some(path) = &args.write {
        fs::write(path, serde_json::to_string_pretty(&digests)?)?;
    }
    if let Some(path) = &args.against {
        let theirs: BTreeMap<String, String> = serde_json::from_slice(&fs::read(path)?)?;
        for (name, digest) in &digests {
            let is_same = theirs.get(*name) == Some(digest);
            equal &= is_same;
            println!("{name:14} {}", if is_same { "as the other build" } else { "OTHER BITS" });
        }
    }
    Ok(if equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The files that `work` writes on `threads` threads with `variable` set.
fn state(
    bench: &Bench,
    work: &Work,
    root: &Path,
    threads: &str,
    variable: Option<(&str, &str)>,
) -> io::Result<State> {
    let folder = root.join("way");
    fs::create_dir_all(&folder)?;
    bench.user.owns(&folder)?;
    let words = [&work.words[..], &["--threads".to_owned(), threads.to_owned()]].concat();
    let output = bench.command(&folder, &words).envs(variable).output()?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(io::Error::other(format!("{}: {said}", work.name)));
    }
    let state = State::of(&folder, work.out)?;
    fs::remove_dir_all(folder)?;
    Ok(state)
}
