//! Mattes by name, as Cryptomatte has them: of each pixel the names that it shows, and how much of it each covers.
//!
//! A name is a number, the hash [Appleby 2011] of its UTF-8 bytes, which is stored as the float with these bits; where that
//! would be no ordinary number, one bit of the exponent is turned over. Ranks follow one another by coverage, two in each
//! group of four channels: number, coverage, number, coverage [Friedman and Jones 2015]. The header has, under
//! `cryptomatte/` and seven digits of the layer's own hash, its name, and the numbers of all names as JSON.

use super::one_layer::Channel;
use exr::meta::attribute::{AttributeValue, Text};
use serde_json::{Map, Value};
use unrender_scene::Image;

/// The names that a pixel can have. With half of them the fourth name at a corner is missing, with double of it files of
/// pictures with few names have twelve channels of zeros more.
pub const RANKS: usize = 6;
/// Names in a group of four channels.
const PER_GROUP: usize = 2;

/// What is seen in each pixel of a picture, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Matte {
    /// The names.
    pub names: Vec<String>,
    /// For each pixel the numbers of names, and the shares of the pixel that they cover, the largest first; a share of
    /// zero is none.
    pub shares: Image<[(u32, f32); RANKS]>,
}

impl Matte {
    /// The channels of the layer called `layer`.
    pub(super) fn channels(&self, layer: &str) -> Vec<Channel> {
        let ids: Vec<f32> = self.names.iter().map(|name| f32::from_bits(id(name))).collect();
        let of = |pixel: &[(u32, f32); RANKS], rank: usize| match pixel[rank] {
            (name, share) if share > 0.0 => [ids[name as usize], share],
            _ => [0.0; 2],
        };
        let channel = |index: usize| {
            let (rank, part) = (index / 2, index % 2);
            let name = ["r", "g", "b", "a"][index % (2 * PER_GROUP)];
            let name = format!("{layer}{:02}.{name}", rank / PER_GROUP);
            (name, self.shares.pixels().iter().map(|pixel| of(pixel, rank)[part]).collect())
        };
        (0..2 * RANKS).map(channel).collect()
    }

    /// The attributes of the header for the layer called `layer`.
    pub(super) fn attributes(&self, layer: &str) -> Vec<(Text, AttributeValue)> {
        let entry = |name: &String| (name.clone(), Value::from(format!("{:08x}", id(name))));
        let manifest = Value::Object(self.names.iter().map(entry).collect::<Map<_, _>>());
        let key = &format!("{:08x}", id(layer))[..7];
        let texts = [
            ("name", layer.to_owned()),
            ("hash", "MurmurHash3_32".to_owned()),
            ("conversion", "uint32_to_float32".to_owned()),
            ("manifest", manifest.to_string()),
        ];
        let attribute = |(name, text): (&str, String)| {
            let key = Text::from(&*format!("cryptomatte/{key}/{name}"));
            (key, AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())))
        };
        texts.map(attribute).into()
    }
}

/// The number of a name, whose bits are those of an ordinary float.
fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 0xff;
    if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash }
}

/// `MurmurHash3_x86_32` with the seed 0 [Appleby 2011].
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed =
        |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let number =
        |bytes: &[u8]| bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte));
    let blocks = bytes.chunks_exact(4);
    let tail = blocks.remainder();
    let mut hash = blocks.fold(0, |hash: u32, block| {
        let hash = (hash ^ mixed(number(block))).rotate_left(13);
        hash.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    hash ^= mixed(number(tail)) ^ bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_hashes_of_others() {
        // By the reference implementation.
        for (text, hash) in [("", 0), ("test", 0xba6b_d213), ("Hello, world!", 0xc036_3e43)] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
        let fox = "The quick brown fox jumps over the lazy dog";
        assert_eq!(murmur3(fox.as_bytes()), 0x2e4f_f723);
        // In a manifest by Blender 4.5.
        for (name, hash) in [("default_surface", 0x78d0_5529), ("shader", 0xa176_7fe9)] {
            assert_eq!(id(name), hash, "{name}");
        }
        assert_eq!((id("wäll"), id("ViewLayer.CryptoMaterial") >> 4), (0x5553_5ad2, 0x0c7d_bf5e));
    }

    #[test]
    fn every_number_is_an_ordinary_float() {
        let names = (0..3000).map(|i| format!("name {i}"));
        let is_odd = |name: &String| !f32::from_bits(murmur3(name.as_bytes())).is_normal();
        assert!(names.clone().any(|name| is_odd(&name)));
        assert!(names.clone().all(|name| f32::from_bits(id(&name)).is_normal()));
    }
}
