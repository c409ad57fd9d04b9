//! JSON for the texts of EXR headers, which have bytes in an encoding that nothing states.

/// `json` with an escape for each character in its strings that is not ASCII.
///
/// ```
/// use unrender_formats::ascii_json::escaped;
///
/// assert_eq!(escaped(r#"["lamp", "à"]"#), r#"["lamp", "\u00e0"]"#);
/// ```
pub fn escaped(json: &str) -> String {
    let mut ascii = String::with_capacity(json.len());
    for unit in json.encode_utf16() {
        match u8::try_from(unit).ok().filter(u8::is_ascii) {
            Some(byte) => ascii.push(char::from(byte)),
            None => ascii.push_str(&format!("\\u{unit:04x}")),
        }
    }
    ascii
}
