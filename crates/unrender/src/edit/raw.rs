//! The edit file as TOML has it. Values are checked where they are read, so that an error has the
//! line of the value; names are checked against the scene later.

use glam::{Vec2, Vec3};
use serde::Deserialize;
use std::path::PathBuf;
use toml::{Spanned, Value};
use unrender_scene::Rgb;

/// All keys of an edit file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEdits {
    pub(super) recovered: Option<Spanned<PathBuf>>,
    pub(super) project: Option<Spanned<PathBuf>>,
    pub(super) scene: Option<Spanned<PathBuf>>,
    pub(super) materials: Option<Spanned<PathBuf>>,
    pub(super) camera: Option<Spanned<Value>>,
    pub(super) environment: Option<Spanned<RawEnvironment>>,
    #[serde(default)]
    pub(super) remove: Vec<Spanned<RawRemove>>,
    #[serde(default)]
    pub(super) repaint: Vec<Spanned<RawRepaint>>,
    #[serde(default)]
    pub(super) lights: Vec<Spanned<RawLight>>,
    #[serde(default)]
    pub(super) insert: Vec<Spanned<RawInsert>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRemove {
    pub(super) name: Option<String>,
    pub(super) object: Option<String>,
    pub(super) group: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRepaint {
    pub(super) group: String,
    pub(super) rho_d: Option<Reflectance>,
    pub(super) rho_s: Option<Reflectance>,
    pub(super) alpha: Option<NotNegative>,
    pub(super) alpha_x: Option<NotNegative>,
    pub(super) alpha_y: Option<NotNegative>,
    pub(super) theta_deg: Option<Finite>,
    pub(super) texture: Option<PathBuf>,
}

/// A material of an inserted model.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMaterial {
    /// The model's own name of it; all of them if there is none.
    pub(super) name: Option<String>,
    pub(super) rho_d: Option<Reflectance>,
    pub(super) rho_s: Option<Reflectance>,
    pub(super) alpha: Option<NotNegative>,
    pub(super) alpha_x: Option<NotNegative>,
    pub(super) alpha_y: Option<NotNegative>,
    pub(super) theta_deg: Option<Finite>,
    pub(super) texture: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLight {
    pub(super) name: String,
    pub(super) add: Option<Kind>,
    #[serde(default)]
    pub(super) remove: bool,
    pub(super) scale: Option<Channels>,
    pub(super) strength: Option<Channels>,
    #[serde(rename = "move")]
    pub(super) shift: Option<Point>,
    pub(super) position: Option<Point>,
    pub(super) direction: Option<Direction>,
    pub(super) size: Option<Size>,
    pub(super) inner_deg: Option<NotNegative>,
    pub(super) outer_deg: Option<NotNegative>,
}

/// The kinds of lights that can be added.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    Area,
    Point,
    Spot,
    Directional,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEnvironment {
    pub(super) file: Option<PathBuf>,
    #[serde(default)]
    pub(super) remove: bool,
    pub(super) rotation_deg: Option<Finite>,
    pub(super) scale: Option<Positive>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawInsert {
    pub(super) name: Option<String>,
    pub(super) file: PathBuf,
    pub(super) position: Option<Point>,
    pub(super) on: Option<String>,
    pub(super) at: Option<Size>,
    pub(super) pixel: Option<Size>,
    pub(super) rotation_deg: Option<Point>,
    pub(super) scale: Option<Positive>,
    #[serde(default)]
    pub(super) material: Vec<RawMaterial>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub(super) eye: Option<Point>,
    pub(super) target: Option<Point>,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
    #[serde(default)]
    pub(super) keys: Vec<RawKey>,
    pub(super) frames: Option<usize>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawKey {
    pub(super) time: Option<Finite>,
    pub(super) eye: Point,
    pub(super) target: Point,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
}

/// Declares a type that is a checked TOML value.
macro_rules! checked {
    ($(#[$doc:meta])* $name:ident($inner:ty), $read:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(try_from = "Value")]
        pub(super) struct $name(pub(super) $inner);

        impl TryFrom<Value> for $name {
            type Error = String;

            fn try_from(value: Value) -> Result<Self, String> {
                let read: fn(&Value) -> Result<$inner, String> = $read;
                read(&value).map(Self)
            }
        }
    };
}

checked!(
    /// Reflectance, for all channels or three of them.
    Reflectance(Rgb),
    |value| within(channels(value)?, |v| (0.0..=1.0).contains(&v), "a reflectance is from 0 to 1")
);
checked!(
    /// Brightness or a factor of it, for all channels or three of them.
    Channels(Rgb),
    |value| within(channels(value)?, |v| v >= 0.0, "light is not negative")
);
checked!(
    /// A point or a way in space, metres, or three angles.
    Point(Vec3),
    |value| Ok(Vec3::from_array(list(value)?))
);
checked!(
    /// A direction in space; kept as a unit vector.
    Direction(Vec3),
    |value| {
        let direction = Vec3::from_array(list(value)?);
        direction.try_normalize().ok_or_else(|| "a direction is not zero".to_owned())
    }
);
checked!(
    /// Two numbers.
    Size(Vec2),
    |value| Ok(Vec2::from_array(list(value)?))
);
checked!(Finite(f32), number);
checked!(NotNegative(f32), |value| {
    let number = number(value)?;
    if number >= 0.0 { Ok(number) } else { Err(format!("{number} is negative")) }
});
checked!(Positive(f32), |value| {
    let number = number(value)?;
    if number > 0.0 { Ok(number) } else { Err(format!("{number} is not above zero")) }
});

fn number(value: &Value) -> Result<f32, String> {
    let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
    let number = number.map(|v| v as f32).filter(|v| v.is_finite());
    number.ok_or_else(|| format!("{value} is not a finite number"))
}

fn list<const N: usize>(value: &Value) -> Result<[f32; N], String> {
    let fault = || format!("{value} is not a list of {N} numbers");
    let numbers = value.as_array().ok_or_else(fault)?;
    let numbers: Vec<f32> = numbers.iter().map(number).collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| fault())
}

fn channels(value: &Value) -> Result<Rgb, String> {
    if value.is_array() { list(value).map(Rgb::from_array) } else { number(value).map(Rgb::splat) }
}

fn within(rgb: Rgb, is_meant: fn(f32) -> bool, meant: &str) -> Result<Rgb, String> {
    match rgb.to_array().into_iter().find(|v| !is_meant(*v)) {
        Some(value) => Err(format!("{value} cannot be; {meant}")),
        None => Ok(rgb),
    }
}
