//! The machine of a measurement, in words.

use std::fs;
use std::process::Command;

/// A sentence: the day, the processor, its cores, memory, the system, and the programs of `versions`.
pub(crate) fn sentence(versions: &[String]) -> String {
    let mut programs = vec![format!("unrender {}{}", env!("CARGO_PKG_VERSION"), revision())];
    programs.extend(versions.iter().cloned());
    format!(
        "Measured on {}: {}, {} cores, {} of memory, {}; {}.",
        time::OffsetDateTime::now_utc().date(),
        field("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown processor".to_owned()),
        cores(),
        memory(),
        std::env::consts::OS,
        programs.join(", "),
    )
}

/// A short sentence: the day, this program's commit, and the cores.
pub(crate) fn origin() -> String {
    let (day, version) = (time::OffsetDateTime::now_utc().date(), env!("CARGO_PKG_VERSION"));
    format!("Measured on {day}: unrender {version}{}, {} cores.", revision(), cores())
}

/// The number of threads.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The commit from which the program was built, if git knows it.
fn revision() -> String {
    let mut git = Command::new("git");
    git.args(["rev-parse", "--short", "HEAD"]).current_dir(crate::root());
    match git.output() {
        Ok(output) if output.status.success() => {
            format!(" ({})", String::from_utf8_lossy(&output.stdout).trim())
        }
        _ => String::new(),
    }
}

fn memory() -> String {
    let kibibytes = field("/proc/meminfo", "MemTotal")
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    kibibytes
        .map_or_else(|| "unknown amount".to_owned(), |kib| format!("{:.0} GiB", kib / 1048576.0))
}

/// The value after the first `name` in one of Linux's files about itself.
fn field(path: &str, name: &str) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
