//! BMP files: pixels as they are shown, what the header declares, and what is refused.

use crate::support::Folder;
use crate::support::pictures::{read, refusal, warned};
use crate::what_is_read::{assert_taken, rows};
use moxcms::ColorProfile;
use std::path::Path;
use unrender_formats::{load_model, picture};
use unrender_scene::Rgb;

/// A header with its fields, followed by `more` (palette, masks or profile) and the rows.
struct Bmp {
    length: u32,
    size: (i32, i32),
    bits: u16,
    packing: u32,
    /// Pixels a metre across and down.
    resolution: [u32; 2],
    /// The header after its first 40 bytes.
    rest: Vec<u8>,
    more: Vec<u8>,
    rows: Vec<u8>,
}

impl Bmp {
    fn new(size: (i32, i32), bits: u16, rows: Vec<u8>) -> Self {
        let (rest, more) = (Vec::new(), Vec::new());
        Self { length: 40, size, bits, packing: 0, resolution: [2835; 2], rest, more, rows }
    }

    fn bytes(&self) -> Vec<u8> {
        let offset = 14 + self.length + self.more.len() as u32;
        let mut bytes = b"BM".to_vec();
        for number in [offset + self.rows.len() as u32, 0, offset, self.length] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(self.size.0.to_le_bytes());
        bytes.extend(self.size.1.to_le_bytes());
        bytes.extend(1u16.to_le_bytes());
        bytes.extend(self.bits.to_le_bytes());
        for number in [self.packing, 0, self.resolution[0], self.resolution[1], 0, 0] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(&self.rest);
        bytes.resize(14 + self.length as usize, 0);
        bytes.extend(&self.more);
        bytes.extend(&self.rows);
        bytes
    }
}

/// Two columns and two rows: red and green, below them blue and white; rows from the bottom, blue first, padded.
fn colours() -> Bmp {
    let rows = vec![255, 0, 0, 255, 255, 255, 0, 0, 0, 0, 255, 0, 255, 0, 0, 0];
    Bmp::new((2, 2), 24, rows)
}

