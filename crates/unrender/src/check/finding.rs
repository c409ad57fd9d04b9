//! Findings, ordered by how much of a result they spoil.

use unrender_scene::Warnings;

/// How much of a result a finding spoils; the gravest comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Gravity {
    /// All groups, likely.
    All,
    /// Some groups, or some pixels.
    Part,
    /// Nothing, likely: it is good to know.
    Note,
}

/// What was found and what to do, in a sentence without a final full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// How much it spoils.
    pub gravity: Gravity,
    /// The sentence.
    pub sentence: String,
    /// The lines of a project that mend it, if they are known.
    pub lines: Option<String>,
}

impl Finding {
    /// One that no line of a project mends.
    pub(super) fn new(gravity: Gravity, sentence: impl Into<String>) -> Self {
        Self { gravity, sentence: sentence.into(), lines: None }
    }
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Findings(Vec<Finding>);

impl Findings {
    /// Adds a finding.
    pub(super) fn push(&mut self, gravity: Gravity, sentence: impl Into<String>) {
        self.0.push(Finding::new(gravity, sentence));
    }

    /// Adds a finding that `lines` of a project mend.
    pub(super) fn push_with(&mut self, gravity: Gravity, sentence: String, lines: String) {
        self.0.push(Finding { lines: Some(lines), ..Finding::new(gravity, sentence) });
    }

    /// The findings that lines of a project mend, with those.
    pub(super) fn remedies(&self) -> Vec<(String, String)> {
        let remedy = |found: &Finding| Some((found.sentence.clone(), found.lines.clone()?));
        self.0.iter().filter_map(remedy).collect()
    }

    /// Adds those of `others`.
    pub(super) fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// How many spoil a part of the result at least.
    pub(super) fn grave(&self) -> usize {
        self.0.iter().filter(|found| found.gravity != Gravity::Note).count()
    }

    /// All of them, the gravest first; those of one gravity in their order.
    pub(super) fn gravest_first(mut self) -> Vec<Finding> {
        self.0.sort_by_key(|finding| finding.gravity);
        self.0
    }

    /// The sentences, the gravest first, and `of_input` before those that are only good to know.
    pub(super) fn with(self, of_input: &Warnings) -> Warnings {
        let (notes, grave): (Vec<Finding>, Vec<Finding>) =
            self.gravest_first().into_iter().partition(|found| found.gravity == Gravity::Note);
        let sentences = |found: Vec<Finding>| found.into_iter().map(|found| found.sentence);
        let mut all = Warnings::default();
        let input = of_input.0.iter().cloned();
        sentences(grave).chain(input).chain(sentences(notes)).for_each(|told| all.push(told));
        all
    }
}

impl FromIterator<Finding> for Findings {
    fn from_iter<I: IntoIterator<Item = Finding>>(findings: I) -> Self {
        Self(findings.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gravest_come_first() {
        let mut findings = Findings::default();
        findings.push(Gravity::Note, "note");
        findings.push(Gravity::Part, "part");
        findings.push(Gravity::All, "all");
        findings.push(Gravity::Part, "second part");
        let told = findings.with(&Warnings(vec!["of the file".to_owned()])).0;
        assert_eq!(told, ["all", "part", "second part", "of the file", "note"]);
    }
}
