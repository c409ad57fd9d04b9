//! The tables `[[lights]]` and `[environment]`, which project files and edit files share.
//!
//! A light is added, changed or removed by its name; an environment is a panorama, or the same
//! radiance from everywhere. [`restage`](crate::restage) makes the change in the scene.

use crate::toml_values::{Channels, Direction, Finite, NotNegative, Place, Positive, Size, Way};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use unrender_formats::Input;
use unrender_formats::{FileError, Limits, ies, picture};
use unrender_restage::light::{
    Alter, LightChange, LightEdit, NewLight, Photometric, PhotometricUnit,
};
use unrender_scene::{Environment, LightKind, LightProfile, Rgb, RgbImage, Warnings};

/// Columns and rows of an unknown environment: 45 degrees per part, as fine as diffuse surfaces can show
/// [Ramamoorthi and Hanrahan 2001]. At half of it, light from a window comes from a quarter of the sphere; double
/// of it takes four times the derivatives for details that only sharp lobes show.
const PARTS: [usize; 2] = [8, 4];

/// One entry of `[[lights]]` as in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLight {
    pub(crate) name: String,
    /// Only in project files: whether the brightness is unknown.
    pub(crate) unknown: Option<bool>,
    /// Only in project files: the colour of an unknown light.
    #[serde(alias = "colour")]
    pub(crate) color: Option<Channels>,
    /// Only in project files: another light of the same colour.
    #[serde(alias = "same_colour_as")]
    pub(crate) same_color_as: Option<String>,
    add: Option<Kind>,
    #[serde(default)]
    pub(crate) remove: bool,
    /// Whether it shines.
    pub(crate) on: Option<bool>,
    scale: Option<Channels>,
    strength: Option<Channels>,
    #[serde(rename = "move")]
    shift: Option<Way>,
    position: Option<Place>,
    direction: Option<Direction>,
    size: Option<Size>,
    radius: Option<Positive>,
    inner_deg: Option<NotNegative>,
    outer_deg: Option<NotNegative>,
    /// The IES file that the lamp shines by.
    pub(crate) profile: Option<PathBuf>,
    /// Rotation about the axis of its profile.
    turn_deg: Option<Finite>,
    lumens: Option<Positive>,
    candela: Option<Positive>,
    lux: Option<Positive>,
}

/// The kinds of lights that can be added.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Area,
    Sphere,
    Point,
    Spot,
    Directional,
}

/// The table `[environment]` as in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawEnvironment {
    #[serde(alias = "panorama")]
    pub(crate) file: Option<PathBuf>,
    #[serde(alias = "colour")]
    color: Option<Channels>,
    #[serde(default)]
    remove: bool,
    rotation_deg: Option<Finite>,
    scale: Option<Positive>,
    /// Only in project files: whether the brightness is unknown.
    pub(crate) unknown: Option<RawUnknown>,
}

/// What is unknown of an environment, as in TOML.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(untagged, expecting = "unknown is true, false or \"uniform\"")]
pub(crate) enum RawUnknown {
    /// Whether its radiance is unknown, direction by direction.
    Whether(bool),
    /// Its radiance is unknown, and the same from everywhere.
    As(UnknownAs),
}

/// Other forms of an unknown environment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum UnknownAs {
    /// One radiance from everywhere.
    Uniform,
}

/// The environment that a file states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EnvironmentChoice {
    /// A panorama.
    Panorama {
        /// Its file.
        file: PathBuf,
        /// Its rotation about +y, counter-clockwise seen from above.
        rotation_rad: f32,
        /// The factor on its radiance.
        scale: f32,
    },
    /// The same radiance from everywhere, W sr^-1 m^-2.
    Uniform(Rgb),
    /// An unknown one, whose radiance changes slowly with direction, or not at all.
    Unknown {
        /// Whether it is the same from everywhere.
        is_uniform: bool,
    },
    /// None.
    Nothing,
}

