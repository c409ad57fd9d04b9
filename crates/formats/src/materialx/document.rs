//! A MaterialX file as XML: elements by their names, and what they inherit from those around them.

use crate::input::Scope;
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeMap;

/// The tree takes at most this many times the memory of its text: `<a/>` becomes a node of 80 bytes. Half of it would not
/// cover such a file; double of it refuses files that fit.
const TEXT_TO_TREE: u64 = 32;
/// The greatest depth of elements. Files have up to six levels; half of it would be enough, and each level takes a
/// kilobyte of the stack.
const DEPTH: usize = 64;

/// An element of the file.
pub(super) type Xml<'a> = Node<'a, 'a>;

/// The text as XML.
///
/// # Errors
/// If it is no XML, begins with another element, has includes or is too deep.
pub(super) fn parse<'a>(scope: &Scope, text: &'a str) -> Result<Document<'a>, String> {
    scope.charge(TEXT_TO_TREE * text.len() as u64)?;
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| format!("is no XML: {error}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "materialx" {
        let tag = root.tag_name().name();
        return Err(format!("begins with <{tag}>, not with <materialx>; is it another format?"));
    }
    for element in root.descendants().filter(Node::is_element) {
        let line = || document.text_pos_at(element.range().start).row;
        if element.tag_name().name() == "include" {
            return Err(format!(
                "line {}: XInclude is not read; write the file without includes, as MaterialX's own writer does by default",
                line()
            ));
        }
        if element.ancestors().take(DEPTH + 1).count() > DEPTH {
            return Err(format!(
                "line {}: has elements within elements, {DEPTH} deep and deeper",
                line()
            ));
        }
    }
    Ok(document)
}

/// The elements that are named, by the element around them and their name; of several of a name the first.
pub(super) struct Names<'a> {
    by_name: BTreeMap<(u32, &'a str), Xml<'a>>,
}

impl<'a> Names<'a> {
    pub(super) fn of(root: Xml<'a>) -> Self {
        let mut by_name = BTreeMap::new();
        for element in root.descendants().filter(Node::is_element) {
            let (Some(parent), Some(name)) = (element.parent(), element.attribute("name")) else {
                continue;
            };
            by_name.entry((parent.id().get(), name)).or_insert(element);
        }
        Self { by_name }
    }

    /// The element called `name` in `parent`.
    pub(super) fn find(&self, parent: Xml<'a>, name: &str) -> Option<Xml<'a>> {
        self.by_name.get(&(parent.id().get(), name)).copied()
    }

    /// The input `name` of `element`.
    pub(super) fn input(&self, element: Xml<'a>, name: &str) -> Option<Xml<'a>> {
        self.find(element, name).filter(|found| found.has_tag_name("input"))
    }
}

/// The attribute `name` of `element`, or of the nearest element around it that has one.
pub(super) fn inherited<'a>(element: Xml<'a>, name: &str) -> Option<&'a str> {
    element.ancestors().find_map(|around| around.attribute(name))
}

/// The numbers of a text such as `0.8, 0.7, 0.6`; none if one is not a finite number or there are more than four.
pub(super) fn numbers(text: &str) -> Option<Vec<f32>> {
    let parts: Vec<&str> = text.split(',').take(5).collect();
    if parts.len() > 4 {
        return None;
    }
    let number = |part: &&str| match part.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        number => number.parse().ok().filter(|v: &f32| v.is_finite()),
    };
    parts.iter().map(number).collect()
}
