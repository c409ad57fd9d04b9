//! The process that reads mutated files, one after the other. It prints the number of each before
//! it reads it, so that the watching process knows which one killed it.

use crate::mutate::mutated;
use crate::random::Random;
use crate::seeds;
use crate::targets::Target;
use std::fs;
use std::io::Write;
use std::time::{Duration, Instant};

/// The memory limit of the process, bytes: that of inputs twice, the second time for the data made from
/// them, and the address space of the program and its threads. With half of it, valid files fail; with
/// double, a reader that allocates four times the limit of inputs is not found.
#[cfg(unix)]
const MEMORY: u64 = 2 * crate::targets::MEMORY + (512 << 20);

/// The limit of processor time for a file, seconds. The slowest valid one of 64 KiB takes one; with half of
/// it nothing changes, with double, a reader that is twice as slow is not found.
pub(crate) const SECONDS: u32 = 10;

/// Limits the memory of this process, and ends it, by SIGXCPU, if what comes next takes more `seconds` of a
/// processor.
///
/// # Errors
/// If there are no limits here.
#[cfg(unix)]
pub(crate) fn limit_resources(seconds: u32) -> std::io::Result<()> {
    use nix::sys::resource::{Resource, UsageWho, getrlimit, getrusage, setrlimit};
    setrlimit(Resource::RLIMIT_AS, MEMORY, MEMORY)?;
    let used = getrusage(UsageWho::RUSAGE_SELF)?;
    let used = used.user_time().tv_sec() + used.system_time().tv_sec();
    let (_, hard) = getrlimit(Resource::RLIMIT_CPU)?;
    // The two were rounded down.
    setrlimit(Resource::RLIMIT_CPU, (used as u64 + 2 + u64::from(seconds)).min(hard), hard)?;
    Ok(())
}

/// Nothing is limited here.
///
/// # Errors
/// Never.
#[cfg(not(unix))]
pub(crate) fn limit_resources(_: u32) -> std::io::Result<()> {
    Ok(())
}

/// The file of case `index`; the first ones are the seeds themselves.
pub(crate) fn case(target: &Target, seeds: &[Vec<u8>], seed: u64, index: u64) -> Vec<u8> {
    if let Some(file) = seeds.get(index as usize).filter(|_| seed == 0) {
        return file.clone();
    }
    let mut random = Random::new(seed, index);
    let one = random.one(seeds).clone();
    let other = random.one(seeds).clone();
    mutated(&one, &other, target.kind, &mut random)
}

/// A folder for the files, in memory if the system has such a place: a disk is ten times slower.
fn folder() -> std::io::Result<tempfile::TempDir> {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir())
}

/// Reads cases from `first` on for `time`.
///
/// # Errors
/// If its folder or its output cannot be written.
pub(crate) fn run(target: &Target, seed: u64, first: u64, time: Duration) -> std::io::Result<()> {
    limit_resources(SECONDS)?;
    let seeds = seeds::of(target.name);
    let folder = folder()?;
    // Files to which some seeds refer.
    for (name, of) in [("seed.png", "png"), ("seed.glb", "glb")] {
        fs::write(folder.path().join(name), &seeds::of(of)[0])?;
    }
    let extension = if target.name == "part" { "exr" } else { target.name };
    let path = folder.path().join(format!("case.{extension}"));
    let started = Instant::now();
    let mut stdout = std::io::stdout().lock();
    let mut index = first;
    while started.elapsed() < time {
        fs::write(&path, case(target, &seeds, seed, index))?;
        writeln!(stdout, "{index}")?;
        stdout.flush()?;
        limit_resources(SECONDS)?;
        (target.read)(&path);
        index += 1;
    }
    Ok(())
}