impl RawLight {
    /// The edit of the scene by this entry, its profile read; `place` makes a path absolute. Warnings go to `warnings`.
    ///
    /// # Errors
    /// If its keys do not go together, or its profile cannot be read; the message is without the place.
    pub(crate) fn edit(
        &self,
        place: &dyn Fn(&Path) -> PathBuf,
        limits: Limits,
        warnings: &mut Warnings,
    ) -> Result<LightEdit, String> {
        let profile = self.profile.as_ref().map(|file| {
            let (profile, told) =
                ies::read(Input::new(&place(file), limits)).map_err(|e| e.to_string())?;
            let name = &self.name;
            told.0.into_iter().for_each(|told| warnings.push(format!("light \"{name}\": {told}")));
            Ok::<_, String>(profile)
        });
        let profile = profile.transpose()?;
        let photometric = self.photometric(profile.as_ref())?;
        let change = match (self.add, self.remove) {
            (Some(kind), false) => LightChange::Add(
                self.new_light(kind, profile)?,
                self.position.map_or(DVec3::ZERO, |at| at.0),
            ),
            (None, true) => LightChange::Remove,
            (Some(_), true) => return Err("a light is added or removed, not both".into()),
            (None, false) => LightChange::Alter(self.alter(profile)?),
        };
        Ok(LightEdit { name: self.name.clone(), change, photometric })
    }

    /// Whether its brightness is stated in photometric units, of which its strength follows.
    pub(crate) fn is_photometric(&self) -> bool {
        let units = [self.lumens, self.candela, self.lux];
        self.strength.is_none() && (units.iter().any(Option::is_some) || self.profile.is_some())
    }

    /// Its brightness in photometric units: as stated, or else that of its profile.
    fn photometric(&self, profile: Option<&LightProfile>) -> Result<Option<Photometric>, String> {
        let units = [
            (PhotometricUnit::Lumens, self.lumens),
            (PhotometricUnit::Candela, self.candela),
            (PhotometricUnit::Lux, self.lux),
        ];
        let stated =
            units.into_iter().filter_map(|(unit, value)| Some((unit, f64::from(value?.0))));
        let mut stated: Vec<(PhotometricUnit, f64)> = stated.collect();
        if stated.len() + usize::from(self.strength.is_some()) > 1 {
            return Err("give one of strength, lumens, candela and lux".into());
        }
        let is_dark = self.remove || self.on == Some(false);
        if is_dark && (!stated.is_empty() || profile.is_some()) {
            return Err(
                "a light that is off or removed has no brightness and no profile; leave them out"
                    .into(),
            );
        }
        if stated.is_empty() && self.strength.is_none() {
            stated
                .extend(profile.map(|profile| (PhotometricUnit::Candela, profile.peak_candela())));
        }
        let scale = self.factor();
        Ok(stated.pop().map(|(unit, value)| Photometric { unit, value, scale }))
    }

    fn alter(&self, profile: Option<LightProfile>) -> Result<Alter, String> {
        if self.position.is_some() {
            return Err(
                "move = [x, y, z] moves an existing light by this vector; to add one, state \
            add = \"point\" or another kind"
                    .into(),
            );
        }
        let is_new = [self.inner_deg.is_some(), self.outer_deg.is_some(), self.size.is_some()];
        if is_new.contains(&true) || self.radius.is_some() {
            return Err(
                "size, radius, inner_deg and outer_deg are for lights that are added".into()
            );
        }
        let is_off = self.on == Some(false);
        if is_off && (self.scale.is_some() || self.strength.is_some()) {
            return Err("a light that is off has no scale and no strength; leave them out".into());
        }
        let color = self.color.filter(|_| self.is_photometric()).map(|color| color.0);
        let scale = if self.is_photometric() { Rgb::ONE } else { self.factor() };
        Ok(Alter {
            scale: if is_off { Rgb::ZERO } else { scale },
            strength: self.strength.map(|strength| strength.0).or(color),
            shift: self.shift.map_or(Vec3::ZERO, |shift| shift.0),
            direction: self.direction.map(|direction| direction.0),
            profile,
            turn_rad: self.turn_deg.map(|angle| angle.0.to_radians()),
        })
    }

    fn factor(&self) -> Rgb {
        self.scale.map_or(Rgb::ONE, |scale| scale.0)
    }

