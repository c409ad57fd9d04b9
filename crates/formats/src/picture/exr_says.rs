//! The colours that the header of an EXR file declares.

use super::colour_space::AP0;
use super::denoised;
use super::primaries::{matrix, of_primaries};
use crate::entry::{Entry, read, refused, told};
use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;
use unrender_scene::Profile;

/// What is read beside the names of colour spaces.
pub(super) const ROWS: [Entry; 19] = [
    read("R, G, B", "the picture; also named red, green and blue, and with other capitals"),
    read("Y", "a grey picture, where there is no RY or BY beside it"),
    read("A", "coverage: where it is zero a photograph has no measurement, with a warning"),
    told(
        "LAYER.R and so on",
        "the layer with a usual name for a renderer's picture, or the only one, is read",
    ),
    refused(
        "several layers",
        "if none has a usual name for a renderer's picture: save the one to read alone",
    ),
    refused("RY, BY", "a luminance-chroma EXR: save it as RGB"),
    refused("channels of fewer samples", "save it without subsampling"),
    refused("deep data", "flatten it, and save R, G and B"),
    refused("DWAA, DWAB and newer compressions", "save it with ZIP or PIZ"),
    read("displayWindow", "the picture; what the file has outside of it is left out"),
    read("dataWindow", "pixels outside of it have no measurement"),
    read("chromaticities", "the colours are turned into those of sRGB"),
    read("acesImageContainerFlag", "the primaries of ACES 2065-1"),
    read("pixelAspectRatio", "pixels that are not square are taken as square, with a warning"),
    told("envmap", "a cube is taken as a flat picture"),
    told("whiteLuminance", "the exposure defines what a value means"),
    read("expTime", "the exposure time"),
    read("aperture", "the f-number"),
    read("isoSpeed", "the sensitivity"),
];

/// The rows of the names of colour spaces.
pub(super) fn spaces() -> [Entry; 5] {
    SPACES.map(|name| told(name, "if it is not linear sRGB: the values are taken as linear"))
}

/// Attributes in which programs name a colour space, in small letters.
const SPACES: [&str; 5] =
    ["colorspace", "oiio:colorspace", "color_space", "colorinteropid", "ocio:colorspace"];
/// Names of linear values with the primaries of sRGB, without blanks, dashes and other signs.
const LINEAR_SRGB: [&str; 11] = [
    "linear",
    "scenelinear",
    "linsrgb",
    "linrec709",
    "linearrec709",
    "linearrec709srgb",
    "linearsrgb",
    "linrec709scene",
    "linearbt709",
    "utilitylinearsrgb",
    "utilitylinearrec709",
];
/// The primaries that the header states.
pub(super) fn profile(header: &Header) -> Option<Profile> {
    let Some(stated) = header.shared_attributes.chromaticities else {
        let is_aces = text_or_number(header, "acesimagecontainerflag").is_some();
        return is_aces.then(|| of_primaries(matrix(AP0), "its acesImageContainerFlag"));
    };
    let of = |xy: exr::math::Vec2<f32>| [xy.x(), xy.y()];
    let corners = [of(stated.red), of(stated.green), of(stated.blue), of(stated.white)];
    Some(of_primaries(matrix(corners), "its chromaticities"))
}

/// Statements of the header about colours that are ignored, as ends of sentences about the file.
pub(super) fn notes(header: &Header) -> Vec<String> {
    let mut notes = Vec::new();
    if header.own_attributes.other.contains_key(denoised::ATTRIBUTE.as_bytes()) {
        notes.push(
            "was denoised by unrender, so its noise does not show its errors: recover materials \
             from a picture rendered without --denoise"
                .to_owned(),
        );
    }
    let has_primaries = header.shared_attributes.chromaticities.is_some();
    for name in SPACES {
        let Some(space) = text_or_number(header, name) else { continue };
        let plain: String = space.chars().filter(char::is_ascii_alphanumeric).collect();
        let is_known = LINEAR_SRGB.contains(&plain.to_ascii_lowercase().as_str());
        if !is_known {
            let primaries =
                if has_primaries { "its chromaticities" } else { "the primaries of sRGB" };
            notes.push(format!(
                "names the colour space \"{space}\" ({name}), which is ignored: its values were \
                 taken as linear with {primaries}"
            ));
        }
    }
    if let Some(luminance) = header.own_attributes.white_luminance {
        notes.push(format!(
            "says that its white has {luminance} cd/m2 (whiteLuminance), which is ignored: the \
             exposure defines what a value means"
        ));
    }
    notes
}

/// The value of an attribute, its name in any case of letters, if it is a text, or a number other than
/// zero.
fn text_or_number(header: &Header, name: &str) -> Option<String> {
    let shared = header.shared_attributes.other.iter();
    let mut all = shared.chain(header.own_attributes.other.iter());
    let (_, value) = all.find(|(key, _)| key.to_string().eq_ignore_ascii_case(name))?;
    match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        AttributeValue::I32(number) => (*number != 0).then(|| number.to_string()),
        _ => None,
    }
}
