//! Wrong pairs are found and named; where no camera can be found, the error says why.

use crate::common::{Random, SIZE, Truth};
use glam::{DVec2, DVec3};
use unrender_formats::points::Pair;
use unrender_photo::calibrate::{CalibrateError, Calibration, Focal, Request, calibrate};

fn view() -> Truth {
    Truth::pinhole([0.4, 1.6, 2.3], [-0.2, 1.1, -1.0], 1100.0)
}

/// Points all over a room that the camera sees.
fn points(count: usize, truth: &Truth, random: &mut Random) -> Vec<DVec3> {
    let mut points = Vec::new();
    while points.len() < count {
        let mut within = |low, high| random.within(low, high);
        let point = DVec3::new(within(-2.0, 2.0), within(0.0, 2.6), within(-2.5, 0.5));
        if truth.shows(point) {
            points.push(point);
        }
    }
    points
}

/// Moves some pairs far away in the picture and exchanges the points of two others; their indices.
fn spoil(pairs: &mut [Pair], count: usize, random: &mut Random) -> Vec<usize> {
    let mut wrong: Vec<usize> = Vec::new();
    while wrong.len() < count {
        let index = (random.unit() * pairs.len() as f64) as usize;
        if !wrong.contains(&index) {
            wrong.push(index);
        }
    }
    let far = |a: [f64; 2], b: [f64; 2]| DVec2::from(a).distance(b.into()) > 60.0;
    let mut moved = 0;
    if count >= 2 && far(pairs[wrong[0]].pixel, pairs[wrong[1]].pixel) {
        let (first, second) = (pairs[wrong[0]].pixel, pairs[wrong[1]].pixel);
        (pairs[wrong[0]].pixel, pairs[wrong[1]].pixel) = (second, first);
        moved = 2;
    }
    for index in &wrong[moved..] {
        let true_pixel = pairs[*index].pixel;
        while !far(true_pixel, pairs[*index].pixel) {
            pairs[*index].pixel = [SIZE.0, SIZE.1].map(|side| random.within(0.0, side as f64));
        }
    }
    wrong.sort_unstable();
    wrong
}

fn rejected(calibration: &Calibration) -> Vec<usize> {
    let mut indices: Vec<usize> = calibration.rejected.iter().map(|r| r.index).collect();
    indices.sort_unstable();
    indices
}

/// In how many of the `trials` all wrong pairs, and only these, are thrown out.
fn found_out(
    trials: usize,
    (count, wrong): (usize, usize),
    request: &Request,
    truth: &Truth,
) -> usize {
    let mut random = Random(3);
    let mut found = 0;
    for trial in 0..trials {
        let points = points(count, truth, &mut random);
        let mut pairs = truth.pairs(&points, 0.5, &mut random);
        let wrong = spoil(&mut pairs, wrong, &mut random);
        match calibrate(&pairs, SIZE, request) {
            Ok(calibration) => {
                let out = rejected(&calibration);
                let off =
                    (DVec3::from_array(calibration.eye.map(|e| e.value)) - truth.eye).length();
                if out == wrong && off < 0.05 {
                    found += 1;
                } else {
                    println!("trial {trial}: wrong {wrong:?}, out {out:?}, eye off {off:.3}");
                }
            }
            Err(error) => println!("trial {trial}: {error}"),
        }
    }
    println!("{wrong} of {count}: {found} of {trials}");
    found
}

#[test]
fn thirty_percent_of_wrong_pairs_are_found() {
    thirty_percent_are_found(10);
}

#[test]
#[ignore = "slow: six times as many trials"]
fn thirty_percent_of_wrong_pairs_are_found_sixty_times() {
    thirty_percent_are_found(60);
    thirty_percent_are_found_behind_a_bending_lens(60);
}

fn thirty_percent_are_found(trials: usize) {
    let found =
        |pairs, request: &Request| assert_eq!(found_out(trials, pairs, request, &view()), trials);
    found((20, 6), &Request::default());
    found((40, 12), &Request::default());
    found((14, 4), &Request { focal: Focal::Known(1100.0), ..Request::default() });
}

#[test]
fn thirty_percent_of_wrong_pairs_are_found_behind_a_bending_lens() {
    thirty_percent_are_found_behind_a_bending_lens(10);
}

