//! Mutates a file: bytes anywhere; words of texts; nodes of JSON and TOML, which stay well-formed.

use crate::random::Random;
use serde_json::{Value, json};

/// Whole numbers that are likely to cause faults.
const WHOLE: [u64; 14] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    1 << 40,
    (1 << 63) - 1,
    u64::MAX,
];
/// Words that are likely to cause faults.
const WORDS: [&str; 18] = [
    "0",
    "-1",
    "1",
    "nan",
    "inf",
    "-inf",
    "1e38",
    "-1e38",
    "1e-45",
    "1e308",
    "4294967295",
    "-9223372036854775808",
    "18446744073709551615",
    "",
    "../../x",
    "/dev/zero",
    "\u{0}",
    "\u{fffd}",
];
/// Files grow to this many bytes at most.
const LARGEST: usize = 1 << 16;

/// The structure of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Bytes.
    Bytes,
    /// Words between spaces.
    Words,
    /// JSON.
    Json,
    /// JSON in the first chunk of a `.glb`.
    Glb,
    /// TOML.
    Toml,
}

/// `seed` changed in one to eight places; pieces may be taken from the file `other`.
pub(crate) fn mutated(seed: &[u8], other: &[u8], kind: Kind, random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(8) {
        let structured = random.below(4) > 0;
        let changed = match kind {
            Kind::Words if structured => Some(words(&bytes, random)),
            Kind::Json if structured => json_text(&bytes, random),
            Kind::Glb if structured => glb(&bytes, random),
            Kind::Toml if structured => toml_text(&bytes, random),
            _ => None,
        };
        bytes = changed.unwrap_or_else(|| byte_level(&bytes, other, random));
        bytes.truncate(LARGEST);
    }
    bytes
}

fn byte_level(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    let at = random.below(bytes.len().max(1));
    let length = (1 + random.below(32)).min(bytes.len() - at.min(bytes.len()));
    match random.below(7) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
        1 if !bytes.is_empty() => bytes[at] = random.next() as u8,
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at.min(seed.len())..at.min(seed.len()) + length)),
        4 => {
            let copy = bytes[at.min(seed.len())..at.min(seed.len()) + length].to_vec();
            let to = random.below(bytes.len() + 1);
            bytes.splice(to..to, copy);
        }
        5 => {
            let from = random.below(other.len().max(1)).min(other.len());
            let to = (from + random.below(64)).min(other.len());
            bytes.splice(at.min(seed.len())..at.min(seed.len()) + length, other[from..to].to_vec());
        }
        _ => {
            let number = *random.one(&WHOLE);
            let width = 1 << random.below(4);
            let little = number.to_le_bytes();
            let mut piece = little[..width].to_vec();
            if random.below(2) == 0 {
                piece.reverse();
            }
            let end = (at + width).min(bytes.len());
            bytes.splice(at.min(end)..end, piece);
        }
    }
    bytes
}

fn words(seed: &[u8], random: &mut Random) -> Vec<u8> {
    let text = String::from_utf8_lossy(seed).into_owned();
    let is_edge = |c: char| c.is_whitespace() || "\"=<>/,".contains(c);
    let starts: Vec<usize> = text
        .char_indices()
        .filter(|(i, c)| !is_edge(*c) && text[..*i].chars().next_back().is_none_or(is_edge))
        .map(|(i, _)| i)
        .collect();
    if starts.is_empty() {
        return text.into_bytes();
    }
    let start = *random.one(&starts);
    let end = text[start..].find(is_edge).map_or(text.len(), |length| start + length);
    let word = match random.below(4) {
        0 => {
            let from = *random.one(&starts);
            let length = text[from..].find(is_edge).unwrap_or(text.len() - from);
            text[from..from + length].to_owned()
        }
        1 => format!("{0} {0}", &text[start..end]),
        _ => (*random.one(&WORDS)).to_owned(),
    };
    format!("{}{word}{}", &text[..start], &text[end..]).into_bytes()
}

fn json_text(seed: &[u8], random: &mut Random) -> Option<Vec<u8>> {
    let mut value: Value = serde_json::from_slice(seed).ok()?;
    json_node(&mut value, random);
    serde_json::to_vec(&value).ok()
}

fn json_node(root: &mut Value, random: &mut Random) {
    let mut node = root;
    // Goes down some levels, and changes the node there.
    for _ in 0..random.below(8) {
        let go_on = match &*node {
            Value::Array(items) => !items.is_empty(),
            Value::Object(map) => !map.is_empty(),
            _ => false,
        };
        if !go_on {
            break;
        }
        node = match node {
            Value::Array(items) => {
                let index = random.below(items.len());
                &mut items[index]
            }
            Value::Object(map) => {
                let index = random.below(map.len());
                match map.iter_mut().nth(index) {
                    Some((_, value)) => value,
                    None => return,
                }
            }
            _ => return,
        };
    }
    match (random.below(5), &mut *node) {
        (0, Value::Array(items)) if !items.is_empty() => {
            let copy = random.one(items).clone();
            (0..1 + random.below(40)).for_each(|_| items.push(copy.clone()));
        }
        (1, Value::Array(items)) if !items.is_empty() => {
            let index = random.below(items.len());
            items.remove(index);
        }
        (0 | 1, Value::Object(map)) if !map.is_empty() => {
            let index = random.below(map.len());
            let key = map.keys().nth(index).cloned().unwrap_or_default();
            map.remove(&key);
        }
        (2, node) => *node = json!([node.clone()]),
        (3, node) => *node = json!(*random.one(&WHOLE)),
        (_, node) => {
            let word = *random.one(&WORDS);
            let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
            *node = match random.below(4) {
                0 => Value::Null,
                1 => json!(word),
                _ => number.map_or(json!(-1), |number| json!(number)),
            };
        }
    }
}

fn glb(seed: &[u8], random: &mut Random) -> Option<Vec<u8>> {
    let length = u32::from_le_bytes(seed.get(12..16)?.try_into().ok()?) as usize;
    let end = length.checked_add(20)?;
    let mut text = json_text(seed.get(20..end)?, random)?;
    while !text.len().is_multiple_of(4) {
        text.push(b' ');
    }
    let rest = &seed[end..];
    let total = (20 + text.len() + rest.len()) as u32;
    let mut bytes = seed[..8].to_vec();
    bytes.extend(total.to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(&seed[16..20]);
    bytes.extend(text);
    bytes.extend(rest);
    Some(bytes)
}

fn toml_text(seed: &[u8], random: &mut Random) -> Option<Vec<u8>> {
    let table: toml::Table = std::str::from_utf8(seed).ok()?.parse().ok()?;
    let mut value = serde_json::to_value(table).ok()?;
    json_node(&mut value, random);
    let table: toml::Table = serde_json::from_value(value).ok()?;
    toml::to_string(&table).ok().map(String::into_bytes)
}
