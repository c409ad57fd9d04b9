//! The pictures of `image` nodes.

use super::document::{Names, Xml, inherited, numbers};
use crate::input::Scope;
use crate::picture;
use std::path::Path;
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{Mapped, Rgb, Wrap};

/// What a picture's numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meant {
    /// Colours, in the colour space that the file states.
    Color,
    /// Numbers, as they are.
    Numbers,
}

/// The picture of `node`, linear, or why there is none; what was taken otherwise goes to `told`.
pub(super) fn read(
    scope: &Scope,
    folder: &Path,
    (names, node): (&Names, Xml),
    meant: Meant,
    told: &mut dyn FnMut(String),
) -> Result<Mapped<Rgb>, String> {
    let input = names.input(node, "file").ok_or("names no file")?;
    let file = input.attribute("value").ok_or("names no file")?;
    let name = format!("{}{file}", inherited(input, "fileprefix").unwrap_or(""));
    if name.contains(['<', '{']) {
        return Err(format!("has the file \"{name}\", whose tokens such as <UDIM> are not read"));
    }
    let path = scope.beside(folder, &name).map_err(|problem| format!("\"{name}\" {problem}"))?;
    let (read, _) =
        picture::read_in(scope, &path).map_err(|error| format!("\"{name}\" {}", error.problem))?;
    tell_of_the_place(names, node, told);
    let wraps = ["uaddressmode", "vaddressmode"].map(|side| wrap(names, node, side, told));
    let image = match space(input, meant) {
        Space::Linear => read.values,
        Space::Srgb => {
            read.values.map(|texel| Rgb::from_array(texel.to_array().map(linear_from_srgb)))
        }
        Space::Other(space) => {
            told(format!(
                "the colour space {space} of \"{name}\" is not read; lin_rec709 was taken"
            ));
            read.values
        }
    };
    Ok(Mapped { image, wrap_u: wraps[0], wrap_v: wraps[1] })
}

enum Space<'a> {
    Linear,
    Srgb,
    Other(&'a str),
}

fn space<'a>(input: Xml<'a>, meant: Meant) -> Space<'a> {
    if meant == Meant::Numbers {
        return Space::Linear;
    }
    match inherited(input, "colorspace") {
        None | Some("" | "none" | "raw" | "lin_rec709" | "lin_rec709_scene") => Space::Linear,
        Some("srgb_texture" | "srgb_rec709_scene") => Space::Srgb,
        Some(other) => Space::Other(other),
    }
}

fn wrap(names: &Names, node: Xml, side: &str, told: &mut dyn FnMut(String)) -> Wrap {
    match names.input(node, side).and_then(|input| input.attribute("value")) {
        None | Some("periodic") => Wrap::Repeat,
        Some("mirror") => Wrap::MirroredRepeat,
        Some("clamp") => Wrap::ClampToEdge,
        Some(other) => {
            told(format!("{side} is \"{other}\"; clamp was taken"));
            Wrap::ClampToEdge
        }
    }
}

/// Pictures lie on the texture coordinates of the scene as they are.
fn tell_of_the_place(names: &Names, node: Xml, told: &mut dyn FnMut(String)) {
    for (input, usual) in [("uvtiling", 1.0), ("uvoffset", 0.0), ("realworldimagesize", 1.0)] {
        let Some(input_of) = names.input(node, input) else { continue };
        let value = input_of.attribute("value").and_then(numbers);
        if value.is_none_or(|numbers| numbers.iter().any(|n| *n != usual)) {
            told(format!(
                "{input} of its picture was left out; write it into the texture coordinates"
            ));
        }
    }
    if names.input(node, "texcoord").is_some() {
        told(
            "the texcoord of its picture was left out; the scene's own texture coordinates count"
                .into(),
        );
    }
}
