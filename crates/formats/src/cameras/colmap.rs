//! Reconstructions by COLMAP: `cameras` and `images`, as text or binary.
//!
//! A line of `cameras.txt` is `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...`. An image in `images.txt` takes
//! two lines, of which the second, with its points, may be empty: `IMAGE_ID QW QX QY QZ TX TY TZ
//! CAMERA_ID NAME`. The binary files hold the same, little-endian, and are taken where both are there,
//! as COLMAP does.

use super::{Intrinsics, Pose};
use crate::entry::{Entry, Table, Taken, passed, read as row, refused};
use crate::{FileError, Input, Limits, input};
use glam::{DMat3, DQuat, DVec3};
use std::path::{Path, PathBuf};

const UNDISTORT: &str =
    "run colmap image_undistorter, and take the pictures and the sparse folder that it writes";

/// COLMAP's models by their numbers, each with the count of its parameters.
const MODELS: [(Entry, usize); 12] = [
    (row("SIMPLE_PINHOLE", "no distortion"), 3),
    (row("PINHOLE", "no distortion"), 4),
    (row("SIMPLE_RADIAL", "k1"), 4),
    (row("RADIAL", "k1 and k2"), 5),
    (row("OPENCV", "k1, k2, p1 and p2"), 8),
    (refused("OPENCV_FISHEYE", UNDISTORT), 8),
    (row("FULL_OPENCV", "k1, k2, p1, p2 and k3; refused unless k4 to k6 are zero"), 12),
    (refused("FOV", UNDISTORT), 5),
    (refused("SIMPLE_RADIAL_FISHEYE", UNDISTORT), 4),
    (refused("RADIAL_FISHEYE", UNDISTORT), 5),
    (refused("THIN_PRISM_FISHEYE", UNDISTORT), 12),
    (refused("RAD_TAN_THIN_PRISM_FISHEYE", UNDISTORT), 16),
];

/// The files, and what is read of them.
const FILES: [Entry; 4] = [
    row("cameras.bin, images.bin", "the cameras and the poses; taken where they are there"),
    row("cameras.txt, images.txt", "the same as text"),
    passed("points3D", "the points of the scene"),
    passed("points of images", "where the points are seen"),
];

/// What is read of COLMAP's reconstructions.
pub(super) fn table() -> Table {
    Table::new(
        "Cameras: COLMAP",
        "file, or camera model",
        FILES.iter().chain(MODELS.iter().map(|(row, _)| row)),
    )
}

/// A camera of the file.
struct Device {
    id: i64,
    model: String,
    size: [f64; 2],
    parameters: Vec<f64>,
}

/// An image of the file.
#[derive(Clone, Debug)]
struct ImageRow {
    /// The rotation as w, x, y, z, then the translation.
    pose: [f64; 7],
    camera: i64,
    name: String,
}

/// The files that [`read`] reads of `path`: a folder, or `cameras.txt` or `cameras.bin` in it.
pub fn files(path: &Path) -> [PathBuf; 2] {
    let is_file = path.extension().is_some_and(|end| end == "txt" || end == "bin");
    if is_file && !path.is_dir() {
        let images = path.with_file_name("images");
        let extension = if is_binary(path) { "bin" } else { "txt" };
        return [path.to_owned(), images.with_extension(extension)];
    }
    let binary = ["cameras.bin", "images.bin"].map(|file| path.join(file));
    if binary.iter().all(|file| file.exists()) {
        return binary;
    }
    ["cameras.txt", "images.txt"].map(|file| path.join(file))
}

