//! Measured responses: which linear value each code of a camera stands for, as CSV.
//!
//! ```text
//! # a grey card under 1, 1/2, 1/4 ... of the light
//! code,linear
//! 0.0,0.0
//! 0.188,0.031
//! 0.537,0.25
//! 1.0,1.0
//! ```
//!
//! The first line that is not a comment names the columns: `code,linear` for one curve, or
//! `code,r,g,b` for one per channel. A code is the file's value from 0 to 1 (of an 8-bit file,
//! divided by 255); a linear value is proportional to radiance, in any unit: `exposure` is radiance
//! per that unit. Both grow from row to row. Lines that begin with `#` are comments.
//! Semicolons or tabs may separate the values as well, and numbers have decimal commas then.

use crate::separated::Table;
use crate::{FileError, atomic, input};
use std::path::Path;

/// The rows of a response file; at least two, codes and values strictly increasing.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRows {
    /// Codes, 0 to 1.
    pub codes: Vec<f64>,
    /// The linear values of the codes, zero or positive, by channel.
    pub linear: [Vec<f64>; 3],
}

/// Reads the response in the file at `path`.
///
/// # Errors
/// If the file is missing, has other columns than those above or fewer than two rows, or if a value
/// is not a number, out of its range, or not above that of the row before.
pub fn read(path: &Path) -> Result<ResponseRows, FileError> {
    let bytes = input::read(path).map_err(|error| FileError::because(path, "", error))?;
    parse(&bytes).map_err(|problem| FileError::new(path, problem))
}

/// Writes `rows` as a response file with a column for each channel; `comment` is a line that says where they
/// come from.
///
/// # Errors
/// If the file cannot be written, or the rows are not valid.
pub fn write(path: &Path, rows: &ResponseRows, comment: &str) -> Result<(), FileError> {
    check(rows, &["code", "r", "g", "b"]).map_err(|problem| FileError::new(path, problem))?;
    let mut text = format!("# {comment}\ncode,r,g,b\n");
    let [red, green, blue] = &rows.linear;
    for (row, code) in rows.codes.iter().enumerate() {
        text.push_str(&format!("{code:.6},{:e},{:e},{:e}\n", red[row], green[row], blue[row]));
    }
    atomic::write(path, text.as_bytes())
}

/// As [`read`], from the bytes of the file.
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(bytes: &[u8]) -> Result<ResponseRows, String> {
    let table = Table::of(bytes);
    let mut reader = table.reader();
    let not_csv = |error: csv::Error| format!("is not CSV ({error})");
    let header = reader.headers().map_err(not_csv)?.clone();
    let columns: Vec<&str> = header.iter().collect();
    if !matches!(columns[..], ["code", "linear"] | ["code", "r", "g", "b"]) {
        return Err(format!(
            "the first line is \"{}\"; a response file begins with code,linear or code,r,g,b",
            columns.join(",")
        ));
    }
    let mut rows = ResponseRows { codes: Vec::new(), linear: Default::default() };
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(not_csv)?;
        if record.len() != header.len() {
            let (row, values, columns) = (index + 1, record.len(), header.len());
            return Err(format!("row {row}: has {values} values, but there are {columns} columns"));
        }
        let mut numbers = record.iter().zip(&columns).map(|(text, column)| {
            let faulty = |problem| format!("row {}: {column} is {problem}", index + 1);
            table.number(text).map_err(faulty)
        });
        rows.codes.extend(numbers.next().transpose()?);
        let linear = numbers.collect::<Result<Vec<f64>, String>>()?;
        for (channel, values) in rows.linear.iter_mut().enumerate() {
            values.push(linear[channel.min(linear.len() - 1)]);
        }
    }
    check(&rows, &columns)?;
    Ok(rows)
}

fn check(rows: &ResponseRows, columns: &[&str]) -> Result<(), String> {
    if rows.codes.len() < 2 {
        return Err(format!("has {} row(s); a response needs two at least", rows.codes.len()));
    }
    if let Some(code) = rows.codes.iter().find(|code| !(0.0..=1.0).contains(*code)) {
        return Err(format!(
            "a code is {code}; codes are from 0 to 1: divide those of an 8-bit file by 255"
        ));
    }
    let channels = rows.linear.iter().zip(&columns[1..]);
    for (values, column) in std::iter::once((&rows.codes, &columns[0])).chain(channels) {
        if let Some(value) = values.iter().find(|value| **value < 0.0) {
            return Err(format!("{column} is {value}; linear values are not negative"));
        }
        if let Some(row) = (1..values.len()).find(|&row| values[row] <= values[row - 1]) {
            return Err(format!(
                "is not monotone: {column} is {} in row {} and {} in row {}; both columns must grow \
                 from row to row (leave out rows where the camera clips)",
                values[row - 1],
                row,
                values[row],
                row + 1
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_curve_or_one_a_channel() {
        let one = parse(b"# c\ncode, linear\n0,0\n0.5,0.2\n# d\n1,1\n").unwrap();
        assert_eq!(one.codes, [0.0, 0.5, 1.0]);
        assert!(one.linear.iter().all(|values| values == &[0.0, 0.2, 1.0]));
        let three = parse(b"\xEF\xBB\xBFcode,r,g,b\r\n0,0,0,0.1\r\n1,1,2,3\r\n").unwrap();
        assert_eq!(three.linear, [vec![0.0, 1.0], vec![0.0, 2.0], vec![0.1, 3.0]]);
        assert_eq!(parse(b"code;linear\r\n0;0\r\n0,5;0,2\r\n1;1\r\n").unwrap(), one);
        assert_eq!(parse(b"code\tlinear\n0\t0\n0.5\t0.2\n1\t1\n").unwrap(), one);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curve.csv");
        let curve = |gamma: f64| [0.0f64, 0.25, 0.5, 1.0].map(|c| c.powf(gamma)).to_vec();
        let linear = [curve(1.8), curve(2.2), curve(2.4)];
        let mut rows = ResponseRows { codes: vec![0.0, 0.25, 0.5, 1.0], linear };
        write(&path, &rows, "a test").unwrap();
        assert_eq!(read(&path).unwrap(), rows);
        rows.linear[2][3] = f64::NAN;
        rows.linear[1][3] = 0.1;
        assert!(write(&path, &rows, "a test").is_err());
    }

    #[test]
    fn faults_say_what_to_do() {
        let faults = [
            ("", "begins with code,linear"),
            ("value,linear\n0,0\n1,1\n", "begins with code,linear"),
            ("code,linear\n", "has 0 row(s)"),
            ("code,linear\n0,0\n", "has 1 row(s)"),
            ("code,linear\n0,0\n1\n", "row 2: has 1 values"),
            ("code,linear\n0,zero\n1,1\n", "row 1: linear is \"zero\""),
            ("code,linear\n0,0\n1,nan\n", "row 2: linear is \"nan\""),
            ("code,linear\n0,0\n255,1\n", "divide those of an 8-bit file by 255"),
            ("code,linear\n0,-0.1\n1,1\n", "linear is -0.1"),
            ("code,linear\n0,0\n0.5,0.6\n1,0.5\n", "linear is 0.6 in row 2 and 0.5 in row 3"),
            ("code,r,g,b\n0,0,0,0\n1,1,1,0\n", "not monotone: b is 0"),
            ("code,linear\n0.5,0\n0.5,1\n", "not monotone: code is 0.5"),
        ];
        for (text, problem) in faults {
            let noted = parse(text.as_bytes()).expect_err(text);
            assert!(noted.contains(problem), "{text}: {noted}");
        }
    }
}
