//! The page of the constants of the recovery, each with its value and its comment.

use super::{cell, files, hold, root};
use std::fs;

const PAGE: &str = "docs/constants.md";
const MARKS: (&str, &str) = ("<!-- the constants -->", "<!-- end of the constants -->");
const FOLDERS: [&str; 5] = [
    "crates/register/src",
    "crates/recover/src",
    "crates/measured/src",
    "crates/paper/src",
    "crates/remote/src",
];

/// A constant as its file declares it. One that follows another on the next line shares its comment.
struct Constant {
    name: String,
    value: String,
    comment: String,
}

/// The constants of a file, without its tests.
fn constants(text: &str) -> Vec<Constant> {
    let product = text.split("#[cfg(test)]").next().unwrap_or_default();
    let (mut found, mut comment) = (Vec::new(), String::new());
    let mut follows = false;
    for line in product.lines() {
        let line = line.trim_start();
        let declared = line.split_once("const ").filter(|(before, _)| is_visibility(before));
        let Some((name, rest)) = declared.and_then(|(_, rest)| rest.split_once(": ")) else {
            match line.strip_prefix("///") {
                Some(more) => comment = format!("{comment} {}", more.trim()),
                None if line.starts_with("#[") => {}
                None => comment.clear(),
            }
            follows = false;
            continue;
        };
        let value = rest.split_once('=').map_or("", |(_, value)| value);
        let value = value.trim().trim_end_matches(';').to_owned();
        let own = std::mem::take(&mut comment).trim().to_owned();
        let comment = if own.is_empty() && follows { "as above".to_owned() } else { own };
        found.push(Constant { name: name.to_owned(), value, comment });
        follows = true;
    }
    found
}

/// Whether the text before `const` is empty or a visibility.
fn is_visibility(before: &str) -> bool {
    before.is_empty() || before.trim_end() == "pub" || before.starts_with("pub(")
}

fn rows() -> String {
    let mut text = String::new();
    for path in FOLDERS.iter().flat_map(|folder| files(folder, ".rs")) {
        let constants = constants(&fs::read_to_string(root().join(&path)).unwrap());
        if constants.is_empty() {
            continue;
        }
        let place = path.trim_start_matches("crates/").replacen("/src", "", 1);
        text.push_str(&format!(
            "\n## {place}\n\n| constant | value | what it is |\n|---|---|---|\n"
        ));
        for Constant { name, value, comment } in constants {
            assert!(!comment.is_empty(), "{path}: {name} has no comment");
            let comment = cell(&comment);
            // Values of several lines are in the code.
            let value = if value.ends_with(['[', '{', '(']) { "" } else { value.as_str() };
            let value = if value.is_empty() { String::new() } else { format!("`{value}`") };
            text.push_str(&format!("| `{name}` | {value} | {comment} |\n"));
        }
    }
    text.replace("|  |", "| |")
}

#[test]
fn the_constants_are_those_of_the_code() {
    hold(PAGE, MARKS, &rows());
}
