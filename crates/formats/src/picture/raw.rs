//! Raw files and other files of cameras that are not read, recognised by their content.
//!
//! A raw file holds what the sensor counted, under a filter of one colour per pixel, and previews that the camera
//! developed with a tone curve. Neither is the photograph.

use crate::entry::{Entry, refused};

/// The signatures of raw files that are not ordinary TIFFs: where, with what bytes, and which file.
const BEGINNINGS: [(usize, &[u8], &str); 14] = [
    (8, b"CR\x02\0", "a raw file (CR2)"),
    (6, b"HEAPCCDR", "a raw file (CRW)"),
    (4, b"ftypcrx ", "a raw file (CR3)"),
    (0, b"FUJIFILMCCD-RAW", "a raw file (RAF)"),
    (0, b"IIRO", "a raw file (ORF)"),
    (0, b"IIRS", "a raw file (ORF)"),
    (0, b"MMOR", "a raw file (ORF)"),
    (0, b"IIU\0", "a raw file (RW2)"),
    (0, b"FOVb", "a raw file (X3F)"),
    (0, b"\0MRM", "a raw file (MRW)"),
    (8, b"IIIITwaR", "a raw file (IIQ)"),
    (8, b"MMMMRawT", "a raw file (IIQ)"),
    (0, b"ARRI", "a raw file (ARI)"),
    (0, b"qktk", "a raw file (QTK)"),
];

/// The signatures of other common picture files that are not read.
const OTHERS: [(usize, &[u8], &str); 13] = [
    (4, b"ftypheic", "HEIC"),
    (4, b"ftypheix", "HEIC"),
    (4, b"ftypmif1", "HEIF"),
    (4, b"ftypavif", "AVIF"),
    (8, b"WEBP", "WebP"),
    (0, b"GIF8", "GIF"),
    (0, b"8BPS", "Photoshop (PSD)"),
    (0, b"DDS ", "DDS"),
    (0, b"\xabKTX 11\xbb", "KTX"),
    (0, b"\xabKTX 20\xbb", "KTX 2"),
    (0, b"\0\0\0\x0cJXL ", "JPEG XL"),
    (0, b"\xff\x0a", "JPEG XL"),
    (0, b"\0\0\0\x0cjP  ", "JPEG 2000"),
];

/// The raw files that are TIFFs, by the beginning of the maker's name.
const MAKERS: [(&str, &str); 10] = [
    ("NIKON", "NEF"),
    ("CANON", "CR2"),
    ("SONY", "ARW"),
    ("PENTAX", "PEF"),
    ("RICOH", "PEF"),
    ("OLYMPUS", "ORF"),
    ("PANASONIC", "RW2"),
    ("SAMSUNG", "SRW"),
    ("HASSELBLAD", "3FR"),
    ("EPSON", "ERF"),
];

/// The rows of all of them, each once.
pub(super) fn rows() -> Vec<Entry> {
    const DEVELOP: &str =
        "it has to be developed first, without a tone curve, to a TIFF of 16 bits or a linear EXR";
    const SAVE: &str = "save it as one of those that are read";
    let raw = BEGINNINGS.iter().map(|&(_, _, name)| refused(name, DEVELOP));
    let makers = MAKERS.iter().map(|&(_, name)| refused(name, DEVELOP));
    let dng = [refused("a raw file (DNG)", DEVELOP)];
    let others = OTHERS.iter().map(|&(_, _, name)| refused(name, SAVE));
    let rest = [refused("others", SAVE)];
    let mut rows: Vec<Entry> = Vec::new();
    for row in dng.into_iter().chain(raw).chain(makers).chain(others).chain(rest) {
        let is_there = |known: &Entry| known.name.contains(row.name);
        if !rows.iter().any(is_there) {
            rows.push(row);
        }
    }
    rows
}

/// The kind of raw file, if the bytes begin as one.
pub(super) fn of_beginning(bytes: &[u8]) -> Option<&'static str> {
    // In JPEG and PNG files these bytes mean something else.
    let is_picture = bytes.starts_with(b"\xff\xd8") || bytes.starts_with(b"\x89PNG");
    found(&BEGINNINGS, bytes).filter(|_| !is_picture)
}

/// The name of another kind of file that is not read.
pub(crate) fn other(bytes: &[u8]) -> Option<&'static str> {
    found(&OTHERS, bytes)
}

fn found(list: &[(usize, &[u8], &'static str)], bytes: &[u8]) -> Option<&'static str> {
    let begins =
        |at: usize, with: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(with));
    list.iter().find(|(at, with, _)| begins(*at, with)).map(|(_, _, name)| *name)
}

/// The raw file of a camera of this maker.
pub(super) fn of_maker(make: &str) -> String {
    let make = make.to_ascii_uppercase();
    let kind = MAKERS.iter().find(|(name, _)| make.starts_with(name));
    kind.map_or("a raw file".into(), |(_, kind)| format!("a raw file ({kind})"))
}

/// Why a file that is `what` is not read, and what to do, as the end of a sentence about it.
pub(super) fn refusal(what: &str) -> String {
    format!(
        "is {what}: it has to be developed first, without a tone curve, to a TIFF of 16 bits or a linear EXR; name \
         that one"
    )
}
