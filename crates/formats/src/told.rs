//! Warnings that hold for many groups, each as one sentence.

/// The most names in a sentence; they fit on two lines.
const NAMED: usize = 8;

/// What is to be told, in the order in which it was found, each with the groups that it holds for.
#[derive(Default)]
pub(crate) struct Told(Vec<(String, Vec<String>)>);

impl Told {
    /// Notes that `what` holds for `group`.
    pub(crate) fn note(&mut self, what: &str, group: &str) {
        match self.0.iter_mut().find(|(known, _)| known == what) {
            Some((_, groups)) => groups.push(group.to_owned()),
            None => self.0.push((what.to_owned(), vec![group.to_owned()])),
        }
    }

    /// One sentence for each.
    pub(crate) fn sentences(&self) -> impl Iterator<Item = String> + '_ {
        self.sentences_of("group")
    }

    /// One sentence for each, where the names are those of something else: its word, whose plural has an s.
    pub(crate) fn sentences_of(&self, word: &str) -> impl Iterator<Item = String> + '_ {
        let word = word.to_owned();
        self.0.iter().map(move |(what, groups)| {
            let named: Vec<String> =
                groups.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect();
            let plural = if groups.len() == 1 { "" } else { "s" };
            let more = match groups.len() - named.len() {
                0 => String::new(),
                rest => format!(" and {rest} more"),
            };
            format!("{word}{plural} {}{more}: {what}", named.join(", "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_holds_for_many_groups_is_told_once() {
        let mut told = Told::default();
        told.note("it is bent", "wall");
        (0..NAMED + 2).for_each(|k| told.note("it is left out", &k.to_string()));
        let sentences: Vec<String> = told.sentences().collect();
        assert_eq!(sentences.len(), 2);
        assert_eq!(sentences[0], "group \"wall\": it is bent");
        assert!(
            sentences[1].starts_with("groups \"0\", \"1\"")
                && sentences[1].contains(" and 2 more: it is left out")
        );
    }
}
