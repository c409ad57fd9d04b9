//! Numbers in attributes, and the steps of a `<transform>`.

use super::elements::STEPS;
use crate::entry::find;
use glam::{DAffine3, DMat3, DVec3};
use unrender_scene::color::linear_from_srgb;

/// A position in double precision.
pub(super) type Point = DVec3;

/// A finite number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let parsed = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    parsed.ok_or_else(|| format!("\"{text}\" is no finite number"))
}

/// The words of a list, between commas and blanks.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split([',', ' ', '\n', '\t', '\r']).filter(|word| !word.is_empty())
}

/// Three numbers, or one for all three; `None` if it is a list of another length.
pub(super) fn triple(text: &str) -> Result<Option<[f64; 3]>, String> {
    let numbers = words(text).map(number).collect::<Result<Vec<f64>, String>>()?;
    Ok(match numbers[..] {
        [all] => Some([all; 3]),
        [x, y, z] => Some([x, y, z]),
        _ => None,
    })
}

/// The numbers of `#rrggbb`, 0 to 1; none if it is something else.
pub(super) fn hexadecimal(text: &str) -> Option<[f64; 3]> {
    let digits = text.trim().strip_prefix('#')?;
    let is_code = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let code = is_code.then(|| u32::from_str_radix(digits, 16).ok()).flatten()?;
    Some([16, 8, 0].map(|shift| f64::from((code >> shift) & 0xff) / 255.0))
}

/// A colour as a picture has it, `#rrggbb` or one number or three of 0 to 1, as linear sRGB.
pub(super) fn encoded(text: &str) -> Result<[f64; 3], String> {
    let problem =
        || format!("\"{text}\" is no sRGB colour; give #rrggbb, or three numbers of 0 to 1");
    let codes = match hexadecimal(text) {
        Some(codes) => codes,
        None if text.trim().starts_with('#') => return Err(problem()),
        None => triple(text)?.ok_or_else(problem)?,
    };
    if codes.iter().any(|code| !(0.0..=1.0).contains(code)) {
        return Err(problem());
    }
    Ok(codes.map(|code| f64::from(linear_from_srgb(code as f32))))
}

/// `true` or `false`, in large letters or small ones.
pub(super) fn flag(text: &str) -> Result<bool, String> {
    if text.eq_ignore_ascii_case("true") {
        return Ok(true);
    }
    if text.eq_ignore_ascii_case("false") {
        return Ok(false);
    }
    Err(format!("\"{text}\" is neither \"true\" nor \"false\""))
}

/// The attributes of an element.
pub(super) type Attributes = Vec<(String, String)>;

/// The value of the attribute `name`.
pub(super) fn attribute<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a str> {
    attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
}

/// The vector in `value` or in `x`, `y` and `z`; an axis that is not there is `default`, if that is given.
pub(super) fn vector(attributes: &Attributes, default: Option<f64>) -> Result<DVec3, String> {
    if let Some(text) = attribute(attributes, "value") {
        let found = triple(text)?;
        return found.map(DVec3::from_array).ok_or_else(|| format!("\"{text}\" is no vector"));
    }
    let axis = |name: &str| match (attribute(attributes, name), default) {
        (Some(text), _) => number(text),
        (None, Some(default)) => Ok(default),
        (None, None) => Err(format!("{name} is missing; give x, y and z")),
    };
    Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
}

/// One step of a transform.
pub(super) fn step(tag: &str, attributes: &Attributes) -> Result<DAffine3, String> {
    let known = find(&STEPS, tag).map_or("", |entry| entry.name);
    let motion = match known {
        "translate" => DAffine3::from_translation(vector(attributes, Some(0.0))?),
        "scale" => DAffine3::from_scale(vector(attributes, Some(1.0))?),
        "rotate" => {
            let angle = number(attribute(attributes, "angle").ok_or("rotate has no angle")?)?;
            let axis = vector(attributes, Some(0.0))?;
            if axis == DVec3::ZERO {
                return Err("rotate has no axis".into());
            }
            DAffine3::from_mat3(turned_about(axis, angle.to_radians()))
        }
        "lookat" => look_at(attributes)?,
        "matrix" => matrix(attribute(attributes, "value").ok_or("a matrix has no value")?)?,
        _ => return Err(format!("there is a transform <{tag}>, which is not known")),
    };
    if motion.is_finite() { Ok(motion) } else { Err(format!("<{tag}> is no transform")) }
}

/// Rodrigues' formula with the axis as it is: with one that is no unit vector, Mitsuba shears and scales as well.
fn turned_about(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = angle.sin_cos();
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|unit| axis.cross(unit));
    let along = DMat3::from_cols(axis.x * axis, axis.y * axis, axis.z * axis);
    DMat3::from_diagonal(DVec3::splat(cos)) + DMat3::from_cols(x, y, z) * sin + along * (1.0 - cos)
}

/// Mitsuba's camera looks along its own +z, with +x to the left.
fn look_at(attributes: &Attributes) -> Result<DAffine3, String> {
    let point = |name: &str| -> Result<Option<DVec3>, String> {
        let Some(text) = attribute(attributes, name) else { return Ok(None) };
        let numbers = words(text).map(number).collect::<Result<Vec<f64>, String>>()?;
        let three = <[f64; 3]>::try_from(numbers).map(DVec3::from_array);
        three.map(Some).map_err(|_| format!("lookat has {name} = \"{text}\"; give 3 numbers"))
    };
    let origin = point("origin")?.ok_or("lookat has no origin")?;
    let target = point("target")?.ok_or("lookat has no target")?;
    let ahead = (target - origin).try_normalize().ok_or("lookat looks at its own origin")?;
    let up = point("up")?.filter(|up| *up != DVec3::ZERO);
    let up = up.unwrap_or_else(|| ahead.any_orthonormal_vector());
    let left =
        up.cross(ahead).try_normalize().ok_or("lookat has its up along its direction of view")?;
    let axes = DMat3::from_cols(left, ahead.cross(left), ahead);
    Ok(DAffine3::from_mat3_translation(axes, origin))
}

/// Nine or sixteen numbers, row by row.
fn matrix(text: &str) -> Result<DAffine3, String> {
    let numbers = words(text).map(number).collect::<Result<Vec<f64>, String>>()?;
    let size = match numbers.len() {
        9 => 3,
        16 => 4,
        other => return Err(format!("a matrix has 16 numbers or 9, not {other}")),
    };
    if size == 4 && numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err("a matrix has a last row that is not 0 0 0 1: it is not affine".into());
    }
    let at = |row: usize, column: usize| numbers[size * row + column];
    let column = |j: usize| DVec3::new(at(0, j), at(1, j), at(2, j));
    let translation = if size == 4 { column(3) } else { DVec3::ZERO };
    let axes = DMat3::from_cols(column(0), column(1), column(2));
    Ok(DAffine3::from_mat3_translation(axes, translation))
}
