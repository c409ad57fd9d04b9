//! IES files: photometric profiles of lamps, as manufacturers publish them [ANSI/IES LM-63-19].
//!
//! All editions are read: LM-63-1986, which has no first line of its own, 1991, 1995, 2002 and 2019. After lines of
//! text and `TILT=`, all numbers follow, separated by blanks, commas or line ends:
//!
//! ```text
//! lamps, lumens per lamp, multiplier, vertical angles, horizontal angles, type, units, width, length, height,
//! ballast factor, factor of lamp and ballast, watts,
//! the vertical angles, the horizontal angles, and for each horizontal angle the candelas at all vertical ones
//! ```
//!
//! A luminous intensity is `candela * multiplier * ballast factor * factor of lamp and ballast`. From 1995 on the last
//! factor is reserved, and in 2019 it says how the file was made, so it counts in earlier editions only. The lamp is a
//! point: its size, and the unit of its size, are not used.

mod values;
mod write;

pub use write::text;

use crate::entry::{Entry, Table, passed, read as row, refused, told};
use crate::input::Scope;
use crate::{FileError, Input};
use std::path::Path;
use unrender_scene::{LightProfile, Photometry, Warnings};
use values::Values;

/// The last edition whose second factor belongs to the light.
const LAST_WITH_FACTOR: u32 = 1991;

/// Edges of lists of horizontal angles may lie so much farther apart than the angles in between: those of type C that
/// stop before 360. With half of it, rounded angles are refused; with double of it, a list that lacks an angle passes.
const GAP: f32 = 1.01;

/// Reads the profile in the file `input`, and the file of its `TILT=` beside it.
///
/// # Errors
/// If the file is missing or is not a valid profile; the message names the line.
pub fn read(input: Input<'_>) -> Result<(LightProfile, Warnings), FileError> {
    let scope = Scope::new(input);
    let folder = input.path.parent().unwrap_or(Path::new(""));
    let beside = |name: &str| {
        let path = scope.beside(folder, name)?;
        scope.read(&path)
    };
    let bytes = scope.read(input.path);
    bytes
        .and_then(|bytes| parse(&bytes, &beside))
        .map_err(|problem| FileError::new(input.path, problem))
}

