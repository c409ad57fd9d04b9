//! The binary container of glTF: a header, a chunk of JSON, a chunk of bytes.

use super::Problem;

const MAGIC: &[u8; 4] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The parts of a glTF file.
pub(super) struct Parts<'a> {
    /// The JSON text.
    pub(super) json: &'a [u8],
    /// The binary chunk of a `.glb`, if there is one.
    pub(super) bin: Option<&'a [u8]>,
}

/// Splits `bytes`, a `.glb` if they start like one and the JSON of a `.gltf` else.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, Problem> {
    if bytes.is_empty() {
        return Err("is empty; export the scene again".into());
    }
    if !bytes.starts_with(MAGIC) {
        let first = bytes.iter().find(|b| !b.is_ascii_whitespace() && !b"\xEF\xBB\xBF".contains(b));
        return match first {
            Some(b'{') => {
                let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
                Ok(Parts { json, bin: None })
            }
            _ => {
                Err("is not glTF: it starts neither with \"glTF\" (.glb) nor with \"{\" (.gltf); \
                      export the scene as glTF 2.0"
                    .into())
            }
        };
    }
    let version = word(bytes, 4).ok_or_else(cut_short)?;
    if version != 2 {
        return Err(format!("is a .glb of version {version}; export it as glTF 2.0"));
    }
    let length = word(bytes, 8).ok_or_else(cut_short)? as usize;
    let whole = bytes.get(..length).ok_or_else(|| {
        format!("is cut short: {length} bytes announced, {} there; copy it again", bytes.len())
    })?;
    let (kind, json, rest) = chunk(whole.get(12..).ok_or_else(cut_short)?)?;
    if kind != JSON {
        return Err("is a .glb whose first chunk is not JSON; export it again".into());
    }
    let bin = if rest.is_empty() { None } else { Some(chunk(rest)?) };
    Ok(Parts { json, bin: bin.filter(|(kind, ..)| *kind == BIN).map(|(_, data, _)| data) })
}

/// A `.glb` of `json` and `bin`; without `bin` if that is empty.
pub(super) fn join(json: &[u8], bin: &[u8]) -> Result<Vec<u8>, Problem> {
    let padded = |length: usize| length.next_multiple_of(4);
    let bin_size = if bin.is_empty() { 0 } else { 8 + padded(bin.len()) };
    let length = 20 + padded(json.len()) + bin_size;
    let length_word = u32::try_from(length)
        .map_err(|_| format!("a .glb holds at most 4 GiB, and this would be {length} bytes"))?;
    let mut glb = Vec::with_capacity(length);
    glb.extend_from_slice(MAGIC);
    glb.extend_from_slice(&2u32.to_le_bytes());
    glb.extend_from_slice(&length_word.to_le_bytes());
    let mut add = |kind: u32, data: &[u8], padding: u8| {
        let size = padded(data.len());
        glb.extend_from_slice(&(size as u32).to_le_bytes());
        glb.extend_from_slice(&kind.to_le_bytes());
        glb.extend_from_slice(data);
        glb.resize(glb.len() + size - data.len(), padding);
    };
    add(JSON, json, b' ');
    if !bin.is_empty() {
        add(BIN, bin, 0);
    }
    Ok(glb)
}

/// The kind and the data of the first chunk of `bytes`, and what follows it.
fn chunk(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), Problem> {
    let length = word(bytes, 0).ok_or_else(cut_short)? as usize;
    let kind = word(bytes, 4).ok_or_else(cut_short)?;
    let body = &bytes[8..];
    let data = body.get(..length).ok_or_else(cut_short)?;
    Ok((kind, data, &body[length..]))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn cut_short() -> Problem {
    "is cut short or damaged: a chunk of the .glb does not fit into it; copy it again".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_splits_again() {
        let glb = join(b"{\"a\":1}", &[1, 2, 3, 4, 5]).unwrap();
        let parts = split(&glb).unwrap();
        assert_eq!(parts.json, b"{\"a\":1} ");
        assert_eq!(parts.bin.unwrap(), [1, 2, 3, 4, 5, 0, 0, 0]);
        for length in 0..glb.len() {
            assert!(split(&glb[..length]).is_err(), "{length} bytes");
        }
    }
}
