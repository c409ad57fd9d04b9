//! Tables of numbers as CSV: what separates the values, and how their decimals are written.
//!
//! Programs write semicolons or tabs where the comma is the decimal mark. The first line that is no comment
//! names the columns, and no name has such a character: it tells the separator. Where that is not the comma,
//! numbers may have decimal commas, all or none.

use std::cell::Cell;

/// A table in the bytes of a file.
pub(crate) struct Table<'a> {
    /// The bytes, without a byte order mark.
    pub bytes: &'a [u8],
    separator: u8,
    /// The decimal mark of the numbers so far.
    mark: Cell<Option<char>>,
}

impl<'a> Table<'a> {
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let mut lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r'));
        let is_header = |line: &&[u8]| !line.trim_ascii().is_empty() && !line.starts_with(b"#");
        let header = lines.find(is_header).unwrap_or_default();
        let count = |separator: &u8| header.iter().filter(|byte| *byte == separator).count();
        // Of equals the last is taken.
        let separator = *b"\t;,".iter().max_by_key(|separator| count(separator)).unwrap_or(&b',');
        Self { bytes, separator, mark: Cell::new(None) }
    }

    /// A reader of its rows, of which the first names the columns.
    pub(crate) fn reader(&self) -> csv::Reader<&'a [u8]> {
        csv::ReaderBuilder::new()
            .delimiter(self.separator)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(self.bytes)
    }

    /// The number in `text`.
    ///
    /// # Errors
    /// If it is none that is finite, or has another decimal mark than those before; as the end of a sentence
    /// about the value.
    pub(crate) fn number(&self, text: &str) -> Result<f64, String> {
        let mark = text.chars().find(|c| matches!(c, '.' | ','));
        if let (Some(now), Some(before)) = (mark, self.mark.get().or(mark))
            && self.separator != b','
            && now != before
        {
            return Err(format!(
                "\"{text}\", but numbers before have the decimal mark \"{before}\"; write all with a \
                 point, without marks between thousands"
            ));
        }
        let number = match self.separator {
            b',' => text.parse(),
            _ => text.replacen(',', ".", 1).parse(),
        };
        self.mark.set(self.mark.get().or(mark));
        number
            .ok()
            .filter(|number: &f64| number.is_finite())
            .ok_or_else(|| format!("\"{text}\"; write a number such as 12.5"))
    }
}

/// The column of what a row is called.
pub(crate) const NAME: &str = "name";

/// One row of [`Rows`].
pub(crate) struct Row {
    /// Its line in the file, from 1.
    pub line: usize,
    values: csv::StringRecord,
}

/// A table whose first line names its columns, in any order.
pub(crate) struct Rows<'a> {
    table: Table<'a>,
    header: csv::StringRecord,
    /// In the order of the file.
    pub all: Vec<Row>,
}

impl<'a> Rows<'a> {
    /// Reads a table that has all `required` columns, and no others but `optional` ones.
    ///
    /// # Errors
    /// If it has others, or a row is incomplete; in words without the file's name.
    pub(crate) fn read(
        bytes: &'a [u8],
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, String> {
        let table = Table::of(bytes);
        let (bytes, mut reader) = (table.bytes, table.reader());
        let header = reader.headers().map_err(|error| faulty(bytes, &error))?.clone();
        let unknown = |column: &&str| !required.contains(column) && !optional.contains(column);
        if let Some(unknown) = header.iter().find(unknown) {
            return Err(format!(
                "there is no column \"{unknown}\"; the first line is {}, and may have {}",
                required.join(","),
                optional.join(" and ")
            ));
        }
        if let Some(missing) = required.iter().find(|column| !header.iter().any(|h| h == **column))
        {
            return Err(format!("the column {missing} is missing"));
        }
        let mut all = Vec::new();
        for record in reader.records() {
            let values = record.map_err(|error| faulty(bytes, &error))?;
            let line = line_of(bytes, values.position());
            if values.len() != header.len() {
                return Err(format!(
                    "line {line}: has {} values, but there are {} columns",
                    values.len(),
                    header.len()
                ));
            }
            all.push(Row { line, values });
        }
        Ok(Self { table, header, all })
    }

    /// What the row has in a column; nothing if there is no such column.
    pub(crate) fn text<'r>(&self, row: &'r Row, column: &str) -> &'r str {
        let place = self.header.iter().position(|name| name == column);
        place.and_then(|place| row.values.get(place)).unwrap_or("")
    }

    /// The number that the row has in a column.
    ///
    /// # Errors
    /// If it is none, with line and column.
    pub(crate) fn number(&self, row: &Row, column: &str) -> Result<f64, String> {
        let faulty = |problem| format!("line {}: {column} is {problem}", row.line);
        self.table.number(self.text(row, column)).map_err(faulty)
    }

    /// As [`Rows::number`], of several columns.
    pub(crate) fn numbers<const N: usize>(
        &self,
        row: &Row,
        columns: [&str; N],
    ) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(row, column)?;
        }
        Ok(numbers)
    }

    /// What the row is called: by [`NAME`], else by its line.
    pub(crate) fn name(&self, row: &Row) -> String {
        match self.text(row, NAME) {
            "" => format!("line {}", row.line),
            name => name.to_owned(),
        }
    }
}

fn faulty(bytes: &[u8], error: &csv::Error) -> String {
    match error.position() {
        Some(position) => format!("line {}: is not CSV ({error})", line_of(bytes, Some(position))),
        None => format!("is not CSV ({error})"),
    }
}

/// The line of the record at `position`. The reader gives the place where it began to look:
/// comments and empty lines may come first.
fn line_of(bytes: &[u8], position: Option<&csv::Position>) -> usize {
    let start = position.map_or(0, |p| p.byte() as usize).min(bytes.len());
    let (before, after) = bytes.split_at(start);
    let skipped = after.split(|byte| *byte == b'\n').take_while(|line| {
        let line = line.trim_ascii();
        line.is_empty() || line.starts_with(b"#")
    });
    1 + before.iter().filter(|byte| **byte == b'\n').count() + skipped.count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_tells_the_separator() {
        for (text, separator) in [
            ("a,b\n1;2\n", b','),
            ("# x,y,z\n\na;b\r\n1,5;2\n", b';'),
            ("a\tb\n", b'\t'),
            ("a", b','),
            ("", b','),
        ] {
            assert_eq!(Table::of(text.as_bytes()).separator, separator, "{text:?}");
        }
    }

    #[test]
    fn decimal_commas_are_read_where_they_separate_nothing() {
        let semicolons = Table::of(b"a;b\n");
        assert_eq!(semicolons.number("1"), Ok(1.0));
        assert_eq!(semicolons.number("-0,25"), Ok(-0.25));
        assert!(semicolons.number("0.5").unwrap_err().contains("decimal mark \",\""));
        assert!(semicolons.number("1,000,5").is_err());
        let commas = Table::of(b"a,b\n");
        assert!(commas.number("0,5").unwrap_err().contains("write a number such as 12.5"));
        assert_eq!(commas.number("0.5"), Ok(0.5));
    }
}
