//! Numbers and colours in the TOML of a project; errors name their keys.

use toml::Value;
use unrender_scene::Rgb;

/// A reflectance, for all channels or for each.
pub(super) fn reflectance(key: &str, value: &Value) -> Result<Rgb, String> {
    let rgb = triple(key, value)?;
    if rgb.to_array().iter().all(|rho| (0.0..=1.0).contains(rho)) {
        Ok(rgb)
    } else {
        Err(format!("{key} is {value}; a reflectance is from 0 to 1"))
    }
}

/// One number for all channels, or a list of three.
pub(super) fn triple(key: &str, value: &Value) -> Result<Rgb, String> {
    let fault = || format!("{key} is {value}; give a number or three, [r, g, b]");
    if let Some(grey) = number(value) {
        return Ok(Rgb::splat(grey));
    }
    match value.as_array().map(Vec::as_slice) {
        Some([r, g, b]) => match (number(r), number(g), number(b)) {
            (Some(r), Some(g), Some(b)) => Ok(Rgb::new(r, g, b)),
            _ => Err(fault()),
        },
        _ => Err(fault()),
    }
}

/// A number; none if `value` is not one.
pub(super) fn number(value: &Value) -> Option<f32> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).map(|v| v as f32)
}
