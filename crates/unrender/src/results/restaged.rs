//! The files that `restage` writes into its folder.

use crate::Error;
use crate::edit::{Composite, Photograph};
use crate::report::{self, Exhibit, Gallery};
use std::ops::Range;
use std::path::Path;
use unrender_formats::picture::{self, ColourSpace, Depth, Passes};
use unrender_formats::{FileError, atomic};
use unrender_restage::pair::{self, Paired};
use unrender_scene::{Rgb, RgbImage};

/// The most pictures of a sequence that its gallery shows.
const SHOWN_MAX: usize = 24;

/// Writes a composite, the photograph from which it was made, its masks and its gallery; returns
/// how many values were not finite.
///
/// `composite.exr` is radiance, or, for photographs of floating-point values, in the values of the
/// photograph's file unless a colour `space` is asked for.
pub(crate) fn write_composite(
    composite: &Composite,
    photograph: &Photograph,
    edits: &[String],
    space: Option<ColourSpace>,
    folder: &Path,
) -> Result<usize, Error> {
    let codes = composite.codes(photograph);
    let (exr, png) = (folder.join("composite.exr"), folder.join("composite.png"));
    let mut bad = 0;
    match photograph.picture.depth {
        Depth::Float => {
            let srgb_from_file = photograph.transfer.srgb_from_file;
            bad += match space {
                None => picture::write_exr_as(&exr, &codes, srgb_from_file)?,
                Some(space) => {
                    let linear = codes.map(|v| srgb_from_file.map_or(*v, |matrix| matrix * *v));
                    picture::write_exr_in(&exr, &linear, space)?
                }
            };
            bad += picture::write_png_srgb(&png, &as_srgb(photograph, &composite.radiance))?;
        }
        _ => {
            bad += picture::write_exr_in(&exr, &composite.radiance, space.unwrap_or_default())?;
            bad += write_codes(&png, photograph, &codes)?;
        }
    }
    let share = |of: fn(&Paired) -> f32| composite.paired.map(|pixel| Rgb::splat(of(pixel)));
    let touched = composite.touched.map(|&touched| Rgb::splat(f32::from(u8::from(touched))));
    for (name, mask) in [("touched", touched), ("invented", share(|pixel| pixel.uncovered))] {
        picture::write_png_codes(&folder.join(format!("{name}.png")), &mask, Depth::Eight)?;
    }
    let space = space.unwrap_or_default();
    let after = Synthetic { radiance: &pair::after(&composite.paired), is_denoised: false, space };
    bad += write_synthetic(&after, Some(photograph), folder, None)?;
    bad += write_photograph(photograph, folder)?;
    let pair = [
        exhibit("photo.png", "photograph", "The photograph."),
        exhibit("composite.png", "composite", "The photograph with the change composited into it."),
    ];
    let others = [
        exhibit("synthetic.png", "Synthetic", "The scene after the edits, rendered whole."),
        exhibit("touched.png", "Touched", "White: pixels of the photograph that were changed."),
        exhibit(
            "invented.png",
            "Invented",
            "White: pixels whose content the photograph does not show.",
        ),
    ];
    let gallery = Gallery { edits, pair: Some(&pair), exhibits: &others, ..titled() };
    write_page(folder, folder, &gallery)?;
    Ok(bad)
}

/// Writes the photograph for the gallery, in the encoding of the pictures beside it; returns how many values were not
/// finite.
pub(crate) fn write_photograph(photograph: &Photograph, folder: &Path) -> Result<usize, FileError> {
    let file = folder.join("photo.png");
    match photograph.picture.depth {
        Depth::Float => {
            picture::write_png_srgb(&file, &as_srgb(photograph, &photograph.photo.radiance))
        }
        _ => write_codes(&file, photograph, &photograph.picture.values),
    }
}

/// Writes code values of the photograph's camera at its depth, with the profile of their encoding; returns how many
/// values were not finite.
fn write_codes(file: &Path, photograph: &Photograph, codes: &RgbImage) -> Result<usize, FileError> {
    let icc = photograph.icc().map_err(|problem| FileError::new(file, problem))?;
    picture::write_png_as(file, codes, photograph.picture.depth, icc.as_deref())
}

/// Whether [`write_composite`] writes a file of this name.
pub(crate) fn writes_composite(name: &str) -> bool {
    let own = ["touched.png", "invented.png", "photo.png", "gallery.html", "manifest.json"];
    let pictures =
        ["composite.exr", "composite.png", "synthetic.exr", "synthetic.png", "passes.exr"];
    own.contains(&name) || pictures.contains(&name)
}

/// Whether the pictures `frames` of a sequence, or all of it, have a file of this name.
pub(crate) fn writes_synthetic(name: &str, frames: Option<&Range<u32>>) -> bool {
    let stem = name.strip_suffix(".exr").or(name.strip_suffix(".png"));
    let of = |name: &str| stem.and_then(|stem| stem.strip_prefix(name)?.strip_prefix('_'));
    let number = of(SYNTHETIC).or_else(|| of(PASSES));
    let is_one = number.and_then(|number| number.parse().ok());
    let is_one = is_one.is_some_and(|n: u32| frames.is_none_or(|frames| frames.contains(&n)));
    stem == Some(SYNTHETIC)
        || stem == Some(PASSES)
        || is_one
        || ["photo.png", "gallery.html", "manifest.json"].contains(&name)
}

