//! The errors of EXR files that the decoder does not know: deep data, subsampled channels, new compressions.
//!
//! The decoder refuses them without naming the channels, so the headers are read here again.

use super::exr_channels::{listed, without_picture};

/// A file with more parts or attributes than this is not a picture.
const MOST: usize = 4096;
/// The bit of the version that says that the file has several parts.
const PARTS: u32 = 1 << 12;
/// The last number of a compression that is known; 10 is HTJ2K.
const LAST_COMPRESSION: u8 = 9;

/// The contents of the headers that matter here.
#[derive(Default)]
struct Said {
    /// The names of the channels, with those of the parts.
    channels: Vec<String>,
    is_deep: bool,
    is_subsampled: bool,
    compression: u8,
}

/// What is wrong with the EXR in `bytes`, which the decoder refused with `error`, as the end of a sentence about it.
pub(crate) fn fault(bytes: &[u8], error: &exr::error::Error) -> String {
    let magic = exr::meta::magic_number::BYTES;
    if !bytes.starts_with(&magic[..magic.len().min(bytes.len())]) {
        return "is no EXR file".into();
    }
    let unsupported = match error {
        exr::error::Error::NotSupported(what) => Some(format!(
            "is a kind of EXR file that is not read ({what}); save R, G and B with ZIP"
        )),
        _ => None,
    };
    let kind = kind(bytes).or(unsupported);
    kind.unwrap_or_else(|| "is cut short or corrupt; copy it or save it once more".into())
}

/// The kind of the EXR in `bytes`, as the end of a sentence about it, if its headers are complete and contain
/// something that the decoder does not know.
fn kind(bytes: &[u8]) -> Option<String> {
    let said = headers(bytes)?;
    let channels = listed(&said.channels);
    if said.is_deep {
        return Some(format!(
            "is a deep EXR: it has several samples a pixel in the channels {channels}; flatten it, and save R, G \
             and B"
        ));
    }
    if said.compression > LAST_COMPRESSION {
        return Some(format!(
            "is compressed by a method of EXR that is not read (number {}); save it with ZIP or PIZ",
            said.compression
        ));
    }
    if said.is_subsampled {
        let is_colour = |name: &String| ["R", "G", "B"].iter().any(|c| name.ends_with(c));
        return Some(match said.channels.iter().any(is_colour) {
            true => format!(
                "has the channels {channels}, some of which have fewer samples than pixels; save it without \
                 subsampling"
            ),
            false => without_picture(&said.channels),
        });
    }
    None
}

/// None if the headers are cut short or damaged.
fn headers(bytes: &[u8]) -> Option<Said> {
    let version = u32::from_le_bytes(bytes.get(4..8)?.try_into().ok()?);
    let mut rest = bytes.get(8..)?;
    let mut said = Said::default();
    for _ in 0..MOST {
        if version & PARTS != 0 && rest.first() == Some(&0) {
            return Some(said);
        }
        part(&mut rest, &mut said)?;
        if version & PARTS == 0 {
            return Some(said);
        }
    }
    None
}

/// Reads the attributes of one part, and the zero after them.
fn part(rest: &mut &[u8], said: &mut Said) -> Option<()> {
    for _ in 0..MOST {
        let name = text(rest)?;
        if name.is_empty() {
            return Some(());
        }
        let _kind = text(rest)?;
        let size = take(rest, 4)?;
        let size = u32::from_le_bytes(size.try_into().ok()?);
        let value = take(rest, usize::try_from(size).ok()?)?;
        match name {
            b"channels" => channels(value, said)?,
            b"type" => said.is_deep |= value.starts_with(b"deep"),
            b"compression" => said.compression = said.compression.max(*value.first()?),
            _ => {}
        }
    }
    None
}

fn channels(mut list: &[u8], said: &mut Said) -> Option<()> {
    for _ in 0..MOST {
        let name = text(&mut list)?;
        if name.is_empty() {
            return Some(());
        }
        // Kind, linearity with three unused bytes, and the samplings along x and y.
        let rest = take(&mut list, 16)?;
        said.is_subsampled |= rest[8..] != [1, 0, 0, 0, 1, 0, 0, 0];
        said.channels.push(String::from_utf8_lossy(name).into_owned());
    }
    None
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}

/// The bytes up to the next zero.
fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().take(256).position(|byte| *byte == 0)?;
    let text = take(rest, end)?;
    take(rest, 1)?;
    Some(text)
}
