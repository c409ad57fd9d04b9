//! The line behind the header of a Radiance picture: its size, and how its pixels stand.
//!
//! The first axis is that from one row of the file to the next, the second that along a row; a sign says
//! whether the coordinate grows. X grows to the right and Y upwards, so that pictures mostly begin with
//! `-Y height +X width`. [Radiance, File Formats]

use std::borrow::Cow;

/// The axes of each line, and the number that EXIF has for it.
const STANDING: [(&str, &str, u8); 8] = [
    ("-Y", "+X", 1),
    ("-Y", "-X", 2),
    ("+Y", "-X", 3),
    ("+Y", "+X", 4),
    ("+X", "-Y", 5),
    ("-X", "-Y", 6),
    ("-X", "+Y", 7),
    ("+X", "+Y", 8),
];

/// The picture in `bytes` as a decoder reads it that knows no line but `-Y height +X width`, and the number that EXIF has for
/// how what it reads is turned to stand upright.
///
/// # Errors
/// If the line is none, as the end of a sentence about the file.
pub(super) fn as_rows(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, u8), String> {
    let Some(empty) = bytes.windows(2).position(|pair| pair == b"\n\n") else {
        return Err("is cut short: its header has no end".into());
    };
    let (header, rest) = bytes.split_at(empty + 2);
    let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
    let line = String::from_utf8_lossy(&rest[..end.min(LONGEST)]);
    let wrong = || {
        format!(
            "has the line \"{}\" behind its header, which states no size such as -Y 512 +X 1024",
            line.escape_debug()
        )
    };
    let words: Vec<&str> = line.split_whitespace().collect();
    let [first, rows, second, columns] = words[..] else { return Err(wrong()) };
    let standing = STANDING.iter().find(|(a, b, _)| (*a, *b) == (first, second));
    let (.., number) = *standing.ok_or_else(wrong)?;
    if number == 1 {
        return Ok((Cow::Borrowed(bytes), number));
    }
    let line = format!("-Y {rows} +X {columns}");
    let whole = [header, line.as_bytes(), &rest[end..]].concat();
    Ok((Cow::Owned(whole), number))
}

/// The longest line that is looked at, bytes: four words of ten digits and signs have fewer. At half of it sizes
/// with blanks in front could be cut; double would only quote more of a faulty file.
const LONGEST: usize = 80;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_lines_are_refused_in_words() {
        for (line, quoted) in [("-Y 1", "\"-Y 1\""), ("-Y 1 -Y 1", "-Y 1 -Y 1"), ("\0\u{7}", "\\0")]
        {
            let bytes = format!("#?RADIANCE\n\n{line}\n");
            let problem = as_rows(bytes.as_bytes()).unwrap_err();
            assert!(problem.contains(quoted) && problem.contains("such as -Y 512"), "{problem}");
        }
        assert!(as_rows(b"#?RADIANCE\n").unwrap_err().contains("cut short"));
    }
}
