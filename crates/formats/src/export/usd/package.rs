//! USD as one file (`.usdz`): a ZIP archive whose files are stored as they are, the stage first, and start at multiples
//! of 64 bytes, so that readers can map them into memory. [OpenUSD, Usdz file format]

use crate::export::Files;
use flate2::Crc;

/// The contents of files start at multiples of so many bytes, as the format demands.
const ALIGNED: usize = 64;
/// Bytes of an archive's head before a file, without its name and padding.
const HEAD: usize = 30;
/// The kind of the padding; readers skip kinds that they do not know.
const PADDING: u16 = 0x1986;
/// 1980-01-01, the day before which archives have no dates: an export holds no time, so that the same scene gives the
/// same bytes.
const DATE: u16 = 1 << 5 | 1;
/// The version of ZIP that is needed to read it, 1.0: without compression.
const VERSION: u16 = 10;

/// The archive of `files`.
///
/// # Errors
/// If it is too large for ZIP.
pub(super) fn bytes(files: &Files) -> Result<Vec<u8>, String> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let place = number(archive.len())?;
        let about = about(name, bytes)?;
        let padding = padding(archive.len() + HEAD + name.len());
        archive.extend(b"PK\x03\x04");
        archive.extend(VERSION.to_le_bytes());
        archive.extend(&about);
        archive.extend((padding.len() as u16).to_le_bytes());
        archive.extend(name.as_bytes());
        archive.extend(padding);
        archive.extend(bytes);
        directory.extend(b"PK\x01\x02");
        directory.extend([VERSION, VERSION].into_iter().flat_map(u16::to_le_bytes));
        directory.extend(&about);
        // No padding, comment, disk or attributes.
        directory.extend([0; 12]);
        directory.extend(place.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let count = u16::try_from(files.len()).map_err(|_| TOO_LARGE)?;
    let sizes = [number(directory.len())?, number(archive.len())?];
    archive.extend(directory);
    archive.extend(b"PK\x05\x06\0\0\0\0");
    archive.extend([count, count].into_iter().flat_map(u16::to_le_bytes));
    archive.extend(sizes.into_iter().flat_map(u32::to_le_bytes));
    archive.extend([0; 2]);
    Ok(archive)
}

/// What to do about a scene that is beyond the format.
const TOO_LARGE: &str = "is too large for usdz, which holds 4 GiB and 65535 files; write usdc";

fn number(size: usize) -> Result<u32, String> {
    u32::try_from(size).map_err(|_| TOO_LARGE.into())
}

/// What both heads of a file say alike: no flags, stored, the date, the checksum, both sizes, the length of its name.
fn about(name: &str, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut sum = Crc::new();
    sum.update(bytes);
    let size = number(bytes.len())?;
    let mut about: Vec<u8> = [0, 0, 0, DATE].into_iter().flat_map(u16::to_le_bytes).collect();
    about.extend([sum.sum(), size, size].into_iter().flat_map(u32::to_le_bytes));
    about.extend(u16::try_from(name.len()).map_err(|_| TOO_LARGE)?.to_le_bytes());
    Ok(about)
}

/// Bytes with a head of their own of four bytes, after which what would start at `place` starts aligned.
fn padding(place: usize) -> Vec<u8> {
    let needed = place.next_multiple_of(ALIGNED) - place;
    let length = match needed {
        0 => return Vec::new(),
        1..4 => needed + ALIGNED,
        _ => needed,
    };
    let mut padding: Vec<u8> =
        [PADDING, (length - 4) as u16].into_iter().flat_map(u16::to_le_bytes).collect();
    padding.resize(length, 0);
    padding
}