/// Reads the camera of the image called `image` (or whose path ends in that) from the two files of a
/// reconstruction; names that end in `.bin` are of binary files.
///
/// # Errors
/// If a file cannot be read, there is no such image, or its camera has a lens of another kind.
pub fn read(
    cameras: &Path,
    images: &Path,
    image: &str,
    limits: Limits,
) -> Result<(Intrinsics, Pose), FileError> {
    let bytes = |path: &Path| {
        input::read(Input::new(path, limits)).map_err(|problem| {
            let remedy = "a folder of COLMAP has cameras and images, both .txt or both .bin";
            FileError::new(path, format!("{problem}; {remedy}"))
        })
    };
    let shots = shots(&bytes(images)?, is_binary(images));
    let shots = shots.map_err(|problem| FileError::new(images, problem))?;
    let shot = choose(&shots, image).map_err(|problem| FileError::new(images, problem))?;
    let devices = devices(&bytes(cameras)?, is_binary(cameras));
    let fault = |problem: String| FileError::new(cameras, problem);
    let devices = devices.map_err(fault)?;
    let device = devices.iter().find(|device| device.id == shot.camera);
    let id = shot.camera;
    let device = device.ok_or_else(|| fault(format!("has no camera {id}, which took {image}")))?;
    let pose = pose(&shot.pose).map_err(|problem| FileError::new(images, problem))?;
    Ok((intrinsics(device).map_err(fault)?, pose))
}

fn is_binary(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "bin")
}

fn pose(&[w, x, y, z, tx, ty, tz]: &[f64; 7]) -> Result<Pose, String> {
    let turn = DQuat::from_xyzw(x, y, z, w);
    let is_turn = turn.is_finite() && turn.length() > 0.0;
    let turn = if is_turn { turn.normalize() } else { DQuat::NAN };
    Pose::new(DMat3::from_quat(turn), DVec3::new(tx, ty, tz))
}

fn intrinsics(device: &Device) -> Result<Intrinsics, String> {
    let Device { id, model, size, parameters } = device;
    if let Some((_, count)) =
        MODELS.iter().find(|(row, count)| row.name == model && *count != parameters.len())
    {
        return Err(format!(
            "has camera {id} of the model {model} with {} numbers after its size; the model has {count}",
            parameters.len()
        ));
    }
    let known = MODELS.iter().find(|(row, _)| row.name == model && row.taken == Taken::Read);
    let known = known.map_or("", |(row, _)| row.name);
    let (fx, fy, cx, cy, distortion) = match (known, parameters.as_slice()) {
        ("SIMPLE_PINHOLE", &[f, cx, cy]) => (f, f, cx, cy, [0.0; 5]),
        ("PINHOLE", &[fx, fy, cx, cy]) => (fx, fy, cx, cy, [0.0; 5]),
        ("SIMPLE_RADIAL", &[f, cx, cy, k]) => (f, f, cx, cy, [k, 0.0, 0.0, 0.0, 0.0]),
        ("RADIAL", &[f, cx, cy, k1, k2]) => (f, f, cx, cy, [k1, k2, 0.0, 0.0, 0.0]),
        ("OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2]) => (fx, fy, cx, cy, [k1, k2, p1, p2, 0.0]),
        ("FULL_OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2, k3, a, b, c])
            if [a, b, c] == [0.0; 3] =>
        {
            (fx, fy, cx, cy, [k1, k2, p1, p2, k3])
        }
        _ => {
            return Err(format!(
                "has camera {id} of the model {model}; supported are SIMPLE_PINHOLE, PINHOLE, \
                 SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV with k4 to k6 zero: {UNDISTORT}"
            ));
        }
    };
    Ok(Intrinsics { fx, fy, cx, cy, distortion, size: Some(*size) })
}

/// The image of this name; else the one whose path ends in it.
fn choose<'a>(shots: &'a [ImageRow], image: &str) -> Result<&'a ImageRow, String> {
    if let Some(shot) = shots.iter().find(|shot| shot.name == image) {
        return Ok(shot);
    }
    let ending = format!("/{image}");
    let found: Vec<&ImageRow> = shots.iter().filter(|shot| shot.name.ends_with(&ending)).collect();
    match *found.as_slice() {
        [shot] => Ok(shot),
        [] => {
            const SHOWN: usize = 6;
            let names: Vec<&str> =
                shots.iter().take(SHOWN).map(|shot| shot.name.as_str()).collect();
            Err(format!(
                "has no image \"{image}\" among its {}: {}, ...; say which one the photo is, by image",
                shots.len(),
                names.join(", ")
            ))
        }
        _ => Err(format!("has {} images of the name {image}; give its folder too", found.len())),
    }
}

