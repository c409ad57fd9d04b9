//! A row of a reader's own table: an element of a format, how it is taken, and what is done with it.
//!
//! Readers look up here what to do with what a file says, and the reference page *What is read* is made of the
//! same rows: [`what_is_read`](crate::what_is_read()).

/// How a reader takes an element of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// As the program that wrote the file means it.
    Read,
    /// Something close to it is taken, without a warning.
    Approximated,
    /// It does not concern shapes, reflectance, light or cameras; there is no warning.
    PassedOver,
    /// It is left out, or something close to it is taken, with a warning.
    WarnedOf,
    /// The file is not read; an error says why.
    Refused,
}

impl Taken {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Approximated => "approximated",
            Self::PassedOver => "passed over",
            Self::WarnedOf => "warned of",
            Self::Refused => "refused",
        }
    }
}

/// An element of a format.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// The word, tag or property.
    pub(crate) name: &'static str,
    pub(crate) taken: Taken,
    /// What is done with it, as a sentence without a full stop.
    pub(crate) done: &'static str,
}

const fn entry(name: &'static str, taken: Taken, done: &'static str) -> Entry {
    Entry { name, taken, done }
}

pub(crate) const fn read(name: &'static str, done: &'static str) -> Entry {
    entry(name, Taken::Read, done)
}

pub(crate) const fn near(name: &'static str, done: &'static str) -> Entry {
    entry(name, Taken::Approximated, done)
}

pub(crate) const fn passed(name: &'static str, done: &'static str) -> Entry {
    entry(name, Taken::PassedOver, done)
}

pub(crate) const fn told(name: &'static str, done: &'static str) -> Entry {
    entry(name, Taken::WarnedOf, done)
}

pub(crate) const fn refused(name: &'static str, done: &'static str) -> Entry {
    entry(name, Taken::Refused, done)
}

/// The row of `table` that is called `name`.
pub(crate) fn find<'a>(table: &'a [Entry], name: &str) -> Option<&'a Entry> {
    table.iter().find(|entry| entry.name == name)
}

/// One row of a table of [`what_is_read`](crate::what_is_read()).
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What it stands in, as the plugin of a property; empty if that is the file itself.
    pub within: &'static str,
    /// The word, tag or property.
    pub element: &'static str,
    /// How it is taken.
    pub taken: Taken,
    /// What is done with it, as a sentence without a full stop.
    pub done: &'static str,
}

/// What is read of a format, or of one part of it.
#[derive(Clone, Debug)]
pub struct Table {
    /// The format, and its part after a colon if there are several.
    pub title: &'static str,
    /// What the rows are: `word`, `property` and the like.
    pub column: &'static str,
    /// The rows in the order of the reader's own table.
    pub rows: Vec<Row>,
}

impl Table {
    pub(crate) fn new<'a>(
        title: &'static str,
        column: &'static str,
        entries: impl IntoIterator<Item = &'a Entry>,
    ) -> Self {
        let mut table = Self { title, column, rows: Vec::new() };
        table.add("", entries);
        table
    }

    /// Adds `entries` that stand in the element `within`.
    pub(crate) fn add<'a>(
        &mut self,
        within: &'static str,
        entries: impl IntoIterator<Item = &'a Entry>,
    ) {
        let row = |entry: &Entry| {
            let Entry { name, taken, done } = *entry;
            Row { within, element: name, taken, done }
        };
        self.rows.extend(entries.into_iter().map(row));
    }
}
