//! The tables of what is read, row by row: rows that are read cause no warning, those warned of cause one, and
//! those refused cause an error. Radiance's are beside its other tests.

mod gltf;
mod mitsuba;
mod obj;
mod pictures;

use unrender_formats::what_is_read::{Row, Taken, what_is_read};
use unrender_scene::Warnings;

/// The rows of the table of this title.
pub(crate) fn rows(title: &str) -> Vec<Row> {
    let mut tables = what_is_read().into_iter();
    tables.find(|table| table.title == title).unwrap_or_else(|| panic!("no table {title}")).rows
}

/// Asserts that a file with the element of `row` was read as the row says; `told_of` is in the warning of it.
pub(crate) fn assert_taken(row: &Row, told_of: &str, read: Result<Warnings, String>) {
    let element = format!("{} {}", row.within, row.element);
    match (row.taken, read) {
        (Taken::Refused, Ok(warnings)) => panic!("{element} is read: {warnings:?}"),
        (Taken::Refused, Err(_)) => {}
        (_, Err(error)) => panic!("{element} is refused: {error}"),
        (Taken::WarnedOf, Ok(warnings)) => {
            let is_told = warnings.0.iter().any(|warning| warning.contains(told_of));
            assert!(is_told, "{element}: nothing is told of \"{told_of}\": {warnings:?}");
        }
        (_, Ok(warnings)) => assert!(warnings.0.is_empty(), "{element}: {warnings:?}"),
    }
}

#[test]
fn rows_say_something_once() {
    for table in what_is_read() {
        let mut seen = std::collections::BTreeSet::new();
        for Row { within, element, done, .. } in table.rows {
            let title = table.title;
            assert!(!done.is_empty() && !done.ends_with('.'), "{title}: {element}: {done}");
            assert!(seen.insert((within, element)), "{title}: {within} {element} twice");
        }
    }
}
