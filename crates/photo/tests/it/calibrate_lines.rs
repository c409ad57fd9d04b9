//! Cameras from lines along the axes: accuracy and coverage over rooms with known cameras, and what is refused.

use crate::common::{Random, SIZE, Truth};
use glam::{DVec2, DVec3};
use unrender_photo::calibrate::{
    CalibrateError, Calibration, Estimate, Focal, LinesRequest, calibrate_lines, sort_to_axes,
};
use unrender_scene::AxisLine;

/// A camera somewhere in a room, looking down a little, both walls of a corner in view.
fn view(random: &mut Random) -> Truth {
    let eye = [random.within(-1.0, 1.0), random.within(1.2, 2.0), random.within(2.0, 4.0)];
    let turn = random.within(0.25, 0.6) * if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let ahead = DVec3::new(f64::sin(turn), random.within(-0.35, -0.15), -f64::cos(turn));
    let target = DVec3::from(eye) + ahead;
    let focal = random.within(0.8, 1.8) * SIZE.0 as f64;
    Truth { roll: random.within(-0.03, 0.03), ..Truth::pinhole(eye, target.into(), focal) }
}

/// `count` lines an axis, as seen with errors of `sigma` pixels at both ends; the first is 1 m long in the scene and
/// begins at `origin`.
fn seen(truth: &Truth, count: usize, sigma: f64, random: &mut Random) -> (Vec<AxisLine>, DVec3) {
    let mut lines = Vec::new();
    let mut origin = DVec3::ZERO;
    for axis in 0..3 {
        let mut found = 0;
        while found < count {
            let begin = DVec3::new(
                random.within(-3.0, 3.0),
                random.within(0.0, 2.5),
                random.within(-4.0, 1.0),
            );
            let length = if lines.is_empty() { 1.0 } else { random.within(0.5, 2.0) };
            let points = [begin, begin + length * DVec3::AXES[axis]];
            if !points.iter().all(|point| truth.shows(*point)) {
                continue;
            }
            let ends = points.map(|point| {
                let error = sigma * DVec2::new(random.normal(), random.normal());
                (truth.pixel(point).expect("it is in front") + error).into()
            });
            if lines.is_empty() {
                origin = begin;
            }
            let length_m = lines.is_empty().then_some(length);
            let name = format!("{axis} {found}");
            lines.push(AxisLine { name, axis, is_directed: true, ends, length_m });
            found += 1;
        }
    }
    (lines, origin)
}

/// Focal length and principal point, angles and position of the truth, and what was found.
fn both(truth: &Truth, origin: DVec3, found: &Calibration) -> Vec<(f64, Estimate)> {
    let [_, _, forward] = truth.axes();
    let eye = truth.eye - origin;
    vec![
        (truth.focal, found.focal_px),
        (forward.x.atan2(-forward.z).to_degrees(), found.heading_deg),
        (forward.y.asin().to_degrees(), found.pitch_deg),
        (truth.roll.to_degrees(), found.roll_deg),
        (eye.x, found.eye[0]),
        (eye.y, found.eye[1]),
        (eye.z, found.eye[2]),
        (0.5 * SIZE.0 as f64 + truth.principal_point.x, found.principal_point_px[0]),
        (0.5 * SIZE.1 as f64 + truth.principal_point.y, found.principal_point_px[1]),
    ]
}

/// The median relative error of the focal length in many rooms, and the mean squared error of each number in its
/// variances.
fn in_rooms(rooms: usize, count: usize, request: &LinesRequest) -> (f64, Vec<f64>) {
    let mut random = Random(5);
    let mut errors = Vec::new();
    let mut pulls: Vec<Vec<f64>> = Vec::new();
    for _ in 0..rooms {
        let mut truth = view(&mut random);
        if request.principal_point {
            truth.principal_point =
                DVec2::new(random.within(-80.0, 80.0), random.within(-80.0, 80.0));
        }
        let (lines, origin) = seen(&truth, count, 1.0, &mut random);
        let found = match calibrate_lines(&lines, SIZE, request) {
            // Four or six lines may happen not to converge.
            Err(CalibrateError::Undetermined { .. }) if count < 6 => continue,
            found => found.expect("the lines determine a camera"),
        };
        assert!(found.rejected.is_empty(), "{:?}", found.rejected);
        errors.push((found.focal_px.value / truth.focal - 1.0).abs());
        let numbers = both(&truth, origin, &found).into_iter();
        let pull = numbers.filter_map(|(truth, found)| Some((found.value - truth) / found.std?));
        pulls.push(pull.collect());
    }
    // Most do.
    assert!(errors.len() * 10 >= rooms * 9, "{} of {rooms} rooms have a camera", errors.len());
    errors.sort_by(f64::total_cmp);
    let mean = |number: usize| {
        pulls.iter().map(|pull| pull[number].powi(2)).sum::<f64>() / pulls.len() as f64
    };
    (errors[errors.len() / 2], (0..pulls[0].len()).map(mean).collect())
}

#[test]
fn lines_give_the_camera_within_their_standard_deviations() {
    for (count, most) in [(2, 0.04), (6, 0.012)] {
        let (error, squares) = in_rooms(20, count, &LinesRequest::default());
        assert!(error < most, "{count} lines an axis: the focal length is {error} off");
        // The mean of 20 squares of a standard normal deviate is 1 with a standard deviation of 0.32.
        assert!(squares.iter().all(|mean| (0.2..2.2).contains(mean)), "{squares:?}");
    }
}

