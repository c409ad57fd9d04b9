//! The lights that a project names, and how their brightness is separated from reflectances.
//!
//! Lights twice as bright on surfaces that reflect half as much make nearly the same picture. So
//! wherever a light is unknown, something else must fix the scale, channel by channel: another
//! light, a known group, or an anchor. For a light of known colour only one factor is unknown.

use super::{Anchor, Project, some_names};
use crate::lighting::RawLight;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use unrender_formats::FileError;
use unrender_photo::Exposure;
use unrender_restage::Edit;
use unrender_restage::light::LightChange;
use unrender_scene::{Rgb, Scene, Source, Warnings};

/// The colour of an unknown light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightColor {
    /// This one, at any brightness.
    Stated(Rgb),
    /// That of the light of this name, which is known or has a stated colour.
    Of(String),
}

/// The colours of the lights in `list` that have one.
pub(super) fn colors(list: &[RawLight]) -> Result<BTreeMap<String, LightColor>, String> {
    let mut colors = BTreeMap::new();
    for raw in list {
        let name = &raw.name;
        let color = match (raw.color, &raw.same_color_as) {
            (None, None) => continue,
            (Some(color), None) => LightColor::Stated(color.0),
            (None, Some(other)) => LightColor::Of(other.clone()),
            (Some(_), Some(_)) => {
                return Err(format!("lights.{name}: give color or same_color_as, not both"));
            }
        };
        if raw.unknown != Some(true) && raw.is_photometric() && raw.same_color_as.is_none() {
            continue;
        }
        if raw.unknown != Some(true) {
            return Err(format!(
                "lights.{name}: color and same_color_as are for lights with unknown = true; \
                 strength states colour and brightness of a known one, and color belongs to lumens, \
                 candela, lux or a profile"
            ));
        }
        if color == LightColor::Stated(Rgb::ZERO) {
            return Err(format!("lights.{name}.color: a light cannot be black"));
        }
        colors.insert(name.clone(), color);
    }
    for (name, color) in &colors {
        let LightColor::Of(other) = color else { continue };
        let fault = |problem: &str| Err(format!("lights.{name}.same_color_as: {problem}"));
        if other == name {
            return fault("it names the light itself; name another");
        }
        let unknown = |raw: &RawLight| raw.name == *other && raw.unknown == Some(true);
        if list.iter().any(unknown) && !matches!(colors.get(other), Some(LightColor::Stated(_))) {
            return fault(&format!(
                "the colour of \"{other}\" is unknown too; give one of them its color, or name a \
                 known light"
            ));
        }
    }
    Ok(colors)
}

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

impl Project {
    /// Applies the lights and the environment of the project to `scene`.
    ///
    /// # Errors
    /// If a light does not exist, or exists already, or the panorama cannot be read.
    pub fn light(&self, scene: &mut Scene) -> Result<Warnings, FileError> {
        scene.up = self.up_axis;
        let edits: Vec<Edit> = self.light_edits.iter().cloned().map(Edit::Light).collect();
        let mut change = unrender_restage::apply(scene, &edits).map_err(|error| {
            let name = &self.light_edits[error.edit].name;
            FileError::new(&self.path, format!("lights.{name}: {}", error.problem))
        })?;
        let mut warnings = std::mem::take(&mut change.warnings);
        color_lights(self, scene).map_err(|problem| FileError::new(&self.path, problem))?;
        if let Some(choice) = &self.environment {
            let (environment, noted) = choice.read(self.limits)?;
            scene.environment = environment.map(|around| around.with_up(scene.up));
            warnings.extend(noted);
        }
        Ok(warnings)
    }

    /// Whether the lights of the project differ from the scene's in more than their brightness.
    pub(crate) fn rebuilds_lights(&self) -> bool {
        self.light_edits.iter().any(|edit| match &edit.change {
            LightChange::Alter(alter) => {
                let is_turned = alter.direction.is_some() || alter.turn_rad.is_some();
                alter.shift != Vec3::ZERO || is_turned || alter.profile.is_some()
            }
            LightChange::Add(..) | LightChange::Remove => true,
        })
    }

