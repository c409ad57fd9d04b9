//! Names of Mitsuba 0.5 and 0.6 as Mitsuba 3 upgrades them, by the version that the file states.

use super::tree::{Plugin, Property, Value};
use glam::{DAffine3, DVec3};
use std::cell::Cell;

/// Whether a file of this version has the old names.
///
/// # Errors
/// If it is not a version.
pub(super) fn is_old(version: &str) -> Result<bool, String> {
    let mut parts = version.trim().split('.').map(|part| part.parse::<u32>().ok());
    let major = parts.next().flatten();
    let is_whole = parts.all(|part| part.is_some());
    match major.filter(|_| is_whole) {
        Some(major) => Ok(major < 2),
        None => Err(format!("\"{version}\" is no version of Mitsuba; write version=\"3.0.0\"")),
    }
}

/// `toWorld` as `to_world`, `intIOR` as `int_ior`.
pub(super) fn snake_case(name: &str) -> String {
    let mut snake = String::with_capacity(name.len() + 4);
    let mut before = ' ';
    let mut in_capitals = false;
    for letter in name.chars() {
        let starts = before.is_ascii_lowercase() && letter.is_ascii_uppercase();
        in_capitals = starts || (in_capitals && letter.is_ascii_uppercase());
        if starts {
            snake.push('_');
        }
        snake.push(if in_capitals { letter.to_ascii_lowercase() } else { letter });
        before = letter;
    }
    snake
}

/// Applies the changes beyond the spelling.
pub(super) fn plugin(plugin: &mut Plugin) {
    if plugin.kind == "diffuse" {
        let renamed = plugin.properties.iter_mut().find(|p| p.name == "diffuse_reflectance");
        renamed.into_iter().for_each(|property| property.name = "reflectance".into());
    }
    let mut taken = |name: &str| {
        let at = plugin.properties.iter().position(|p| p.name == name);
        let at = at.filter(|&i| matches!(plugin.properties[i].value, Value::Number(_)))?;
        let Property { value: Value::Number(number), place, .. } = plugin.properties.remove(at)
        else {
            return None;
        };
        Some((number, place))
    };
    let names = ["uoffset", "voffset", "uscale", "vscale"].map(&mut taken);
    let Some(place) = names.iter().flatten().map(|(_, place)| *place).next() else { return };
    let number = |index: usize, default: f64| names[index].map_or(default, |(number, _)| number);
    let offset = DVec3::new(number(0, 0.0), number(1, 0.0), 0.0);
    let scale = DVec3::new(number(2, 1.0), number(3, 1.0), 1.0);
    let motion = DAffine3::from_scale(scale) * DAffine3::from_translation(offset);
    plugin.properties.push(Property {
        name: "to_uv".into(),
        value: Value::Motion(motion),
        place,
        asked: Cell::new(false),
    });
}
