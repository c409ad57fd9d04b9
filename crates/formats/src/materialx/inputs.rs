//! The inputs of one shader: their values, and warnings of what is not read of them.

use super::document::{Names, Xml, numbers};
use super::graph::{self, Origin, Source};
use super::picture::{self, Meant};
use crate::Input;
use crate::entry::{Entry, Taken, find};
use crate::input::Scope;
use crate::materials::mean_of;
use std::path::Path;
use unrender_scene::{Mapped, Rgb, Warnings};

/// Inputs that are neutral at one; all others that are told of are at zero.
const NEUTRAL_AT_ONE: [&str; 3] = ["opacity", "geometry_opacity", "alpha"];

/// The inputs of a shader.
pub(super) struct Inputs<'s, 'a> {
    /// The file, and what is counted of its memory.
    pub(super) input: Input<'s>,
    pub(super) scope: &'s Scope,
    pub(super) folder: &'s Path,
    pub(super) names: &'s Names<'a>,
    pub(super) shader: Xml<'a>,
    /// The name of the material, for messages.
    pub(super) material: &'s str,
    pub(super) warnings: &'s mut Warnings,
}

impl<'a> Inputs<'_, 'a> {
    /// Warns that the material `what`.
    pub(super) fn tell(&mut self, what: &str) {
        self.warnings.push(format!("material \"{}\": {what}", self.material));
    }

    /// Warns of inputs that are not read and state something, and of such that the shader does not have.
    pub(super) fn tell_of_the_unread(&mut self, rows: &[Entry]) {
        for input in self.shader.children().filter(|child| child.has_tag_name("input")) {
            let Some(name) = input.attribute("name") else { continue };
            match find(rows, name) {
                None => {
                    let tag = self.shader.tag_name().name();
                    self.tell(&format!("{tag} has no input {name}; it was left out"));
                }
                Some(row) if row.taken == Taken::WarnedOf && !self.is_neutral(input, name) => {
                    self.tell(&format!("{name}: {}", row.done));
                }
                Some(_) => {}
            }
        }
    }

    fn is_neutral(&self, input: Xml<'a>, name: &str) -> bool {
        let neutral = if NEUTRAL_AT_ONE.contains(&name) { 1.0 } else { 0.0 };
        match graph::origin(self.names, input).source {
            Source::Text(text) => {
                numbers(text).is_some_and(|numbers| numbers.iter().all(|n| *n == neutral))
            }
            Source::Picture(_) | Source::Other(_) => false,
        }
    }

    /// A number from 0 to 1.
    pub(super) fn number(&mut self, name: (&'static str, f32)) -> f32 {
        self.any_number(name).clamp(0.0, 1.0)
    }

    /// A number above zero.
    pub(super) fn positive(&mut self, (name, usual): (&'static str, f32)) -> f32 {
        let number = self.any_number((name, usual));
        if number > 0.0 { number } else { usual }
    }

    /// A number: the mean of a picture.
    pub(super) fn any_number(&mut self, name: (&'static str, f32)) -> f32 {
        let (mean, is_picture) = self.mean(name, Meant::Numbers);
        if is_picture {
            self.tell(&format!(
                "its {} is a picture, of which the mean, {:.3}, was taken",
                name.0, mean.x
            ));
        }
        mean.x
    }

    /// A colour from 0 to 1 and beyond: the mean of a picture.
    pub(super) fn color(&mut self, name: (&'static str, f32)) -> Rgb {
        let (mean, is_picture) = self.mean(name, Meant::Color);
        if is_picture {
            self.tell(&format!("its {} is a picture, of which the mean was taken", name.0));
        }
        mean.max(Rgb::ZERO)
    }

    /// A colour; of a picture its mean, and the picture itself.
    pub(super) fn color_or_picture(
        &mut self,
        name: (&'static str, f32),
    ) -> (Rgb, Option<Mapped<Rgb>>) {
        self.value(name, Meant::Color, self.scope)
    }

    /// The picture of a normal map and the scale of its x and y; none for the normals of the mesh.
    pub(super) fn normals(&mut self, name: &'static str) -> Option<(Mapped<Rgb>, f32)> {
        let input = self.names.input(self.shader, name)?;
        let origin = graph::origin(self.names, input);
        let (Source::Picture(node), Some(map)) = (origin.source, origin.normal_map) else {
            self.tell(&format!(
                "its {name} is no normal map of a picture; the normals of the mesh were taken"
            ));
            return None;
        };
        let scale = self.names.input(map, "scale").and_then(|input| input.attribute("value"));
        let scale = scale.and_then(numbers).and_then(|numbers| numbers.first().copied());
        let picture = self.picture(node, name, Meant::Numbers, self.scope)?;
        Some((picture, scale.unwrap_or(1.0)))
    }

    /// The value of `name`, and whether it is the mean of a picture. As the picture is not kept, its memory is counted apart.
    fn mean(&mut self, name: (&'static str, f32), meant: Meant) -> (Rgb, bool) {
        let alone = Scope::new(self.input);
        let (mean, picture) = self.value(name, meant, &alone);
        (mean, picture.is_some())
    }

    /// The value of `name`, or its usual one.
    fn value(
        &mut self,
        (name, usual): (&'static str, f32),
        meant: Meant,
        scope: &Scope,
    ) -> (Rgb, Option<Mapped<Rgb>>) {
        let usual_value = (Rgb::splat(usual), None);
        let Some(input) = self.names.input(self.shader, name) else { return usual_value };
        let origin = graph::origin(self.names, input);
        match origin.source {
            Source::Text(text) => match graph::color(text) {
                Some(color) => (through(color, &origin), None),
                None => {
                    self.tell(&format!("its {name} is \"{}\"; {usual} was taken", shortened(text)));
                    usual_value
                }
            },
            Source::Picture(node) => match self.picture(node, name, meant, scope) {
                Some(Mapped { image, wrap_u, wrap_v }) => {
                    let image = image.map(|texel| through(*texel, &origin));
                    (mean_of(&image), Some(Mapped { image, wrap_u, wrap_v }))
                }
                None => usual_value,
            },
            Source::Other(node) => {
                let node = node.map_or_else(
                    || "is connected to nothing".to_owned(),
                    |node| {
                        let (tag, id) =
                            (node.tag_name().name(), node.attribute("name").unwrap_or(""));
                        format!("comes from <{tag}> \"{id}\", which is not read")
                    },
                );
                self.tell(&format!("its {name} {node}; {usual} was taken"));
                usual_value
            }
        }
    }

    fn picture(
        &mut self,
        node: Xml<'a>,
        name: &str,
        meant: Meant,
        scope: &Scope,
    ) -> Option<Mapped<Rgb>> {
        let mut told = Vec::new();
        let read = picture::read(scope, self.folder, (self.names, node), meant, &mut |what| {
            told.push(what)
        });
        told.iter().for_each(|what| self.tell(&format!("its {name}: {what}")));
        read.map_err(|problem| {
            let id = node.attribute("name").unwrap_or("");
            self.tell(&format!(
                "its {name}: the picture of \"{id}\" {problem}; the default was taken"
            ));
        })
        .ok()
    }
}

/// `value` after what is done with it on the way.
fn through(value: Rgb, origin: &Origin) -> Rgb {
    origin.channel.map_or(value, |channel| Rgb::splat(value[channel])) * origin.factor
}

/// The beginning of a text that may be long.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