    /// The anchor, if anything needs it: an exposure or a light that is unknown.
    pub fn used_anchor(&self) -> Option<&Anchor> {
        let needed = self.exposure == Exposure::Auto || !self.unknown_lights.is_empty();
        self.anchor.as_ref().filter(|_| needed)
    }

    /// The indices of the unknown lights, ascending, as [`Source::index`] counts; the names must
    /// have passed [`Project::check_against`].
    pub fn unknown_sources(&self, scene: &Scene) -> Vec<usize> {
        let unknown = scene.sources().filter(|source| self.unknown_lights.contains(source.name));
        let around = scene.environment_parts();
        let parts =
            |index: usize| if index == around.start { around.clone() } else { index..index + 1 };
        unknown.flat_map(|source| parts(source.index)).collect()
    }

    /// Those of [`Project::unknown_sources`] whose colour the project states.
    pub fn coloured_sources(&self, scene: &Scene) -> Vec<usize> {
        let coloured = scene.sources().filter(|source| self.light_colors.contains_key(source.name));
        coloured.map(|source| source.index).collect()
    }

    /// Checks that light and reflectance can be separated in `scene`. Where exposure and all
    /// lights are unknown, brightness is only relative: the exposure becomes one, with a warning.
    ///
    /// # Errors
    /// If nothing fixes the scale, or an unknown light is black.
    pub fn settle_scale(&mut self, scene: &Scene) -> Result<Warnings, FileError> {
        settle_scale(self, scene).map_err(|problem| FileError::new(&self.path, problem))
    }
}

/// Gives lights the colours in `project`, at their brightness in `scene`.
fn color_lights(project: &Project, scene: &mut Scene) -> Result<(), String> {
    for (name, color) in &project.light_colors {
        let color = match color {
            LightColor::Stated(color) => *color,
            LightColor::Of(other) => match project.light_colors.get(other) {
                Some(LightColor::Stated(color)) => *color,
                _ => find(other, scene)?.strength,
            },
        };
        if color.max_element() <= 0.0 {
            return Err(format!("lights.{name}.same_color_as: that light is black"));
        }
        let source = find(name, scene)?;
        let (index, brightness) = (source.index, source.strength.element_sum());
        if let Some(strength) = scene.strength_mut(index) {
            *strength = color * (brightness / color.element_sum());
        }
    }
    Ok(())
}

/// Checks that the lights in `project` are lights of `scene`.
pub(super) fn check(project: &Project, scene: &Scene) -> Result<(), String> {
    for name in project.known_lights.iter().chain(&project.unknown_lights) {
        find(name, scene)?;
    }
    for taken in project.photographs() {
        let (key, names) = taken.switched.stated();
        for name in names {
            let fault = |problem: String| format!("{key}, in {}: {problem}", taken.photo.display());
            find(name, scene).map_err(fault)?;
        }
    }
    Ok(())
}

/// The source called `name`.
fn find<'a>(name: &str, scene: &'a Scene) -> Result<Source<'a>, String> {
    let mut of_this_name = scene.sources().filter(|source| source.name == name);
    let found = of_this_name.next();
    let others = of_this_name.count();
    if others > 0 {
        let count = others + 1;
        return Err(format!(
            "lights.{name}: the scene has {count} lights of this name; give each its own"
        ));
    }
    found.ok_or_else(|| {
        let there = some_names(scene.sources().map(|source| source.name));
        let dark = match scene.group_index(name) {
            Some(_) => "; the group of this name emits nothing: give it an emission",
            None => "",
        };
        format!("lights.{name}: the scene has no light \"{name}\"; it has {there}{dark}")
    })
}

