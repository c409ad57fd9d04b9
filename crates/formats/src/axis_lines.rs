//! Lines along the axes of a scene: where a photograph shows them, as CSV.
//!
//! ```text
//! # the corner of a room, marked in a viewer
//! axis,x1_px,y1_px,x2_px,y2_px,length_m,name
//! x,102.0,840.5,700.0,801.0,,skirting
//! y,655.0,702.5,652.0,340.0,2.0,door
//! z,102.0,840.5,12.0,910.0,,window sill
//! ```
//!
//! The first line that is not a comment names the columns, in any order; `length_m` and `name` may be left out, and the
//! former may be empty. `axis` is `x`, `y` or `z` for a line that is parallel to it, and `+x` or `-x` for one whose second
//! end is further along it, or less far. Pixels are those of the upright photograph: (0, 0) is its top left corner, the
//! centre of its first pixel (0.5, 0.5). Comments, separators and decimals are those of [`crate::points`].

use crate::separated::{NAME, Row, Rows};
use crate::{FileError, input};
use std::path::Path;
use unrender_scene::AxisLine;

const AXIS: &str = "axis";
const ENDS: [&str; 4] = ["x1_px", "y1_px", "x2_px", "y2_px"];
const LENGTH: &str = "length_m";
const AXES: [&str; 3] = ["x", "y", "z"];

/// Reads the lines in the file at `path`.
///
/// # Errors
/// If the file is missing, lacks a column, has an unknown one, or a value is not what its column holds.
pub fn read(path: &Path) -> Result<Vec<AxisLine>, FileError> {
    let bytes = input::read(path).map_err(|error| FileError::because(path, "", error))?;
    parse(&bytes).map_err(|problem| FileError::new(path, problem))
}

/// As [`read`], from the bytes of the file.
///
/// ```
/// let csv = b"axis,x1_px,y1_px,x2_px,y2_px,length_m\n-y,10,20,10,90,2.0\nx,0,0,50,1,\n";
/// let lines = unrender_formats::axis_lines::parse(csv).unwrap();
/// // The line runs along y from its lower end.
/// assert_eq!((lines[0].axis, lines[0].ends[0], lines[0].length_m), (1, [10.0, 90.0], Some(2.0)));
/// assert!(lines[0].is_directed && !lines[1].is_directed);
/// assert!(unrender_formats::axis_lines::parse(b"x,y\n1,2\n").is_err());
/// ```
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(bytes: &[u8]) -> Result<Vec<AxisLine>, String> {
    let required = [&[AXIS][..], &ENDS].concat();
    let rows = Rows::read(bytes, &required, &[LENGTH, NAME])?;
    let lines: Vec<AxisLine> =
        rows.all.iter().map(|row| line(&rows, row)).collect::<Result<_, _>>()?;
    let mut measured = lines.iter().filter(|line| line.length_m.is_some());
    if let (Some(first), Some(second)) = (measured.next(), measured.next()) {
        return Err(format!(
            "\"{}\" and \"{}\" both have a {LENGTH}; the scale follows from one, leave the others empty",
            first.name, second.name
        ));
    }
    Ok(lines)
}

fn line(rows: &Rows<'_>, row: &Row) -> Result<AxisLine, String> {
    let stated = rows.text(row, AXIS).to_ascii_lowercase();
    let name = stated.trim_start_matches(['+', '-']);
    let signs = stated.len() - name.len();
    let axis = AXES.iter().position(|axis| *axis == name).filter(|_| signs <= 1);
    let axis = axis.ok_or_else(|| {
        format!("line {}: {AXIS} is \"{stated}\"; write x, y or z, or one with a sign", row.line)
    })?;
    let [x1, y1, x2, y2] = rows.numbers(row, ENDS)?;
    if (x1, y1) == (x2, y2) {
        return Err(format!("line {}: both ends are at ({x1}, {y1})", row.line));
    }
    let mut ends = [[x1, y1], [x2, y2]];
    if stated.starts_with('-') {
        ends.reverse();
    }
    let length_m = match rows.text(row, LENGTH) {
        "" => None,
        _ => Some(rows.number(row, LENGTH)?),
    };
    if let Some(length) = length_m.filter(|length| *length <= 0.0) {
        return Err(format!("line {}: {LENGTH} is {length}; lengths are positive", row.line));
    }
    Ok(AxisLine { name: rows.name(row), axis, is_directed: signs == 1, ends, length_m })
}

/// The lines as a file that [`read`] reads.
pub fn to_csv(lines: &[AxisLine]) -> String {
    let mut text = format!("{AXIS},{},{LENGTH},{NAME}\n", ENDS.join(","));
    for line in lines {
        let sign = if line.is_directed { "+" } else { "" };
        let [[x1, y1], [x2, y2]] = line.ends;
        let length = line.length_m.map(|length| length.to_string()).unwrap_or_default();
        // Names with a comma or a quotation mark are quoted.
        let name = line.name.replace('"', "\"\"");
        text.push_str(&format!(
            "{sign}{},{x1:.2},{y1:.2},{x2:.2},{y2:.2},{length},\"{name}\"\n",
            AXES[line.axis]
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let line = |axis: usize, is_directed: bool, length_m: Option<f64>| AxisLine {
            name: format!("a, \"{axis}\""),
            axis,
            is_directed,
            ends: [[1.25, 2.0], [30.5, -4.0]],
            length_m,
        };
        let lines = [line(0, false, None), line(1, true, Some(2.5)), line(2, false, None)];
        assert_eq!(parse(to_csv(&lines).as_bytes()).unwrap(), lines);
    }

    #[test]
    fn faults_have_a_line() {
        let header = "axis,x1_px,y1_px,x2_px,y2_px,length_m\n";
        for (text, fault) in [
            ("axis,y\n".to_owned(), "there is no column \"y\""),
            ("axis,x1_px,y1_px,x2_px\n".to_owned(), "the column y2_px is missing"),
            (format!("{header}w,0,0,1,1,\n"), "line 2: axis is \"w\""),
            (format!("{header}+-x,0,0,1,1,\n"), "line 2: axis is \"+-x\""),
            (format!("{header}x,0,0,zero,1,\n"), "line 2: x2_px is \"zero\""),
            (format!("{header}x,3,4,3,4,\n"), "line 2: both ends are at (3, 4)"),
            (format!("{header}x,0,0,1,1,0\n"), "line 2: length_m is 0; lengths"),
            (format!("{header}x,0,0,1,1,2\ny,0,0,1,1,3\n"), "\"line 2\" and \"line 3\" both"),
        ] {
            let told = parse(text.as_bytes()).unwrap_err();
            assert!(told.starts_with(fault), "{told}");
        }
    }
}
