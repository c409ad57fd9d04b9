//! Calibrations by OpenCV: YAML, XML or JSON of its `FileStorage`, ROS's `camera_info`, and JSON or YAML
//! with lists of rows.
//!
//! It reads, by any of the names below, the camera matrix, the distortion, the size of the pictures,
//! and the pose, as `rvec` or `R` with `tvec`, or as rows of `extrinsic_parameters`, which is how the
//! sample `calibration.cpp` writes the poses of all its views.

use super::storage::{self, Matrix, Node};
use super::{Intrinsics, Pose};
use crate::entry::{Table, read as row, refused};
use crate::{FileError, Input, input};
use glam::{DMat3, DVec3};

const MATRICES: [&str; 7] =
    ["camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "K", "M", "mtx"];
const DISTORTIONS: [&str; 7] = [
    "distortion_coefficients",
    "distCoeffs",
    "dist_coeffs",
    "Distortion_Coefficients",
    "distortion",
    "D",
    "dist",
];
const WIDTHS: [&str; 3] = ["image_width", "image_Width", "width"];
const HEIGHTS: [&str; 3] = ["image_height", "image_Height", "height"];
const ROTATIONS: [&str; 4] = ["rvec", "R", "rotation", "rotation_matrix"];
const TRANSLATIONS: [&str; 5] = ["tvec", "T", "t", "translation", "translation_vector"];
const VIEWS: [&str; 2] = ["extrinsic_parameters", "Extrinsic_Parameters"];

/// Coefficients that are read: k1, k2, p1, p2, k3. OpenCV writes up to nine more, which are zero unless
/// its rational, thin-prism or tilted model was asked for.
const TERMS: usize = 5;

/// Numbers of the pose of a view: three of a rotation vector, three of a translation.
const VIEW: usize = 6;

/// A skew below this, relatively to the focal length, shifts no pixel of a picture by a hundredth.
const SKEW: f64 = 1e-6;

/// What is read of calibrations by OpenCV.
pub(super) fn table() -> Table {
    let mut table = Table::new("Cameras: OpenCV and ROS", "key, or lens model", []);
    let mut add = |names: &[&'static str], done: &'static str| {
        names.iter().for_each(|&name| table.add("", [&row(name, done)]));
    };
    add(&MATRICES, "the camera matrix; its pixels count from the centre of the first one");
    add(&DISTORTIONS, "k1, k2, p1, p2 and k3; refused if further ones are not zero");
    add(&WIDTHS, "the width of the pictures");
    add(&HEIGHTS, "the height of the pictures");
    add(&ROTATIONS, "the rotation, as a vector or a matrix");
    add(&TRANSLATIONS, "the translation");
    add(&VIEWS, "one row per view: three numbers of a rotation vector, three of a translation");
    let models = BROWN.map(|name| row(name, "the value of distortion_model: Brown's model"));
    table.add("distortion_model", &models);
    let fisheye = ["fisheye", "equidistant"].map(|name| refused(name, "undistort the photo"));
    table.add("distortion_model", &fisheye);
    table.add("distortion_model", [&refused("others", "undistort the photo")]);
    table.add("", [&refused("fisheye_model", "if it is not zero: undistort the photo")]);
    table
}

/// What a file says: the intrinsics, and the pose if there is one.
pub type Calibrated = (Intrinsics, Option<Pose>);

/// Reads the calibration in the file of `input`; `view` chooses one of several poses, counted from
/// zero.
///
/// # Errors
/// If the file cannot be read, has no camera matrix, or has an unsupported lens or an invalid pose.
pub fn read<'a>(input: impl Into<Input<'a>>, view: Option<usize>) -> Result<Calibrated, FileError> {
    let input = input.into();
    let fault = |problem: String| FileError::new(input.path, problem);
    let text = input::text(input).map_err(|error| FileError::because(input.path, "", error))?;
    let extension = input.path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    parse(&text, &extension, view).map_err(fault)
}

/// As [`read`], from the text of a file whose name ends in `extension`.
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(text: &str, extension: &str, view: Option<usize>) -> Result<Calibrated, String> {
    let tree = storage::parse(text, extension)?;
    refuse_other_lenses(&tree)?;
    let matrix = matrix(&tree, &MATRICES)?.ok_or_else(|| {
        format!(
            "has no camera matrix; call it {}, 3 x 3 as cv2.calibrateCamera gives it",
            MATRICES[0]
        )
    })?;
    let (fx, fy, cx, cy) = of_matrix(&matrix)?;
    let side = |names: &[&str]| find(&tree, names).and_then(Node::number);
    let intrinsics = Intrinsics {
        fx,
        fy,
        // OpenCV counts from the centre of the first pixel.
        cx: cx + 0.5,
        cy: cy + 0.5,
        distortion: distortion(&tree)?,
        size: side(&WIDTHS).zip(side(&HEIGHTS)).map(|(width, height)| [width, height]),
    };
    Ok((intrinsics, pose(&tree, view)?))
}

fn find<'a>(tree: &'a Node, names: &[&str]) -> Option<&'a Node> {
    names.iter().find_map(|name| tree.get(name))
}

