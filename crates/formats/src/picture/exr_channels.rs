//! Which channels of an EXR file are the picture: R, G and B, the same of a layer, or grey.
//!
//! A file has parts, and each part has channels, whose names are `LAYER.CHANNEL` or the channel alone. The picture
//! is the channels without a layer. Where all have one, it is the layer with a usual name for a renderer's picture
//! ([`BEAUTY`]), or the only one. A file where this is ambiguous is refused.

use exr::meta::header::Header;

/// The last words of the names of layers that renderers give to the picture itself.
const BEAUTY: [&str; 6] = ["combined", "beauty", "rgba", "rgb", "color", "colour"];
/// Blender's name for the layer of the composited picture, the one that it shows.
const COMPOSITE: &str = "composite.";
/// The most names that are listed; others are counted.
const LISTED: usize = 16;

/// The channels to read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    /// The index of the part.
    pub part: usize,
    /// Indices of the channels red, green and blue in the part; all the same in a grey picture.
    pub colours: [usize; 3],
    /// The index of the channel of coverage, if there is one.
    pub alpha: Option<usize>,
    /// A note on the choice for the user, as the end of a sentence about the file.
    pub note: Option<String>,
}

/// Three channels, or one, under one name.
#[derive(Clone, Debug)]
struct Candidate {
    part: usize,
    /// The layer, with the name of the part before it where parts have names; may be empty.
    name: String,
    /// Whether the channels' names contain no layer.
    is_base: bool,
    colours: [usize; 3],
    alpha: Option<usize>,
}

/// Chooses among the channels of all parts.
///
/// # Errors
/// If there is no picture among them or more than one, as the end of a sentence about the file.
pub(super) fn choose(headers: &[Header]) -> Result<Chosen, String> {
    for find in [colours as fn(&[&str]) -> Option<[usize; 3]>, grey] {
        let candidates = candidates(headers, find);
        if !candidates.is_empty() {
            return among(candidates);
        }
    }
    let all: Vec<String> =
        headers.iter().flat_map(|h| &h.channels.list).map(|c| c.name.to_string()).collect();
    Err(without_picture(&all))
}

/// The error of a file with these channels.
pub(super) fn without_picture(channels: &[String]) -> String {
    let last = |name: &String| last_word(name).to_ascii_lowercase();
    let is_chroma = |name: &String| ["ry", "by"].contains(&last(name).as_str());
    if channels.iter().any(is_chroma) {
        return format!(
            "is a luminance-chroma EXR: it has the channels {}, and R, G and B are wanted; save it as RGB",
            listed(channels)
        );
    }
    format!(
        "has the channels {}, among which there is no picture; R, G and B are wanted, or Y for grey, \
         alone or as those of a layer (beauty.R): save the picture with these names",
        listed(channels)
    )
}

/// Names for a message.
pub(super) fn listed(names: &[String]) -> String {
    let shown: Vec<&str> = names.iter().take(LISTED).map(String::as_str).collect();
    let more = names.len().saturating_sub(LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    if shown.is_empty() { "(none)".to_owned() } else { format!("{}{more}", shown.join(", ")) }
}

/// The layer of a channel, and its name in the layer.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

fn last_word(name: &str) -> &str {
    split(name).1
}

fn candidates(headers: &[Header], find: fn(&[&str]) -> Option<[usize; 3]>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
        let mut of_layer: std::collections::BTreeMap<&str, Vec<(usize, &str)>> =
            std::collections::BTreeMap::new();
        for (index, name) in names.iter().enumerate() {
            let (layer, channel) = split(name);
            of_layer.entry(layer).or_default().push((index, channel));
        }
        let part_name = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
        for (layer, channels) in of_layer {
            let words: Vec<&str> = channels.iter().map(|(_, channel)| *channel).collect();
            let Some(colours) = find(&words) else { continue };
            let alpha = position(&words, &["A", "alpha"]);
            let named = [part_name.as_deref().unwrap_or(""), layer];
            let named: Vec<&str> = named.into_iter().filter(|name| !name.is_empty()).collect();
            candidates.push(Candidate {
                part,
                name: named.join("."),
                is_base: layer.is_empty(),
                colours: colours.map(|at| channels[at].0),
                alpha: alpha.map(|at| channels[at].0),
            });
        }
    }
    candidates
}

/// The place among `words` of the first of the names, in any case of letters.
fn position(words: &[&str], names: &[&str]) -> Option<usize> {
    let exact = words.iter().position(|word| names.contains(word));
    let alike = |word: &&str| names.iter().any(|name| word.eq_ignore_ascii_case(name));
    exact.or_else(|| words.iter().position(alike))
}

fn colours(words: &[&str]) -> Option<[usize; 3]> {
    Some([
        position(words, &["R", "red"])?,
        position(words, &["G", "green"])?,
        position(words, &["B", "blue"])?,
    ])
}

/// Luminance alone: with X and Z it would be a position or a direction, with RY and BY a colour.
fn grey(words: &[&str]) -> Option<[usize; 3]> {
    let others = ["X", "Z", "U", "V", "RY", "BY"];
    if position(words, &others).is_some() {
        return None;
    }
    position(words, &["Y"]).map(|at| [at; 3])
}

fn among(candidates: Vec<Candidate>) -> Result<Chosen, String> {
    let names: Vec<String> = candidates.iter().map(|candidate| candidate.name.clone()).collect();
    let Some(taken) = taken(&candidates) else {
        return Err(format!(
            "has several pictures as layers, {}; save the one to read alone, as R, G and B",
            listed(&names)
        ));
    };
    let others: Vec<String> = names.into_iter().filter(|name| *name != taken.name).collect();
    let note = match (taken.name.as_str(), others.is_empty()) {
        ("", _) => None,
        (name, false) => {
            Some(format!("the layer \"{name}\" was read, and not {}", listed(&others)))
        }
        // It may be another pass of a renderer, not its picture.
        (name, true) => {
            let is_doubtful = !taken.is_base && !is_beauty(taken);
            is_doubtful.then(|| format!("the layer \"{name}\" was read, the only one with colours"))
        }
    };
    Ok(Chosen { part: taken.part, colours: taken.colours, alpha: taken.alpha, note })
}

/// The candidate that is the picture; none if that would be a guess.
fn taken(candidates: &[Candidate]) -> Option<&Candidate> {
    let is_composite = |c: &&Candidate| c.name.to_ascii_lowercase().starts_with(COMPOSITE);
    let base = only(candidates.iter().filter(|c| c.is_base));
    // A layer with a picture's name in another part is a likelier picture than plain R, G and B.
    let rivals = |base: &Candidate| candidates.iter().any(|c| is_beauty(c) && c.part != base.part);
    base.filter(|base| !rivals(base))
        .or_else(|| only(candidates.iter()))
        .or_else(|| only(candidates.iter().filter(|c| is_beauty(c))))
        .or_else(|| only(candidates.iter().filter(|c| is_beauty(c)).filter(is_composite)))
        // Parts have an order, unlike layers.
        .or_else(|| candidates.iter().find(|c| c.is_base && c.part == 0))
}

/// Whether it has a usual name for a renderer's picture.
fn is_beauty(candidate: &Candidate) -> bool {
    let last = last_word(&candidate.name);
    BEAUTY.iter().any(|word| last.eq_ignore_ascii_case(word))
}

/// The item, if there is exactly one.
fn only<T>(mut items: impl Iterator<Item = T>) -> Option<T> {
    let first = items.next()?;
    items.next().is_none().then_some(first)
}
