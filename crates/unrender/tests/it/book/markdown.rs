//! Pages as Markdown: fenced blocks, headings, links.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};
use std::collections::BTreeSet;
use std::ops::Range;
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
    /// The first word after the fence.
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

    /// The elements of the page, each with its place.
    fn events(&self) -> impl Iterator<Item = (Event<'_>, Range<usize>)> {
        Parser::new_ext(&self.text, Options::ENABLE_TABLES).into_offset_iter()
    }

    /// The line of a place, counted from one.
    fn line(&self, place: &Range<usize>) -> usize {
        1 + self.text[..place.start].matches('\n').count()
    }

    pub(crate) fn links(&self) -> Vec<Link> {
        let link = |(event, place): (Event<'_>, Range<usize>)| match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                Some(Link { line: self.line(&place), target: dest_url.into_string() })
            }
            _ => None,
        };
        self.events().filter_map(link).collect()
    }

    /// The anchors of this page: what can follow `#` in a link to it, by the rule of GitHub and
    /// mdBook.
    pub(crate) fn anchors(&self) -> BTreeSet<String> {
        let mut anchors = BTreeSet::new();
        let mut heading: Option<String> = None;
        for (event, _) in self.events() {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::Text(text) | Event::Code(text) => {
                    heading.iter_mut().for_each(|heading| heading.push_str(&text));
                }
                Event::End(TagEnd::Heading(_)) => {
                    let heading = heading.take().unwrap_or_default().to_lowercase();
                    let kept = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
                    let slug = heading.chars().filter(kept).collect::<String>().replace(' ', "-");
                    let all =
                        std::iter::once(slug.clone()).chain((1..).map(|n| format!("{slug}-{n}")));
                    all.into_iter().find(|anchor| anchors.insert(anchor.clone()));
                }
                _ => {}
            }
        }
        anchors
    }

    pub(crate) fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let mut is_open = false;
        for (event, place) in self.events() {
            match event {
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(words))) => {
                    let mut words = words.split([' ', ',']).map(str::to_owned);
                    let (language, kind) = (words.next(), words.next());
                    blocks.push(Block {
                        line: self.line(&place),
                        language: language.unwrap_or_default(),
                        kind: kind.unwrap_or_default(),
                        text: String::new(),
                    });
                    is_open = true;
                }
                Event::End(TagEnd::CodeBlock) => is_open = false,
                Event::Text(text) if is_open => {
                    blocks.last_mut().into_iter().for_each(|block| block.text.push_str(&text));
                }
                _ => {}
            }
        }
        blocks
    }
}

/// The file to which a link on the page at `path` leads, from the root, and the heading in it.
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

#[test]
fn pages_are_read_as_their_renderers_do() {
    let text = "# A `b_c` [d](e.md)\n\n## A b_c d\n\n`[no](link)` ![p](q.png) <https://a.b>\n\n\
                - ```toml project\n  a = 1\n  # no heading\n  ```\n\n| a |\n|---|\n| [x\\|y](z.md#w) |\n";
    let page = Page { text: text.to_owned() };
    let links: Vec<(usize, String)> =
        page.links().into_iter().map(|link| (link.line, link.target)).collect();
    let expected = [(1, "e.md"), (5, "q.png"), (5, "https://a.b"), (14, "z.md#w")];
    assert_eq!(links, expected.map(|(line, target)| (line, target.to_owned())));
    let anchors = ["a-b_c-d", "a-b_c-d-1"].map(str::to_owned);
    assert_eq!(page.anchors(), BTreeSet::from(anchors));
    let [block] = &page.blocks()[..] else { panic!("there is one block") };
    assert_eq!((block.line, block.language.as_str(), block.kind.as_str()), (7, "toml", "project"));
    assert_eq!(block.text, "a = 1\n# no heading\n");
}