/// The matrix of one of these names.
fn matrix(tree: &Node, names: &[&str]) -> Result<Option<Matrix>, String> {
    let name = names.iter().find(|name| tree.get(name).is_some());
    let Some((name, node)) = name.and_then(|name| Some((name, tree.get(name)?))) else {
        return Ok(None);
    };
    let whole = || {
        format!("has a {name} that is no matrix: write rows, cols, and as data rows x cols numbers")
    };
    node.matrix().map(Some).ok_or_else(whole)
}

/// The names of Brown's model, with which the coefficients are those of [`distortion`].
const BROWN: [&str; 8] = [
    "plumb_bob",
    "rational_polynomial",
    "radtan",
    "radial_tangential",
    "brown",
    "brown_conrady",
    "opencv",
    "none",
];

fn refuse_other_lenses(tree: &Node) -> Result<(), String> {
    let flag = tree.get("fisheye_model").and_then(Node::number).is_some_and(|flag| flag != 0.0);
    let stated = match tree.get("distortion_model") {
        Some(Node::Text(model)) => model.trim(),
        _ => BROWN[0],
    };
    let model = stated.to_lowercase().replace([' ', '-'], "_");
    if flag || model.contains("equidistant") || model.contains("fisheye") {
        return Err("is of a fisheye lens; undistort the photo by cv2.fisheye.undistortImage and \
                    give the new camera matrix"
            .into());
    }
    if !BROWN.contains(&model.as_str()) {
        return Err(format!(
            "is of the lens model \"{stated}\", which is not read; if its coefficients are k1, k2, p1, p2, k3, call \
             it {}, else undistort the photo and leave them out",
            BROWN[0]
        ));
    }
    Ok(())
}

fn of_matrix(matrix: &Matrix) -> Result<(f64, f64, f64, f64), String> {
    let &[fx, skew, cx, g, fy, cy, h, i, one] = matrix.data.as_slice() else {
        let Matrix { rows, columns, .. } = matrix;
        return Err(format!("has a camera matrix of {rows} x {columns} numbers; it is 3 x 3"));
    };
    if [g, h, i] != [0.0; 3] || one != 1.0 {
        return Err(
            "has a camera matrix that is not [fx 0 cx; 0 fy cy; 0 0 1], row by row; is it \
                    transposed?"
                .into(),
        );
    }
    if skew.abs() > SKEW * fx.abs() {
        return Err(format!(
            "has a camera matrix with the skew {skew}, which no lens of ours has; calibrate without \
             it"
        ));
    }
    Ok((fx, fy, cx, cy))
}