    /// The light, at zero: its place is known in double precision.
    fn new_light(&self, kind: Kind, profile: Option<LightProfile>) -> Result<NewLight, String> {
        let strength = if self.is_photometric() {
            self.color.map_or(Rgb::ONE, |color| color.0)
        } else {
            let stated = self.strength.ok_or(
                "a light that is added needs a strength, or its lumens, candela, lux or a profile",
            )?;
            stated.0 * self.factor()
        };
        if !strength.is_finite() {
            return Err("strength times scale is not a finite number".into());
        }
        let position =
            self.position.map(|_| Vec3::ZERO).ok_or("a light that is added needs a position");
        let direction =
            self.direction.ok_or("this kind of light needs a direction in which it shines");
        if self.shift.is_some() {
            return Err("a light that is added has a position; move is for existing lights".into());
        }
        if self.on.is_some() {
            return Err("a light that is added is on; on is for existing lights".into());
        }
        if let Some(profile) = profile {
            return self.new_profiled(kind, strength, profile);
        }
        if self.turn_deg.is_some() {
            return Err(
                "turn_deg turns a lamp about the axis of its profile; give profile = \"lamp.ies\""
                    .into(),
            );
        }
        Ok(match kind {
            Kind::Point => {
                NewLight::Punctual(LightKind::Point { position: position?, intensity: strength })
            }
            Kind::Directional => NewLight::Punctual(LightKind::Directional {
                direction: direction?.0,
                irradiance: strength,
            }),
            Kind::Spot => {
                let (inner_rad, outer_rad) = self.cone()?;
                NewLight::Punctual(LightKind::Spot {
                    position: position?,
                    direction: direction?.0,
                    intensity: strength,
                    inner_rad,
                    outer_rad,
                })
            }
            Kind::Area => {
                let size = self.size.ok_or("an area light needs its two sides, size = [1.0, 0.5]");
                let size = size?.0;
                if size.min_element() <= 0.0 {
                    return Err("both sides of an area light are above zero".into());
                }
                let (centre, normal) = (position?, direction?.0);
                NewLight::Area { centre, normal, size, radiance: strength }
            }
            Kind::Sphere => {
                let radius = self.radius.ok_or("a sphere needs its radius = 0.05")?.0;
                NewLight::Sphere { centre: position?, radius, radiance: strength }
            }
        })
    }

    /// A lamp with a profile, at zero.
    fn new_profiled(
        &self,
        kind: Kind,
        intensity: Rgb,
        profile: LightProfile,
    ) -> Result<NewLight, String> {
        if kind != Kind::Point || self.inner_deg.is_some() || self.outer_deg.is_some() {
            return Err(
                "a lamp with a profile is added as a point: add = \"point\"; direction aims it, and its cone is that of \
                 the profile"
                    .into(),
            );
        }
        if self.position.is_none() {
            return Err("a light that is added needs a position".into());
        }
        Ok(NewLight::Profiled {
            position: Vec3::ZERO,
            direction: self.direction.map(|direction| direction.0),
            turn_rad: self.turn_deg.map_or(0.0, |angle| angle.0.to_radians()),
            intensity,
            profile,
        })
    }

    /// Half the angles of a spot's cone, radians: where it begins to fade, and where it ends.
    fn cone(&self) -> Result<(f32, f32), String> {
        let outer_deg = self.outer_deg.map_or(45.0, |angle| angle.0);
        let inner_deg = self.inner_deg.map_or(0.0, |angle| angle.0);
        if !(inner_deg < outer_deg && outer_deg <= 90.0) {
            return Err("inner_deg is below outer_deg, which is at most 90".into());
        }
        Ok((inner_deg.to_radians(), outer_deg.to_radians()))
    }
}

impl RawEnvironment {
    /// Whether its brightness is unknown.
    pub(crate) fn is_unknown(&self) -> bool {
        self.unknown.is_some_and(|unknown| unknown != RawUnknown::Whether(false))
    }

