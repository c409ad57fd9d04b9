//! What an input comes from: a value, a picture, or a node that is not read.
//!
//! Connections are followed through outputs of node graphs, their interfaces, and nodes that pass on what they get:
//! `convert` and `dot`; `multiply` by a value; `extract` and `separate` of a channel; `normalmap`.

use super::document::{Names, Xml, numbers};
use unrender_scene::Rgb;

/// The most connections from an input to its source. Files have up to five; half of it would be enough, double of it too.
/// It ends circles.
const STEPS: usize = 32;

/// Where a value comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source<'a> {
    /// This text.
    Text(&'a str),
    /// The picture of an `image` node.
    Picture(Xml<'a>),
    /// A node of a kind that is not read, or a connection to nothing.
    Other(Option<Xml<'a>>),
}

/// What an input comes from, and what is done on the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin<'a> {
    pub(super) source: Source<'a>,
    /// What it is multiplied by.
    pub(super) factor: Rgb,
    /// The one channel that is taken, 0 to 3, if it is not all.
    pub(super) channel: Option<usize>,
    /// The `normalmap` node that it went through.
    pub(super) normal_map: Option<Xml<'a>>,
}

/// The origin of `input`, an `<input>` or an `<output>`.
pub(super) fn origin<'a>(names: &Names<'a>, input: Xml<'a>) -> Origin<'a> {
    let found =
        Origin { source: Source::Other(None), factor: Rgb::ONE, channel: None, normal_map: None };
    follow(names, input, found, STEPS)
}

fn follow<'a>(names: &Names<'a>, at: Xml<'a>, found: Origin<'a>, steps: usize) -> Origin<'a> {
    let nothing = Origin { source: Source::Other(None), ..found };
    let Some(steps) = steps.checked_sub(1) else { return nothing };
    if let Some(text) = at.attribute("value").filter(|_| !is_connected(at)) {
        return Origin { source: Source::Text(text), ..found };
    }
    let Some((target, output)) = target(names, at) else { return nothing };
    if matches!(target.tag_name().name(), "output" | "input") {
        return follow(names, target, found, steps);
    }
    through(names, (target, output), found, steps)
}

fn is_connected(at: Xml) -> bool {
    ["nodename", "nodegraph", "interfacename"].iter().any(|key| at.has_attribute(*key))
}

/// The element that `at` is connected to, and which of its outputs.
fn target<'a>(names: &Names<'a>, at: Xml<'a>) -> Option<(Xml<'a>, Option<&'a str>)> {
    let output = at.attribute("output");
    // An output stands in its graph; an input in a node, which stands in a graph or in the file.
    let own = at.parent_element()?;
    let around = if at.has_tag_name("output") { own } else { own.parent_element()? };
    let root = at.document().root_element();
    if let Some(name) = at.attribute("interfacename") {
        return names.input(around, name).map(|input| (input, None));
    }
    if let Some(graph) = at.attribute("nodegraph") {
        let graph = names.find(root, graph)?;
        let only = || graph.children().find(|child| child.has_tag_name("output"));
        let output = output.map_or_else(only, |output| names.find(graph, output))?;
        return Some((output, None));
    }
    // The input of a graph's interface is connected outside of it.
    let scope =
        if own.has_tag_name("nodegraph") && at.has_tag_name("input") { root } else { around };
    Some((names.find(scope, at.attribute("nodename")?)?, output))
}

/// What the `output` of `node` is.
fn through<'a>(
    names: &Names<'a>,
    (node, output): (Xml<'a>, Option<&'a str>),
    found: Origin<'a>,
    steps: usize,
) -> Origin<'a> {
    let unread = Origin { source: Source::Other(Some(node)), ..found };
    let passed = |name: &str, found: Origin<'a>| match names.input(node, name) {
        Some(input) => follow(names, input, found, steps),
        None => unread,
    };
    match node.tag_name().name() {
        "image" | "tiledimage" | "gltf_image" => Origin { source: Source::Picture(node), ..found },
        "gltf_colorimage" if output != Some("outa") => {
            Origin { source: Source::Picture(node), ..found }
        }
        "gltf_normalmap" => {
            Origin { source: Source::Picture(node), normal_map: Some(node), ..found }
        }
        "normalmap" => passed("in", Origin { normal_map: Some(node), ..found }),
        "constant" => passed("value", found),
        "convert" | "dot" => passed("in", found),
        "separate2" | "separate3" | "separate4" => {
            let channel = output.and_then(|name| match name {
                "outx" | "outr" => Some(0),
                "outy" | "outg" => Some(1),
                "outz" | "outb" => Some(2),
                _ => None,
            });
            if channel.is_none() { unread } else { passed("in", Origin { channel, ..found }) }
        }
        "extract" => {
            let index = names.input(node, "index").and_then(|input| input.attribute("value"));
            let channel = index.map_or(Some(0), |text| text.parse().ok()).filter(|c| *c < 3);
            if channel.is_none() { unread } else { passed("in", Origin { channel, ..found }) }
        }
        "multiply" => multiplied(names, node, found, steps).unwrap_or(unread),
        _ => unread,
    }
}

/// The product of a value and whatever the other is.
fn multiplied<'a>(
    names: &Names<'a>,
    node: Xml<'a>,
    found: Origin<'a>,
    steps: usize,
) -> Option<Origin<'a>> {
    let inputs = [names.input(node, "in1")?, names.input(node, "in2")?];
    // Each side is followed with half of the steps left, so that products of products end.
    let [one, two] = inputs.map(|input| {
        let alone = Origin { factor: Rgb::ONE, channel: None, normal_map: None, ..found };
        follow(names, input, alone, steps / 2)
    });
    let value = |side: &Origin| match side.source {
        Source::Text(text) => color(text).map(|value| value * side.factor),
        _ => None,
    };
    let (factor, other) = match (value(&one), value(&two)) {
        (Some(factor), _) => (factor, two),
        (None, Some(factor)) => (factor, one),
        (None, None) => return None,
    };
    // A channel that is taken of the product, where the picture has one of its own, is not that of the picture.
    let channel = match (found.channel, other.channel) {
        (Some(_), Some(_)) => return None,
        (one, two) => one.or(two),
    };
    Some(Origin { factor: found.factor * factor * other.factor, channel, ..other })
}

/// One number, or three, as a colour.
pub(super) fn color(text: &str) -> Option<Rgb> {
    match numbers(text)?.as_slice() {
        [all] => Some(Rgb::splat(*all)),
        [r, g, b] | [r, g, b, _] => Some(Rgb::new(*r, *g, *b)),
        _ => None,
    }
}
