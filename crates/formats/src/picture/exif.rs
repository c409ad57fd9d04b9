//! The lens and the exposure in a photograph's EXIF data.

use crate::entry::{Entry, passed, read};
use exif::{Exif, In, Reader, Tag, Value};
use std::io::Cursor;

const FOCAL: &str = "the focal length, where no calibration states it";

/// The tags that are looked at; others are passed over.
pub(super) const TAGS: [Entry; 14] = [
    read("Orientation", "the picture is turned upright, and cameras of the stored pixels with it"),
    read("InteroperabilityIndex", "R03: the colours are those of Adobe RGB"),
    read("FocalLengthIn35mmFilm", FOCAL),
    read("FocalLength", FOCAL),
    read("FocalPlaneXResolution", FOCAL),
    read("FocalPlaneResolutionUnit", FOCAL),
    read("PixelXDimension", "how much the picture was scaled since"),
    read("PixelYDimension", "how much the picture was scaled since"),
    read("ExposureTime", "the exposure time"),
    read("ShutterSpeedValue", "the exposure time, if there is no ExposureTime"),
    read("FNumber", "the f-number"),
    read("ApertureValue", "the f-number, if there is no FNumber"),
    read("PhotographicSensitivity", "ISO"),
    passed("others", "such as the lens's name"),
];

/// Diagonal of the 24 x 36 mm frame, to which cameras relate their focal lengths, millimetres.
const FULL_FRAME_DIAGONAL_MM: f64 = 43.266_615_305_567_87;

/// The focal length in pixels by the EXIF data in the file `bytes` of a picture of `width` x
/// `height` pixels: from the equivalent for a full frame, else from focal length and pixel pitch.
/// None if neither is stated. With zoom lenses and crops it is only a first guess.
pub fn exif_focal_px(bytes: &[u8], width: usize, height: usize) -> Option<f64> {
    let exif = Reader::new().read_from_container(&mut Cursor::new(bytes)).ok()?;
    let (width, height) = (width as f64, height as f64);
    let focal = match number(&exif, Tag::FocalLengthIn35mmFilm) {
        Some(equivalent_mm) if equivalent_mm > 0.0 => {
            equivalent_mm / FULL_FRAME_DIAGONAL_MM * width.hypot(height)
        }
        _ => by_pixel_pitch(&exif, width.max(height))?,
    };
    (focal.is_finite() && focal > 0.0).then_some(focal)
}

/// How a photograph was exposed, as far as its file states it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExifExposure {
    /// The exposure time, seconds.
    pub seconds: Option<f64>,
    /// The f-number: focal length over the diameter of the aperture.
    pub f_number: Option<f64>,
    /// The sensitivity, ISO.
    pub iso: Option<f64>,
}

/// How the photograph in the file `bytes` was exposed, by its EXIF data, or by the standard attributes
/// `expTime`, `aperture` and `isoSpeed` of an EXR. Numbers that are not positive count as missing.
pub fn exposure_of(bytes: &[u8]) -> ExifExposure {
    let good = |number: Option<f64>| number.filter(|n| n.is_finite() && *n > 0.0);
    if let Ok(meta) = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false) {
        let own = meta.headers.first().map(|header| &header.own_attributes);
        let of = |number: Option<f32>| good(number.map(f64::from));
        return own.map_or(ExifExposure::default(), |own| ExifExposure {
            seconds: of(own.exposure),
            f_number: of(own.aperture),
            iso: of(own.iso_speed),
        });
    }
    let Ok(exif) = Reader::new().read_from_container(&mut Cursor::new(bytes)) else {
        return ExifExposure::default();
    };
    // APEX: the time is 2^-Tv, the square of the f-number 2^Av.
    let apex = |tag, factor: f64| number(&exif, tag).map(|value| (factor * value).exp2());
    let seconds = good(number(&exif, Tag::ExposureTime));
    let f_number = good(number(&exif, Tag::FNumber));
    ExifExposure {
        seconds: seconds.or_else(|| good(apex(Tag::ShutterSpeedValue, -1.0))),
        f_number: f_number.or_else(|| good(apex(Tag::ApertureValue, 0.5))),
        iso: good(number(&exif, Tag::PhotographicSensitivity)),
    }
}

/// Whether the EXIF data in the file `bytes` state Adobe RGB, as cameras do instead of a profile.
pub(super) fn is_adobe_rgb(bytes: &[u8]) -> bool {
    let exif = Reader::new().read_from_container(&mut Cursor::new(bytes)).ok();
    let index = exif.as_ref().and_then(|e| e.get_field(Tag::InteroperabilityIndex, In::PRIMARY));
    index.is_some_and(|field| match &field.value {
        Value::Ascii(texts) => texts.iter().any(|text| text.starts_with(b"R03")),
        _ => false,
    })
}

fn by_pixel_pitch(exif: &Exif, longer_side: f64) -> Option<f64> {
    let focal_mm = number(exif, Tag::FocalLength)?;
    let unit_mm = match number(exif, Tag::FocalPlaneResolutionUnit) {
        Some(3.0) => 10.0,
        _ => 25.4,
    };
    let pixels_per_mm = number(exif, Tag::FocalPlaneXResolution)? / unit_mm;
    // The pitch is that of the picture as the camera wrote it; it may have been scaled since.
    let side = |tag| number(exif, tag).filter(|side| *side > 0.0);
    let (x, y) = (side(Tag::PixelXDimension), side(Tag::PixelYDimension));
    let scale = x.zip(y).map_or(1.0, |(x, y)| longer_side / x.max(y));
    Some(focal_mm * pixels_per_mm * scale)
}

