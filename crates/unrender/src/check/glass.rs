//! Groups that let light through by their names, and are opaque in the scene.

use super::finding::{Findings, Gravity};
use super::{Subject, some};
use unrender_recover::Role;

/// Words for what lets light through, in the languages of most artists.
const WORDS: [&str; 8] =
    ["glass", "glas", "pane", "windowpane", "verre", "vetro", "vidrio", "cristal"];
/// Words for glass that lets no light through: a hob, a screen, a table top that is painted below.
const OPAQUE: [&str; 4] = ["black", "dark", "opaque", "painted"];
/// Fewer pixels spoil nothing but themselves: at half of them bottles far away are told of, at double a vase is not.
const PIXELS_MIN: usize = 40;

/// The finding of groups with such names.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut findings = Findings::default();
    let is_clear = |g: &usize| {
        let name = subject.group_name(*g);
        subject.specs[*g].role == Role::Unknown
            && !subject.job.project.ignored.contains(name)
            && subject.observation.all_pixels_of_group[*g].len() >= PIXELS_MIN
            && sounds_clear(name)
    };
    let names: Vec<&str> =
        (0..subject.specs.len()).filter(is_clear).map(|g| subject.group_name(g)).collect();
    if let Some(first) = names.first() {
        let told = format!(
            "{} sounds like glass and is opaque in the scene. If it lets light through, leave out its pixels: \
             [groups.{first:?}] with ignore = true",
            some(&names)
        );
        let lines: Vec<String> =
            names.iter().map(|name| format!("[groups.{name:?}]\nignore = true")).collect();
        findings.push_with(Gravity::Part, told, lines.join("\n"));
    }
    findings
}

/// Whether a thing of this name lets light through.
fn sounds_clear(name: &str) -> bool {
    let words = words(name);
    let has = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
    has(&WORDS) && !has(&OPAQUE)
}

/// The words of a name in lower case: `WindowGlass_2` has `window` and `glass`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        let begins = letter.is_uppercase() && before.is_lowercase();
        if !letter.is_alphabetic() || begins {
            words.push(String::new());
        }
        if letter.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_word_by_word() {
        for name in
            ["Glass", "window_glass.001", "WineGlass", "GLASS", "kitchen pane", "Fenster-Glas"]
        {
            assert!(sounds_clear(name), "{name}");
        }
        for name in ["Glasses case", "fiberglass", "panel", "wall", "", "dark_glass", "BlackGlass"]
        {
            assert!(!sounds_clear(name), "{name}");
        }
    }
}
