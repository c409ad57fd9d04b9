//! Small TIFF and EXR files of any kind, made from a test's description.

use exr::meta::attribute::IntegerBounds;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use std::io::Cursor;
use std::path::Path;
use unrender_formats::picture::{self, Picture};

/// The picture in `bytes`, and the warnings.
pub(crate) fn read(bytes: &[u8]) -> (Picture, Vec<String>) {
    let (picture, warnings) = picture::decode(bytes, Path::new("p")).unwrap();
    (picture, warnings.0)
}

/// Why `bytes` are not read.
#[track_caller]
pub(crate) fn refusal(bytes: &[u8]) -> String {
    picture::decode(bytes, Path::new("p")).unwrap_err().to_string()
}

/// Asserts that `bytes` are read with one warning, which has `words`.
#[track_caller]
pub(crate) fn warned(bytes: &[u8], words: &str) -> Picture {
    let (picture, warnings) = read(bytes);
    assert!(warnings.len() == 1 && warnings[0].contains(words), "{words:?}: {warnings:?}");
    picture
}

/// A page of a TIFF.
#[derive(Clone, Default)]
pub(crate) struct Page {
    fields: Vec<(u16, u16, Vec<u32>)>,
    pixels: Vec<u8>,
    inner: Vec<Page>,
}

impl Page {
    /// A page of whole numbers of `bits` bits: grey, or RGB with further channels.
    pub(crate) fn new(
        (width, height): (u32, u32),
        samples: u32,
        bits: u32,
        pixels: Vec<u8>,
    ) -> Self {
        let mut page = Self { pixels, ..Self::default() };
        for (tag, value) in [(256, width), (257, height), (259, 1), (277, samples), (278, height)] {
            page = page.with(tag, 4, &[value]);
        }
        page.with(258, 3, &vec![bits; samples as usize]).with(
            262,
            3,
            &[if samples >= 3 { 2 } else { 1 }],
        )
    }

    /// A grey page of 8 bits, all of the same code.
    pub(crate) fn grey(size: (u32, u32), code: u8) -> Self {
        Self::new(size, 1, 8, vec![code; (size.0 * size.1) as usize])
    }

    /// The same with this field, in place of its own.
    pub(crate) fn with(mut self, tag: u16, kind: u16, values: &[u32]) -> Self {
        self.fields.retain(|field| field.0 != tag);
        self.fields.push((tag, kind, values.to_vec()));
        self
    }

    /// The same with a text.
    pub(crate) fn text(self, tag: u16, text: &str) -> Self {
        let bytes: Vec<u32> = text.bytes().chain([0]).map(u32::from).collect();
        self.with(tag, 2, &bytes)
    }

    /// The same with a page within (SubIFD).
    pub(crate) fn within(mut self, page: Page) -> Self {
        self.inner.push(page);
        self
    }

    /// Appends the page; returns the offset of its directory, and where to write that of the next
    /// one.
    fn put(&self, bytes: &mut Vec<u8>) -> (u32, usize) {
        let inner: Vec<u32> = self.inner.iter().map(|page| page.put(bytes).0).collect();
        let strip = bytes.len() as u32;
        bytes.extend(&self.pixels);
        let mut fields = self.fields.clone();
        fields.push((273, 4, vec![strip]));
        fields.push((279, 4, vec![self.pixels.len() as u32]));
        if !inner.is_empty() {
            fields.push((330, 4, inner));
        }
        fields.sort();
        let mut directory = (fields.len() as u16).to_le_bytes().to_vec();
        for (tag, kind, values) in fields {
            let number = |v: &u32| match kind {
                1 | 2 => vec![*v as u8],
                3 => (*v as u16).to_le_bytes().to_vec(),
                _ => v.to_le_bytes().to_vec(),
            };
            let mut data: Vec<u8> = values.iter().flat_map(number).collect();
            let count = if kind == 5 { values.len() / 2 } else { values.len() };
            if data.len() > 4 {
                let place = bytes.len() as u32;
                bytes.extend(&data);
                data = place.to_le_bytes().to_vec();
            }
            data.resize(4, 0);
            directory.extend(tag.to_le_bytes());
            directory.extend(kind.to_le_bytes());
            directory.extend((count as u32).to_le_bytes());
            directory.extend(data);
        }
        let at = bytes.len();
        bytes.extend(&directory);
        bytes.extend([0; 4]);
        (at as u32, at + directory.len())
    }
}