    /// The environment that the table of an edit states, its panorama read; `place` makes a path absolute.
    ///
    /// # Errors
    /// If it is unknown, its keys do not go together, or its panorama cannot be read.
    pub(crate) fn stated(
        &self,
        place: &dyn Fn(&Path) -> PathBuf,
        limits: Limits,
    ) -> Result<(Option<Environment>, Warnings), String> {
        if self.unknown.is_some() {
            return Err(
                "environment: unknown is a key of project files only; state the environment".into(),
            );
        }
        self.choice(place)?.read(limits).map_err(|error| error.to_string())
    }

    /// The environment of the table; `place` makes a path absolute.
    ///
    /// # Errors
    /// If its keys do not go together.
    pub(crate) fn choice(
        &self,
        place: &dyn Fn(&Path) -> PathBuf,
    ) -> Result<EnvironmentChoice, String> {
        let is_unknown = self.is_unknown();
        match (&self.file, self.color, self.remove) {
            (_, _, true) if is_unknown => {
                Err("environment: it is unknown or removed, not both".into())
            }
            (Some(file), None, false) => Ok(EnvironmentChoice::Panorama {
                file: place(file),
                rotation_rad: self.rotation_deg.map_or(0.0, |angle| angle.0.to_radians()),
                scale: self.scale.map_or(1.0, |scale| scale.0),
            }),
            _ if self.rotation_deg.is_some() || self.scale.is_some() => {
                Err("environment: rotation_deg and scale are for a panorama only".into())
            }
            (None, Some(color), false) => Ok(EnvironmentChoice::Uniform(color.0)),
            (None, None, true) => Ok(EnvironmentChoice::Nothing),
            (None, None, false) if is_unknown => Ok(EnvironmentChoice::Unknown {
                is_uniform: self.unknown == Some(RawUnknown::As(UnknownAs::Uniform)),
            }),
            _ => Err("environment: give one of file (a panorama), color (the same from \
            everywhere), unknown = true (in a project), and remove = true"
                .into()),
        }
    }
}

impl EnvironmentChoice {
    /// The file that it names.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Panorama { file, .. } => Some(file),
            Self::Uniform(_) | Self::Unknown { .. } | Self::Nothing => None,
        }
    }

    /// A description for readers of results; none if there is no environment.
    pub(crate) fn in_words(&self) -> Option<String> {
        match self {
            Self::Panorama { file, .. } => Some(file.display().to_string()),
            Self::Uniform(color) => {
                let [r, g, b] = color.to_array();
                Some(format!("[{r}, {g}, {b}] from everywhere"))
            }
            Self::Unknown { is_uniform: true } => Some("the same from everywhere, unknown".into()),
            Self::Unknown { is_uniform: false } => Some("unknown".into()),
            Self::Nothing => None,
        }
    }

    /// The environment, its panorama read; a radiance of one if it is unknown.
    ///
    /// # Errors
    /// If the panorama cannot be read, or is not a valid radiance.
    pub fn read(&self, limits: Limits) -> Result<(Option<Environment>, Warnings), FileError> {
        match self {
            Self::Panorama { file, rotation_rad, scale } => {
                let input = Input::new(file, limits);
                let (environment, warnings) =
                    picture::read_environment(input, *rotation_rad, *scale)?;
                Ok((Some(environment), warnings))
            }
            Self::Uniform(radiance) => Ok((uniform(*radiance), Warnings::default())),
            Self::Unknown { is_uniform: true } => Ok((uniform(Rgb::ONE), Warnings::default())),
            Self::Unknown { is_uniform: false } => {
                let [columns, rows] = PARTS;
                let panorama = RgbImage::from_fn(columns, rows, |_, _| Rgb::ONE);
                let environment = Environment::new(panorama, 0.0).ok();
                Ok((environment.map(Environment::in_parts), Warnings::default()))
            }
            Self::Nothing => Ok((None, Warnings::default())),
        }
    }
}

/// The same `radiance` from everywhere, which is finite and not negative: a panorama of one pixel.
pub(crate) fn uniform(radiance: Rgb) -> Option<Environment> {
    Environment::new(RgbImage::new(1, 1, vec![radiance]), 0.0).ok()
}
