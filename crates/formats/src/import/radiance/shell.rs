//! Command lines: programs one after the other and through pipes, as far as they are plain words.
//!
//! Radiance gives a command to the system's shell. Here nothing is run; so a line that only a shell
//! understands is refused.

/// A program with its words, and the file that it reads as its input.
#[derive(Debug, PartialEq, Eq, Default)]
pub(super) struct Stage {
    pub(super) words: Vec<String>,
    pub(super) input: Option<String>,
}

/// Programs that each read what the one before prints.
pub(super) type Pipeline = Vec<Stage>;

/// A word or a sign of a command line.
#[derive(Debug, PartialEq, Eq)]
enum Token {
    Word(String),
    /// `|`, `;` or `<`.
    Sign(char),
}

/// The pipelines of `line`, one after the other.
pub(super) fn pipelines(line: &str) -> Result<Vec<Pipeline>, String> {
    let mut all = vec![vec![Stage::default()]];
    let mut tokens = tokens(line)?.into_iter();
    while let Some(token) = tokens.next() {
        let pipeline = all.last_mut().ok_or("has no program")?;
        let stage = pipeline.last_mut().ok_or("has no program")?;
        match token {
            Token::Word(word) => stage.words.push(word),
            Token::Sign('|') => pipeline.push(Stage::default()),
            Token::Sign(';') => all.push(vec![Stage::default()]),
            Token::Sign(sign) => match tokens.next() {
                Some(Token::Word(file)) => stage.input = Some(file),
                _ => return Err(format!("has no file behind \"{sign}\"")),
            },
        }
    }
    // A semicolon may end the line.
    all.retain(|pipeline| *pipeline != [Stage::default()]);
    if all.is_empty() || all.iter().flatten().any(|stage| stage.words.is_empty()) {
        return Err("has no program where one should be".into());
    }
    Ok(all)
}

fn tokens(line: &str) -> Result<Vec<Token>, String> {
    let mut tokens = Vec::new();
    // `None` between words.
    let mut word: Option<String> = None;
    let mut letters = line.chars().peekable();
    let finish = |word: &mut Option<String>, tokens: &mut Vec<Token>| {
        tokens.extend(word.take().map(Token::Word));
    };
    while let Some(letter) = letters.next() {
        match letter {
            _ if letter.is_whitespace() => finish(&mut word, &mut tokens),
            '#' if word.is_none() => break,
            '\'' | '"' => {
                let word = word.get_or_insert_default();
                loop {
                    match letters.next() {
                        Some(end) if end == letter => break,
                        Some(inside @ ('$' | '`' | '\\')) if letter == '"' => {
                            return Err(shells(inside));
                        }
                        Some(inside) => word.push(inside),
                        None => return Err(format!("has a {letter} that is not closed")),
                    }
                }
            }
            '\\' => word.get_or_insert_default().extend(letters.next()),
            '|' | ';' | '<' if letters.peek() != Some(&letter) => {
                finish(&mut word, &mut tokens);
                tokens.push(Token::Sign(letter));
            }
            '&' if letters.peek() == Some(&'&') => {
                letters.next();
                finish(&mut word, &mut tokens);
                tokens.push(Token::Sign(';'));
            }
            '$' | '`' | '&' | '>' | '(' | ')' | '*' | '?' | '[' | ']' | '{' | '}' | '|' | ';'
            | '<' => {
                return Err(shells(letter));
            }
            '~' if word.is_none() => return Err(shells(letter)),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    finish(&mut word, &mut tokens);
    Ok(tokens)
}

fn shells(letter: char) -> String {
    format!("has a {letter} that only a shell understands")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<Vec<Vec<String>>> {
        let all = pipelines(line).unwrap();
        all.into_iter().map(|line| line.into_iter().map(|stage| stage.words).collect()).collect()
    }

    #[test]
    fn programs_words_and_pipes_are_told_apart() {
        let found = words("genbox 'a b' \"c|d\" 1\\ 2| xform -t 1 0 0;cat x && cat y; # end");
        let [boxed, x, y] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(boxed[0], ["genbox", "a b", "c|d", "1 2"]);
        assert_eq!(boxed[1], ["xform", "-t", "1", "0", "0"]);
        assert_eq!(
            (x[0].as_slice(), y[0].as_slice()),
            (["cat", "x"].map(String::from).as_slice(), ["cat", "y"].map(String::from).as_slice())
        );
        assert_eq!(pipelines("xform -s 2 < a.rad").unwrap()[0][0].input.as_deref(), Some("a.rad"));
    }

    #[test]
    fn what_only_a_shell_understands_is_refused() {
        for line in [
            "",
            "|",
            "a |",
            "| a",
            "a ;; b",
            "a > b",
            "cat *.rad",
            "a $B",
            "a `b`",
            "a \"$b\"",
            "(a)",
            "a &",
            "a 'b",
            "a <",
            "cat ~/a",
            "a {b,c}",
            "a || b",
        ] {
            assert!(pipelines(line).is_err(), "{line}");
        }
    }
}
