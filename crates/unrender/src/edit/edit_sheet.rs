//! One edit file, or one flag that stands for a line of it.

use super::raw::RawEdits;
use super::written::{self, Written};
use crate::{Error, text_file};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_formats::{FileError, LightUnits, Limits};
use unrender_scene::Scene;

/// Edits as they are written, with the name of their place in messages.
#[derive(Debug)]
pub struct EditSheet {
    /// Their file or flag.
    pub(super) written: Written,
    pub(super) raw: RawEdits,
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

    /// Whether more may follow the name after a colon.
    fn has_body(self) -> bool {
        matches!(self, Self::Repaint | Self::Light | Self::Insert | Self::Environment)
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
        Ok(Self { written: Written::of_file(path, text), raw })
    }

    /// The edit of a flag with this value.
    ///
    /// # Errors
    /// If the value is not of the flag's form.
    pub fn of_flag(flag: Flag, value: &str) -> Result<Self, Error> {
        let (written, head, tail) = flag.forms();
        let is_on = |word: &str| word.trim().eq_ignore_ascii_case("on");
        let is_off = |word: &str| word.trim().eq_ignore_ascii_case("off");
        let is_switch = |word: &str| flag == Flag::Light && (is_on(word) || is_off(word));
        let (name, body) = match value.split_once(": ").filter(|_| flag.has_body()) {
            Some((name, word)) if is_switch(word) => (name, format!(", on = {}", is_on(word))),
            Some((name, body)) => (name, format!(", {body}")),
            None => (value, String::new()),
        };
        let text = format!("{head}{}{body}{tail}", toml::Value::String(name.trim().to_owned()));
        let name = format!("{written} '{value}'");
        let raw = toml::from_str(&text)
            .map_err(|error| Error::Request(format!("{name}: {}", error.message())))?;
        Ok(Self { written: Written::of_flag(name), raw })
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
        let named = stated.chain(inserted).chain(around).chain(painted);
        named.map(|path| self.written.path(path)).chain(self.written.file()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            sheet.raw.lights[0].get_ref().edit()
        };
        assert_eq!(of_light("off").unwrap(), of_light("scale = 0").unwrap());
        assert_eq!(of_light("on").unwrap(), of_light("scale = 1").unwrap());
        assert!(of_light("on = false, strength = 3").is_err());
        assert!(
            of_light("on = true, add = \"point\", position = [0, 0, 0], strength = 3").is_err()
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
