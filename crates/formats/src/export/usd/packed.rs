//! What the binary form of USD packs its tables with: LZ4 blocks, and differences of whole numbers.
//!
//! A block starts with the number of its chunks, 0 for a single one, and goes on as LZ4. Ours has one sequence of literals,
//! so that it needs no search for repetitions: tables are a small part of a scene, whose meshes the format keeps as they are.
//! Whole numbers become the differences between neighbours: first the most common difference, then a code of two bits
//! for each (that difference, or one of 1, 2 or 4 bytes), then those bytes. [OpenUSD, Usdc file format; LZ4 block format]

use std::collections::BTreeMap;

/// The longest block of one chunk, bytes: LZ4's own limit. Half of it would refuse tables that readers take; no reader takes
/// double of it as one chunk.
const LONGEST: usize = 0x7e00_0000;

/// `bytes` as a block.
///
/// # Errors
/// If they are too many for a block.
pub(super) fn block(bytes: &[u8]) -> Result<Vec<u8>, String> {
    if bytes.len() > LONGEST {
        return Err(
            "has more names, paths or properties than a usdc file can hold; write usda".into()
        );
    }
    // One chunk; then the length of the literals: 15 and more as a sum of bytes, of which 255 means that another follows.
    let mut packed = vec![0, (bytes.len().min(15) as u8) << 4];
    if let Some(more) = bytes.len().checked_sub(15) {
        packed.resize(packed.len() + more / 255, 255);
        packed.push((more % 255) as u8);
    }
    packed.extend(bytes);
    Ok(packed)
}

/// `numbers` as a block of differences, after the block's length.
///
/// # Errors
/// If they are too many for a block.
pub(super) fn integers(numbers: impl Iterator<Item = i32>) -> Result<Vec<u8>, String> {
    let mut before = 0i32;
    let differences: Vec<i32> = numbers
        .map(|number| {
            let difference = number.wrapping_sub(before);
            before = number;
            difference
        })
        .collect();
    let common = most_common(&differences);
    let mut codes = vec![0u8; differences.len().div_ceil(4)];
    let mut rest = Vec::new();
    for (index, difference) in differences.into_iter().enumerate() {
        let code = if difference == common {
            0
        } else if let Ok(byte) = i8::try_from(difference) {
            rest.extend(byte.to_le_bytes());
            1
        } else if let Ok(short) = i16::try_from(difference) {
            rest.extend(short.to_le_bytes());
            2
        } else {
            rest.extend(difference.to_le_bytes());
            3
        };
        codes[index / 4] |= code << (2 * (index % 4));
    }
    sized(&[&common.to_le_bytes()[..], &codes, &rest].concat())
}

/// `bytes` as a block, after its length.
///
/// # Errors
/// If they are too many for a block.
pub(super) fn sized(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let block = block(bytes)?;
    Ok([&(block.len() as u64).to_le_bytes()[..], &block].concat())
}

/// The number that occurs most often, of several the largest; zero of none.
fn most_common(numbers: &[i32]) -> i32 {
    let mut counts: BTreeMap<i32, usize> = BTreeMap::new();
    for number in numbers {
        *counts.entry(*number).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map_or(0, |(number, _)| number)
}