fn thirty_percent_are_found_behind_a_bending_lens(trials: usize) {
    let truth = Truth { k: [-0.15, 0.03], principal_point: DVec2::new(20.0, -10.0), ..view() };
    let request = Request { principal_point: true, distortion: true, ..Request::default() };
    assert_eq!(found_out(trials, (40, 12), &request, &truth), trials);
}

#[test]
fn a_few_pairs_show_one_that_is_wrong() {
    assert!(found_out(30, (9, 2), &Request::default(), &view()) >= 27);
}

#[test]
fn rejected_pairs_are_named_and_the_same_every_time() {
    let mut random = Random(9);
    let points = points(12, &view(), &mut random);
    let mut pairs = view().pairs(&points, 0.5, &mut random);
    pairs[4].pixel[0] += 120.0;
    pairs[4].name = "lamp".into();
    let first = calibrate(&pairs, SIZE, &Request::default()).unwrap();
    assert_eq!(first.rejected.len(), 1);
    assert_eq!(first.rejected[0].name, "lamp");
    assert!((first.rejected[0].distance_px - 120.0).abs() < 5.0);
    assert_eq!(first, calibrate(&pairs, SIZE, &Request::default()).unwrap());
}

fn fails(pairs: &[Pair], request: &Request) -> CalibrateError {
    let error = calibrate(pairs, SIZE, request).expect_err("there is no camera");
    println!("{error}");
    error
}

#[test]
fn mirrored_measurements_are_reported() {
    let mut random = Random(21);
    for _ in 0..3 {
        let points = points(16, &view(), &mut random);
        let good = view().pairs(&points, 0.5, &mut random);
        let (width, height) = (SIZE.0 as f64, SIZE.1 as f64);
        let spoilt = |spoil: &dyn Fn(&mut Pair)| {
            let mut pairs = good.clone();
            pairs.iter_mut().for_each(spoil);
            fails(&pairs, &Request::default())
        };
        for error in [
            spoilt(&|pair| pair.point[2] = -pair.point[2]),
            spoilt(&|pair| pair.pixel[0] = width - pair.pixel[0]),
            spoilt(&|pair| pair.pixel[1] = height - pair.pixel[1]),
            spoilt(&|pair| pair.point.swap(1, 2)),
        ] {
            assert!(matches!(error, CalibrateError::Mirrored { .. }), "{error}");
        }
    }
}

#[test]
fn pairs_without_sense_are_reported() {
    let mut random = Random(33);
    let points = points(20, &view(), &mut random);
    let mut pairs = view().pairs(&points, 0.5, &mut random);
    for pair in &mut pairs {
        pair.pixel = [SIZE.0, SIZE.1].map(|side| random.within(0.0, side as f64));
    }
    let error = fails(&pairs, &Request::default());
    assert!(matches!(error, CalibrateError::NoConsensus { there: 20, needed: 11, .. }), "{error}");
}

#[test]
fn too_few_pairs_are_told_with_what_they_are_for() {
    let mut random = Random(2);
    let points = points(20, &view(), &mut random);
    let pairs = view().pairs(&points, 0.1, &mut random);
    let known = Request { focal: Focal::Known(1100.0), ..Request::default() };
    let axis = Request { principal_point: true, ..Request::default() };
    let all = Request { distortion: true, ..axis };
    for (request, needed) in [(known, 4), (Request::default(), 5), (axis, 6), (all, 7)] {
        let error = fails(&pairs[..needed - 1], &request);
        let CalibrateError::TooFew { there, needed: told, .. } = error else { panic!("{error}") };
        assert_eq!((there, told), (needed - 1, needed));
        // Two more pairs in general position are enough for an answer, if not for a good one.
        let enough = calibrate(&pairs[..needed + 2], SIZE, &request);
        assert!(enough.is_ok(), "{needed}: {:?}", enough.err());
    }
    let text = fails(&pairs[..4], &Request::default()).to_string();
    assert!(text.contains("pose and focal length (with 7 unknowns)"), "{text}");
}

#[test]
fn points_on_a_line_are_reported() {
    let mut random = Random(4);
    let on_line =
        |n: usize| DVec3::new(-1.0, 0.2, -1.0) + 0.25 * n as f64 * DVec3::new(1.0, 0.5, -0.3);
    let points: Vec<DVec3> = (0..8).map(on_line).collect();
    let error = fails(&view().pairs(&points, 0.5, &mut random), &Request::default());
    assert!(matches!(error, CalibrateError::Collinear { .. }), "{error}");
    let same = vec![DVec3::new(0.0, 1.0, -1.0); 8];
    let error = fails(&view().pairs(&same, 0.5, &mut random), &Request::default());
    assert!(matches!(error, CalibrateError::Collinear { .. }), "{error}");
}

