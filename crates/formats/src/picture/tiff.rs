//! The directories of a TIFF file, read before a decoder looks at one of them.
//!
//! Counts and offsets come from the file and are not trusted: what lies outside of it counts as
//! missing.

/// The size of a number of each kind of field, bytes, by the kind's code.
const SIZES: [usize; 19] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8];

/// The tags that are read.
pub(super) mod tag {
    pub(in super::super) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(in super::super) const SUBFILE_TYPE: u16 = 255;
    pub(in super::super) const WIDTH: u16 = 256;
    pub(in super::super) const HEIGHT: u16 = 257;
    pub(in super::super) const BITS: u16 = 258;
    pub(in super::super) const COMPRESSION: u16 = 259;
    pub(in super::super) const PHOTOMETRIC: u16 = 262;
    pub(in super::super) const MAKE: u16 = 271;
    pub(in super::super) const STRIPS: u16 = 273;
    pub(in super::super) const SAMPLES: u16 = 277;
    pub(in super::super) const X_RESOLUTION: u16 = 282;
    pub(in super::super) const Y_RESOLUTION: u16 = 283;
    pub(in super::super) const TRANSFER_FUNCTION: u16 = 301;
    pub(in super::super) const WHITE_POINT: u16 = 318;
    pub(in super::super) const PRIMARIES: u16 = 319;
    pub(in super::super) const TILES: u16 = 324;
    pub(in super::super) const SUB_IFDS: u16 = 330;
    pub(in super::super) const EXTRA_SAMPLES: u16 = 338;
    pub(in super::super) const SAMPLE_FORMAT: u16 = 339;
    pub(in super::super) const ICC_PROFILE: u16 = 34_675;
    pub(in super::super) const CFA_DIMENSIONS: u16 = 33_421;
    pub(in super::super) const CFA_PATTERN: u16 = 33_422;
    pub(in super::super) const NO_DATA: u16 = 42_113;
    pub(in super::super) const DNG_VERSION: u16 = 50_706;
}

/// A TIFF file, or one of BigTIFF.
pub(super) struct Tiff<'a> {
    bytes: &'a [u8],
    little: bool,
    big: bool,
}

/// One directory: the fields of a picture.
#[derive(Clone, Debug, Default)]
pub(super) struct Directory {
    /// Where it is in the file.
    pub at: u64,
    /// The offset of the next one; zero after the last.
    pub next: u64,
    fields: Vec<Field>,
}

#[derive(Clone, Copy, Debug)]
struct Field {
    tag: u16,
    kind: u16,
    count: usize,
    /// Where its numbers are in the file.
    at: usize,
}

impl<'a> Tiff<'a> {
    /// None if the bytes do not begin like a TIFF.
    pub(super) fn of(bytes: &'a [u8]) -> Option<Self> {
        let (little, big) = match bytes.get(..4)? {
            b"II*\0" => (true, false),
            b"MM\0*" => (false, false),
            b"II+\0" => (true, true),
            b"MM\0+" => (false, true),
            _ => return None,
        };
        Some(Self { bytes, little, big })
    }

    /// Where the first directory is.
    pub(super) fn first(&self) -> Option<u64> {
        if self.big { self.whole(8, 8) } else { self.whole(4, 4) }
    }

    /// The file with the directory at `at` as its first one.
    pub(super) fn beginning_at(&self, at: u64) -> Vec<u8> {
        let mut bytes = self.bytes.to_vec();
        let (place, size) = if self.big { (8, 8) } else { (4, 4) };
        let number = if self.little { at.to_le_bytes() } else { at.to_be_bytes() };
        let number = if self.little { &number[..size] } else { &number[8 - size..] };
        if let Some(field) = bytes.get_mut(place..place + size) {
            field.copy_from_slice(number);
        }
        bytes
    }

