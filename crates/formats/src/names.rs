//! Names for groups, each given once.

use std::collections::{BTreeMap, BTreeSet};
use unrender_scene::Warnings;

/// The group of triangles that have no material.
pub(crate) const DEFAULT: &str = "default";

/// `wanted` with " (2)", " (3)" and so on behind the second and later uses of a name.
pub(crate) fn unique(wanted: &[String], warnings: &mut Warnings) -> Vec<String> {
    let all: BTreeSet<&String> = wanted.iter().collect();
    let mut taken: BTreeSet<String> = BTreeSet::new();
    // The next number to try for a name; starting from one each time would take quadratic time.
    let mut next: BTreeMap<&String, usize> = BTreeMap::new();
    let mut names = Vec::with_capacity(wanted.len());
    for name in wanted {
        let mut candidate = name.clone();
        let number = next.entry(name).or_insert(2);
        let mut is_new = true;
        while taken.contains(&candidate) || (!is_new && all.contains(&candidate)) {
            candidate = format!("{name} ({number})");
            *number += 1;
            is_new = false;
        }
        if candidate != *name && name != DEFAULT {
            warnings.push(format!(
                "There are several materials called \"{name}\"; one of them is \"{candidate}\" here."
            ));
        }
        taken.insert(candidate.clone());
        names.push(candidate);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_given_once() {
        let wanted = ["a", "b", "a", "a (2)", "a"].map(String::from);
        let mut warnings = Warnings::default();
        let names = unique(&wanted, &mut warnings);
        assert_eq!(names, ["a", "b", "a (3)", "a (2)", "a (4)"]);
        assert_eq!(warnings.0.len(), 2);
    }
}