#[test]
fn what_a_plane_cannot_tell_is_reported() {
    let mut random = Random(6);
    let wall = |n: usize| DVec3::new(0.5 * (n % 4) as f64 - 0.9, 0.4 * (n / 4) as f64 + 0.4, -2.0);
    let points: Vec<DVec3> = (0..16).map(wall).collect();
    let slanted = Truth::pinhole([2.4, 1.9, 0.4], [-0.1, 0.9, -2.0], 1100.0);
    let axis = Request { principal_point: true, ..Request::default() };
    let error = fails(&slanted.pairs(&points, 0.5, &mut random), &axis);
    assert_eq!(error, CalibrateError::CoplanarPrincipalPoint);
    let facing = Truth::pinhole([-0.15, 1.0, 1.5], [-0.15, 1.0, -2.0], 1100.0);
    let pairs = facing.pairs(&points, 0.5, &mut random);
    let error = fails(&pairs, &Request::default());
    assert!(matches!(error, CalibrateError::Undetermined { .. }), "{error}");
    let known = Request { focal: Focal::Known(1100.0), ..Request::default() };
    let calibration = calibrate(&pairs, SIZE, &known).unwrap();
    assert!((calibration.eye[2].value - 1.5).abs() < 6.0 * calibration.eye[2].std.unwrap());
}

#[test]
fn a_plane_seen_from_afar_has_two_poses() {
    let mut random = Random(8);
    let tile = |n: usize| DVec3::new(0.1 * (n % 3) as f64, 0.0, 0.1 * (n / 3) as f64);
    let points: Vec<DVec3> = (0..9).map(tile).collect();
    let truth = Truth::pinhole([0.3, 4.0, 2.0], [0.1, 0.0, 0.1], 1500.0);
    let known = Request { focal: Focal::Known(1500.0), ..Request::default() };
    let calibration = calibrate(&truth.pairs(&points, 1.0, &mut random), SIZE, &known).unwrap();
    assert!(calibration.warnings.0.iter().any(|w| w.contains("nearly as well")), "{calibration:?}");
}

#[test]
fn a_mirrored_floor_is_doubted() {
    let mut random = Random(17);
    let tile = |n: usize| DVec3::new(0.45 * (n % 4) as f64, 0.0, 0.45 * (n / 4) as f64);
    let points: Vec<DVec3> = (0..16).map(tile).collect();
    let truth = Truth::pinhole([2.6, 1.5, 2.4], [0.7, 0.0, 0.7], 1300.0);
    let good = truth.pairs(&points, 0.5, &mut random);
    let told = |spoil: &dyn Fn(&mut Pair)| {
        let mut pairs = good.clone();
        pairs.iter_mut().for_each(spoil);
        calibrate(&pairs, SIZE, &Request::default()).unwrap().warnings.0
    };
    assert_eq!(told(&|_| {}), [""; 0]);
    let from_bottom = told(&|pair| pair.pixel[1] = SIZE.1 as f64 - pair.pixel[1]);
    assert!(from_bottom[0].contains("below the points"), "{from_bottom:?}");
    let left_handed = told(&|pair| pair.point[2] = -pair.point[2]);
    assert!(left_handed[0].contains("upside down"), "{left_handed:?}");
}

#[test]
fn the_camera_shows_the_points_where_they_were_seen() {
    let truth =
        Truth { k: [-0.15, 0.03], principal_point: DVec2::new(20.0, -10.0), roll: 0.4, ..view() };
    let request = Request { principal_point: true, distortion: true, ..Request::default() };
    let mut random = Random(14);
    let points = points(40, &truth, &mut random);
    let pairs = truth.pairs(&points, 0.0, &mut random);
    let calibration = calibrate(&pairs, SIZE, &request).unwrap();
    assert!(calibration.rejected.is_empty() && calibration.rms_px < 1e-6);
    let camera = calibration.camera("photo");
    for pair in &pairs {
        let point = DVec3::from_array(pair.point).as_vec3();
        let (x, y) = camera.project(point, SIZE.0, SIZE.1).expect("the point is in the picture");
        let off = DVec2::new(x.into(), y.into()).distance(pair.pixel.into());
        assert!(off < 0.01, "{}: {off} px", pair.name);
    }
}
