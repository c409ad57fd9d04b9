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