fn number(exif: &Exif, tag: Tag) -> Option<f64> {
    match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(values) => values.first().map(exif::Rational::to_f64),
        Value::SRational(values) => values.first().map(exif::SRational::to_f64),
        other => other.get_uint(0).map(f64::from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exif::experimental::Writer;
    use exif::{Field, Rational};

    /// A JPEG without a picture, with the fields.
    fn jpeg(fields: &[(Tag, Value)]) -> Vec<u8> {
        let field = |(tag, value): &(Tag, Value)| Field {
            tag: *tag,
            ifd_num: In::PRIMARY,
            value: value.clone(),
        };
        let fields: Vec<Field> = fields.iter().map(field).collect();
        let mut writer = Writer::new();
        fields.iter().for_each(|field| writer.push_field(field));
        let mut tiff = Cursor::new(Vec::new());
        writer.write(&mut tiff, true).unwrap();
        let tiff = tiff.into_inner();
        let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xE1];
        bytes.extend_from_slice(&(tiff.len() as u16 + 8).to_be_bytes());
        bytes.extend_from_slice(b"Exif\0\0");
        bytes.extend_from_slice(&tiff);
        bytes.extend_from_slice(&[0xFF, 0xD9]);
        bytes
    }

    fn rational(num: u32, denom: u32) -> Value {
        Value::Rational(vec![Rational { num, denom }])
    }

    #[test]
    fn every_tag_that_is_looked_at_has_a_row() {
        let code = include_str!("exif.rs").split("#[cfg(test)]").next().unwrap_or_default();
        let mut used: Vec<&str> = code
            .split("Tag::")
            .skip(1)
            .filter_map(|rest| rest.split(|c: char| !c.is_ascii_alphanumeric()).next())
            .collect();
        used.sort_unstable();
        used.dedup();
        // The decoder hands out the orientation.
        let rows = TAGS.iter().filter(|row| !["Orientation", "others"].contains(&row.name));
        let mut rows: Vec<&str> = rows.map(|row| row.name).collect();
        rows.sort_unstable();
        assert_eq!(used, rows);
    }

    #[test]
    fn the_full_frame_equivalent_counts_by_the_diagonal() {
        let bytes = jpeg(&[(Tag::FocalLengthIn35mmFilm, Value::Short(vec![28]))]);
        let focal = exif_focal_px(&bytes, 3600, 2400).unwrap();
        assert!((focal - 2800.0).abs() < 1e-6, "{focal}");
        let upright = exif_focal_px(&bytes, 2400, 3600).unwrap();
        assert!((focal - upright).abs() < 1e-9);
    }

    #[test]
    fn focal_length_and_pixel_pitch_do_too() {
        let bytes = jpeg(&[
            (Tag::FocalLength, rational(350, 10)),
            (Tag::FocalPlaneXResolution, rational(6000, 3)),
            (Tag::FocalPlaneResolutionUnit, Value::Short(vec![3])),
            (Tag::PixelXDimension, Value::Long(vec![4800])),
            (Tag::PixelYDimension, Value::Long(vec![3200])),
        ]);
        // 35 mm at 200 pixels a millimetre, in a picture of half the size.
        let focal = exif_focal_px(&bytes, 1600, 2400).unwrap();
        assert!((focal - 3500.0).abs() < 1e-6, "{focal}");
    }

    #[test]
    fn the_exposure_is_read() {
        let bytes = jpeg(&[
            (Tag::ExposureTime, rational(1, 60)),
            (Tag::FNumber, rational(28, 10)),
            (Tag::PhotographicSensitivity, Value::Short(vec![200])),
        ]);
        let found =
            ExifExposure { seconds: Some(1.0 / 60.0), f_number: Some(2.8), iso: Some(200.0) };
        assert_eq!(exposure_of(&bytes), found);
        let apex = jpeg(&[
            (Tag::ExposureTime, rational(0, 1)),
            (Tag::ShutterSpeedValue, Value::SRational(vec![exif::SRational { num: 4, denom: 2 }])),
            (Tag::ApertureValue, rational(4, 1)),
        ]);
        let found = ExifExposure { seconds: Some(0.25), f_number: Some(4.0), iso: None };
        assert_eq!(exposure_of(&apex), found);
        assert_eq!(exposure_of(b"no picture"), ExifExposure::default());
        let broken = jpeg(&[(Tag::ExposureTime, rational(1, 0))]);
        assert_eq!(exposure_of(&broken).seconds, None);
    }

    #[test]
    fn files_that_say_nothing_say_nothing() {
        assert_eq!(exif_focal_px(b"no picture", 10, 10), None);
        assert_eq!(exif_focal_px(&jpeg(&[(Tag::FocalLength, rational(35, 1))]), 10, 10), None);
        let none = jpeg(&[(Tag::FocalLengthIn35mmFilm, Value::Short(vec![0]))]);
        assert_eq!(exif_focal_px(&none, 10, 10), None);
    }
}
