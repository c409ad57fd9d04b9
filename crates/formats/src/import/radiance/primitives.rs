//! Primitives: what one is, how its words are read, and how it is moved.

use super::kinds::{Sort, kind};
use super::motion::Motion;
use super::words::Words;
use crate::record::Note;
use glam::DVec3;
use std::fmt;
use std::rc::Rc;
use unrender_scene::LightKind;

/// Where a primitive begins.
#[derive(Clone, Debug, Default)]
pub(super) struct Place {
    /// The file and a comma, unless it is the scene's own.
    pub(super) file: Rc<str>,
    pub(super) line: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}line {}", self.file, self.line)
    }
}

/// A primitive: `modifier kind id`, and its arguments.
#[derive(Clone, Debug, Default)]
pub(super) struct Primitive {
    pub(super) modifier: String,
    pub(super) kind: String,
    pub(super) id: String,
    pub(super) strings: Vec<String>,
    pub(super) reals: Vec<f64>,
    pub(super) place: Place,
}

/// A primitive, and our comment above it.
#[derive(Clone, Debug)]
pub(super) struct Noted {
    pub(super) primitive: Primitive,
    pub(super) note: Option<Note>,
}

impl Noted {
    /// The same, its places counted from `origin` instead of from the world's zero.
    pub(super) fn counted_from(mut self, origin: DVec3) -> Self {
        let reals = &mut self.primitive.reals;
        for place in reals.chunks_exact_mut(3).take(places(&self.primitive.kind)) {
            place.copy_from_slice(&(DVec3::from_slice(place) - origin).to_array());
        }
        if let Some(note) = &mut self.note {
            let here = (note.light_at - origin).as_vec3();
            let light = note.light.as_mut().map(|light| &mut light.kind);
            if let Some(
                LightKind::Point { position, .. }
                | LightKind::Spot { position, .. }
                | LightKind::Profiled { position, .. },
            ) = light
            {
                *position = here;
            }
        }
        self
    }
}

/// The number of points of a primitive of this kind; its numbers begin with them.
fn places(kind: &str) -> usize {
    match kind {
        "polygon" => usize::MAX,
        "sphere" | "bubble" | "ring" => 1,
        "cylinder" | "tube" | "cone" | "cup" => 2,
        _ => 0,
    }
}

impl Primitive {
    /// Reads the next primitive from `words`.
    pub(super) fn read(words: &mut Words) -> Result<Self, String> {
        let cut = |so_far: &str| format!("ends in the middle of \"{so_far}\"");
        let modifier = words.word().ok_or_else(|| cut("a word in quotation marks"))?.to_owned();
        let kind = words.word().ok_or_else(|| cut(&modifier))?.to_owned();
        let id = words.word().ok_or_else(|| cut(&format!("{modifier} {kind}")))?.to_owned();
        let mut read = Self { modifier, kind, id, ..Self::default() };
        let Some(known) = super::kinds::kind(&read.kind) else {
            return Err(format!(
                "\"{}\" is no kind of primitive that Radiance has; perhaps the one before it \
                 states a wrong number of arguments",
                read.kind
            ));
        };
        if known.sort == Sort::Alias {
            let original = words.word().ok_or_else(|| cut(&read.named()))?;
            read.strings.push(original.to_owned());
            return Ok(read);
        }
        let miscounted = format!("{} does not say how many arguments it has", read.named());
        let count = |words: &mut Words| {
            let count = words.number().and_then(|word| word.parse::<usize>().ok());
            count.ok_or_else(|| miscounted.clone())
        };
        for _ in 0..count(words)? {
            let word = words.word().ok_or_else(|| miscounted.clone())?;
            read.strings.push(word.to_owned());
        }
        if count(words)? != 0 {
            return Err(format!(
                "{} has whole numbers between its words and its numbers; Radiance has none there",
                read.named()
            ));
        }
        for _ in 0..count(words)? {
            let word = words.number().ok_or_else(|| miscounted.clone())?;
            let number = word.parse::<f64>().ok().filter(|v| (*v as f32).is_finite());
            read.reals.push(number.ok_or_else(|| {
                format!("{} has an argument that is no number (\"{word}\")", read.named())
            })?);
        }
        read.check_count()?;
        Ok(read)
    }

    /// Whether it has as many numbers as its kind.
    fn check_count(&self) -> Result<(), String> {
        let wanted = kind(&self.kind).map_or(&[][..], |kind| kind.reals);
        if wanted.is_empty() || wanted.contains(&self.reals.len()) {
            return Ok(());
        }
        let wanted: Vec<String> = wanted.iter().map(ToString::to_string).collect();
        let count = self.reals.len();
        Err(format!("{} has {count} numbers instead of {}", self.named(), wanted.join(" or ")))
    }

    /// Its kind and identifier, for messages.
    pub(super) fn named(&self) -> String {
        format!("the {} \"{}\"", self.kind, self.id)
    }

    /// Exactly this many numbers.
    pub(super) fn reals<const N: usize>(&self) -> Result<[f32; N], String> {
        let reals: Vec<f32> = self.reals.iter().map(|v| *v as f32).collect();
        let count = reals.len();
        reals.try_into().map_err(|_| format!("{} has {count} numbers instead of {N}", self.named()))
    }

    /// Three numbers, from number `at` on.
    pub(super) fn vector(&self, at: usize) -> DVec3 {
        let number = |k: usize| self.reals.get(at + k).copied().unwrap_or_default();
        DVec3::new(number(0), number(1), number(2))
    }

