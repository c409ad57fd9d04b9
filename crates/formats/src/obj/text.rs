//! The lines of OBJ and MTL files: encoding, continued lines, comments, numbers.
//!
//! Each line that is not UTF-8 is taken as Latin-1, so that a name is the same in an OBJ in one
//! encoding and an MTL in the other. Lines end in LF, CR LF or CR. A line that ends in `\` goes on in
//! the next one, unless it has a comment: comments often end in the name of a folder.

use std::borrow::Cow;

/// A line with its continuation lines.
pub(super) struct Line<'a> {
    /// The number of its first line in the file, from 1.
    pub(super) number: usize,
    text: Cow<'a, str>,
}

impl Line<'_> {
    /// Its first word; nothing if it is empty or a comment.
    pub(super) fn word(&self) -> &str {
        let word = self.text.split_ascii_whitespace().next().unwrap_or_default();
        if word.starts_with('#') { "" } else { word }
    }

    /// What follows the first word, without blanks around it: for names, which may have blanks and
    /// `#` in them.
    pub(super) fn rest(&self) -> &str {
        let text = self.text.trim_ascii();
        text.find(|c: char| c.is_ascii_whitespace()).map_or("", |at| text[at..].trim_ascii())
    }

    /// The words after the first one, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.text.split_ascii_whitespace().skip(1).take_while(|word| !word.starts_with('#'))
    }

    /// Its text for messages, cut if it is long.
    pub(super) fn shown(&self) -> String {
        shown(self.text.trim_ascii(), 80)
    }

    /// Whether it is a comment that begins with `start`.
    pub(super) fn is_comment(&self, start: &str) -> bool {
        self.text.trim_ascii_start().starts_with(start)
    }
}

/// The first `most` characters of `text`, and dots where there are more.
pub(super) fn shown(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// `name` without a comment after it. Names may contain a `#`, so use it only if `name` as it
/// stands is unknown.
pub(super) fn without_comment(name: &str) -> &str {
    let ends = |(at, _): &(usize, _)| name[..*at].ends_with(|c: char| c.is_ascii_whitespace());
    name.match_indices('#').find(ends).map_or(name, |(at, _)| name[..at].trim_ascii_end())
}

/// Whether `bytes` can be text at all: neither binary nor UTF-16.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    !bytes.contains(&0) && !bytes.starts_with(&[0xFF, 0xFE]) && !bytes.starts_with(&[0xFE, 0xFF])
}

/// The number that `word` stands for; NaN, too, as the various systems print it.
pub(super) fn number(word: &str) -> Option<f64> {
    let printed = || {
        let lower = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
        lower.starts_with("nan(") || lower.contains(".#")
    };
    word.parse().ok().or_else(|| printed().then_some(f64::NAN))
}

/// The lines of `bytes`.
pub(super) fn lines(bytes: &[u8]) -> Lines<'_> {
    Lines { rest: bytes, number: 0 }
}

/// See [`lines`].
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// The next line as it stands, without its end.
    fn raw(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        let end = if rest.starts_with(b"\r\n") { 2 } else { rest.len().min(1) };
        self.rest = &rest[end..];
        // In files that were joined, later lines may have a byte order mark, too.
        Some(line.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(line))
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let mut raw = self.raw()?;
        let number = self.number;
        let mut text = decoded(raw);
        while continues(raw) {
            let whole = text.to_mut();
            whole.truncate(whole.trim_ascii_end().len() - 1);
            let Some(next) = self.raw() else { break };
            whole.push(' ');
            whole.push_str(&decoded(next));
            raw = next;
        }
        Some(Line { number, text })
    }
}

fn decoded(line: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(line) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(line.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// Whether the next line belongs to `line`.
fn continues(line: &[u8]) -> bool {
    let line = line.trim_ascii_end();
    let Some(before) = line.strip_suffix(b"\\") else { return false };
    // The second byte of some Japanese characters is a backslash.
    let is_half = before.last().is_some_and(|byte| *byte >= 0x80);
    let is_half = is_half && std::str::from_utf8(line).is_err();
    let mut words = before.split(u8::is_ascii_whitespace);
    !is_half && !words.any(|word| word.starts_with(b"#"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(bytes: &[u8]) -> Vec<(usize, String)> {
        lines(bytes).map(|line| (line.number, line.text.into_owned())).collect()
    }

    #[test]
    fn lines_end_and_go_on() {
        let text = b"a\r\nb \\\r\n c\\\nd\re\n\\\n\\\nf\\";
        let expected = [(1, "a"), (2, "b   c d"), (5, "e"), (6, "  f")];
        assert_eq!(texts(text), expected.map(|(number, text)| (number, text.to_owned())));
        let comments = b"# C:\\a\\\nv 1 # b\\\nv 2";
        assert_eq!(texts(comments).len(), 3);
    }

    #[test]
    fn names_are_the_same_in_every_encoding() {
        assert_eq!(texts(b"\xEF\xBB\xBFWei\xDFe"), texts("Weiße".as_bytes()));
        // The last character of the Japanese name is a 0x95 and a backslash.
        assert_eq!(texts(b"usemtl \x95\\\nf 1 2 3").len(), 2);
        let line = lines(b" usemtl  a #2 \t").next().unwrap();
        assert_eq!((line.word(), line.rest(), line.words().count()), ("usemtl", "a #2", 1));
        assert_eq!([without_comment("a #2"), without_comment("a#2")], ["a", "a#2"]);
    }

    #[test]
    fn numbers_of_all_systems() {
        for (word, value) in [("1e-3", 0.001), (".5", 0.5), ("+2.", 2.0), ("-1E2", -100.0)] {
            assert_eq!(number(word), Some(value));
        }
        for word in ["nan", "-nan(ind)", "-1.#IND", "1.#QNAN"] {
            assert!(number(word).unwrap().is_nan(), "{word}");
        }
        assert_eq!(["zero", "0,5", "", "1d3", "nano"].map(number), [None; 5]);
    }
}
