//! Folders of tests, and small glTF files: one triangle, a lamp, and what a test changes about them.

#![allow(dead_code, reason = "not every test uses everything here")]

pub(crate) mod pictures;

use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of its own for a test, removed when it is dropped.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self(tempfile::Builder::new().prefix("unrender-").tempdir().unwrap())
    }

    /// Its path.
    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    /// The path of `name` in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }

    /// Writes `bytes` under `name` and returns the path.
    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        // Some file systems flush a file that is overwritten, which would slow the loops down.
        let _ = fs::remove_file(&path);
        fs::write(&path, bytes).unwrap();
        path
    }
}

/// The bytes of the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0): positions, normals, then indices.
pub(crate) fn triangle_bytes() -> Vec<u8> {
    let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let normals = [0.0f32, 0.0, 1.0].repeat(3);
    let floats = positions.into_iter().chain(normals).flat_map(f32::to_le_bytes);
    floats.chain([0u16, 1, 2].into_iter().flat_map(u16::to_le_bytes)).collect()
}

/// The JSON of a scene whose buffer is [`triangle_bytes`]; it shines.
pub(crate) fn triangle_json() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "tri", "mesh": 0 }],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }
        ]}],
        "materials": [{
            "name": "lamp",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.25, 0.5, 0.75, 1], "metallicFactor": 0, "roughnessFactor": 1
            },
            "emissiveFactor": [1, 0.5, 0.25],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } }
        }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 78 }]
    })
}

/// A `.glb` of `json` and `bin`.
pub(crate) fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((28 + text.len() + bin.len()) as u32).to_le_bytes());
    glb.extend((text.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb
}

/// The `.glb` of the shining triangle after `change`.
pub(crate) fn changed(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut json, mut bin) = (triangle_json(), triangle_bytes());
    change(&mut json, &mut bin);
    glb(&json, &bin)
}

/// A small generator of numbers, the same in every run.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// A number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        ((self.0 >> 33) as usize) % end
    }
}

/// `whole` with a few of its bytes changed, or its end cut off.
pub(crate) fn damaged(whole: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..=numbers.below(4) {
        let at = numbers.below(bytes.len());
        match numbers.below(4) {
            0 => bytes[at] ^= 1 << numbers.below(8),
            1 => bytes[at] = b"0123456789-[]{},\"e."[numbers.below(19)],
            2 => bytes.truncate(at.max(1)),
            _ => bytes[at] = numbers.below(256) as u8,
        }
    }
    bytes
}
