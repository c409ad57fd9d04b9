//! Real photographs, of a chessboard by a lens that bends lines: one view alone against what
//! OpenCV's `calibrateCamera` finds from thirteen views of the same camera (0.21 px rms).

use glam::DVec3;
use unrender_formats::points::{self, Pair};
use unrender_photo::calibrate::{Calibration, Focal, Request, calibrate};

const SIZE: (usize, usize) = (640, 480);

// OpenCV's answer with one focal length, without tangential and sixth-power distortion. Its axes
// are turned by half a turn about x to ours, and half a pixel is added.
const FOCAL: f64 = 532.886;
const AXIS: [f64; 2] = [342.997, 233.357];
const K: [f64; 2] = [-0.2905, 0.1041];
const VIEWS: [(&str, [f64; 3]); 3] = [
    (include_str!("../chessboard/left01.csv"), [0.18296, -0.04113, 0.37434]),
    (include_str!("../chessboard/left05.csv"), [0.23392, -0.07379, 0.23670]),
    (include_str!("../chessboard/left12.csv"), [0.21249, -0.03344, 0.26341]),
];

fn pairs(view: &str) -> Vec<Pair> {
    points::parse(view.as_bytes()).unwrap()
}

fn eye(calibration: &Calibration) -> DVec3 {
    DVec3::from_array(calibration.eye.map(|estimate| estimate.value))
}

#[test]
fn one_view_tells_pose_axis_and_distortion() {
    for (view, true_eye) in VIEWS {
        let focal = Focal::Known(FOCAL);
        let request = Request { focal, principal_point: true, distortion: true, seed: 0 };
        let found = calibrate(&pairs(view), SIZE, &request).unwrap();
        let off = (eye(&found) - DVec3::from_array(true_eye)).length();
        let [x, y] = [0, 1].map(|n| found.principal_point_px[n].value - AXIS[n]);
        println!("{:.2} px rms; eye {:.2} mm off, axis {x:.1} {y:.1} px", found.rms_px, 1e3 * off);
        assert!(found.rejected.is_empty() && found.rms_px < 0.25);
        assert!(off < 1e-3, "{off}");
        assert!(x.hypot(y) < 12.0, "{x} {y}");
        assert!((found.k1.value - K[0]).abs() < 0.03, "{:?}", found.k1);
        assert!((found.k2.value - K[1]).abs() < 0.05, "{:?}", found.k2);
    }
}

#[test]
fn one_view_tells_the_focal_length_with_the_axis_in_the_middle() {
    for (view, true_eye) in VIEWS {
        let request = Request { distortion: true, ..Request::default() };
        let found = calibrate(&pairs(view), SIZE, &request).unwrap();
        let off = (eye(&found) - DVec3::from_array(true_eye)).length();
        println!(
            "{:.2} px rms; eye {:.1} mm off, focal {:?}",
            found.rms_px,
            1e3 * off,
            found.focal_px
        );
        assert!((found.focal_px.value / FOCAL - 1.0).abs() < 0.05);
        assert!(off < 0.02, "{off}");
    }
}

#[test]
fn a_bending_lens_is_reported() {
    for (view, _) in VIEWS {
        let found = calibrate(&pairs(view), SIZE, &Request::default()).unwrap();
        let told = found.warnings.0.iter().any(|w| w.contains("find the distortion"));
        assert!(told, "{:?}", found.warnings);
    }
}
