//! The words of a scene file: between blanks or in quotation marks, and the comments and commands that
//! stand between primitives.
//!
//! As Radiance's own reader has it: a quotation mark opens a word only where the word begins, a `#` is a
//! comment only where a primitive or a number may begin, and a command goes on in the next line after `\`.
//! ["The RADIANCE 5.4 Synthetic Imaging System" (reference manual), section 2]

/// What comes next in a file.
#[derive(Debug, PartialEq)]
pub(super) enum Item<'a> {
    /// A comment, without its `#`.
    Comment(&'a str),
    /// A command, without its `!`, in one line.
    Command(String),
    /// The first word of a primitive, not yet read.
    Primitive,
}

/// The place in a text up to which it was read.
pub(super) struct Words<'a> {
    rest: &'a str,
    line: usize,
    /// The line in which the last item begins.
    began: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text.strip_prefix('\u{feff}').unwrap_or(text), line: 1, began: 1 }
    }

    /// The line in which the last item begins.
    pub(super) fn first_line(&self) -> usize {
        self.began
    }

    /// What comes next, if anything does.
    pub(super) fn item(&mut self) -> Option<Item<'a>> {
        self.skip_blanks();
        self.began = self.line;
        if let Some(comment) = self.rest.strip_prefix('#') {
            let end = comment.find('\n').unwrap_or(comment.len());
            self.rest = &comment[end..];
            return Some(Item::Comment(comment[..end].trim_end_matches('\r')));
        }
        if let Some(command) = self.rest.strip_prefix('!') {
            self.rest = command;
            return Some(Item::Command(self.command()));
        }
        (!self.rest.is_empty()).then_some(Item::Primitive)
    }

    /// The rest of a command, with its continued lines.
    fn command(&mut self) -> String {
        let mut command = String::new();
        while !self.rest.is_empty() {
            let end = self.rest.find('\n').unwrap_or(self.rest.len());
            let line = self.rest[..end].trim_end_matches('\r');
            let Some(part) = line.strip_suffix('\\') else {
                command.push_str(line);
                self.rest = &self.rest[end..];
                break;
            };
            command.push_str(part);
            self.rest = self.rest.get(end + 1..).unwrap_or("");
            self.line += 1;
        }
        command
    }

    /// The next word, if there is one more.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        self.skip_blanks();
        let mark = self.rest.chars().next()?;
        if mark == '"' || mark == '\'' {
            let quoted = &self.rest[1..];
            let end = quoted.find(mark)?;
            self.line += quoted[..end].matches('\n').count();
            self.rest = &quoted[end + 1..];
            return Some(&quoted[..end]);
        }
        let end = self.rest.find(is_blank).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    /// The next word where a number is expected, without comments.
    pub(super) fn number(&mut self) -> Option<&'a str> {
        self.skip_blanks();
        while self.rest.starts_with('#') {
            let end = self.rest.find('\n').unwrap_or(self.rest.len());
            self.rest = &self.rest[end..];
            self.skip_blanks();
        }
        let end = self.rest.find(|c| is_blank(c) || c == '#').unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn skip_blanks(&mut self) {
        let end = self.rest.find(|c| !is_blank(c)).unwrap_or(self.rest.len());
        self.line += self.rest[..end].matches('\n').count();
        self.rest = &self.rest[end..];
    }
}

/// Blanks, as in C.
fn is_blank(c: char) -> bool {
    c.is_ascii_whitespace() || c == '\u{b}'
}

/// The text of a file: UTF-8, or else Latin-1, in which every byte is a letter.
pub(super) fn decoded(bytes: Vec<u8>) -> String {
    let latin_1 = |error: std::string::FromUtf8Error| {
        error.into_bytes().into_iter().map(char::from).collect()
    };
    String::from_utf8(bytes).unwrap_or_else(latin_1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_comments_and_commands_are_told_apart() {
        let text = "\u{feff}# one\r\n \t!genbox a \\\r\n  b\nvoid  'a b' \"c#'d\" e#f\n3 # three\n 4#four\n5";
        let mut words = Words::new(text);
        assert_eq!(words.item(), Some(Item::Comment(" one")));
        assert_eq!(words.item(), Some(Item::Command("genbox a   b".into())));
        assert_eq!((words.item(), words.first_line()), (Some(Item::Primitive), 4));
        for expected in ["void", "a b", "c#'d", "e#f"] {
            assert_eq!(words.word(), Some(expected));
        }
        for expected in ["3", "4", "5"] {
            assert_eq!(words.number(), Some(expected));
        }
        assert_eq!(
            (words.number(), words.word(), words.item(), words.first_line()),
            (None, None, None, 7)
        );
    }

    #[test]
    fn what_is_not_closed_is_no_word() {
        assert_eq!(Words::new("\"never closed").word(), None);
        assert_eq!(Words::new("!a \\").item(), Some(Item::Command("a ".into())));
        assert_eq!(decoded(vec![b'a', 0xe4]), "a\u{e4}");
    }
}
