//! Measures the peak memory of this process.

/// The peak memory of the process, bytes; none if the system does not report it.
///
/// On Linux, a process's resource usage includes the memory of the process that started it, which it shares until it
/// begins: a recovery that a large program starts would seem as large. Its status has its own.
#[cfg(target_os = "linux")]
pub(super) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// The same on other Unix systems.
#[cfg(all(unix, not(target_os = "linux")))]
pub(super) fn peak_bytes() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
    let usage = getrusage(UsageWho::RUSAGE_SELF).ok()?;
    u64::try_from(usage.max_rss()).ok().map(|rss| unit * rss)
}

/// Other systems do not report it.
#[cfg(not(unix))]
pub(super) fn peak_bytes() -> Option<u64> {
    None
}
