//! As much of Markdown as these pages use: fenced blocks, headings, links.

use std::collections::BTreeSet;
use std::path::{Component, Path};

/// A page as text.
pub(crate) struct Page {
    pub(crate) text: String,
}

/// A link or a picture.
pub(crate) struct Link {
    /// Counted from one.
    pub(crate) line: usize,
    pub(crate) target: String,
}

/// A fenced block.
pub(crate) struct Block {
    /// The line of its opening fence, counted from one.
    pub(crate) line: usize,
    /// The first word behind the fence.
    pub(crate) language: String,
    /// The second.
    pub(crate) kind: String,
    pub(crate) text: String,
}

impl Page {
    pub(crate) fn read(root: &Path, path: &str) -> Self {
        let text = std::fs::read_to_string(root.join(path));
        Self { text: text.unwrap_or_else(|error| panic!("{path}: {error}")) }
    }

    /// The lines outside fenced blocks, with their numbers.
    fn prose(&self) -> impl Iterator<Item = (usize, &str)> {
        let mut fenced = false;
        self.text.lines().enumerate().filter_map(move |(index, line)| {
            let is_fence = line.trim_start().starts_with("```");
            fenced ^= is_fence;
            (!fenced && !is_fence).then_some((index + 1, line))
        })
    }

    pub(crate) fn links(&self) -> Vec<Link> {
        let mut links = Vec::new();
        for (line, text) in self.prose() {
            let mut rest = without_code(text);
            while let Some((_, behind)) = rest.split_once("](") {
                let Some((target, behind)) = behind.split_once(')') else { break };
                links.push(Link { line, target: target.to_owned() });
                rest = behind.to_owned();
            }
        }
        links
    }

    /// What can stand behind `#` in a link to this page, by the rule of GitHub and mdBook.
    pub(crate) fn anchors(&self) -> BTreeSet<String> {
        let mut anchors = BTreeSet::new();
        for (_, line) in self.prose().filter(|(_, line)| line.starts_with('#')) {
            let heading = line.trim_start_matches('#').trim().to_lowercase();
            let kept = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
            let slug = heading.chars().filter(kept).collect::<String>().replace(' ', "-");
            let all = std::iter::once(slug.clone()).chain((1..).map(|n| format!("{slug}-{n}")));
            all.into_iter().find(|anchor| anchors.insert(anchor.clone()));
        }
        anchors
    }

    pub(crate) fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let mut open = false;
        for (index, line) in self.text.lines().enumerate() {
            if let Some(fence) = line.trim_start().strip_prefix("```") {
                open = !open;
                let mut words = fence.split([' ', ',']).map(str::to_owned);
                let (language, kind) = (words.next(), words.next());
                if open {
                    blocks.push(Block {
                        line: index + 1,
                        language: language.unwrap_or_default(),
                        kind: kind.unwrap_or_default(),
                        text: String::new(),
                    });
                }
            } else if open && let Some(block) = blocks.last_mut() {
                block.text.push_str(line);
                block.text.push('\n');
            }
        }
        blocks
    }
}

/// The line without what is in backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect()
}

/// The file that a link on the page at `path` leads to, from the root, and the heading in it.
pub(crate) fn resolve(path: &str, target: &str) -> (String, Option<String>) {
    let (file, anchor) = match target.split_once('#') {
        Some((file, anchor)) => (file, Some(anchor.to_owned())),
        None => (target, None),
    };
    if file.is_empty() {
        return (path.to_owned(), anchor);
    }
    let mut parts: Vec<String> = Vec::new();
    let folder = Path::new(path).parent().unwrap_or(Path::new(""));
    for part in folder.join(file).components() {
        match part {
            Component::ParentDir => drop(parts.pop()),
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            _ => {}
        }
    }
    (parts.join("/"), anchor)
}
