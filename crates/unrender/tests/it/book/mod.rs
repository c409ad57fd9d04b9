//! The book in `docs/`: every page is in its summary, links have targets, projects, edits and
//! commands on the pages are valid, tables of keys agree with the schemas, the schemas with the
//! readers, and citations with the bibliography.
//!
//! Parts of pages are written by these tests: tables of keys from `docs/reference/schema`, and the
//! command line from its definition. With `UNRENDER_WRITE_PAGES=1` they rewrite stale parts; without
//! it, they fail.

mod citations;
mod code_map;
mod commands;
mod constants;
mod figures;
mod markdown;
mod schema;
mod tables;
mod what_is_read;

use markdown::Page;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use unrender::Project;
use unrender::edit::EditSheet;

/// Documents outside the book that have links, too.
const AROUND: [&str; 4] = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "SECURITY.md"];

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The files under `folder` that end in `extension`, as paths from the root.
fn files(folder: &str, extension: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root().join(folder)).unwrap().map(Result::unwrap) {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&path, extension));
        } else if path.ends_with(extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The pages of the book and the documents around it, by their paths from the root.
fn documents() -> BTreeMap<String, Page> {
    let pages = files("docs", ".md").into_iter().chain(AROUND.map(str::to_owned));
    pages.map(|path| (path.clone(), Page::read(&root(), &path))).collect()
}

/// A text of the code for a cell of a table, without its links, which have no target on a page.
fn cell(text: &str) -> String {
    text.replace("[`", "`").replace("`]", "`").replace('|', "\\|").replace('[', "\\[")
}

/// Compares the part of a page between two marks with what it should be, or writes it.
fn hold(path: &str, (begin, end): (&str, &str), wanted: &str) {
    let file = root().join(path);
    let text = fs::read_to_string(&file).unwrap();
    let (before, rest) =
        text.split_once(begin).unwrap_or_else(|| panic!("{path} lacks the mark {begin}"));
    let (stretch, after) =
        rest.split_once(end).unwrap_or_else(|| panic!("{path} lacks the mark {end}"));
    let wanted = format!("\n{}\n", wanted.trim());
    if stretch == wanted {
        return;
    }
    let remedy = "run `UNRENDER_WRITE_PAGES=1 cargo test --release --test it book::`";
    assert!(
        std::env::var_os("UNRENDER_WRITE_PAGES").is_some(),
        "{path}: what follows {begin} is stale; {remedy}"
    );
    fs::write(file, format!("{before}{begin}{wanted}{end}{after}")).unwrap();
}

#[test]
fn the_readme_is_short() {
    let lines = Page::read(&root(), "README.md").text.lines().count();
    assert!(lines <= 150, "README.md has {lines} lines; move the rest into the book");
}

#[test]
fn every_page_is_in_the_summary_once() {
    let documents = documents();
    let summary = documents["docs/SUMMARY.md"].links();
    let mut listed = BTreeSet::new();
    for link in summary {
        let target = markdown::resolve("docs/SUMMARY.md", &link.target).0;
        assert!(documents.contains_key(&target), "the summary names {target}, which is not there");
        assert!(listed.insert(target.clone()), "the summary names {target} twice");
    }
    let missing: Vec<_> = documents
        .keys()
        .filter(|page| *page != "docs/SUMMARY.md" && !listed.contains(*page))
        .collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md lacks {missing:?}");
}

#[test]
fn links_lead_somewhere() {
    let documents = documents();
    for (path, page) in &documents {
        for link in page.links().iter().filter(|link| !link.target.contains("://")) {
            let (target, anchor) = markdown::resolve(path, &link.target);
            let place = format!("{path}, line {}: {}", link.line, link.target);
            assert!(root().join(&target).exists(), "{place} is not there");
            if let Some(anchor) = anchor {
                let page = documents.get(&target).unwrap_or_else(|| panic!("{place}: no page"));
                assert!(page.anchors().contains(&anchor), "{place}: no such heading");
            }
            // The HTML has only the files that docs/build_book.sh copies into it.
            let is_in_html = target.starts_with("docs/") || documents.contains_key(&target);
            let is_page = path.starts_with("docs/");
            assert!(is_in_html || !is_page, "{place} is not in the book; write its path in `code`");
        }
    }
}

/// Writes the photometric profiles that a project names into `folder`.
fn profiles_of(project: &str, folder: &Path) {
    for line in project.lines() {
        let Some(name) = line.strip_prefix("profile = \"") else { continue };
        let name = name.split('"').next().unwrap();
        let profile = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 0\n0 90\n0\n1 0\n";
        fs::write(folder.join(name), profile).unwrap();
    }
}

#[test]
fn projects_and_edits_on_the_pages_are_understood() {
    let place = tempfile::tempdir().unwrap();
    let mut count = 0;
    for (path, page) in documents() {
        for block in page.blocks().iter().filter(|block| block.language == "toml") {
            let fault = format!("{path}, line {}", block.line);
            let files = "scene = \"scene.glb\"\nphoto = \"photo.png\"\n";
            match block.kind.as_str() {
                "project" => {
                    let head = if block.text.contains("scene =") { "" } else { files };
                    let text = format!("{head}{}", block.text);
                    profiles_of(&text, place.path());
                    let read = Project::parse(&place.path().join("page.toml"), &text);
                    assert!(read.is_ok(), "{fault}: {:?}", read.err());
                    schema::holds("project", &schema::from_toml(&text), &fault);
                }
                "edit" => {
                    let file = place.path().join("edit.toml");
                    fs::write(&file, &block.text).unwrap();
                    let read = EditSheet::read(&file);
                    assert!(read.is_ok(), "{fault}: {:?}", read.err());
                    schema::holds("edit", &schema::from_toml(&block.text), &fault);
                }
                other => panic!("{fault}: write ```toml project or ```toml edit, not {other:?}"),
            }
            count += 1;
        }
    }
    assert!(count >= 8, "only {count} projects and edits are on the pages");
}