#[test]
#[ignore = "slow: ten times as many rooms"]
fn standard_deviations_cover_in_many_rooms() {
    for count in [2, 3, 6, 20] {
        let (error, squares) = in_rooms(200, count, &LinesRequest::default());
        eprintln!("{count} lines an axis: focal length {error}, squared pulls {squares:.2?}");
        assert!(squares.iter().all(|mean| (0.7..1.5).contains(mean)), "{squares:?}");
    }
}

#[test]
fn three_vanishing_points_give_the_principal_point() {
    let request = LinesRequest { principal_point: true, ..LinesRequest::default() };
    let (error, squares) = in_rooms(15, 6, &request);
    assert!(error < 0.02, "the focal length is {error} off");
    assert!(squares.iter().all(|mean| (0.2..2.5).contains(mean)), "{squares:?}");
}

/// Lines of a room, the camera that saw them, and the origin.
fn room(count: usize) -> (Truth, Vec<AxisLine>, DVec3) {
    let mut random = Random(11);
    let truth = view(&mut random);
    let (lines, origin) = seen(&truth, count, 0.5, &mut random);
    (truth, lines, origin)
}

#[test]
fn lines_along_another_axis_are_found() {
    let (truth, mut lines, origin) = room(8);
    for wrong in [3, 12, 20] {
        lines[wrong].axis = (lines[wrong].axis + 1) % 3;
    }
    let found = calibrate_lines(&lines, SIZE, &LinesRequest::default()).unwrap();
    let mut rejected: Vec<usize> = found.rejected.iter().map(|out| out.index).collect();
    rejected.sort_unstable();
    assert_eq!(rejected, [3, 12, 20]);
    for (truth, found) in both(&truth, origin, &found) {
        let std = found.std.unwrap_or(1e-9);
        assert!((found.value - truth).abs() < 4.0 * std, "{truth} is found as {found:?}");
    }
}

#[test]
fn directions_tell_one_end_of_the_room_from_the_other() {
    let (truth, mut lines, _) = room(6);
    let heading = |lines: &[AxisLine]| {
        calibrate_lines(lines, SIZE, &LinesRequest::default()).unwrap().heading_deg.value
    };
    let [_, _, forward] = truth.axes();
    let seen = forward.x.atan2(-forward.z).to_degrees();
    assert!((heading(&lines) - seen).abs() < 1.0);
    // The same room with x and z pointing the other way.
    for line in lines.iter_mut().filter(|line| line.axis != 1) {
        line.ends.reverse();
    }
    let turned = heading(&lines) - seen;
    assert!((turned.abs() - 180.0).abs() < 1.0, "{turned}");
    // Without directions the camera looks towards -z.
    lines.iter_mut().for_each(|line| (line.is_directed, line.length_m) = (false, None));
    assert!((heading(&lines) - seen).abs() < 1.0);
}

#[test]
fn a_height_gives_the_scale_and_nothing_gives_a_warning() {
    let (_, mut lines, _) = room(6);
    lines.iter_mut().for_each(|line| line.length_m = None);
    let of = |height_m| {
        let request = LinesRequest { height_m, ..LinesRequest::default() };
        calibrate_lines(&lines, SIZE, &request).unwrap()
    };
    let stated = of(Some(1.25));
    assert_eq!(
        stated.eye.map(|eye| (eye.value, eye.std)),
        [(0.0, None), (1.25, None), (0.0, None)]
    );
    assert!(stated.warnings.0.is_empty());
    assert!(of(None).warnings.0[0].contains("size of the scene is not known"));
}

#[test]
fn what_lines_cannot_tell_is_reported() {
    let (_, lines, _) = room(6);
    let fails = |lines: &[AxisLine], request: &LinesRequest| {
        calibrate_lines(lines, SIZE, request).expect_err("they do not determine a camera")
    };
    let request = LinesRequest::default();
    let few = fails(&lines[..7], &request);
    assert!(matches!(few, CalibrateError::FewDirections { counts: [6, 1, 0], .. }), "{few}");
    // A wall that the camera faces: only the lines that lead away from it converge.
    let facing = Truth::pinhole([0.0, 1.5, 3.0], [0.0, 1.5, 0.0], 1500.0);
    let (lines, _) = seen(&facing, 6, 0.0, &mut Random(3));
    let vague = fails(&lines, &request);
    assert!(
        matches!(&vague, CalibrateError::Undetermined { what, .. } if what == "the focal length"),
        "{vague}"
    );
    let known = LinesRequest { focal: Focal::Known(1500.0), ..request };
    let found = calibrate_lines(&lines, SIZE, &known).unwrap();
    assert!(found.heading_deg.value.abs() < 1e-6 && found.pitch_deg.value.abs() < 1e-6);
}

#[test]
fn lines_without_sense_are_reported() {
    let mut random = Random(2);
    let mut end = || [random.within(0.0, 1600.0), random.within(0.0, 1200.0)];
    let lines: Vec<AxisLine> = (0..30)
        .map(|index| AxisLine {
            name: index.to_string(),
            axis: index % 3,
            is_directed: false,
            ends: [end(), end()],
            length_m: None,
        })
        .collect();
    let told = calibrate_lines(&lines, SIZE, &LinesRequest::default()).expect_err("no camera");
    assert!(matches!(told, CalibrateError::LinesDisagree { .. }), "{told}");
    let ends: Vec<_> = lines.iter().map(|line| line.ends).collect();
    let told = sort_to_axes(&ends, SIZE, &LinesRequest::default()).expect_err("no directions");
    assert!(matches!(told, CalibrateError::NoDirections { there: 30 }), "{told}");
}
