//! Raw files and TIFFs of several pages: the photograph is read, not simply the first page.

use crate::support::pictures::{Page, read, refusal, tiff, warned};
use crate::support::{Numbers, damaged};
use std::path::Path;
use unrender_formats::picture;

const PREVIEW: (u16, u16, [u32; 1]) = (254, 4, [1]);

/// The page, marked as a reduced one.
fn preview(size: (u32, u32)) -> Page {
    let rgb = vec![90; (3 * size.0 * size.1) as usize];
    Page::new(size, 3, 8, rgb).with(PREVIEW.0, PREVIEW.1, &PREVIEW.2)
}

/// A page of raw sensor values.
fn sensor(size: (u32, u32)) -> Page {
    Page::new(size, 1, 16, vec![7; (2 * size.0 * size.1) as usize])
        .with(262, 3, &[32_803])
        .with(33_421, 3, &[2, 2])
        .with(33_422, 1, &[0, 1, 1, 2])
}

#[track_caller]
fn is_raw(bytes: &[u8], name: &str) {
    let said = refusal(bytes);
    assert!(said.contains(name) && said.contains("TIFF of 16 bits or a linear EXR"), "{said}");
}

#[test]
fn raw_files_are_refused_by_name() {
    let dng = preview((8, 6)).within(sensor((32, 24))).with(50_706, 1, &[1, 4, 0, 0]);
    is_raw(&tiff(&[dng]), "raw file (DNG)");
    for (make, name) in [("NIKON CORPORATION", "NEF"), ("SONY", "ARW"), ("Canon", "CR2")] {
        let page = preview((8, 6)).within(sensor((32, 24))).text(271, make);
        is_raw(&tiff(&[page]), &format!("raw file ({name})"));
    }
    // The sensor's page first, as by Pentax; its values interpolated; a colour filter over values
    // called grey.
    is_raw(&tiff(&[sensor((8, 8)), preview((4, 4))]), "raw file");
    let linear = Page::new((4, 4), 3, 16, vec![9; 96]);
    is_raw(&tiff(&[linear.clone().with(262, 3, &[34_892])]), "raw file");
    is_raw(&tiff(&[linear.with(50_706, 1, &[1, 4, 0, 0])]), "raw file (DNG)");
    is_raw(&tiff(&[sensor((8, 8)).with(262, 3, &[1])]), "raw file");
    is_raw(&tiff(&[Page::grey((8, 8), 3).with(259, 3, &[34_713])]), "raw file");
    // A larger picture within, and one only within.
    is_raw(&tiff(&[Page::grey((4, 4), 3).within(Page::grey((8, 8), 3))]), "SubIFD");
    is_raw(&tiff(&[preview((4, 4)).within(Page::grey((8, 8), 3))]), "previews");
}

#[test]
fn raw_files_that_are_no_tiff_are_known_by_how_they_begin() {
    for (begins, name) in [
        (&b"II*\0\x10\0\0\0CR\x02\0"[..], "CR2"),
        (b"\0\0\0\x18ftypcrx \0\0\0\x01crx isom", "CR3"),
        (b"FUJIFILMCCD-RAW 0201FF389301", "RAF"),
        (b"IIRO\x08\0\0\0", "ORF"),
        (b"IIU\0\x18\0\0\0", "RW2"),
        (b"FOVb\0\0\x02\0", "X3F"),
        (b"\0MRM\0\0\0\0", "MRW"),
        (b"II\x1a\0\0\0HEAPCCDR", "CRW"),
        (b"II*\0\x08\0\0\0IIIITwaR", "IIQ"),
    ] {
        is_raw(&[begins, &[0; 64]].concat(), &format!("raw file ({name})"));
    }
    for (begins, name) in
        [(&b"\0\0\0\x18ftypheic\0\0\0\0"[..], "HEIC"), (b"RIFF\x10\0\0\0WEBPVP8 ", "WebP")]
    {
        let said = refusal(begins);
        assert!(said.contains(&format!("but {name}, which is not read; save it")), "{said}");
    }
}

