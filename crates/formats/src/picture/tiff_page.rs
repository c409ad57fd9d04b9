//! Which directory of a TIFF file is the photograph: not a preview, and not part of a raw file.

use super::raw;
use super::tiff::{Directory, Tiff, tag};

/// A file with more directories, or more fields in all of them, is not a picture.
const DIRECTORIES: usize = 4096;
const FIELDS: usize = 1 << 18;
/// The photometric interpretations of raw files: values of a sensor under its colour filters, and the same
/// interpolated but not developed.
const RAW_PHOTOMETRIC: [u64; 2] = [32_803, 34_892];
/// Compressions that raw files alone have: those of Sony, Samsung, Nikon, lossy DNG, Kodak and Pentax.
const RAW_COMPRESSION: [u64; 7] = [32_767, 32_769, 32_770, 34_713, 34_892, 65_000, 65_535];
/// The bits of NewSubfileType that mark a page as no picture of its own: a reduced one, a mask, a depth
/// map, ...
const NO_PICTURE: u64 = 0b1_1101;

/// The directory of the photograph.
pub(super) struct Page {
    /// Its fields.
    pub directory: Directory,
    /// Whether it is the first one of the file.
    pub is_first: bool,
    /// A note on the choice for the user, as the end of a sentence about the file.
    pub note: Option<String>,
}

/// Chooses the page of `tiff` that is the photograph; none if the file has no directory that can be read.
///
/// # Errors
/// If the file is a raw one, or if its only pictures of full size are in directories within others.
pub(super) fn choose(tiff: &Tiff<'_>) -> Result<Option<Page>, String> {
    let pages = chain(tiff, tiff.first().unwrap_or(0))?;
    if pages.is_empty() {
        return Ok(None);
    }
    let inner = within(tiff, &pages)?;
    if pages.iter().chain(&inner).any(|directory| is_raw(tiff, directory)) {
        return Err(raw::refusal(&raw_name(tiff, &pages)));
    }
    let size = |directory: &Directory| area(tiff, directory);
    let full: Vec<usize> = (0..pages.len()).filter(|k| is_picture(tiff, &pages[*k])).collect();
    let largest = inner.iter().filter(|d| is_picture(tiff, d)).map(size).max().unwrap_or(0);
    let Some(&taken) = full.first() else {
        return Err(if largest > 0 {
            raw::refusal("a TIFF whose pages are previews of a picture within")
        } else {
            "has reduced pictures (previews) only, by its NewSubfileType; save the picture itself as a TIFF".into()
        });
    };
    if largest > size(&pages[taken]) {
        return Err(raw::refusal("a TIFF whose page is smaller than a picture within (SubIFD)"));
    }
    let [number, count] = [taken + 1, pages.len()];
    let note = if full.len() > 1 {
        Some(format!("has {} pictures; page {number} was read, and no other", full.len()))
    } else {
        (taken > 0).then(|| format!("begins with a preview; page {number} of {count} was read"))
    };
    Ok(Some(Page { directory: pages[taken].clone(), is_first: taken == 0, note }))
}

/// The directories from the one at `at` on.
fn chain(tiff: &Tiff<'_>, mut at: u64) -> Result<Vec<Directory>, String> {
    let mut found: Vec<Directory> = Vec::new();
    let mut fields = 0;
    let mut places = std::collections::BTreeSet::new();
    while at != 0 {
        let Some(directory) = tiff.directory(at) else { break };
        fields += directory.len();
        if !places.insert(at) || found.len() >= DIRECTORIES || fields > FIELDS {
            return Err(format!(
                "has an endless chain of directories, or more than {DIRECTORIES}; save it again"
            ));
        }
        at = directory.next;
        found.push(directory);
    }
    Ok(found)
}

/// The directories within `pages` (SubIFDs).
fn within(tiff: &Tiff<'_>, pages: &[Directory]) -> Result<Vec<Directory>, String> {
    let mut found = Vec::new();
    let mut fields = 0;
    for page in pages {
        for k in 0..tiff.count(page, tag::SUB_IFDS) {
            let Some(at) = tiff.number(page, tag::SUB_IFDS, k) else { break };
            let Some(directory) = tiff.directory(at as u64) else { continue };
            fields += directory.len();
            if found.len() >= DIRECTORIES || fields > FIELDS {
                return Err(format!("has more than {DIRECTORIES} directories; save it again"));
            }
            found.push(directory);
        }
    }
    Ok(found)
}

fn area(tiff: &Tiff<'_>, directory: &Directory) -> u64 {
    let side = |tag| tiff.code(directory, tag).unwrap_or(0);
    side(tag::WIDTH).saturating_mul(side(tag::HEIGHT))
}

/// Whether it is a picture of its own, and not a preview, a mask or a thumbnail.
fn is_picture(tiff: &Tiff<'_>, directory: &Directory) -> bool {
    let code = |tag| tiff.code(directory, tag).unwrap_or(0);
    let is_reduced = code(tag::NEW_SUBFILE_TYPE) & NO_PICTURE != 0 || code(tag::SUBFILE_TYPE) == 2;
    // EXIF's thumbnails are JPEG files without strips.
    let has_pixels = directory.has(tag::STRIPS) || directory.has(tag::TILES);
    !is_reduced && has_pixels
}

fn is_raw(tiff: &Tiff<'_>, directory: &Directory) -> bool {
    let is =
        |tag, codes: &[u64]| tiff.code(directory, tag).is_some_and(|code| codes.contains(&code));
    is(tag::PHOTOMETRIC, &RAW_PHOTOMETRIC)
        || is(tag::COMPRESSION, &RAW_COMPRESSION)
        || [tag::DNG_VERSION, tag::CFA_DIMENSIONS, tag::CFA_PATTERN]
            .iter()
            .any(|t| directory.has(*t))
}

/// What kind of raw file it is.
fn raw_name(tiff: &Tiff<'_>, pages: &[Directory]) -> String {
    if pages.iter().any(|page| page.has(tag::DNG_VERSION)) {
        return "a raw file (DNG)".into();
    }
    let make = pages.iter().find_map(|page| tiff.text(page, tag::MAKE)).unwrap_or_default();
    raw::of_maker(&make)
}
