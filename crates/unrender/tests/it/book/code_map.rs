//! The code map: every file of the code with the first sentence of its description.

use super::{cell, files, hold, root};
use std::fs;

const PAGE: &str = "docs/code-map.md";
const MARKS: (&str, &str) = ("<!-- the code map -->", "<!-- end of the code map -->");

/// The folders of code, each with its own table, and the endings of their files.
const FOLDERS: [(&str, &[&str]); 18] = [
    ("crates/scene/src", &[".rs"]),
    ("crates/formats/src", &[".rs"]),
    ("crates/photo/src", &[".rs"]),
    ("crates/render/src", &[".rs"]),
    ("crates/register/src", &[".rs"]),
    ("crates/recover/src", &[".rs"]),
    ("crates/measured/src", &[".rs"]),
    ("crates/paper/src", &[".rs"]),
    ("crates/remote/src", &[".rs"]),
    ("crates/restage/src", &[".rs"]),
    ("crates/unrender/src", &[".rs"]),
    ("python/src", &[".rs"]),
    ("python/unrender", &[".py"]),
    ("blender", &[".py"]),
    ("fuzz/src", &[".rs"]),
    ("benches/src", &[".rs", ".py"]),
    ("benches/peers", &[".py"]),
    ("benches/rooms", &[".py"]),
];

/// The description at the head of a file: the module comment, or the first docstring.
fn head(path: &str) -> String {
    let text = fs::read_to_string(root().join(path)).unwrap();
    if path.ends_with(".py") {
        return text.split("\"\"\"").nth(1).unwrap_or_default().to_owned();
    }
    let lines = text.lines().map_while(|line| line.strip_prefix("//!"));
    lines.map(str::trim).collect::<Vec<_>>().join("\n")
}

/// The first sentence of a text, on one line, for a cell of a table.
fn first_sentence(text: &str) -> String {
    let paragraph = text.trim().split("\n\n").next().unwrap_or_default();
    let line = paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
    // A full stop in brackets belongs to a citation.
    let is_end = |&(at, _): &(usize, &str)| {
        let before = &line[..at];
        before.matches('[').count() == before.matches(']').count()
    };
    let end = line.match_indices(". ").find(is_end).map_or(line.len(), |(at, _)| at);
    cell(line[..end].trim_end_matches('.'))
}

fn table(folder: &str, endings: &[&str]) -> String {
    let mut paths: Vec<String> = endings.iter().flat_map(|end| files(folder, end)).collect();
    paths.retain(|path| !path.contains("/tests/"));
    paths.sort();
    let mut text = format!("## {folder}\n\n| file | what it is |\n|---|---|\n");
    for path in paths {
        let sentence = first_sentence(&head(&path));
        assert!(!sentence.is_empty(), "{path} has no description");
        let within = path.strip_prefix(folder).unwrap_or(&path).trim_start_matches('/');
        text.push_str(&format!("| `{within}` | {sentence} |\n"));
    }
    text
}

#[test]
fn the_code_map_is_that_of_the_code() {
    let tables: Vec<String> = FOLDERS.iter().map(|(folder, ends)| table(folder, ends)).collect();
    hold(PAGE, MARKS, &tables.join("\n"));
}
