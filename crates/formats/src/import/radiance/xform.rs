//! The command line of `xform`: what it moves, where to, how often, and with which names.
//!
//! Options that rename come before the motions, files after them. `-a n` makes n copies, moved not at all,
//! once, twice and so on; `-f` takes further words from a file and makes one copy for each of its lines.
//! [Radiance, `xform(1)`]

use super::motion::Motion;
pub(super) use super::primitives::Change;
use super::words::Words;

/// The most `-a` and `-f` in one command: three are a lattice.
const NESTED: usize = 8;

/// Memory charged for a repetition, bytes: it allows half a million of them, which take a second.
const REPETITION: u64 = 4096;

/// The most words of one command; `xform` itself takes 256.
const WORDS: usize = 256;

/// Where the words of lists come from, and the limit of the number of repetitions.
pub(super) trait Source {
    /// The text of the list in the file `name`.
    fn list(&mut self, name: &str) -> Result<String, String>;
    /// Counts `bytes` that are about to be allocated.
    fn charge(&self, bytes: u64) -> Result<(), String>;
}

/// A change, and the files to which it applies.
pub(super) type Made = (Change, Vec<String>);

/// All that a command makes.
pub(super) fn parse(words: &[String], source: &mut impl Source) -> Result<Vec<Made>, String> {
    let mut all = Vec::new();
    expand(source, words.to_vec(), NESTED, &mut all)?;
    Ok(all)
}

/// Adds what `words` make to `all`, arrays and lists written out.
fn expand(
    source: &mut impl Source,
    words: Vec<String>,
    depth: usize,
    all: &mut Vec<Made>,
) -> Result<(), String> {
    if words.len() > WORDS {
        return Err(format!("xform has more than {WORDS} words"));
    }
    let list = words.iter().position(|word| word == "-f");
    let array = words.iter().position(|word| word == "-a");
    if depth == 0 && (list.is_some() || array.is_some()) {
        return Err(format!("xform has more than {NESTED} lists and arrays in one another"));
    }
    if let Some(at) = list {
        let file = words.get(at + 1).ok_or("xform has no file behind -f")?;
        let text = source.list(file)?;
        for (number, line) in lists(&text).into_iter().enumerate() {
            let mut one = words.clone();
            one.splice(at..at + 2, line);
            expand(source, numbered(one, 'i', number), depth - 1, all)?;
        }
        return Ok(());
    }
    if let Some(at) = array {
        let count = words.get(at + 1).and_then(|word| word.parse::<usize>().ok());
        let count = count.filter(|count| *count > 0).ok_or("xform has no count behind -a")?;
        for number in 0..count {
            let mut one = words.clone();
            one[at] = "-i".into();
            one[at + 1] = number.to_string();
            expand(source, numbered(one, 'a', number), depth - 1, all)?;
        }
        return Ok(());
    }
    // Each repetition is charged, which bounds their number.
    source.charge(REPETITION)?;
    all.push(single(&words)?);
    Ok(())
}

/// The words of each line of a list; lines go on after `\`.
fn lists(text: &str) -> Vec<Vec<String>> {
    let (mut found, mut line) = (Vec::new(), String::new());
    for part in text.lines() {
        match part.strip_suffix('\\') {
            Some(part) => line.push_str(part),
            None => {
                line.push_str(part);
                if !line.trim().is_empty() && !line.starts_with('#') {
                    let words = line.strip_prefix('!').unwrap_or(&line);
                    let mut words = Words::new(words.strip_prefix("xform ").unwrap_or(words));
                    found.push(std::iter::from_fn(|| words.word().map(str::to_owned)).collect());
                }
                line.clear();
            }
        }
    }
    found
}

/// `words` with the number of a repetition after the name if they have one, else as the name.
fn numbered(mut words: Vec<String>, letter: char, number: usize) -> Vec<String> {
    match words.iter().position(|word| word == "-n") {
        Some(at) if at + 1 < words.len() => words[at + 1] = format!("{}.{number}", words[at + 1]),
        _ => drop(words.splice(0..0, ["-n".to_owned(), format!("{letter}{number}")])),
    }
    words
}

/// The change that words without arrays and lists state, and the files that they name.
fn single(words: &[String]) -> Result<Made, String> {
    let (mut modifier, mut prefix, mut inverted) = (None, None::<String>, false);
    let mut rest = words;
    loop {
        match rest {
            [option, value, others @ ..] if option == "-m" => {
                modifier.get_or_insert_with(|| value.clone());
                rest = others;
            }
            [option, value, others @ ..] if option == "-n" => {
                prefix = Some(prefix.map_or(value.clone(), |before| format!("{before}.{value}")));
                rest = others;
            }
            [option, others @ ..] if option == "-I" => {
                inverted = !inverted;
                rest = others;
            }
            // Commands are always carried out.
            [option, others @ ..] if option == "-e" || option == "-c" => rest = others,
            _ => break,
        }
    }
    let (motion, read) = Motion::parse(rest);
    let (said, files) = rest.split_at(read);
    if let Some(wrong) = files.first().filter(|word| word.starts_with('-')) {
        return Err(format!(
            "xform has \"{wrong}\", which is no motion, or lacks the numbers that it needs"
        ));
    }
    let change = Change { motion, words: said.to_vec(), inverted, modifier, prefix };
    Ok((change, files.to_vec()))
}
