//! Measured points: where points of the scene are seen in a photograph, as CSV.
//!
//! ```text
//! # the desk, measured with a tape; pixels from the viewer
//! x_px,y_px,x_m,y_m,z_m,name
//! 812.5,433.0,0.00,0.74,-1.20,desk left
//! 1033.0,440.5,1.40,0.74,-1.20,desk right
//! ```
//!
//! The first line that is not a comment names the columns, in any order; `name` may be left out.
//! `x_px`, `y_px` are pixels of the upright photograph: (0, 0) is its top left corner, the centre of
//! its first pixel (0.5, 0.5). `x_m`, `y_m`, `z_m` are metres, right-handed with y up. Lines that
//! begin with `#` are comments. Semicolons or tabs may separate the values as well, and numbers have decimal
//! commas then.

use crate::separated::{NAME, Row, Rows};
use crate::{FileError, input};
use std::path::Path;
pub use unrender_scene::Pair;

const COLUMNS: [&str; 5] = ["x_px", "y_px", "x_m", "y_m", "z_m"];

/// Reads the pairs in the file at `path`.
///
/// # Errors
/// If the file is missing, lacks a column, has an unknown one, or a value is no finite number.
pub fn read(path: &Path) -> Result<Vec<Pair>, FileError> {
    let bytes = input::read(path).map_err(|error| FileError::because(path, "", error))?;
    parse(&bytes).map_err(|problem| FileError::new(path, problem))
}

/// As [`read`], from the bytes of the file.
///
/// ```
/// let csv = b"x_px,y_px,x_m,y_m,z_m,name\n812.5,433,0,0.74,-1.2,desk\n";
/// let pairs = unrender_formats::points::parse(csv).unwrap();
/// assert_eq!((pairs[0].name.as_str(), pairs[0].pixel), ("desk", [812.5, 433.0]));
/// assert!(unrender_formats::points::parse(b"x,y\n1,2\n").is_err());
/// ```
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(bytes: &[u8]) -> Result<Vec<Pair>, String> {
    let rows = Rows::read(bytes, &COLUMNS, &[NAME])?;
    let pair = |row: &Row| {
        let [x_px, y_px, x, y, z] = rows.numbers(row, COLUMNS)?;
        Ok(Pair { name: rows.name(row), pixel: [x_px, y_px], point: [x, y, z] })
    };
    rows.all.iter().map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_may_stand_in_any_order_and_comments_anywhere() {
        let text = "# made by hand\nname, x_m,y_m,z_m,x_px,y_px\n\n# two\na b,1,2,3,10.5,20\n,4,5,6,7,-8\n";
        let pairs = parse(text.as_bytes()).unwrap();
        assert_eq!(pairs.len(), 2);
        assert_eq!((pairs[0].pixel, pairs[0].point), ([10.5, 20.0], [1.0, 2.0, 3.0]));
        assert_eq!(pairs[0].name, "a b");
        assert_eq!(pairs[1].name, "line 6");
        assert_eq!(parse(b"\xEF\xBB\xBFx_px,y_px,x_m,y_m,z_m\r\n1,2,3,4,5\r\n").unwrap().len(), 1);
    }

    #[test]
    fn semicolons_and_tabs_separate_as_well() {
        let commas =
            parse(b"x_px,y_px,x_m,y_m,z_m,name\n812.5,433,0,0.74,-1.2,\"a, b\"\n").unwrap();
        let semicolons = "x_px;y_px;x_m;y_m;z_m;name\n812,5;433;0;0,74;-1,2;a, b\n";
        for text in [semicolons.to_owned(), semicolons.replace(';', "\t"), points(semicolons)] {
            assert_eq!(parse(text.as_bytes()).unwrap(), commas, "{text}");
        }
        let mixed = "x_px;y_px;x_m;y_m;z_m\n812,5;433;0;0.74;-1,2\n";
        assert!(parse(mixed.as_bytes()).unwrap_err().starts_with("line 2: y_m is \"0.74\", but"));
    }

    /// `text` with decimal points.
    fn points(text: &str) -> String {
        text.replace("2,5", "2.5").replace("0,74", "0.74").replace("1,2", "1.2")
    }

    #[test]
    fn faults_have_a_line() {
        let header = "x_px,y_px,x_m,y_m,z_m\n";
        let faults = [
            ("x,y\n".to_owned(), "there is no column \"x\""),
            ("x_px,y_px,x_m,y_m\n".to_owned(), "the column z_m is missing"),
            (format!("{header}1,2,3,4,5\n1,2,3,4\n"), "line 3: has 4 values"),
            (format!("{header}# c\n1,2,3,4,five\n"), "line 3: z_m is \"five\""),
            (format!("{header}1,2,3,4,inf\n"), "line 2: z_m is \"inf\""),
            (String::new(), "the column x_px is missing"),
        ];
        for (text, problem) in faults {
            let noted = parse(text.as_bytes()).expect_err(&text);
            assert!(noted.contains(problem), "{text}: {noted}");
        }
    }
}
