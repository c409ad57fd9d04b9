//! The page *What is read*: the tables of the readers of `unrender-formats`.

use super::{cell, hold};
use unrender_formats::what_is_read::{Row, Table, what_is_read};

const PAGE: &str = "docs/reference/what-is-read.md";
const MARKS: (&str, &str) = ("<!-- the tables -->", "<!-- end of the tables -->");

/// A row of the page: neighbours with the same text share one.
fn line(rows: &[Row]) -> String {
    let Row { within, taken, done, .. } = rows[0];
    let elements: Vec<String> = rows.iter().map(|row| format!("`{}`", row.element)).collect();
    let within = if within.is_empty() { String::new() } else { format!("`{within}`: ") };
    let elements = cell(&elements.join(", "));
    format!("| {within}{elements} | {} | {} |\n", taken.word(), cell(done))
}

fn text(table: &Table) -> String {
    let Table { title, column, rows } = table;
    let mut text = format!("## {title}\n\n| {column} | taken | what is done |\n|---|---|---|\n");
    let is_alike = |a: &Row, b: &Row| (a.within, a.taken, a.done) == (b.within, b.taken, b.done);
    rows.chunk_by(is_alike).for_each(|rows| text.push_str(&line(rows)));
    text
}

#[test]
fn what_is_read_is_what_the_readers_say() {
    let tables: Vec<String> = what_is_read().iter().map(text).collect();
    hold(PAGE, MARKS, &tables.join("\n"));
}
