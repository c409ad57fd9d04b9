//! The most memory that this process held.

/// The largest memory that the process held at a time, bytes; none where the system does not tell.
#[cfg(unix)]
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
