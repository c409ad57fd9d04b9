//! Figures: pages of validation state when and at which commit they were measured, and the README has
//! the numbers of these pages.

use super::markdown::resolve;
use super::{documents, files};

/// Whether `text` has a date such as 2026-11-22.
fn is_dated(text: &str) -> bool {
    let parts: Vec<&str> = text.split(|c: char| !c.is_ascii_digit() && c != '-').collect();
    parts.iter().any(|part| {
        let lengths: Vec<usize> = part.split('-').map(str::len).collect();
        lengths == [4, 2, 2]
    })
}

/// Whether `text` has the short name of a commit: seven hexadecimal digits, one of them a digit.
fn has_commit(text: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let is_hex = |word: &str| word.chars().all(|c| matches!(c, '0'..='9' | 'a'..='f'));
    let has_both = |word: &str| {
        word.contains(|c: char| c.is_ascii_digit()) && word.contains(|c: char| c.is_alphabetic())
    };
    words.any(|word| word.len() == 7 && is_hex(word) && has_both(word))
}

#[test]
fn pages_of_validation_say_when_and_at_which_commit_they_were_measured() {
    let documents = documents();
    for path in files("docs/validation", ".md") {
        let text = &documents[&path].text;
        assert!(is_dated(text), "{path}: state the day of the measurement");
        assert!(has_commit(text), "{path}: state the commit that was measured");
    }
}

/// The numbers in `text`, as they are written.
fn numbers(text: &str) -> Vec<&str> {
    let words = text.split(|c: char| !c.is_ascii_digit() && c != '.');
    words.map(|word| word.trim_matches('.')).filter(|word| !word.is_empty()).collect()
}

/// Whether `number` is `exact`, or that in percent, to the digits that it has.
fn is_rounded(number: &str, exact: f64) -> bool {
    let digits = number.split_once('.').map_or(0, |(_, digits)| digits.len());
    let half = 0.5001 * 0.1f64.powi(digits as i32);
    let number: f64 = number.parse().unwrap();
    [exact, 100.0 * exact].iter().any(|exact| (number - exact).abs() <= half)
}

/// Each row of the table names the page from which its numbers are.
#[test]
fn the_readmes_figures_are_those_of_the_pages() {
    let documents = documents();
    let readme = &documents["README.md"].text;
    let section = readme.split_once("## How good it is").expect("the section of the table").1;
    let section = section.split_once("\n## ").unwrap().0;
    let mut figures_seen = 0;
    for row in section.lines().filter(|line| line.starts_with("| [")) {
        let target = row.split_once("](").unwrap().1.split_once(')').unwrap().0;
        let page = &documents[&resolve("README.md", target).0].text;
        let exact: Vec<f64> = numbers(page).iter().filter_map(|n| n.parse().ok()).collect();
        let figures = row.split_once(')').unwrap().1;
        for number in numbers(figures) {
            let is_there = exact.iter().any(|exact| is_rounded(number, *exact));
            assert!(is_there, "README.md: {number} is not on {target}:\n{row}");
            figures_seen += 1;
        }
    }
    assert!(figures_seen >= 15, "only {figures_seen} figures are in the table");
}
