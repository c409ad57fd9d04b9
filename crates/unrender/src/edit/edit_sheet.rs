//! One edit file, or one flag that stands for a line of it.

use super::raw::RawEdits;
use super::written::{self, Written};
use crate::{Error, text_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_formats::{FileError, LightUnits, Limits};
use unrender_scene::{Environment, Scene, Warnings};

/// Edits as they are written, with the name of their place in messages.
#[derive(Debug)]
pub struct EditSheet {
    /// Their file or flag.
    pub(super) written: Written,
    pub(super) raw: RawEdits,
    /// The flag and its value, if it is one.
    flag: Option<(Flag, String)>,
}

/// The flags that stand for one edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// `--remove NAME`
    Remove,
    /// `--repaint 'GROUP: rho_d = [0.5, 0.1, 0.1]'`
    Repaint,
    /// `--light 'NAME: scale = 0.5'`, `--light 'NAME: off'`
    Light,
    /// `--insert 'FILE: on = "floor", at = [0, 1]'`
    Insert,
    /// `--environment 'FILE: rotation_deg = 90'`
    Environment,
    /// `--camera NAME`
    Camera,
    /// `--recovered DIR`
    Recovered,
    /// `--project FILE`
    Project,
    /// `--scene FILE`
    Scene,
    /// `--materials FILE`
    Materials,
}

impl Flag {
    /// The flag, and the text for it in an edit file before its value and after the rest.
    fn forms(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Remove => ("--remove", "remove = [{ name = ", "}]"),
            Self::Repaint => ("--repaint", "repaint = [{ group = ", "}]"),
            Self::Light => ("--light", "lights = [{ name = ", "}]"),
            Self::Insert => ("--insert", "insert = [{ file = ", "}]"),
            Self::Environment => ("--environment", "environment = { file = ", "}"),
            Self::Camera => ("--camera", "camera = ", ""),
            Self::Recovered => ("--recovered", "recovered = ", ""),
            Self::Project => ("--project", "project = ", ""),
            Self::Scene => ("--scene", "scene = ", ""),
            Self::Materials => ("--materials", "materials = ", ""),
        }
    }

    /// An edit of the part or file called `name`, as it may be written; none where nothing follows the name.
    fn example(self, name: &str) -> Option<String> {
        let body = match self {
            Self::Repaint => "rho_d = [0.6, 0.1, 0.1]",
            Self::Light => "scale = 0.5",
            Self::Insert => "at = [0, 0, 0]",
            Self::Environment => "scale = 0.5",
            _ => return None,
        };
        Some(format!("{} '{name}: {body}'", self.forms().0))
    }

    /// Whether more may follow the name after a colon.
    fn has_body(self) -> bool {
        matches!(self, Self::Repaint | Self::Light | Self::Insert | Self::Environment)
    }

    /// Whether its value begins with the name of something in the scene.
    fn names_a_part(self) -> bool {
        matches!(self, Self::Remove | Self::Repaint | Self::Light)
    }

    /// The edit of the part or file called `name`, with the `body` that follows the colon.
    fn edit(self, name: &str, body: Option<&str>) -> Result<RawEdits, toml::de::Error> {
        let (_, head, tail) = self.forms();
        let is_on = |word: &str| word.trim().eq_ignore_ascii_case("on");
        let is_off = |word: &str| word.trim().eq_ignore_ascii_case("off");
        let is_switch = |word: &str| self == Self::Light && (is_on(word) || is_off(word));
        let body = match body {
            Some(word) if is_switch(word) => format!(", on = {}", is_on(word)),
            Some(body) => format!(", {body}"),
            None => String::new(),
        };
        toml::from_str(&format!("{head}{}{body}{tail}", toml::Value::String(name.to_owned())))
    }
}