#[test]
fn the_content_counts_and_not_the_name() {
    let plain = tiff(&[Page::grey((3, 2), 40)]);
    let (picture, warnings) = picture::decode(&plain, Path::new("photo.dng")).unwrap();
    assert!(picture.values.width() == 3 && warnings.0.is_empty());
    let raw = tiff(&[preview((8, 6)).within(sensor((32, 24)))]);
    assert!(picture::decode(&raw, Path::new("photo.tif")).is_err());
    // Four pixels of the code 73 are not the mark of an IIQ.
    let (picture, _) = read(&tiff(&[Page::grey((4, 4), b'I')]));
    assert_eq!(picture.values.pixels()[3].x, 73.0 / 255.0);
}

#[test]
fn the_first_page_that_is_no_preview_is_the_photograph() {
    let code = |picture: picture::Picture| (picture.values.pixels()[0].x * 255.0).round();
    let pages = [preview((4, 4)), Page::grey((8, 8), 50)];
    let picture = warned(&tiff(&pages), "begins with a preview; page 2 of 2 was read");
    assert_eq!((picture.values.width(), code(picture)), (8, 50.0));
    let pages = [Page::grey((4, 4), 20), Page::grey((8, 8), 50), preview((2, 2))];
    assert_eq!(code(warned(&tiff(&pages), "has 2 pictures; page 1 was read")), 20.0);
    // A mask, a thumbnail and a pyramid are no pictures.
    let mask = Page::grey((8, 8), 1).with(254, 4, &[4]);
    let old = Page::grey((2, 2), 1).with(255, 3, &[2]);
    let pyramid = Page::grey((8, 8), 50).within(preview((4, 4)));
    let (picture, warnings) = read(&tiff(&[pyramid, mask, old]));
    assert!(code(picture) == 50.0 && warnings.is_empty(), "{warnings:?}");
    assert!(refusal(&tiff(&[preview((4, 4))])).contains("previews"));
}

#[test]
fn directories_without_end_are_refused() {
    let mut bytes = tiff(&[Page::grey((2, 2), 9)]);
    let first = bytes[4..8].to_vec();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&first);
    assert!(refusal(&bytes).contains("an endless chain"));
    // A directory whose count leads out of the file, and a SubIFD that does.
    let mut lost = tiff(&[Page::grey((2, 2), 9)]);
    let at = u32::from_le_bytes(lost[4..8].try_into().unwrap()) as usize;
    lost[at..at + 2].copy_from_slice(&[0xff; 2]);
    assert!(refusal(&lost).contains("corrupt"));
    assert_eq!(read(&tiff(&[Page::grey((2, 2), 9).with(330, 4, &[u32::MAX])])).1, [""; 0]);
}

#[test]
fn large_tiffs_are_read_by_their_content() {
    // The header and the directory of BigTIFF: 1 x 1, grey.
    let fields: [(u16, u16, u64); 9] = [
        (256, 4, 1),
        (257, 4, 1),
        (258, 3, 8),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 16),
        (277, 3, 1),
        (278, 4, 1),
        (279, 4, 1),
    ];
    let mut bytes = b"II+\0\x08\0\0\0".to_vec();
    bytes.extend(24u64.to_le_bytes());
    bytes.extend([51, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend((fields.len() as u64).to_le_bytes());
    for (tag, kind, value) in fields {
        bytes.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        bytes.extend([1u64.to_le_bytes(), value.to_le_bytes()].concat());
    }
    bytes.extend([0; 8]);
    assert_eq!(read(&bytes).0.values.pixels()[0].x, 0.2);
}

#[test]
fn damaged_directories_never_panic() {
    let whole = tiff(&[
        preview((4, 4)).within(Page::grey((3, 3), 5)).text(42_113, "5"),
        Page::grey((8, 8), 50).with(301, 3, &[7; 256]).with(282, 5, &[72, 1]).with(
            283,
            5,
            &[36, 1],
        ),
    ]);
    assert!(picture::decode(&whole, Path::new("p")).is_ok());
    let mut numbers = Numbers(5);
    for _ in 0..4000 {
        let _ = picture::decode(&damaged(&whole, &mut numbers), Path::new("p"));
    }
}