fn devices(bytes: &[u8], is_binary: bool) -> Result<Vec<Device>, String> {
    if is_binary {
        return binary_devices(&mut Words(bytes)).ok_or_else(|| cut_short("cameras.bin"))?;
    }
    let mut devices = Vec::new();
    for (number, line) in lines(bytes)? {
        let words: Vec<&str> = line.split_whitespace().collect();
        let device = || {
            let [id, model, width, height, parameters @ ..] = words.as_slice() else { return None };
            let parameters = parameters.iter().map(|word| word.parse().ok());
            Some(Device {
                id: id.parse().ok()?,
                model: (*model).to_owned(),
                size: [width.parse().ok()?, height.parse().ok()?],
                parameters: parameters.collect::<Option<_>>()?,
            })
        };
        devices.push(device().ok_or_else(|| {
            format!("line {number} is not CAMERA_ID MODEL WIDTH HEIGHT PARAMS, as COLMAP writes it")
        })?);
    }
    Ok(devices)
}

/// The lines that are neither empty nor a comment, with their numbers.
fn lines(bytes: &[u8]) -> Result<impl Iterator<Item = (usize, &str)>, String> {
    let text = str::from_utf8(bytes).map_err(|_| "is no text (UTF-8)".to_owned())?;
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    Ok(lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')))
}

fn shots(bytes: &[u8], is_binary: bool) -> Result<Vec<ImageRow>, String> {
    if is_binary {
        return binary_shots(&mut Words(bytes)).ok_or_else(|| cut_short("images.bin"));
    }
    let text = str::from_utf8(bytes).map_err(|_| "is no text (UTF-8)".to_owned())?;
    let mut shots = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let shot = text_shot(line).ok_or_else(|| {
            let number = index + 1;
            format!(
                "line {number} is not IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, followed by a \
                 line of points that may be empty, as COLMAP writes it"
            )
        })?;
        shots.push(shot);
        // Its points.
        lines.next();
    }
    Ok(shots)
}

fn text_shot(line: &str) -> Option<ImageRow> {
    let mut rest = line.trim();
    let mut word = || {
        let (word, after) = rest.split_once(char::is_whitespace)?;
        rest = after.trim_start();
        Some(word)
    };
    word()?.parse::<u64>().ok()?;
    let mut pose = [0.0; 7];
    for number in &mut pose {
        *number = word()?.parse().ok()?;
    }
    let camera = word()?.parse().ok()?;
    (!rest.is_empty()).then(|| ImageRow { pose, camera, name: rest.to_owned() })
}

fn cut_short(file: &str) -> String {
    format!("is no {file} of COLMAP, or is cut short; write it again by colmap model_converter")
}

/// What is left of a binary file.
struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }
}

/// None if the file is cut short; an error if it has a model with an unknown number of parameters.
fn binary_devices(words: &mut Words<'_>) -> Option<Result<Vec<Device>, String>> {
    let mut devices = Vec::new();
    for _ in 0..words.u64()? {
        let (id, model) = (i64::from(words.i32()?), words.i32()?);
        let size = [words.u64()? as f64, words.u64()? as f64];
        let Some(&(known, count)) = usize::try_from(model).ok().and_then(|m| MODELS.get(m)) else {
            return Some(Err(format!(
                "has camera {id} of the unknown model number {model}; write it as text by colmap \
                 model_converter"
            )));
        };
        let parameters = (0..count).map(|_| words.f64()).collect::<Option<_>>()?;
        devices.push(Device { id, model: known.name.to_owned(), size, parameters });
    }
    Some(Ok(devices))
}