const SHOWN: [[f32; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];

#[track_caller]
fn assert_shown(bmp: &Bmp) {
    let (picture, warnings) = read(&bmp.bytes());
    assert_eq!(warnings, [""; 0]);
    assert_eq!((picture.values.width(), picture.values.height()), (2, 2));
    assert_eq!(picture.values.pixels(), SHOWN.map(Rgb::from_array));
}

#[test]
fn pixels_are_as_they_are_shown() {
    assert_shown(&colours());
    // Rows from the top, with an unused byte per pixel.
    let rows = [[0, 0, 255, 9], [0, 255, 0, 9], [255, 0, 0, 9], [255, 255, 255, 9]].concat();
    assert_shown(&Bmp::new((2, -2), 32, rows));
    // By a palette of 256 colours, of which four are used.
    let mut palette = [[0, 0, 255, 0], [0, 255, 0, 0], [255, 0, 0, 0], [255, 255, 255, 0]].concat();
    palette.resize(1024, 0);
    let rows = vec![2, 3, 0, 0, 0, 1, 0, 0];
    assert_shown(&Bmp { more: palette, ..Bmp::new((2, 2), 8, rows) });
}

#[test]
fn textures_of_scenes_may_be_bmp() {
    let folder = Folder::new();
    folder.file("t.bmp", colours().bytes());
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    folder.file("q.mtl", "newmtl m\nKd 1 1 1\nmap_Kd t.bmp\n");
    let obj = format!("mtllib q.mtl\n{quad}usemtl m\nf 1/1 2/2 3/3 4/4\n");
    let xml = "<scene version=\"3.0.0\"><shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" \
               name=\"reflectance\"><string name=\"filename\" value=\"t.bmp\"/></texture></bsdf></shape></scene>";
    for path in [folder.file("q.obj", obj), folder.file("q.xml", xml)] {
        let (scene, warnings) = load_model(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(warnings.0.is_empty(), "{warnings:?}");
        let texture = scene.groups[0].material.texture.as_ref().unwrap();
        for (found, shown) in texture.image.pixels().iter().zip(SHOWN) {
            assert!(found.abs_diff_eq(Rgb::from_array(shown), 1e-5), "{}", path.display());
        }
    }
}

/// The rest of a header of version 4 or 5 that names this colour space.
fn declares(length: u32, space: &[u8; 4], more: Vec<u8>) -> Bmp {
    // After the first 40 bytes: four masks, the colour space, nine numbers of its primaries.
    let mut rest = [[0; 16].as_slice(), space.as_slice()].concat();
    if space == b"DEBM" {
        rest.resize(72, 0);
        rest.extend(length.to_le_bytes());
        rest.extend((more.len() as u32).to_le_bytes());
    }
    Bmp { length, rest, more, ..colours() }
}

#[test]
fn declared_colours_are_those_of_the_file() {
    let icc = ColorProfile::new_display_p3().encode().unwrap();
    let profile = read(&declares(124, b"DEBM", icc.clone()).bytes()).0.profile.unwrap();
    assert!(profile.understood && profile.source.contains("P3"), "{}", profile.source);
    // A profile beyond the end of the file is ignored.
    let mut cut = declares(124, b"DEBM", icc);
    cut.rest[76..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(read(&cut.bytes()).0.profile.is_none());
    for space in [b"BGRs", b" niW", &[0; 4]] {
        assert!(read(&declares(108, space, Vec::new()).bytes()).0.profile.is_none());
    }
    let elsewhere = read(&declares(124, b"KNIL", Vec::new()).bytes()).0.profile.unwrap();
    assert!(!elsewhere.understood && elsewhere.source.contains("another file"));
    let mut own = declares(108, &[0; 4], Vec::new());
    own.rest.extend([1; 36]);
    let own = read(&own.bytes()).0.profile.unwrap();
    assert!(!own.understood && own.source.contains("primaries"), "{}", own.source);
}

#[test]
fn what_a_header_says_of_pixels_is_believed_only_if_it_can_be() {
    warned(&Bmp { resolution: [2835, 5670], ..colours() }.bytes(), "2.000 times as wide as high");
    let wide = Bmp { size: (30_000, 30_000), ..colours() };
    assert!(refusal(&wide.bytes()).contains("cannot hold"));
    let whole = colours().bytes();
    assert!(refusal(&whole[..whole.len() - 1]).contains("cannot hold"));
    assert!(refusal(&whole[..20]).contains("cut short"));
    for packing in [1, 2] {
        let packed = Bmp { packing, bits: if packing == 1 { 8 } else { 4 }, ..colours() };
        assert!(refusal(&packed.bytes()).contains("RLE"));
    }
    // A JPEG within.
    assert!(refusal(&Bmp { packing: 4, ..colours() }.bytes()).contains("JPEG"));
}

#[test]
fn every_kind_of_bmp_is_taken_as_its_row_says() {
    for row in rows("Pictures: BMP") {
        let bmp = match row.element {
            "run lengths (RLE)" => Bmp { packing: 1, bits: 8, ..colours() },
            "a JPEG or PNG within" => Bmp { packing: 5, ..colours() },
            "CSType" => declares(124, b"DEBM", ColorProfile::new_display_p3().encode().unwrap()),
            _ => colours(),
        };
        let read = picture::decode(&bmp.bytes(), Path::new("p"));
        let read = read.map(|(_, warnings)| warnings).map_err(|error| error.to_string());
        assert_taken(&row, "", read);
    }
}

#[test]
fn textures_of_other_kinds_are_named() {
    let folder = Folder::new();
    folder.file("q.mtl", "newmtl m\nmap_Kd t.ktx2\n");
    folder.file("t.ktx2", b"\xabKTX 20\xbb\r\n\x1a\n");
    let obj = folder.file("q.obj", "mtllib q.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n");
    let refused = load_model(&obj).unwrap_err().to_string();
    assert!(refused.contains("but KTX 2; convert it"), "{refused}");
}
