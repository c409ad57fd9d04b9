//! How much a picture file may claim to hold: pixels in all, and bytes for its own size.

/// More pixels than any camera has today; beyond it a header is taken to be corrupt.
pub(super) const MAX_PIXELS: u64 = 1 << 28;

/// No decoder here unpacks a byte of a file to more bytes than this.
const MAX_UNPACKING: u64 = 4096;

/// Files that claim less than this are plausible whatever their size.
const ALWAYS_BELIEVED_BYTES: u64 = 64 << 20;

/// How many unpacked bytes a file of `file_bytes` may claim.
pub(super) fn plausible(file_bytes: u64) -> u64 {
    ALWAYS_BELIEVED_BYTES.max(file_bytes.saturating_mul(MAX_UNPACKING))
}

/// The error that a file of `file_bytes` cannot hold these pixels, as the end of a sentence about
/// it.
pub(super) fn unbelievable(width: u64, height: u64, file_bytes: u64) -> String {
    format!("claims {width} x {height} pixels, which its {file_bytes} bytes cannot hold")
}
