//! Checks the statements of ARCHITECTURE.md and docs/ about the code against the code.

mod circles;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The documents, besides the book, whose paths in backticks must exist.
const DOCUMENTS: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "SECURITY.md"];

/// Which crates of the workspace each crate may use.
const DIRECTIONS: [(&str, &[&str]); 11] = [
    ("scene", &[]),
    ("formats", &["scene"]),
    ("render", &["scene"]),
    ("photo", &["scene"]),
    ("register", &["scene", "render"]),
    ("recover", &["scene", "render", "register"]),
    ("measured", &["scene", "render"]),
    ("paper", &["scene", "render", "recover"]),
    ("remote", &["scene", "render"]),
    ("restage", &["scene", "render"]),
    (
        "unrender",
        &[
            "scene", "formats", "render", "photo", "register", "recover", "measured", "paper",
            "remote", "restage",
        ],
    ),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The paths of all files under `folder` that end in `ending`, relative to the root.
fn files(folder: &str, ending: &str) -> Vec<String> {
    let mut found = Vec::new();
    let entries = fs::read_dir(root().join(folder)).unwrap();
    for entry in entries.map(Result::unwrap) {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&path, ending));
        } else if path.ends_with(ending) {
            found.push(path);
        }
    }
    found
}

fn rust_files(folder: &str) -> Vec<String> {
    files(folder, ".rs")
}

fn crates() -> Vec<String> {
    let entries = fs::read_dir(root().join("crates")).unwrap();
    let folders = entries.map(Result::unwrap).filter(|e| e.path().join("Cargo.toml").is_file());
    folders.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
}

fn modules() -> Vec<String> {
    crates().iter().flat_map(|name| rust_files(&format!("crates/{name}/src"))).collect()
}

/// The parts of `text` in backticks that are paths of this repository; fenced blocks are left out.
fn paths_in(text: &str) -> BTreeSet<String> {
    let outside_fences = text.split("```").step_by(2).collect::<String>();
    let quoted = outside_fences.split('`').skip(1).step_by(2);
    let folders = ["crates/", "benches/", "fuzz/", "docs/", "examples/", ".ci/"];
    let is_path =
        |piece: &&str| folders.iter().any(|f| piece.starts_with(f)) && !piece.contains([' ', '*']);
    quoted.filter(is_path).map(str::to_owned).collect()
}

#[test]
fn paths_and_tests_that_the_documents_name_exist() {
    let pages = files("docs", ".md").into_iter();
    for document in pages.chain(DOCUMENTS.map(str::to_owned)) {
        for piece in paths_in(&read(&document)) {
            let (path, test) = match piece.split_once("::") {
                Some((path, test)) => (path, Some(test)),
                None => (piece.as_str(), None),
            };
            assert!(root().join(path).exists(), "{document} names {path}, which is not there");
            if let Some(test) = test {
                let declared = read(path).contains(&format!("fn {test}("));
                assert!(declared, "{document}: there is no test {test} in {path}");
            }
        }
    }
}

#[test]
fn crates_depend_in_one_direction() {
    let known: BTreeSet<String> = DIRECTIONS.iter().map(|d| d.0.to_owned()).collect();
    assert_eq!(crates().into_iter().collect::<BTreeSet<_>>(), known);
    for (name, allowed) in DIRECTIONS {
        let manifest: toml::Table = read(&format!("crates/{name}/Cargo.toml")).parse().unwrap();
        let dependencies = manifest["dependencies"].as_table().unwrap();
        for used in dependencies.keys().filter_map(|d| d.strip_prefix("unrender-")) {
            assert!(allowed.contains(&used), "{name} may not use {used}");
        }
    }
}

/// The lines of a module that ship: up to its test module, without comments.
fn product_lines(path: &str) -> Vec<String> {
    let text = read(path);
    let product = text.split("#[cfg(test)]").next().unwrap_or_default();
    let code = |line: &&str| !line.trim_start().starts_with("//");
    product.lines().filter(code).map(str::to_owned).collect()
}

/// Asserts that no module matching `inside` but those of `except` has one of `words`.
fn assert_absent(words: &[&str], inside: impl Fn(&str) -> bool, except: &[&str]) {
    for path in modules().iter().filter(|m| inside(m) && !except.contains(&m.as_str())) {
        for line in product_lines(path) {
            let found = words.iter().find(|word| line.contains(**word));
            assert!(found.is_none(), "{path} has {found:?}: {line}");
        }
    }
}

fn is_core(path: &str) -> bool {
    ["scene", "render", "photo", "register", "recover", "paper", "remote", "restage"]
        .iter()
        .any(|c| path.starts_with(&format!("crates/{c}/")))
}

#[test]
fn the_core_touches_no_file_clock_or_terminal() {
    let words = ["std::fs", "File::", "std::env", "std::net", "std::process", "std::io"];
    // This file may choose one of its box tests, so that their bits can be compared.
    assert_absent(&words, is_core, &["crates/render/src/accel/mod.rs"]);
    assert_absent(&["Instant", "SystemTime"], is_core, &[]);
    assert_absent(&["println!", "print!", "dbg!"], is_core, &[]);
}

#[test]
fn files_are_written_in_one_place() {
    let words = ["fs::write", "fs::rename", "File::create", "OpenOptions"];
    // The journal of a recovery grows record by record, which a file that is replaced as a whole
    // cannot.
    let journal = "crates/unrender/src/recovery_journal.rs";
    let places = ["crates/formats/src/atomic.rs", "crates/unrender/src/output.rs", journal];
    assert_absent(&words, |_| true, &places);
}

#[test]
fn no_file_of_the_recovery_names_the_tracer() {
    let is_recovery =
        |path: &str| path.starts_with("crates/recover/") || path.starts_with("crates/paper/");
    assert_absent(&["Tracer"], is_recovery, &[]);
}

#[test]
fn the_process_ends_and_keeps_state_in_one_place() {
    let place = ["crates/unrender/src/interrupt.rs"];
    assert_absent(&["process::exit", "thread_local!", "LazyLock", "OnceLock"], |_| true, &place);
    for path in modules().iter().filter(|m| m.as_str() != place[0]) {
        let is_global = |line: &&String| line.split_whitespace().any(|word| word == "static");
        let lines = product_lines(path);
        let found = lines.iter().find(is_global);
        assert!(found.is_none(), "{path} has global state: {found:?}");
    }
}

#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    let workspace: toml::Table = read("Cargo.toml").parse().unwrap();
    assert_eq!(workspace["workspace"]["lints"]["rust"]["unsafe_code"].as_str(), Some("deny"));
    for name in crates() {
        let manifest: toml::Table = read(&format!("crates/{name}/Cargo.toml")).parse().unwrap();
        assert_eq!(manifest["lints"]["workspace"].as_bool(), Some(true), "{name}");
    }
    let outside = |path: &str| !path.starts_with("crates/render/src/accel/");
    assert_absent(&["unsafe"], outside, &[]);
}
