//! The chunks of a PNG file that its decoder does not hand on: declared colours and the shape of pixels.

/// The data of the first chunk called `name` before the pixels.
pub(super) fn find<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let mut rest = bytes.get(8..)?;
    loop {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (kind, data) = after.split_first_chunk::<4>()?;
        let length = usize::try_from(u32::from_be_bytes(*length)).ok()?;
        if kind == b"IDAT" {
            return None;
        }
        let (data, after) = data.split_at_checked(length)?;
        if kind == name {
            return Some(data);
        }
        // Behind the checksum.
        rest = after.get(4..)?;
    }
}

/// How many times as wide as high the pixels are, by the chunk pHYs.
pub(super) fn pixel_aspect(bytes: &[u8]) -> Option<f64> {
    let data = find(bytes, b"pHYs")?;
    let (across, rest) = data.split_first_chunk::<4>()?;
    let (down, _) = rest.split_first_chunk::<4>()?;
    Some(f64::from(u32::from_be_bytes(*down)) / f64::from(u32::from_be_bytes(*across)))
}