/// As [`read`], from the bytes of the file; `beside` reads the file of its `TILT=`, by its name.
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(
    bytes: &[u8],
    beside: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<(LightProfile, Warnings), String> {
    let mut warnings = Warnings::default();
    let text = String::from_utf8_lossy(bytes).replace("\r\n", "\n").replace('\r', "\n");
    let Some((line, tilt)) =
        text.lines().enumerate().find_map(|(line, text)| tilt_of(text).map(|t| (line, t)))
    else {
        return Err(
            "has no line TILT=; it is not an IES file: give a photometric file of LM-63".into()
        );
    };
    let mut values = Values::of(&text, line + 1);
    match tilt.to_ascii_uppercase().as_str() {
        "NONE" => {}
        "INCLUDE" => skip_tilt(&mut values)?,
        _ => {
            let file = beside(tilt).map_err(|problem| {
                format!(
                    "line {}: TILT={tilt} names a file that {problem}; put it beside this one, or write TILT=NONE if the \
                     lamp hangs as it was measured",
                    line + 1
                )
            })?;
            let file = String::from_utf8_lossy(&file).into_owned();
            skip_tilt(&mut Values::of(&file, 0))
                .map_err(|problem| format!("TILT={tilt}: {problem}"))?;
        }
    }
    if !tilt.eq_ignore_ascii_case("NONE") {
        warnings.push("TILT: how the lamp's light changes where it is tilted is not modelled; it shines as measured.");
    }
    let first = text.lines().next().unwrap_or_default();
    let profile = table(&mut values, edition(first), &mut warnings)?;
    if values.left() > 0 {
        warnings.push(format!("{} numbers after the last candela were ignored.", values.left()));
    }
    Ok((profile, warnings))
}

/// What follows `TILT=`, if the line says that.
fn tilt_of(line: &str) -> Option<&str> {
    let (word, rest) = line.split_once('=')?;
    word.trim().eq_ignore_ascii_case("TILT").then_some(rest.trim())
}

/// The year of the edition by a file's first line.
fn edition(line: &str) -> u32 {
    /// What the years of editions end with: those since 1991 name themselves.
    const YEARS: [(&str, u32); 4] = [("91", 1991), ("95", 1995), ("02", 2002), ("19", 2019)];
    let line = line.trim();
    let is_named = line.starts_with("IES");
    let named = YEARS.iter().find(|(end, _)| is_named && line.ends_with(end));
    named.map_or(1986, |(_, year)| *year)
}

/// Passes over the data of a tilted lamp: its geometry, the number of angles, the angles, their factors.
fn skip_tilt(values: &mut Values<'_>) -> Result<(), String> {
    values.number("the geometry of TILT")?;
    let count = values.count("the number of angles of TILT")?;
    values.list(count, "the angles of TILT")?;
    values.list(count, "the factors of TILT").map(|_| ())
}

fn table(
    values: &mut Values<'_>,
    edition: u32,
    warnings: &mut Warnings,
) -> Result<LightProfile, String> {
    let from = values.line();
    values.number("the number of lamps")?;
    values.number("the lumens per lamp")?;
    let mut factor = values.factor("the candela multiplier")?;
    let rows = values.count("the number of vertical angles")?;
    let columns = values.count("the number of horizontal angles")?;
    let photometry =
        match values.one_of(["1", "2", "3"], "the photometric type (1 for C, 2 for B, 3 for A)")? {
            0 => Photometry::C,
            1 => Photometry::B,
            _ => Photometry::A,
        };
    values.one_of(["1", "2"], "the unit of length (1 for feet, 2 for metres)")?;
    for side in ["width", "length", "height"] {
        values.number(&format!("the {side} of the opening"))?;
    }
    factor *= values.factor("the ballast factor")?;
    let of_lamp = values.number("the factor of lamp and ballast")?;
    if edition <= LAST_WITH_FACTOR {
        factor *= of_lamp;
    }
    values.number("the watts")?;
    let vertical = angles(values.list(rows, "the vertical angles")?);
    let mut horizontal = angles(values.list(columns, "the horizontal angles")?);
    let entries = rows.checked_mul(columns).ok_or("has more angles than any file")?;
    let mut candela = values.list(entries, "the candelas")?;
    candela.iter_mut().for_each(|value| *value *= factor);
    if photometry == Photometry::C && stops_short(&horizontal) {
        warnings.push(
            "The horizontal angles stop before 360; the light there was taken to be that at 0.",
        );
        horizontal.push(360.0);
        candela.extend_from_within(..rows);
    }
    LightProfile::new(photometry, vertical, horizontal, &candela).map_err(|problem| {
        format!("the table from line {from} on: {problem}; ask for the file anew")
    })
}

fn angles(values: Vec<f64>) -> Vec<f32> {
    values.into_iter().map(|angle| angle as f32).collect()
}

/// Whether only the angle of 360 degrees is missing, which is that of 0.
fn stops_short(horizontal: &[f32]) -> bool {
    let (Some(&first), Some(&last)) = (horizontal.first(), horizontal.last()) else { return false };
    let widest = horizontal.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f32::max);
    first == 0.0 && (180.0 < last && last < 360.0) && 360.0 - last <= GAP * widest
}

/// What is read of the format.
const ELEMENTS: &[Entry] = &[
    row("TILT=NONE", "the lamp hangs as it was measured"),
    told(
        "TILT=INCLUDE",
        "how the light changes where the lamp is tilted is not modelled; it shines as measured",
    ),
    told("TILT=file", "as TILT=INCLUDE; a file that is missing is refused"),
    passed("[keywords]", "names, dates and numbers for people"),
    passed("number of lamps, lumens per lamp", "the candelas count"),
    row("candela multiplier", "a factor on all candelas"),
    row("ballast factor", "a factor on all candelas"),
    row(
        "ballast-lamp photometric factor",
        "to LM-63-1991 a factor on all candelas; later editions have none",
    ),
    row("photometric type", "C, B and A, each with its own angles and its own interpolation"),
    passed("units, width, length, height", "the lamp is a point"),
    passed("input watts", "the candelas count"),
    row("vertical angles", "there is no light outside them"),
    row(
        "horizontal angles",
        "0 alone, 0 to 90, 0 to 180, 90 to 270 and 0 to 360 of type C; others are refused",
    ),
    row("candela values", "intensities, linear in both angles between them"),
    refused(
        "negative candelas, descending angles",
        "the error names the line where the table begins",
    ),
];

/// What is read of the format, as a table of the reference.
pub(crate) fn table_of_elements() -> Table {
    Table::new("IES profiles (LM-63)", "element", ELEMENTS)
}