    /// The directory at `at`; none if it does not lie in the file.
    pub(super) fn directory(&self, at: u64) -> Option<Directory> {
        let start = usize::try_from(at).ok()?;
        let (head, each, value) = if self.big { (8, 20, 12) } else { (2, 12, 8) };
        let count = usize::try_from(self.whole(start, head)?).ok()?;
        let first = start.checked_add(head)?;
        let end = first.checked_add(count.checked_mul(each)?)?;
        // The list must be there before memory is taken for it.
        self.bytes.get(first..end)?;
        let field = |k: usize| {
            let at = first + k * each;
            let kind = self.whole(at + 2, 2)? as u16;
            let count = usize::try_from(self.whole(at + 4, value - 4)?).ok()?;
            let size = count.checked_mul(*SIZES.get(usize::from(kind))?)?;
            let place = if size <= each - value {
                at + value
            } else {
                usize::try_from(self.whole(at + value, each - value)?).ok()?
            };
            self.bytes.get(place..place.checked_add(size)?)?;
            Some(Field { tag: self.whole(at, 2)? as u16, kind, count, at: place })
        };
        let fields = (0..count).filter_map(field).collect();
        let next = self.whole(end, if self.big { 8 } else { 4 }).unwrap_or(0);
        Some(Directory { at, next, fields })
    }

    /// How many numbers the field has.
    pub(super) fn count(&self, directory: &Directory, tag: u16) -> usize {
        directory.field(tag).map_or(0, |field| field.count)
    }

    /// The number at `index` of the field; none if it has none there.
    pub(super) fn number(&self, directory: &Directory, tag: u16, index: usize) -> Option<f64> {
        let field = directory.field(tag).filter(|field| index < field.count)?;
        let size = SIZES[usize::from(field.kind)];
        let at = field.at + index * size;
        let whole = self.whole(at, size.min(8))?;
        Some(match field.kind {
            5 => self.whole(at, 4)? as f64 / self.whole(at + 4, 4)? as f64,
            10 => {
                f64::from(self.whole(at, 4)? as u32 as i32)
                    / f64::from(self.whole(at + 4, 4)? as u32 as i32)
            }
            6 => f64::from(whole as u8 as i8),
            8 => f64::from(whole as u16 as i16),
            9 => f64::from(whole as u32 as i32),
            11 => f64::from(f32::from_bits(whole as u32)),
            12 => f64::from_bits(whole),
            17 => whole as i64 as f64,
            _ => whole as f64,
        })
    }

    /// The first number of the field, as a whole one.
    pub(super) fn code(&self, directory: &Directory, tag: u16) -> Option<u64> {
        self.number(directory, tag, 0).map(|number| number as u64)
    }

    /// The bytes of the field.
    pub(super) fn bytes(&self, directory: &Directory, tag: u16) -> Option<&[u8]> {
        let field = directory.field(tag)?;
        self.bytes.get(field.at..field.at + field.count * SIZES[usize::from(field.kind)])
    }

    /// The text of the field, up to the first zero.
    pub(super) fn text(&self, directory: &Directory, tag: u16) -> Option<String> {
        let field = directory.field(tag).filter(|field| field.kind == 2)?;
        let bytes = self.bytes.get(field.at..field.at + field.count)?;
        let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
        Some(String::from_utf8_lossy(text).trim().to_owned())
    }

    /// A whole number of `size` bytes, at most eight.
    fn whole(&self, at: usize, size: usize) -> Option<u64> {
        let bytes = self.bytes.get(at..at.checked_add(size)?)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(if self.little { bytes.iter().rev().fold(0, add) } else { bytes.iter().fold(0, add) })
    }
}

impl Directory {
    /// Whether there is such a field.
    pub(super) fn has(&self, tag: u16) -> bool {
        self.field(tag).is_some()
    }

    /// The number of its fields.
    pub(super) fn len(&self) -> usize {
        self.fields.len()
    }

    fn field(&self, tag: u16) -> Option<&Field> {
        self.fields.iter().find(|field| field.tag == tag)
    }
}
