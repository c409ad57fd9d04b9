//! The most memory that this process held.

/// The largest memory that the process held at a time, bytes; none where the system does not tell.
///
/// Linux counts into a process's resource usage what whoever started it held, as the new process shares that
/// memory until it begins: a recovery that a large program starts would seem to be as large. Its status tells apart.
#[cfg(target_os = "linux")]
pub(super) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// The same of other systems of its family.
#[cfg(all(unix, not(target_os = "linux")))]
pub(super) fn peak_bytes() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
    let usage = getrusage(UsageWho::RUSAGE_SELF).ok()?;
    u64::try_from(usage.max_rss()).ok().map(|rss| unit * rss)
}

/// Other systems tell nothing of this kind.
#[cfg(not(unix))]
pub(super) fn peak_bytes() -> Option<u64> {
    None
}
