//! Values of project and edit files, checked where they are read: an error has the line of the value.

use glam::{DVec2, DVec3, Vec2, Vec3};
use serde::Deserialize;
use toml::Value;
use unrender_scene::Rgb;

/// Declares a type that is a checked TOML value.
macro_rules! checked {
    ($(#[$doc:meta])* $name:ident($inner:ty), $read:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(try_from = "Value")]
        pub(crate) struct $name(pub(crate) $inner);

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
    /// Reflectance, for all channels or one per channel.
    Reflectance(Rgb),
    |value| within(channels(value)?, |v| (0.0..=1.0).contains(&v), "a reflectance is from 0 to 1")
);
checked!(
    /// Brightness or a factor on it, for all channels or one per channel.
    Channels(Rgb),
    |value| within(channels(value)?, |v| v >= 0.0, "light is not negative")
);
checked!(
    /// A displacement in space, metres, or three angles.
    Way(Vec3),
    |value| Ok(Vec3::from_array(list(value)?))
);
checked!(
    /// A place in the world, metres; it may be far from zero.
    Place(DVec3),
    |value| Ok(DVec3::from_array(doubles(value)?))
);
checked!(
    /// A place on the ground, metres.
    Ground(DVec2),
    |value| Ok(DVec2::from_array(doubles(value)?))
);
checked!(
    /// A direction in space; kept as a unit vector.
    Direction(Vec3),
    |value| {
        let direction = Vec3::from_array(list(value)?);
        direction.try_normalize().ok_or_else(|| "a direction cannot be zero".to_owned())
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
    double(value).map(|v| v as f32)
}

/// A number that single precision can hold.
fn double(value: &Value) -> Result<f64, String> {
    let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
    let number = number.filter(|v| (*v as f32).is_finite());
    number.ok_or_else(|| format!("{value} is not a finite number"))
}

fn list<const N: usize>(value: &Value) -> Result<[f32; N], String> {
    Ok(doubles(value)?.map(|v| v as f32))
}

fn doubles<const N: usize>(value: &Value) -> Result<[f64; N], String> {
    let fault = || format!("{value} is not a list of {N} numbers");
    let numbers = value.as_array().ok_or_else(fault)?;
    let numbers: Vec<f64> = numbers.iter().map(double).collect::<Result<_, _>>()?;
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