impl EditSheet {
    /// Reads the edit file at `path`.
    ///
    /// # Errors
    /// If it is missing, is not TOML, has an unknown key or an invalid value.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = text_file::read(path, text_file::Expected::Edit)?;
        let raw = toml::from_str(&text).map_err(|error| {
            FileError::new(path, written::with_line(&text, error.span(), error.message()))
        })?;
        Ok(Self { written: Written::of_file(path, text), raw, flag: None })
    }

    /// The edit of a flag with this value. Where the value has several colons, its name ends at the first one that leaves
    /// an edit; once the scene is read, its names tell better.
    ///
    /// # Errors
    /// If the value is not of the flag's form.
    pub fn of_flag(flag: Flag, value: &str) -> Result<Self, Error> {
        let (written, ..) = flag.forms();
        let place = format!("{written} '{value}'");
        let split = |(at, _): (usize, &str)| (&value[..at], Some(&value[at + 2..]));
        let colons = value.match_indices(": ").filter(|_| flag.has_body()).map(split);
        let mut splits: Vec<_> = colons.collect();
        if splits.is_empty() {
            splits.push((value, None));
        }
        let read = |(name, body): &(&str, Option<&str>)| flag.edit(name.trim(), *body);
        let raw = splits.iter().find_map(|split| read(split).ok());
        let raw = raw.map_or_else(|| read(&splits[0]), Ok).map_err(|error| {
            let (name, body) = splits[0];
            let read_as = body.map(|body| {
                let name = name.trim();
                let example = flag.example(name).unwrap_or_default();
                format!(" (taken as \"{name}\", and `{body}` as its edit; write, for instance, {example})")
            });
            Error::Request(format!("{place}: {}{}", error.message(), read_as.unwrap_or_default()))
        })?;
        let written = Written::of_flag(place);
        Ok(Self { written, raw, flag: Some((flag, value.to_owned())) })
    }

    /// The same, with the longest name of `scene` that the value of its flag begins with, if there is one: names may hold
    /// colons, and begin or end with blanks.
    ///
    /// # Errors
    /// If what follows that name is no edit.
    pub(super) fn with_names_of(mut self, scene: &Scene) -> Result<Self, Error> {
        let Some((flag, value)) = self.flag.as_ref().filter(|(flag, _)| flag.names_a_part()) else {
            return Ok(self);
        };
        let groups = scene.groups.iter().map(|group| &group.name);
        let objects = scene.objects.iter().map(|object| &object.name);
        let names = groups.chain(objects).chain(scene.lights.iter().map(|light| &light.name));
        let rest = |name: &'_ String| {
            let rest = value.strip_prefix(name.as_str())?;
            let body = rest.trim_start().strip_prefix(':').filter(|_| flag.has_body());
            (rest.is_empty() || body.is_some()).then_some((name.clone(), body))
        };
        let longest = names.filter_map(rest).max_by_key(|(name, _)| name.len());
        if let Some((name, body)) = longest {
            self.raw = flag.edit(&name, body).map_err(|error| {
                let place = self.written.place(0..0);
                Error::Request(format!("{place}: {}", error.message()))
            })?;
        }
        Ok(self)
    }

    /// The same, with limits of reading its files.
    pub fn within(mut self, limits: Limits) -> Self {
        self.written.limits = limits;
        self
    }

    /// The same, with these units of the scene's lights, if they are stated.
    pub fn in_light_units(mut self, light_units: Option<LightUnits>) -> Self {
        self.written.light_units = light_units;
        self
    }

    /// The same, with a scene in memory, if any, instead of the file that `scene` names.
    pub fn with_scene(mut self, scene: Option<Arc<Scene>>) -> Self {
        self.written.scene = scene;
        self
    }

    /// The environment that it states, and warnings of its panorama; none if it states none.
    ///
    /// # Errors
    /// If its keys do not go together, or its panorama cannot be read.
    pub(crate) fn environment(&self) -> Result<(Option<Environment>, Warnings), Error> {
        let Some(raw) = &self.raw.environment else { return Ok((None, Warnings::default())) };
        let read = raw.get_ref().stated(&|file| self.written.path(file), self.written.limits);
        let place = self.written.place(raw.span());
        read.map_err(|problem| Error::Request(format!("{place}: {problem}")))
    }

    /// The files that it names, and itself.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let raw = &self.raw;
        let stated = [&raw.recovered, &raw.project, &raw.scene, &raw.materials];
        let stated = stated.into_iter().flatten().map(|path| path.get_ref());
        let inserted = raw.insert.iter().map(|insert| &insert.get_ref().file);
        let around = raw.environment.iter().filter_map(|e| e.get_ref().file.as_ref());
        let materials = raw.insert.iter().flat_map(|insert| &insert.get_ref().material);
        let painted = raw.repaint.iter().map(|repaint| repaint.get_ref()).chain(materials);
        let painted = painted.filter_map(|paint| paint.texture.as_ref());
        let profiles = raw.lights.iter().filter_map(|light| light.get_ref().profile.as_ref());
        let named = stated.chain(inserted).chain(around).chain(painted).chain(profiles);
        named.map(|path| self.written.path(path)).chain(self.written.file()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Light, Rgb, Warnings};

    #[test]
    fn lights_are_switched_by_one_word() {
        for (word, is_on) in [("on", true), ("off", false), ("OFF", false), (" On ", true)] {
            let sheet = EditSheet::of_flag(Flag::Light, &format!("bulb: {word}")).unwrap();
            let light = sheet.raw.lights[0].get_ref();
            assert_eq!((light.name.as_str(), light.on), ("bulb", Some(is_on)));
        }
        // Only lights are, and only in edit files.
        assert!(EditSheet::of_flag(Flag::Repaint, "floor: off").is_err());
        let of_light = |body: &str| {
            let sheet = EditSheet::of_flag(Flag::Light, &format!("bulb: {body}")).unwrap();
            let light = sheet.raw.lights[0].get_ref();
            light.edit(&Path::to_path_buf, Limits::default(), &mut Warnings::default())
        };
        assert_eq!(of_light("off").unwrap(), of_light("scale = 0").unwrap());
        assert_eq!(of_light("on").unwrap(), of_light("scale = 1").unwrap());
        assert!(of_light("on = false, strength = 3").is_err());
        assert!(
            of_light("on = true, add = \"point\", position = [0, 0, 0], strength = 3").is_err()
        );
    }

    /// The names of lights, each in a flag of its own, after a look at a scene with lights of these names.
    fn named(names: &[&str], value: &str) -> String {
        let kind =
            unrender_scene::LightKind::Point { position: glam::Vec3::ZERO, intensity: Rgb::ONE };
        let light = |name: &&str| Light { name: (*name).to_owned(), kind: kind.clone() };
        let scene = Scene { lights: names.iter().map(light).collect(), ..Scene::default() };
        let sheet = EditSheet::of_flag(Flag::Light, value).unwrap().with_names_of(&scene).unwrap();
        sheet.raw.lights[0].get_ref().name.clone()
    }

    #[test]
    fn the_longest_name_of_the_scene_is_meant() {
        let names = ["Lamp", "Lamp: ceiling=1.001", " lead ", "Lamp: off", "sun: key.001"];
        assert_eq!(named(&names, "Lamp: ceiling=1.001: scale = 0.5"), names[1]);
        assert_eq!(named(&names, "Lamp: scale = 0.5"), names[0]);
        assert_eq!(named(&names, " lead : off"), names[2]);
        assert_eq!(named(&names, "Lamp: off: on"), names[3]);
        assert_eq!(named(&names, "sun: key.001: scale = 0.5"), names[4]);
        // Without such a name: what leaves an edit.
        assert_eq!(named(&[], "Lamp: ceiling=1.001: scale = 0.5"), names[1]);
        assert_eq!(named(&[], " lead : off"), "lead");
    }

    #[test]
    fn what_a_flag_was_taken_for_is_said_where_it_is_no_edit() {
        let error = EditSheet::of_flag(Flag::Repaint, "Floor: oak: rho = [1, 1]").unwrap_err();
        let error = error.to_string();
        assert!(
            error.contains(
                "(taken as \"Floor\", and `oak: rho = [1, 1]` as its edit; write, for instance, --repaint 'Floor: rho_d ="
            ),
            "{error}"
        );
    }

    #[test]
    fn flags_are_lines_of_the_file() {
        let sheet =
            EditSheet::of_flag(Flag::Repaint, "my \"floor\": rho_d = [0.5, 0.1, 0], alpha = 0.1");
        let repaint = &sheet.unwrap().raw.repaint[0];
        assert_eq!(repaint.get_ref().group.as_deref(), Some("my \"floor\""));
        assert_eq!(repaint.get_ref().rho_d.unwrap().0.to_array(), [0.5, 0.1, 0.0]);
        let error = EditSheet::of_flag(Flag::Light, "lamp: scale = -1").unwrap_err().to_string();
        assert!(
            error.contains("--light 'lamp: scale = -1'") && error.contains("negative"),
            "{error}"
        );
        assert_eq!(
            EditSheet::of_flag(Flag::Remove, "a: b").unwrap().raw.remove[0]
                .get_ref()
                .name
                .as_deref(),
            Some("a: b")
        );
    }
}
