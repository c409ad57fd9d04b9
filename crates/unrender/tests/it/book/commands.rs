//! The command line accepts the commands on the pages; the page of the command line is its
//! definition; completions and manual pages are made from the same.

use super::{documents, hold};
use clap::Command;
use std::process;
use unrender::cli::command;

/// The words of a command line, with '...' and "..." taken together.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (None, '\'' | '"') => quote = Some(c),
            (Some(open), _) if c == open => quote = None,
            (None, ' ') => words.push(String::new()),
            _ => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The arguments of `unrender` in a line of a console block, if it runs it.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next().unwrap_or_default().trim();
    let line = line.split(" > ").next().unwrap_or_default();
    let behind =
        line.strip_prefix("unrender ").or_else(|| line.strip_prefix("cargo run --release -- "))?;
    Some(std::iter::once("unrender".to_owned()).chain(words(behind)).collect())
}

#[test]
fn commands_on_the_pages_are_understood() {
    let mut count = 0;
    for (path, page) in documents() {
        for block in page.blocks().iter().filter(|block| block.language == "console") {
            let text = block.text.replace("\\\n", " ");
            for arguments in text.lines().filter_map(arguments) {
                let tried = command().try_get_matches_from(&arguments);
                let place = format!("{path}, line {}: {arguments:?}", block.line);
                assert!(tried.is_ok(), "{place}: {}", tried.unwrap_err());
                count += 1;
            }
        }
    }
    assert!(count >= 30, "only {count} commands are on the pages");
}

/// The help of a command as text of a fixed width.
fn help(definition: &Command) -> String {
    let mut definition = definition.clone().term_width(100);
    let text = definition.render_long_help().to_string();
    let lines = text.lines().map(str::trim_end).collect::<Vec<_>>();
    format!("```text\n{}\n```", lines.join("\n").trim_end())
}

#[test]
fn the_page_of_the_command_line_is_its_definition() {
    let mut definition = command();
    definition.build();
    let mut text = help(&definition);
    for sub in definition.get_subcommands().filter(|sub| sub.get_name() != "help") {
        text.push_str(&format!("\n\n## {}\n\n{}", sub.get_name(), help(sub)));
    }
    let marks = ("<!-- command line -->", "<!-- end of command line -->");
    hold("docs/reference/command-line.md", marks, &text);
}

fn run(arguments: &[&str]) -> process::Output {
    process::Command::new(env!("CARGO_BIN_EXE_unrender")).args(arguments).output().unwrap()
}

#[test]
fn completions_know_the_subcommands_and_their_flags() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = run(&["completions", shell]);
        assert!(output.status.success(), "{shell}");
        let script = String::from_utf8(output.stdout).unwrap();
        for word in ["recover", "restage", "keep-camera", "composite"] {
            assert!(script.contains(word), "the script for {shell} lacks {word}");
        }
    }
    assert_eq!(run(&["completions", "tcsh"]).status.code(), Some(2));
}

#[test]
fn every_subcommand_has_a_manual_page() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("man1");
    let output = run(&["man", "--quiet", "--out", folder.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(page("unrender.1").contains("unrender\\-recover(1)"));
    let definition = command();
    for sub in definition.get_subcommands() {
        let text = page(&format!("unrender-{}.1", sub.get_name()));
        assert!(text.contains(".SH SYNOPSIS"), "{}", sub.get_name());
        for flag in sub.get_arguments().filter_map(|argument| argument.get_long()) {
            let flag = flag.replace('-', "\\-");
            assert!(text.contains(&flag), "the page of {} lacks {flag}", sub.get_name());
        }
    }
}
