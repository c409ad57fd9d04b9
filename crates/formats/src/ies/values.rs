//! The numbers of a file in their order, each with its line.

/// The numbers that are not taken yet.
pub(super) struct Values<'a> {
    /// What follows the last one.
    rest: &'a str,
    /// The line's number from one at the beginning of `rest`.
    line: usize,
    left: usize,
}

fn separates(c: char) -> bool {
    // Old programs end their files by the control character of DOS.
    c.is_whitespace() || c == ',' || c == '\u{1a}'
}

impl<'a> Values<'a> {
    /// Those of `text` from the line with the index `from` on.
    pub(super) fn of(text: &'a str, from: usize) -> Self {
        let start: usize = text.split_inclusive('\n').take(from).map(str::len).sum();
        let rest = &text[start..];
        let left = rest.split(separates).filter(|word| !word.is_empty()).count();
        let mut values = Self { rest, line: from + 1, left };
        values.pass_separators();
        values
    }

    /// How many there are yet.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// The line of the next one, or of the end if there is none.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    fn pass_separators(&mut self) {
        let next = self.rest.trim_start_matches(separates);
        let passed = &self.rest[..self.rest.len() - next.len()];
        self.line += passed.matches('\n').count();
        self.rest = next;
    }

    fn word(&mut self, what: &str) -> Result<(usize, &'a str), String> {
        if self.left == 0 {
            return Err(format!("ends before {what}; it may be cut off: ask for the file anew"));
        }
        let end = self.rest.find(separates).unwrap_or(self.rest.len());
        let (line, word) = (self.line, &self.rest[..end]);
        self.rest = &self.rest[end..];
        self.left -= 1;
        self.pass_separators();
        Ok((line, word))
    }

    /// The next one, which is `what`.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, String> {
        let (line, word) = self.word(what)?;
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        number.ok_or_else(|| format!("line {line}: {what} is \"{word}\"; expected a number"))
    }

    /// The next one, which is above zero.
    pub(super) fn factor(&mut self, what: &str) -> Result<f64, String> {
        let (line, number) = (self.line(), self.number(what)?);
        if number > 0.0 {
            return Ok(number);
        }
        Err(format!("line {line}: {what} is {number}; expected a number above zero"))
    }

    /// The next one, a number of things that are still to come.
    pub(super) fn count(&mut self, what: &str) -> Result<usize, String> {
        let (line, number) = (self.line(), self.number(what)?);
        let left = self.left();
        if number.fract() != 0.0 || number < 1.0 {
            return Err(format!("line {line}: {what} is {number}; expected 1, 2, 3 and so on"));
        }
        if number > left as f64 {
            return Err(format!(
                "line {line}: {what} is {number}, but only {left} numbers follow; ask for the file anew"
            ));
        }
        Ok(number as usize)
    }

    /// The next one, one of `choices`; which.
    pub(super) fn one_of<const N: usize>(
        &mut self,
        choices: [&str; N],
        what: &str,
    ) -> Result<usize, String> {
        let (line, number) = (self.line(), self.number(what)?);
        let place = choices.iter().position(|choice| choice.parse() == Ok(number));
        place.ok_or_else(|| {
            format!("line {line}: {what} is {number}; expected one of {}", choices.join(", "))
        })
    }

    /// The next `count` of them.
    pub(super) fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, String> {
        if count > self.left() {
            return Err(format!(
                "ends within {what}: {count} numbers are due and {} are there; ask for the file anew",
                self.left()
            ));
        }
        (0..count).map(|_| self.number(what)).collect()
    }
}