fn binary_shots(words: &mut Words<'_>) -> Option<Vec<ImageRow>> {
    /// Two coordinates and the number of a point.
    const POINT: usize = 24;
    let mut shots = Vec::new();
    for _ in 0..words.u64()? {
        words.i32()?;
        let mut pose = [0.0; 7];
        for number in &mut pose {
            *number = words.f64()?;
        }
        let camera = i64::from(words.i32()?);
        let end = words.0.iter().position(|byte| *byte == 0)?;
        let name = String::from_utf8_lossy(words.take(end)?).into_owned();
        words.take(1)?;
        let points = usize::try_from(words.u64()?).ok()?;
        words.take(points.checked_mul(POINT)?)?;
        shots.push(ImageRow { pose, camera, name });
    }
    Some(shots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const CAMERAS: &str = "# Camera list with one line of data per camera:\n\
        1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n\
        2 OPENCV 640 480 500 510 321 241 -0.1 0.02 0.001 -0.002\n\
        3 OPENCV_FISHEYE 640 480 500 510 321 241 0 0 0 0\n";
    const IMAGES: &str = "# Image list with two lines of data per image:\n\
        1 1 0 0 0 0.5 0 2 1 hall/a.jpg\n100.5 20.25 -1 30 40 7\n\
        2 0 1 0 0 1 2 3 2 b c.jpg\n\n\
        3 2 0 0 0 0 0 0 3 fish.jpg\n\n";

    /// The same as binary files.
    fn binary() -> [Vec<u8>; 2] {
        let devices = devices(CAMERAS.as_bytes(), false).unwrap();
        let mut cameras = (devices.len() as u64).to_le_bytes().to_vec();
        for device in devices {
            let model = MODELS.iter().position(|(row, _)| row.name == device.model).unwrap();
            cameras.extend((device.id as i32).to_le_bytes());
            cameras.extend((model as i32).to_le_bytes());
            device.size.iter().for_each(|side| cameras.extend((*side as u64).to_le_bytes()));
            device.parameters.iter().for_each(|number| cameras.extend(number.to_le_bytes()));
        }
        let shots = shots(IMAGES.as_bytes(), false).unwrap();
        let mut images = (shots.len() as u64).to_le_bytes().to_vec();
        for (shot, points) in shots.into_iter().zip([2u64, 0, 0]) {
            images.extend(1i32.to_le_bytes());
            shot.pose.iter().for_each(|number| images.extend(number.to_le_bytes()));
            images.extend((shot.camera as i32).to_le_bytes());
            images.extend(shot.name.as_bytes());
            images.push(0);
            images.extend(points.to_le_bytes());
            images.extend(vec![7; 24 * points as usize]);
        }
        [cameras, images]
    }

    fn folder(files: [(&str, &[u8]); 2]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        folder
    }

    fn at(path: &Path, image: &str) -> Result<(Intrinsics, Pose), FileError> {
        let [cameras, images] = files(path);
        read(&cameras, &images, image, Limits::default())
    }

    fn text() -> tempfile::TempDir {
        folder([("cameras.txt", CAMERAS.as_bytes()), ("images.txt", IMAGES.as_bytes())])
    }

    #[test]
    fn text_and_binary_say_the_same() {
        let [cameras, images] = binary();
        let (text, binary) = (text(), folder([("cameras.bin", &cameras), ("images.bin", &images)]));
        for image in ["hall/a.jpg", "a.jpg", "b c.jpg"] {
            let of = |folder: &tempfile::TempDir| {
                let read = |path: &Path| at(path, image).unwrap();
                let file = if folder.path().join("cameras.bin").exists() { "bin" } else { "txt" };
                let all = read(folder.path());
                assert_eq!(all, read(&folder.path().join(format!("cameras.{file}"))));
                all
            };
            assert_eq!(of(&text), of(&binary), "{image}");
        }
        let (k, pose) = at(text.path(), "a.jpg").unwrap();
        assert_eq!((k.fx, k.fy, k.cx, k.cy), (500.0, 500.0, 320.0, 240.0));
        assert_eq!((k.distortion[0], k.size), (-0.1, Some([640.0, 480.0])));
        assert_eq!(pose.rotation, DMat3::IDENTITY);
        assert_eq!(pose.translation, DVec3::new(0.5, 0.0, 2.0));
        let (k, pose) = at(text.path(), "b c.jpg").unwrap();
        assert_eq!((k.fy, k.distortion), (510.0, [-0.1, 0.02, 0.001, -0.002, 0.0]));
        assert!(
            pose.rotation.abs_diff_eq(DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)), 1e-12)
        );
    }

    #[test]
    fn faults_name_file_and_remedy() {
        let text = text();
        let fault = |path: &Path, image| at(path, image).unwrap_err().to_string();
        let noted = fault(text.path(), "none.jpg");
        assert!(noted.contains("images.txt") && noted.contains("hall/a.jpg, b c.jpg"), "{noted}");
        let noted = fault(text.path(), "fish.jpg");
        assert!(noted.contains("cameras.txt") && noted.contains("image_undistorter"), "{noted}");
        for (line, told) in [
            (
                "1 FULL_OPENCV 6 4 5 5 3 2 0 0 0 0",
                "FULL_OPENCV with 8 numbers after its size; the model has 12",
            ),
            ("1 PINHOLE 6 4 5 3 2", "PINHOLE with 3 numbers after its size; the model has 4"),
            ("1 FULL_OPENCV 6 4 5 5 3 2 0 0 0 0 0 0.1 0 0", "k4 to k6 zero"),
            (
                "1 THIN_PRISM_FISHEYE 6 4 5 5 3 2 0 0 0 0 0 0 0 0",
                "model THIN_PRISM_FISHEYE; supported are",
            ),
            ("1 MINE 6 4 5", "model MINE; supported are"),
        ] {
            let broken =
                folder([("cameras.txt", line.as_bytes()), ("images.txt", IMAGES.as_bytes())]);
            let noted = fault(broken.path(), "a.jpg");
            assert!(noted.contains(told), "{noted}");
        }
        let noted = fault(Path::new("nowhere"), "a.jpg");
        assert!(noted.contains("does not exist"), "{noted}");
        let broken = folder([("cameras.txt", b"1 PINHOLE x\n"), ("images.txt", IMAGES.as_bytes())]);
        assert!(fault(broken.path(), "a.jpg").contains("line 1 is not CAMERA_ID"));
        let broken = folder([("cameras.txt", CAMERAS.as_bytes()), ("images.txt", b"1 2 3\n")]);
        assert!(fault(broken.path(), "a.jpg").contains("line 1 is not IMAGE_ID"));
        let less = folder([
            ("cameras.txt", b"7 PINHOLE 4 3 1 1 1 1\n"),
            ("images.txt", IMAGES.as_bytes()),
        ]);
        assert!(fault(less.path(), "a.jpg").contains("has no camera 1"));
        let zero =
            folder([("cameras.txt", CAMERAS.as_bytes()), ("images.txt", b"1 0 0 0 0 0 0 0 1 a\n")]);
        assert!(fault(zero.path(), "a").contains("no rotation"));
    }

    #[test]
    fn binary_files_cut_short_are_told_at_every_length() {
        let [cameras, images] = binary();
        for length in 0..cameras.len() {
            assert!(devices(&cameras[..length], true).is_err(), "{length} bytes");
        }
        for length in 0..images.len() {
            assert!(shots(&images[..length], true).is_err(), "{length} bytes");
        }
        let mut other = cameras;
        other[12] = 99;
        assert!(devices(&other, true).err().unwrap().contains("model number 99"));
        assert!(shots(&u64::MAX.to_le_bytes(), true).is_err());
    }
}
