//! Writes `performance.md`: a head, and one section per claim between marks, so that each can be
//! replaced alone.

use crate::{Claim, Failure};
use clap::ValueEnum;
use std::path::Path;
use unrender::formats::atomic;

/// The name of the page.
pub(crate) const FILE: &str = "performance.md";

const HEAD: &str = "# Performance

How fast unrender is beside the programs that one would use instead. This page is written by

```console
cargo run --profile dist -p unrender-benches
```

or, for one section, by `cargo run --profile dist -p unrender-benches -- NAME` with the name above its
first table. Everything in a table was measured in one run: compared programs alternate, round by
round, and a ratio is the median over the rounds. `benches/src/main.rs` describes how.
";

/// The section of a claim.
pub(crate) struct Section {
    /// Markdown, from its heading on.
    pub(crate) text: String,
    /// Plots by file name, as SVG.
    pub(crate) plots: Vec<(String, String)>,
}

/// Writes the section of the claim called `name` into the page in `folder`, and its plots into
/// `images` there.
///
/// # Errors
/// If one of them cannot be written.
pub(crate) fn write(folder: &Path, name: &str, section: &Section) -> Result<(), Failure> {
    std::fs::create_dir_all(folder.join("images"))?;
    for (file, svg) in &section.plots {
        atomic::write(&folder.join("images").join(file), svg.as_bytes())?;
    }
    let path = folder.join(FILE);
    let before = std::fs::read_to_string(&path).unwrap_or_default();
    let names: Vec<String> = Claim::value_variants().iter().map(|claim| claim.name()).collect();
    Ok(atomic::write(&path, replace(HEAD, &before, &names, name, &section.text).as_bytes())?)
}

/// The page with this `head` and with `text` as the section called `name`; the other sections of
/// `names` stay.
pub(crate) fn replace(head: &str, page: &str, names: &[String], name: &str, text: &str) -> String {
    let mut sections = String::from(head);
    for other in names {
        let (begin, end) = (format!("<!-- {other} -->\n"), format!("<!-- end of {other} -->\n"));
        let old = page.split_once(&begin).and_then(|(_, rest)| rest.split_once(&end));
        let body = if other == name { Some(text) } else { old.map(|(body, _)| body) };
        if let Some(body) = body {
            sections.push_str(&format!("\n{begin}{}\n{end}", body.trim_end()));
        }
    }
    sections
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_is_replaced_and_the_others_stay_in_their_order() {
        let names = ["first".to_owned(), "second".to_owned()];
        let page = replace(HEAD, "", &names, "second", "## Two\n");
        let page = replace(HEAD, &page, &names, "first", "## One\n");
        let page = replace(HEAD, &page, &names, "second", "## Two, again\n\nMore.\n");
        let body = page.strip_prefix(HEAD).unwrap();
        assert_eq!(
            body,
            "\n<!-- first -->\n## One\n<!-- end of first -->\n\
             \n<!-- second -->\n## Two, again\n\nMore.\n<!-- end of second -->\n"
        );
    }
}
