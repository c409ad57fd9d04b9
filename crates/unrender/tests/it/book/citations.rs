//! Code and pages cite only entries of `docs/bibliography.md`, and every entry is cited.

use super::{documents, files, root};
use std::collections::BTreeMap;
use std::fs;

const BIBLIOGRAPHY: &str = "docs/bibliography.md";

/// The keys in the bibliography, such as `Ward 1992`.
fn known() -> Vec<String> {
    let text = fs::read_to_string(root().join(BIBLIOGRAPHY)).unwrap();
    let entries = text.lines().filter_map(|line| line.strip_prefix("- **["));
    entries.map(|entry| entry.split("]**").next().unwrap().to_owned()).collect()
}

/// The keys that `text` cites: `[Name 1992]`, `[Name 1992, eq. 5; Other and Name 2002]`.
fn cited(text: &str) -> Vec<String> {
    let mut keys = Vec::new();
    for piece in text.split('[').skip(1) {
        let Some((inside, _)) = piece.split_once(']') else { continue };
        for part in inside.split("; ") {
            let key = part.split([',', ':']).next().unwrap_or_default().trim();
            let last = key.rsplit(' ').next().unwrap_or_default();
            let year = last.trim_end_matches(|c: char| c.is_ascii_lowercase());
            let is_year = year.len() == 4 && year.chars().all(|c| c.is_ascii_digit());
            if is_year && key.contains(' ') && key.starts_with(|c: char| c.is_uppercase()) {
                keys.push(key.to_owned());
            }
        }
    }
    keys
}

/// The comments of a source file as one text, so that a citation may be broken across lines.
fn comments(path: &str) -> String {
    let text = fs::read_to_string(root().join(path)).unwrap();
    let comment = |line: &str| {
        let (_, comment) = line.split_once("//")?;
        Some(comment.trim_start_matches(['/', '!', ' ']).to_owned())
    };
    text.lines().filter_map(comment).collect::<Vec<_>>().join(" ")
}

/// The keys that are cited, each with one place.
fn citations() -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    for folder in ["crates", "benches", "fuzz"] {
        for path in files(folder, ".rs").into_iter().filter(|path| !path.contains("/tests/")) {
            all.extend(cited(&comments(&path)).into_iter().map(|key| (key, path.clone())));
        }
    }
    for (path, page) in documents().iter().filter(|(path, _)| *path != BIBLIOGRAPHY) {
        let text = page.text.replace('\n', " ");
        all.extend(cited(&text).into_iter().map(|key| (key, path.clone())));
    }
    all
}

#[test]
fn what_is_cited_is_in_the_bibliography() {
    let known = known();
    let missing: Vec<_> = citations().into_iter().filter(|(key, _)| !known.contains(key)).collect();
    assert!(missing.is_empty(), "{BIBLIOGRAPHY} lacks {missing:#?}");
}

#[test]
fn what_is_in_the_bibliography_is_cited() {
    let folders = ["crates", "benches", "fuzz"].into_iter().flat_map(|folder| files(folder, ".rs"));
    let mut all: String = folders.map(|path| comments(&path) + " ").collect();
    for (_, page) in documents().iter().filter(|(path, _)| *path != BIBLIOGRAPHY) {
        all.push_str(&page.text.replace('\n', " "));
    }
    let is_cited =
        |key: &String| ["[", "; "].iter().any(|open| all.contains(&format!("{open}{key}")));
    let unused: Vec<_> = known().into_iter().filter(|key| !is_cited(key)).collect();
    assert!(unused.is_empty(), "nothing cites {unused:#?}");
}

/// Comments must not refer to documents that are not in the repository.
#[test]
fn nothing_refers_to_what_is_not_here() {
    for folder in ["crates", "benches", "fuzz"] {
        for path in files(folder, ".rs") {
            let text = comments(&path).to_lowercase();
            for words in ["(design", "design, section", "design section", "the design's"] {
                // The list above is not a comment.
                assert!(!text.contains(words), "{path} refers to \"{words}\"");
            }
        }
    }
}
