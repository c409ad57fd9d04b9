//! The state of the disk: the SHA-256 of every file, without times and the command line.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use unrender::formats::atomic;

/// The files of a result, by their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct State(BTreeMap<String, String>);

/// Keys that differ between two runs of one command: times, memory, the words of the command line.
/// The report shows them, and the manifest has the hashes of both files.
const NOT_SAME: [&str; 5] = ["seconds", "stages", "peak_memory_bytes", "command", "settings"];
const NOT_COMPARED: [&str; 3] = ["report.html", "manifest.json", "gallery.html"];

impl State {
    /// The result called `out` in `folder`: a file, or a folder with files.
    pub(crate) fn of(folder: &Path, out: &str) -> io::Result<Self> {
        let path = folder.join(out);
        let mut files = BTreeMap::new();
        if path.is_file() {
            files.insert(out.to_owned(), digest(&path)?);
        }
        for (path, _) in if path.is_dir() { files_of(&path)? } else { Vec::new() } {
            let name = path.strip_prefix(folder.join(out)).unwrap_or(&path).to_string_lossy();
            if !NOT_COMPARED.contains(&&*name) {
                files.insert(name.into_owned(), digest(&path)?);
            }
        }
        Ok(Self(files))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// One digest of all.
    pub(crate) fn digest(&self) -> String {
        hex(&Sha256::digest(format!("{:?}", self.0)))
    }

    /// The names of the files that are not as in `other`.
    pub(crate) fn difference(&self, other: &Self) -> Vec<String> {
        let names = self.0.keys().chain(other.0.keys());
        let mut names: Vec<String> =
            names.filter(|name| self.0.get(*name) != other.0.get(*name)).cloned().collect();
        names.dedup();
        names
    }
}

/// Whether `path` is a temporary file of ours.
pub(crate) fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(atomic::PREFIX))
}

/// All files in `folder` except our temporary ones, with their bytes, in order.
pub(crate) fn files_of(folder: &Path) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let (mut open, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if is_hidden(&path) {
                continue;
            }
            if path.is_dir() {
                open.push(path);
            } else {
                found.push((path.clone(), fs::read(path)?));
            }
        }
    }
    found.sort();
    Ok(found)
}

fn digest(path: &Path) -> io::Result<String> {
    let mut bytes = fs::read(path)?;
    if path.file_name().is_some_and(|name| name == "run.json" || name == "materials.json")
        && let Ok(mut value) = serde_json::from_slice::<Value>(&bytes)
    {
        without_times(&mut value);
        bytes = value.to_string().into_bytes();
    }
    Ok(hex(&Sha256::digest(&bytes)))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn without_times(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(without_times),
        Value::Object(map) => {
            NOT_SAME.iter().for_each(|key| drop(map.shift_remove(*key)));
            map.values_mut().for_each(without_times);
        }
        _ => {}
    }
}
