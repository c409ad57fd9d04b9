//! Pictures and cameras: a line of a header, a kind of coding, a model of a lens.

use super::{assert_taken, rows};
use crate::support::Folder;
use std::path::Path;
use unrender_formats::cameras::{colmap, opencv};
use unrender_formats::{Limits, picture};
use unrender_scene::{Rgb, RgbImage, Warnings};

fn decoded(bytes: &[u8]) -> Result<Warnings, String> {
    let read = picture::decode(bytes, Path::new("picture"));
    read.map(|(_, warnings)| warnings).map_err(|error| error.to_string())
}

#[test]
fn every_line_of_an_hdr_is_taken_as_its_row_says() {
    for row in rows("Pictures: Radiance HDR") {
        let value = match row.element {
            "EXPOSURE" | "PIXASPECT" => "1",
            "COLORCORR" => "1 2 1",
            "PRIMARIES" => "0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329",
            _ => "32-bit_rle_rgbe",
        };
        let header = format!("#?RADIANCE\n{}={value}\nFORMAT=32-bit_rle_rgbe\n\n", row.element);
        let mut bytes = format!("{header}-Y 1 +X 1\n").into_bytes();
        bytes.extend([128, 128, 128, 129]);
        assert_taken(&row, "", decoded(&bytes));
    }
}

#[test]
fn every_kind_of_jpeg_is_taken_as_its_row_says() {
    let image = RgbImage::new(8, 8, vec![Rgb::splat(0.5); 64]);
    let whole = picture::jpeg_bytes(&image, 90).unwrap();
    let frame = whole.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    for row in rows("Pictures: JPEG").iter().filter(|row| row.element.starts_with("a ")) {
        let (marker, bits) = match row.element {
            "a lossless JPEG" => (0xc3, 8),
            "a hierarchical JPEG" => (0xc5, 8),
            "a JPEG-LS" => (0xf7, 8),
            "a JPEG with arithmetic coding" => (0xc9, 8),
            "a JPEG of 12 bits" => (0xc1, 12),
            _ => (0xc0, 8),
        };
        let mut bytes = whole.clone();
        bytes[frame + 1] = marker;
        bytes[frame + 4] = bits;
        let read = decoded(&bytes);
        if let Err(told) = &read {
            assert!(told.contains(row.element), "{}: {told}", row.element);
        }
        assert_taken(row, "", read);
    }
}

#[test]
fn every_model_of_colmap_is_taken_as_its_row_says() {
    let models = rows("Cameras: COLMAP")
        .into_iter()
        .filter(|row| row.element.chars().all(|c| c.is_ascii_uppercase() || c == '_'));
    let mut count = 0;
    for row in models {
        let parameters = match row.element {
            "SIMPLE_PINHOLE" => 3,
            "PINHOLE" | "SIMPLE_RADIAL" | "SIMPLE_RADIAL_FISHEYE" => 4,
            "RADIAL" | "RADIAL_FISHEYE" | "FOV" => 5,
            "OPENCV" | "OPENCV_FISHEYE" => 8,
            "FULL_OPENCV" | "THIN_PRISM_FISHEYE" => 12,
            _ => 16,
        };
        let numbers = ["500", "500", "320", "240"].into_iter().chain(std::iter::repeat("0"));
        let numbers: Vec<&str> = numbers.take(parameters).collect();
        let folder = Folder::new();
        let line = format!("1 {} 640 480 {}\n", row.element, numbers.join(" "));
        let cameras = folder.file("cameras.txt", line);
        let images = folder.file("images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n\n");
        let read = colmap::read(&cameras, &images, "a.jpg", Limits::default());
        let read = read.map(|_| Warnings::default()).map_err(|error| error.to_string());
        assert_taken(&row, "", read);
        count += 1;
    }
    assert_eq!(count, 12);
}

#[test]
fn every_key_and_model_of_opencv_is_taken_as_its_row_says() {
    for row in rows("Cameras: OpenCV and ROS") {
        let matrix = "camera_matrix: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]\n";
        let text = match (row.within, row.element) {
            ("distortion_model", "others") => format!("{matrix}distortion_model: any\n"),
            ("distortion_model", model) => format!("{matrix}distortion_model: {model}\n"),
            (_, "fisheye_model") => format!("{matrix}fisheye_model: 1\n"),
            (_, key) if row.done.starts_with("the camera matrix") => {
                matrix.replace("camera_matrix", key)
            }
            (_, key) if row.done.starts_with("k1") => format!("{matrix}{key}: [0.1, 0, 0, 0, 0]\n"),
            (_, key) if row.done.starts_with("the rotation") => {
                format!("{matrix}{key}: [0, 0, 0]\ntvec: [0, 0, 1]\n")
            }
            (_, key) if row.done.starts_with("the translation") => {
                format!("{matrix}rvec: [0, 0, 0]\n{key}: [0, 0, 1]\n")
            }
            (_, key) if row.done.starts_with("one row per view") => {
                format!("{matrix}{key}: [[0, 0, 0, 0, 0, 1]]\n")
            }
            (_, key) => format!("{matrix}{key}: 640\n"),
        };
        let read = opencv::parse(&text, "yml", None).map(|_| Warnings::default());
        assert_taken(&row, "", read);
    }
}