fn distortion(tree: &Node) -> Result<[f64; TERMS], String> {
    let mut terms = [0.0; TERMS];
    let Some(Matrix { data, .. }) = matrix(tree, &DISTORTIONS)? else { return Ok(terms) };
    if data.iter().skip(TERMS).any(|term| *term != 0.0) {
        return Err(
            "has distortion beyond k1, k2, p1, p2, k3: undistort the photo by cv2.undistort \
                    and leave the coefficients out, or calibrate without CALIB_RATIONAL_MODEL, \
                    CALIB_THIN_PRISM_MODEL and CALIB_TILTED_MODEL"
                .into(),
        );
    }
    terms.iter_mut().zip(data).for_each(|(term, number)| *term = number);
    Ok(terms)
}

fn pose(tree: &Node, view: Option<usize>) -> Result<Option<Pose>, String> {
    let triple = |name: &str, data: &[f64]| match *data {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("has a {name} of {} numbers; it has 3", data.len())),
    };
    let views = matrix(tree, &VIEWS)?;
    let own = matrix(tree, &ROTATIONS)?.zip(matrix(tree, &TRANSLATIONS)?);
    if let (Some((turn, shift)), None) = (&own, view) {
        let translation = triple("translation", &shift.data)?;
        return match <[f64; 9]>::try_from(turn.data.as_slice()) {
            Ok(rows) => Pose::new(DMat3::from_cols_array(&rows).transpose(), translation).map(Some),
            Err(_) => {
                Pose::of_rotation_vector(triple("rotation", &turn.data)?, translation).map(Some)
            }
        };
    }
    let Some(views) = views else {
        return match (view, own) {
            (Some(view), Some(_)) => Err(format!(
                "has one pose (R or rvec, and tvec) and no view {view}; leave out view"
            )),
            (Some(view), None) => Err(format!(
                "has no poses of views ({}), so no view {view}; leave out view, and give eye and target",
                VIEWS[0]
            )),
            (None, _) => Ok(None),
        };
    };
    if views.columns != VIEW {
        return Err(format!(
            "has {} with {} columns; each row is one view and has {VIEW}: a rotation vector and a translation",
            VIEWS[0], views.columns
        ));
    }
    let row = match (view, views.rows) {
        (Some(view), rows) if view < rows => view,
        (None, 1) => 0,
        (Some(view), rows) => {
            return Err(format!(
                "has the poses of {rows} views and no view {view}; they count from 0"
            ));
        }
        (None, rows) => {
            return Err(format!(
                "has the poses of {rows} views; say which one the photo is, by view = 0 for the first"
            ));
        }
    };
    let of_view = &views.data[VIEW * row..VIEW * (row + 1)];
    let [turn, shift] = [&of_view[..3], &of_view[3..]].map(DVec3::from_slice);
    Pose::of_rotation_vector(turn, shift).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n\
        camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500., 0., \
        319.5, 0., 510., 239.5, 0., 0., 1. ]\n\
        distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   \
        data: [ -0.2, 0.1, 1.0e-03, 2.0e-03, -0.01 ]\n";

    fn fault(text: &str) -> String {
        parse(text, "yml", None).unwrap_err()
    }

    #[test]
    fn half_a_pixel_is_added() {
        let (k, pose) = parse(CAMERA, "yml", None).unwrap();
        assert_eq!((k.fx, k.fy, k.cx, k.cy), (500.0, 510.0, 320.0, 240.0));
        assert_eq!(k.distortion, [-0.2, 0.1, 1e-3, 2e-3, -0.01]);
        assert_eq!((k.size, pose), (Some([640.0, 480.0]), None));
    }

    #[test]
    fn poses_are_vectors_matrices_or_rows_of_views() {
        let vector = parse(
            &format!("{CAMERA}rvec: [3.141592653589793, 0, 0]\ntvec: [1, 2, 3]\n"),
            "yml",
            None,
        );
        let matrix = "R: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]\nT: [[1], [2], [3]]\n";
        let matrix = parse(&format!("{CAMERA}{matrix}"), "yml", None);
        let rows = "extrinsic_parameters: !!opencv-matrix\n   rows: 2\n   cols: 6\n   dt: d\n   data: \
                    [ 0., 0., 0., 0., 0., 0., 3.141592653589793, 0., 0., 1., 2., 3. ]\n";
        let rows = format!("{CAMERA}{rows}");
        let view = parse(&rows, "yml", Some(1));
        let [vector, matrix, view] = [vector, matrix, view].map(|read| read.unwrap().1.unwrap());
        assert_eq!(matrix.rotation, DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)));
        assert_eq!(matrix.translation, DVec3::new(1.0, 2.0, 3.0));
        for other in [vector, view] {
            assert!(other.rotation.abs_diff_eq(matrix.rotation, 1e-15));
            assert_eq!(other.translation, matrix.translation);
        }
        assert!(fault(&rows).contains("view = 0"));
        let both = format!("{rows}rvec: [0, 0, 0]\ntvec: [7, 8, 9]\n");
        let of = |text: &str, view| parse(text, "yml", view).unwrap().1.unwrap().translation;
        assert_eq!(of(&both, Some(1)), matrix.translation, "the view that was asked for");
        assert_eq!(of(&both, None), DVec3::new(7.0, 8.0, 9.0));
        let one = format!("{CAMERA}rvec: [0, 0, 0]\ntvec: [7, 8, 9]\n");
        assert!(parse(&one, "yml", Some(3)).unwrap_err().contains("no view 3; leave out"));
        assert!(parse(CAMERA, "yml", Some(3)).unwrap_err().contains("no poses of views"));
        let wide = format!("{CAMERA}extrinsic_parameters: [[1, 0, 0, 0]]\n");
        assert!(fault(&wide).contains("with 4 columns"));
        assert!(parse(&rows, "yml", Some(2)).unwrap_err().contains("no view 2"));
    }

    #[test]
    fn lenses_that_are_not_read_are_reported() {
        assert!(fault("a: 1\n").contains("call it camera_matrix"));
        assert!(fault("K: [[1, 0], [0, 1]]\n").contains("2 x 2"));
        assert!(fault("K: [1, 2, 3, 4, 5]\n").contains("5 x 1"));
        assert!(fault("K: three\n").contains("no matrix"));
        assert!(fault("K: [[5, 0, 0], [0, 5, 0], [3, 2, 1]]\n").contains("transposed"));
        assert!(fault("K: [[5, 0.1, 3], [0, 5, 2], [0, 0, 1]]\n").contains("skew"));
        assert!(fault(&format!("{CAMERA}fisheye_model: 1\n")).contains("fisheye"));
        assert!(fault(&format!("{CAMERA}distortion_model: equidistant\n")).contains("fisheye"));
        let omni = fault(&format!("{CAMERA}distortion_model: omnidirectional\n"));
        assert!(omni.contains("lens model \"omnidirectional\", which is not read"), "{omni}");
        for brown in ["plumb_bob", "rational_polynomial", "Brown-Conrady", "radtan"] {
            assert!(parse(&format!("{CAMERA}distortion_model: {brown}\n"), "yml", None).is_ok());
        }
        let k = "K: [[5, 0, 3], [0, 5, 2], [0, 0, 1]]\n";
        assert!(fault(&format!("{k}D: [0, 0, 0, 0, 0, 0.1, 0, 0]\n")).contains("RATIONAL"));
        assert!(parse(&format!("{k}D: [0.1, 0, 0, 0, 0, 0, 0, 0]\n"), "yml", None).is_ok());
        assert!(fault(&format!("{k}rvec: [1, 2]\ntvec: [1, 2, 3]\n")).contains("of 2 numbers"));
        assert!(
            fault(&format!("{k}R: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\nt: [1, 2, 3]\n"))
                .contains("no rotation")
        );
    }
}