fn settle_scale(project: &mut Project, scene: &Scene) -> Result<Warnings, String> {
    let mut warnings = Warnings::default();
    for name in &project.unknown_lights {
        warnings.extend(dark_channels(&find(name, scene)?)?);
    }
    let is_unknown = |source: &Source| project.unknown_lights.contains(source.name);
    // When an area light is removed, its group is left.
    let removed = project.light_edits.iter().filter(|edit| edit.change == LightChange::Remove);
    let removed: Vec<&str> = removed.map(|edit| edit.name.as_str()).collect();
    let sources = || scene.sources().filter(|source| !removed.contains(&source.name));
    let lit = channels(sources().map(|source| source.strength));
    let known = channels(sources().filter(|source| !is_unknown(source)).map(|s| s.strength));
    // The channels in which only unknown lights shine.
    let open: [bool; 3] = std::array::from_fn(|c| lit[c] && !known[c]);
    if open == [false; 3] {
        return Ok(warnings);
    }
    if project.exposure == Exposure::Auto {
        if open != lit {
            return Err(format!(
                "{}every light is unknown, and so is the exposure: one common factor cannot be \
                 determined. Give the exposure, or one light's intensity",
                in_channels(open, lit)
            ));
        }
        project.exposure = Exposure::Fixed(Rgb::ONE);
        warnings.push(
            "the exposure and every light are unknown, so intensities are only relative: the \
             exposure was taken as 1, and the lights' numbers are per unit of exposure",
        );
    } else if project.anchor.is_none() {
        // Ignored groups fix nothing.
        let known = project.known.iter().filter(|(name, _)| !project.ignored.contains(*name));
        let known = known.filter(|(name, _)| reflects(scene, name));
        let reflecting = channels(known.map(|(_, known)| known.reflecting()));
        let loose: [bool; 3] = std::array::from_fn(|c| open[c] && !reflecting[c]);
        // If all colours are known, a known channel fixes all.
        let mut unknown = project.unknown_lights.iter();
        let is_tied = unknown.all(|name| project.light_colors.contains_key(name));
        let is_fixed = (0..3).any(|c| lit[c] && !loose[c]);
        if loose != [false; 3] && !(is_tied && is_fixed) {
            return Err(format!(
                "{}every light is unknown and no reflectance is known: light and reflectance can \
                 be separated only up to one common factor. Give an [anchor], a known group, or \
                 one light's intensity",
                in_channels(loose, lit)
            ));
        }
    }
    Ok(warnings)
}

/// The brightness of a light is estimated as a multiple of the scene's: zero stays zero.
fn dark_channels(source: &Source) -> Result<Warnings, String> {
    let mut warnings = Warnings::default();
    let dark = source.strength.to_array().map(|strength| strength <= 0.0);
    let name = source.name;
    if dark == [true; 3] {
        return Err(format!(
            "lights.{name}: the light is black in the scene; give it any intensity there"
        ));
    }
    if dark != [false; 3] {
        warnings.push(format!(
            "the unknown light \"{name}\" has no {} in the scene, so none is recovered",
            names_of(dark)
        ));
    }
    Ok(warnings)
}

/// True for groups that show their reflectance and not their own light.
fn reflects(scene: &Scene, group: &str) -> bool {
    scene.group_index(group).is_some_and(|index| !scene.groups[index].is_emitter())
}

/// The channels in which some value is positive.
fn channels(values: impl Iterator<Item = Rgb>) -> [bool; 3] {
    values.fold(Rgb::ZERO, Rgb::max).to_array().map(|value| value > 0.0)
}

/// The beginning of a sentence about `some` of the channels in which there is light.
fn in_channels(some: [bool; 3], lit: [bool; 3]) -> String {
    if some == lit { String::new() } else { format!("in {} ", names_of(some)) }
}

fn names_of(channels: [bool; 3]) -> String {
    let names = CHANNELS.iter().zip(channels).filter(|(_, is)| *is).map(|(name, _)| *name);
    names.collect::<Vec<_>>().join(" and ")
}