/// The TIFF of `pages`.
pub(crate) fn tiff(pages: &[Page]) -> Vec<u8> {
    let mut bytes = b"II*\0\0\0\0\0".to_vec();
    let mut link = 4;
    for page in pages {
        let (at, next) = page.put(&mut bytes);
        bytes[link..link + 4].copy_from_slice(&at.to_le_bytes());
        link = next;
    }
    bytes
}

/// A part of an EXR: its name, where its data begin, their size, and channels of one value each.
pub(crate) struct Part<'a> {
    pub(crate) name: &'a str,
    pub(crate) from: (i32, i32),
    pub(crate) size: (usize, usize),
    pub(crate) channels: &'a [(&'a str, f32)],
}

/// An EXR part of 4 x 3 pixels.
pub(crate) fn part<'a>(name: &'a str, channels: &'a [(&'a str, f32)]) -> Part<'a> {
    Part { name, from: (0, 0), size: (4, 3), channels }
}

/// The EXR of `parts` with a display window from `from` on, after `change` of the attributes.
pub(crate) fn exr_of(
    parts: &[Part<'_>],
    window: IntegerBounds,
    change: impl Fn(&mut exr::meta::header::ImageAttributes, &mut LayerAttributes),
) -> Vec<u8> {
    let mut shared = exr::meta::header::ImageAttributes::new(window);
    let mut layers: Vec<Layer<AnyChannels<FlatSamples>>> = Vec::new();
    for part in parts {
        let mut own = LayerAttributes {
            layer_name: (!part.name.is_empty()).then(|| part.name.into()),
            layer_position: Vec2(part.from.0, part.from.1),
            ..LayerAttributes::default()
        };
        change(&mut shared, &mut own);
        let channel = |(name, value): &(&str, f32)| {
            AnyChannel::new(*name, FlatSamples::F32(vec![*value; part.size.0 * part.size.1]))
        };
        let channels = AnyChannels::sort(part.channels.iter().map(channel).collect());
        layers.push(Layer::new(part.size, own, Encoding::SMALL_LOSSLESS, channels));
    }
    let mut out = Cursor::new(Vec::new());
    let written = if layers.len() == 1 {
        let mut image = Image::from_layer(layers.remove(0));
        image.attributes = shared;
        image.write().to_buffered(&mut out)
    } else {
        Image::from_layers(shared, layers).write().to_buffered(&mut out)
    };
    written.unwrap();
    out.into_inner()
}

/// The EXR of these parts of 4 x 3 pixels.
pub(crate) fn exr(parts: &[Part<'_>]) -> Vec<u8> {
    exr_of(parts, IntegerBounds::from_dimensions((4, 3)), |_, _| {})
}

/// The head of an EXR with these channels, their sampling, this compression and type: no pixels follow.
pub(crate) fn exr_head(channels: &[(&str, u32)], compression: u8, kind: &str) -> Vec<u8> {
    let mut list = Vec::new();
    for (name, sampling) in channels {
        list.extend([name.as_bytes(), b"\0\x01\0\0\0\0\0\0\0"].concat());
        list.extend([sampling.to_le_bytes(), sampling.to_le_bytes()].concat());
    }
    list.push(0);
    let flags: u32 = if kind.starts_with("deep") { 2 | 1 << 11 } else { 2 };
    let mut bytes = [&[0x76, 0x2f, 0x31, 0x01][..], &flags.to_le_bytes()].concat();
    let window: Vec<u8> = [0i32, 0, 3, 1].iter().flat_map(|n| n.to_le_bytes()).collect();
    let one = 1f32.to_le_bytes();
    let attributes: [(&str, &str, &[u8]); 12] = [
        ("channels", "chlist", &list),
        ("chunkCount", "int", &[1, 0, 0, 0]),
        ("compression", "compression", &[compression]),
        ("dataWindow", "box2i", &window),
        ("displayWindow", "box2i", &window),
        ("lineOrder", "lineOrder", &[0]),
        ("name", "string", b"part"),
        ("pixelAspectRatio", "float", &one),
        ("screenWindowCenter", "v2f", &[0; 8]),
        ("screenWindowWidth", "float", &one),
        ("type", "string", kind.as_bytes()),
        ("version", "int", &[1, 0, 0, 0]),
    ];
    for (name, kind, value) in attributes {
        bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    }
    bytes.push(0);
    bytes.extend([0xff; 400]);
    bytes
}

/// A PNG with one more chunk after its header.
pub(crate) fn with_chunk(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    crc.update(data);
    let length = (data.len() as u32).to_be_bytes();
    let chunk = [&length, kind.as_slice(), data, &crc.sum().to_be_bytes()].concat();
    [&png[..33], &chunk, &png[33..]].concat()
}