/// Synthetic pictures as a gallery shows them.
pub(crate) struct Restaged<'a> {
    /// The number of each in its sequence; none of the only one.
    pub(crate) numbers: &'a [Option<usize>],
    /// Whether they were denoised.
    pub(crate) is_denoised: bool,
    /// Whether there is a photograph, in photo.png, and whether the only picture shows the same pixels.
    pub(crate) photograph: Option<Beside>,
    /// The edits, a sentence each.
    pub(crate) edits: &'a [String],
}

/// How a photograph stands beside new pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    /// The only new picture has its camera and size.
    SameView,
    /// They have other cameras or sizes.
    OtherView,
}

/// Writes the gallery of synthetic pictures in the folder `pictures`.
pub(crate) fn write_gallery(
    pictures: &Path,
    folder: &Path,
    restaged: &Restaged<'_>,
) -> Result<(), Error> {
    let mut caption =
        if restaged.edits.is_empty() { "The scene." } else { "The scene after the edits." }
            .to_owned();
    if restaged.is_denoised {
        caption.push_str(" Denoised: neighbouring pixels have errors in common.");
    }
    let caption = caption.as_str();
    let step = restaged.numbers.len().div_ceil(SHOWN_MAX).max(1);
    let shown = restaged.numbers.iter().step_by(step).map(|number| {
        let title = number.map_or("Picture".to_owned(), |n| format!("Picture {n}"));
        exhibit(&format!("{}.png", name_of(*number)), &title, caption)
    });
    let photograph = exhibit("photo.png", "photograph", "The photograph.");
    let mut exhibits: Vec<Exhibit> = shown.collect();
    let pair = match (&exhibits[..], restaged.photograph) {
        ([only], Some(Beside::SameView)) => {
            Some([photograph.clone(), exhibit(&only.file, "edited", caption)])
        }
        _ => None,
    };
    match pair {
        Some(_) => exhibits.clear(),
        None if restaged.photograph.is_some() => exhibits.insert(0, photograph),
        None => {}
    }
    let lead = match restaged.edits {
        [] => "The scene as it is, without edits.",
        _ => "The scene after these edits:",
    };
    let gallery = Gallery {
        lead,
        edits: restaged.edits,
        pair: pair.as_ref(),
        exhibits: &exhibits,
        ..titled()
    };
    write_page(pictures, folder, &gallery)
}

fn titled<'a>() -> Gallery<'a> {
    Gallery { title: "Restaged", lead: "The photograph after these edits:", ..Gallery::default() }
}

fn write_page(pictures: &Path, folder: &Path, gallery: &Gallery<'_>) -> Result<(), Error> {
    let page = report::gallery(pictures, gallery)?;
    Ok(atomic::write(&folder.join("gallery.html"), page.as_bytes())?)
}

fn exhibit(file: &str, title: &str, caption: &str) -> Exhibit {
    let [file, title, caption] = [file, title, caption].map(str::to_owned);
    Exhibit { file, title, caption }
}

/// Whether the picture `number` of a sequence is in the folder `pictures`.
pub(crate) fn is_written(pictures: &Path, number: u32) -> bool {
    pictures.join(format!("{}.png", name_of(Some(number as usize)))).is_file()
}

/// The name of a synthetic picture, without its extension.
fn name_of(number: Option<usize>) -> String {
    numbered(SYNTHETIC, number)
}

fn numbered(name: &str, number: Option<usize>) -> String {
    number.map_or(name.to_owned(), |n| format!("{name}_{n:04}"))
}

/// The name of a synthetic picture, without its number.
const SYNTHETIC: &str = "synthetic";
/// The name of the passes of a picture, without its number.
const PASSES: &str = "passes";

/// A picture of the scene after the edits.
pub(crate) struct Synthetic<'a> {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub(crate) radiance: &'a RgbImage,
    /// Whether noise was removed from it.
    pub(crate) is_denoised: bool,
    /// The colour space of the EXR.
    pub(crate) space: ColourSpace,
}

/// Writes the passes of a picture, whose place in a sequence is `number`; returns how many values of the picture were not
/// finite.
pub(crate) fn write_passes(
    passes: &Passes,
    space: ColourSpace,
    folder: &Path,
    number: Option<usize>,
) -> Result<usize, FileError> {
    picture::write_passes(&folder.join(format!("{}.exr", numbered(PASSES, number))), passes, space)
}

/// Writes a synthetic picture as radiance, and as the photograph's camera would show it, or,
/// without one, as sRGB; returns how many values were not finite. `number` is its place in a
/// sequence.
pub(crate) fn write_synthetic(
    synthetic: &Synthetic<'_>,
    photograph: Option<&Photograph>,
    folder: &Path,
    number: Option<usize>,
) -> Result<usize, FileError> {
    let name = name_of(number);
    let (radiance, exr) = (synthetic.radiance, folder.join(format!("{name}.exr")));
    let bad = match synthetic.is_denoised {
        true => picture::write_denoised(&exr, radiance, synthetic.space)?,
        false => picture::write_exr_in(&exr, radiance, synthetic.space)?,
    };
    let png = folder.join(format!("{name}.png"));
    match photograph {
        Some(photograph) if photograph.picture.depth != Depth::Float => {
            write_codes(&png, photograph, &photograph.transfer.codes(radiance))?;
        }
        Some(photograph) => {
            picture::write_png_srgb(&png, &as_srgb(photograph, radiance))?;
        }
        None => {
            picture::write_png_srgb(&png, radiance)?;
        }
    }
    Ok(bad)
}

/// Linear values at the photograph's exposure.
fn as_srgb(photograph: &Photograph, radiance: &RgbImage) -> RgbImage {
    radiance.map(|radiance| *radiance / photograph.transfer.exposure)
}
