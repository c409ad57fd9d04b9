//! A project's statements about its photograph: bracket, response, black and white level,
//! vignetting.

use super::raw::{RawBracket, RawPhoto};
use super::values::{number, triple};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Value;
use unrender_photo::{Response, vignetting};
use unrender_scene::Rgb;

/// The response of the photograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ResponseChoice {
    /// By a curve with a name or by a gamma.
    Stated(Response),
    /// Measured: the file with its rows.
    Measured(PathBuf),
    /// An unknown gamma.
    Auto,
}

/// The vignetting of the photograph.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VignettingChoice {
    /// By this law.
    Stated(vignetting::Law),
    /// An unknown radial polynomial.
    Auto,
}

/// The photographs of a bracket of exposures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// Their files.
    pub files: Vec<PathBuf>,
    /// Their exposure times, or values proportional to the exposures; if none, those in the files.
    pub times: Option<Vec<f64>>,
}

const RESPONSES: &str =
    "give \"srgb\", \"linear\", { gamma = 2.2 }, a file such as \"curve.csv\", or \"auto\"";
const VIGNETTINGS: &str = "give \"cos4\", { radial = [a1, a2, a3] } or \"auto\"";

/// The key `photo`: the file that represents it, and the bracket if it is one. Files are relative to `folder`.
pub(super) fn photo(raw: &RawPhoto, folder: &Path) -> Result<(PathBuf, Option<Frames>), String> {
    let RawBracket { bracket, times } = match raw {
        RawPhoto::File(file) => return Ok((folder.join(file), None)),
        RawPhoto::Bracket(raw) => raw,
    };
    let [first, _, ..] = &bracket[..] else {
        return Err(format!(
            "photo.bracket names {} photograph(s); a bracket has two at least: name all of them, or \
             give photo = \"FILE\"",
            bracket.len()
        ));
    };
    let time = |value: &Value| match value.as_str() {
        Some(text) => seconds(text),
        None => seconds(&value.to_string()),
    };
    let times = times.as_ref().map(|times| times.iter().map(time).collect::<Result<Vec<f64>, _>>());
    let times = times.transpose().map_err(|problem| format!("photo.times: a time {problem}"))?;
    if let Some(times) = times.as_ref().filter(|times| times.len() != bracket.len()) {
        return Err(format!(
            "photo.times has {} times for {} photographs; give one for each, in the same order",
            times.len(),
            bracket.len()
        ));
    }
    let files = bracket.iter().map(|file| folder.join(file)).collect();
    Ok((folder.join(first), Some(Frames { files, times })))
}

/// An exposure time: a number, or a fraction such as 1/60.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let time = match text.split_once('/') {
        Some((above, below)) => number(above).zip(number(below)).map(|(a, b)| a / b),
        None => number(text),
    };
    let good = time.filter(|time| time.is_finite() && *time > 0.0);
    good.ok_or_else(|| format!("is {text}; give positive numbers, or fractions such as 1/60"))
}

/// The key `response`; files are relative to `folder`.
pub(super) fn response(value: &Value, folder: &Path) -> Result<ResponseChoice, String> {
    if let Some(name) = value.as_str() {
        if let Ok(response) = name.parse() {
            return Ok(ResponseChoice::Stated(response));
        }
        return match name {
            "auto" => Ok(ResponseChoice::Auto),
            _ if name.contains(['.', '/']) => Ok(ResponseChoice::Measured(folder.join(name))),
            _ => Err(format!("response: there is no \"{name}\"; {RESPONSES}")),
        };
    }
    let table = value.as_table().filter(|t| t.len() == 1).and_then(|t| t.get("gamma"));
    let gamma = table.and_then(number).ok_or_else(|| format!("response: {RESPONSES}"))?;
    if !(0.1..=10.0).contains(&gamma) {
        return Err(format!("response.gamma is {gamma}; it is from 0.1 to 10"));
    }
    Ok(ResponseChoice::Stated(Response::Gamma(gamma)))
}

/// The key `black_level`.
pub(super) fn black_level(value: &Value) -> Result<Rgb, String> {
    let black = triple("black_level", value)?;
    if black.to_array().iter().all(|black| (0.0..0.5).contains(black)) {
        return Ok(black);
    }
    Err(format!(
        "black_level is {value}; it is a code from 0 to below 0.5, where 1 is white: divide that of \
         an 8-bit file by 255"
    ))
}

/// The key `white_level`, for a photograph of this black level.
pub(super) fn white_level(value: &Value, black_level: Rgb) -> Result<Rgb, String> {
    let white = triple("white_level", value)?;
    if white.is_finite() && white.cmpgt(black_level).all() {
        return Ok(white);
    }
    Err(format!(
        "white_level is {value}; it is a code above black_level, mostly a little below 1, from which \
         on the photo is clipped"
    ))
}

/// The key `vignetting`.
pub(super) fn vignetting(value: &Value) -> Result<VignettingChoice, String> {
    if let Some(name) = value.as_str() {
        return match name {
            "cos4" => Ok(VignettingChoice::Stated(vignetting::Law::Cos4)),
            "auto" => Ok(VignettingChoice::Auto),
            _ => Err(format!("vignetting: there is no \"{name}\"; {VIGNETTINGS}")),
        };
    }
    let radial = value.as_table().filter(|t| t.len() == 1).and_then(|t| t.get("radial"));
    let list =
        radial.and_then(Value::as_array).ok_or_else(|| format!("vignetting: {VIGNETTINGS}"))?;
    let numbers: Vec<f32> = list.iter().filter_map(number).filter(|a| a.is_finite()).collect();
    if numbers.len() != list.len() || !(1..=3).contains(&numbers.len()) {
        let given = radial.map_or(String::new(), Value::to_string);
        return Err(format!("vignetting.radial is {given}; give one to three numbers, a1, a2, a3"));
    }
    let mut coefficients = [0.0; 3];
    coefficients[..numbers.len()].copy_from_slice(&numbers);
    Ok(VignettingChoice::Stated(vignetting::Law::Radial(coefficients)))
}
