//! What a reader does not read of a file: one warning for each kind, with its count and its first line.

use super::text::shown;
use std::collections::BTreeMap;
use unrender_scene::Warnings;

/// Further kinds get one warning together: a file with so many is not an OBJ. With half of it, real
/// files with many words of another program could lose some; with double, nothing changes.
const MAX_KINDS: usize = 50;
/// The most names that are shown. More do not help, and fewer hide that there are several.
const MAX_NAMES: usize = 5;

/// The warning of a word that no table has.
pub(super) fn unknown(word: &str) -> String {
    format!("the word \"{}\" is not known and was passed over", shown(word, 40))
}

struct Found {
    count: usize,
    first: usize,
    names: Vec<String>,
}

/// What was not read of a file.
#[derive(Default)]
pub(super) struct Unread {
    kinds: BTreeMap<String, Found>,
}

impl Unread {
    /// Records `what` in `line`, which belongs to the material `name`, if there is any.
    pub(super) fn note(&mut self, what: &str, line: usize, name: Option<&str>) {
        let is_one_too_many = self.kinds.len() >= MAX_KINDS && !self.kinds.contains_key(what);
        let what = if is_one_too_many { "more is not read" } else { what };
        if !self.kinds.contains_key(what) {
            self.kinds.insert(what.into(), Found { count: 0, first: line, names: Vec::new() });
        }
        let Some(found) = self.kinds.get_mut(what) else { return };
        found.count += 1;
        found.first = found.first.min(line);
        if found.names.len() < MAX_NAMES {
            found.names.extend(name.map(str::to_owned));
        }
    }

    /// Removes the warning `what`.
    pub(super) fn forget(&mut self, what: &str) {
        self.kinds.remove(what);
    }

    /// Adds the warnings of `file`, in the order of the lines.
    pub(super) fn tell(self, file: &str, warnings: &mut Warnings) {
        let mut kinds: Vec<_> = self.kinds.into_iter().collect();
        kinds.sort_by_key(|(_, found)| found.first);
        for (what, Found { count, first, names }) in kinds {
            let place = match count {
                1 => format!("line {first}"),
                _ => format!("{count} times, the first in line {first}"),
            };
            let whose = if names.is_empty() { String::new() } else { listed(&names, count) + ": " };
            warnings.push(format!("{file}: {whose}{what} ({place})."));
        }
    }
}

/// The first of `names` in quotes, and how many of `count` more there are.
pub(super) fn listed<S: AsRef<str>>(names: &[S], count: usize) -> String {
    let first = &names[..names.len().min(MAX_NAMES)];
    let quoted = first.iter().map(|name| format!("\"{}\"", shown(name.as_ref(), 60)));
    let quoted = quoted.collect::<Vec<_>>().join(", ");
    let more = count.saturating_sub(first.len());
    if more == 0 { quoted } else { format!("{quoted} and {more} more") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_told_once_and_there_are_not_many() {
        let mut unread = Unread::default();
        unread.note("b is not read", 7, Some("wall"));
        (2..9).for_each(|line| unread.note("a is not read", line, Some(&format!("m{line}"))));
        (0..1000).for_each(|line| unread.note(&unknown(&format!("w{line}")), 10 + line, None));
        let mut warnings = Warnings::default();
        unread.tell("x.mtl", &mut warnings);
        let some = "\"m2\", \"m3\", \"m4\", \"m5\", \"m6\" and 2 more";
        let first = format!("x.mtl: {some}: a is not read (7 times, the first in line 2).");
        assert_eq!(warnings.0[..2], [first, "x.mtl: \"wall\": b is not read (line 7).".into()]);
        assert_eq!(warnings.0.len(), MAX_KINDS + 1);
        assert!(warnings.0[MAX_KINDS].contains("more is not read (952 times"), "{warnings:?}");
    }
}