    fn set_vector(&mut self, at: usize, vector: DVec3) {
        for (number, moved) in self.reals.iter_mut().skip(at).zip(vector.to_array()) {
            *number = moved;
        }
    }

    /// The memory that it takes.
    pub(super) fn bytes(&self) -> u64 {
        let words = self.strings.iter().map(|word| word.len() + size_of::<String>());
        let names = self.modifier.len() + self.kind.len() + self.id.len();
        let numbers = self.reals.len() * size_of::<f64>();
        (size_of::<Noted>() + words.sum::<usize>() + names + numbers) as u64
    }
}

/// What `xform` does with all primitives that it reads.
#[derive(Clone, Debug)]
pub(super) struct Change {
    pub(super) motion: Motion,
    /// The words of the motion, which are added to functions and meshes.
    pub(super) words: Vec<String>,
    /// Turned inside out.
    pub(super) inverted: bool,
    /// The modifier of all surfaces.
    pub(super) modifier: Option<String>,
    /// The prefix of the names of surfaces.
    pub(super) prefix: Option<String>,
}

impl Change {
    /// `noted` moved.
    pub(super) fn of(&self, noted: &Noted) -> Noted {
        let mut changed = noted.clone();
        let sort = kind(&noted.primitive.kind).map(|kind| kind.sort);
        if sort == Some(Sort::Surface) {
            self.name(&mut changed);
        }
        self.arguments(&mut changed.primitive, sort);
        if let Some(Note { light: Some(light), light_at, .. }) = changed.note.as_mut() {
            *light_at = self.motion.point(*light_at);
            self.light(&mut light.kind);
            if let Some(prefix) = &self.prefix {
                light.name = format!("{prefix}.{}", light.name);
            }
        }
        changed
    }

    fn name(&self, Noted { primitive, note }: &mut Noted) {
        if let Some(modifier) = &self.modifier {
            primitive.modifier.clone_from(modifier);
        }
        let Some(prefix) = &self.prefix else { return };
        let name = note.as_mut().and_then(|note| note.name.as_mut());
        for name in [Some(&mut primitive.id), name].into_iter().flatten() {
            *name = format!("{prefix}.{name}");
        }
    }

    fn arguments(&self, p: &mut Primitive, sort: Option<Sort>) {
        let motion = &self.motion;
        let point = |p: &mut Primitive, at: usize| p.set_vector(at, motion.point(p.vector(at)));
        let vector = |p: &mut Primitive, at: usize| p.set_vector(at, motion.vector(p.vector(at)));
        let scale = |p: &mut Primitive, at: usize| {
            p.reals.iter_mut().skip(at).for_each(|length| *length *= motion.scale());
        };
        match p.kind.as_str() {
            "polygon" => {
                (0..p.reals.len() / 3).for_each(|k| point(p, 3 * k));
                if motion.mirrors() != self.inverted {
                    let corners: Vec<_> =
                        p.reals.chunks_exact(3).rev().flatten().copied().collect();
                    p.reals[..corners.len()].copy_from_slice(&corners);
                }
            }
            "sphere" | "bubble" => {
                point(p, 0);
                scale(p, 3);
            }
            "cylinder" | "tube" | "cone" | "cup" => {
                point(p, 0);
                point(p, 3);
                scale(p, 6);
            }
            "ring" => {
                point(p, 0);
                vector(p, 3);
                scale(p, 6);
                if self.inverted {
                    p.set_vector(3, -p.vector(3));
                }
            }
            "source" => vector(p, 0),
            "glow" => scale(p, 3),
            "spotlight" => vector(p, 4),
            // The words of other kinds end with the place of a function or the motion of a mesh.
            _ => {
                let has_place = kind(&p.kind).is_some_and(|kind| kind.has_words);
                let is_text = p.kind.ends_with("text");
                let is_named =
                    matches!(p.kind.as_str(), "illum" | "mirror" | "mist" | "antimatter");
                if has_place && !is_named && !is_text && sort != Some(Sort::Alias) {
                    // An earlier `-i` must not repeat this motion.
                    let apart = self.words.first().is_some_and(|word| word != "-i");
                    p.strings
                        .extend(apart.then(|| ["-i", "1"].map(String::from)).into_iter().flatten());
                    p.strings.extend(self.words.iter().cloned());
                }
            }
        }
        if self.inverted
            && let Some(inverse) = inside_out(&p.kind)
        {
            p.kind = inverse.to_owned();
        }
    }

    /// Moves a light without a surface, except its place: a small ball of the same radiance, larger or
    /// smaller.
    fn light(&self, light: &mut LightKind) {
        let turned = |v: glam::Vec3| self.motion.vector(v.as_dvec3()).normalize_or_zero().as_vec3();
        let area = (self.motion.scale() * self.motion.scale()) as f32;
        match light {
            LightKind::Point { intensity, .. } => *intensity *= area,
            LightKind::Spot { direction, intensity, .. } => {
                *direction = turned(*direction);
                *intensity *= area;
            }
            LightKind::Directional { direction, .. } => *direction = turned(*direction),
            LightKind::Profiled { direction, upright, intensity, .. } => {
                (*direction, *upright) = (turned(*direction), turned(*upright));
                *intensity *= area;
            }
        }
    }
}

/// The kind of surface whose front is the back of `kind`, if it has another name.
fn inside_out(kind: &str) -> Option<&'static str> {
    let pairs = [("sphere", "bubble"), ("cylinder", "tube"), ("cone", "cup")];
    pairs.into_iter().find_map(|(out, inwards)| match kind {
        _ if kind == out => Some(inwards),
        _ if kind == inwards => Some(out),
        _ => None,
    })
}
