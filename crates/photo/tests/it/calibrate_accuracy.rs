//! Calibration is as good as the measured points allow: the Cramer-Rao bound, from derivatives of
//! the tests' own camera by finite differences, and the stated standard deviations against it.

use crate::common::{Random, SIZE, Truth};
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};
use unrender_photo::calibrate::{Calibration, Estimate, Focal, Request, calibrate};

const SIGMA: f64 = 0.5;
const REALISATIONS: usize = 100;
/// The most that an error may be above the bound, as a share of it.
const ABOVE_BOUND: f64 = 1.2;

/// Eye, heading, pitch, roll (degrees), focal length, then principal point, k1 and k2.
fn numbers(truth: &Truth) -> Vec<f64> {
    let forward = (truth.target - truth.eye).normalize();
    let heading = forward.x.atan2(-forward.z).to_degrees();
    let pitch = forward.y.asin().to_degrees();
    let DVec3 { x, y, z } = truth.eye;
    let DVec2 { x: cx, y: cy } = truth.principal_point;
    vec![
        x,
        y,
        z,
        heading,
        pitch,
        truth.roll.to_degrees(),
        truth.focal,
        cx,
        cy,
        truth.k[0],
        truth.k[1],
    ]
}

fn truth_of(numbers: &[f64]) -> Truth {
    let [heading, pitch, roll] = [3, 4, 5].map(|n| numbers[n].to_radians());
    let forward =
        DVec3::new(pitch.cos() * heading.sin(), pitch.sin(), -pitch.cos() * heading.cos());
    let eye = DVec3::from_slice(numbers);
    Truth {
        eye,
        target: eye + forward,
        roll,
        focal: numbers[6],
        principal_point: DVec2::from_slice(&numbers[7..]),
        k: [numbers[9], numbers[10]],
    }
}

/// The same numbers of a calibration.
fn found(calibration: &Calibration) -> Vec<Estimate> {
    let centre = [0.5 * SIZE.0 as f64, 0.5 * SIZE.1 as f64];
    let [x, y] = [0, 1].map(|n| {
        let estimate = calibration.principal_point_px[n];
        Estimate { value: estimate.value - centre[n], ..estimate }
    });
    let Calibration { eye, heading_deg, pitch_deg, roll_deg, focal_px, k1, k2, .. } = calibration;
    let mut all = eye.to_vec();
    all.extend([*heading_deg, *pitch_deg, *roll_deg, *focal_px, x, y, *k1, *k2]);
    all
}

/// Which of [`numbers`] are searched for.
fn free(request: &Request) -> Vec<usize> {
    let mut free: Vec<usize> = (0..6).collect();
    if !matches!(request.focal, Focal::Known(_)) {
        free.push(6);
    }
    if request.principal_point {
        free.extend([7, 8]);
    }
    if request.distortion {
        free.extend([9, 10]);
    }
    free
}

/// The least standard deviations that unbiased estimates of the free numbers can have.
fn bound(truth: &Truth, points: &[DVec3], free: &[usize]) -> DVector<f64> {
    let at = numbers(truth);
    let mut jacobian = DMatrix::zeros(2 * points.len(), free.len());
    for (column, &number) in free.iter().enumerate() {
        let step = 1e-5 * (1.0 + 0.01 * at[number].abs());
        let shifted = |by: f64| {
            let mut numbers = at.clone();
            numbers[number] += by;
            truth_of(&numbers)
        };
        let (above, below) = (shifted(step), shifted(-step));
        for (row, point) in points.iter().enumerate() {
            let slope =
                (above.pixel(*point).unwrap() - below.pixel(*point).unwrap()) / (2.0 * step);
            jacobian[(2 * row, column)] = slope.x;
            jacobian[(2 * row + 1, column)] = slope.y;
        }
    }
    let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    jacobian.column_iter_mut().zip(&norms).for_each(|(mut column, norm)| column /= *norm);
    let covariance = (jacobian.transpose() * &jacobian).try_inverse().expect("determined");
    DVector::from_fn(free.len(), |n, _| SIGMA * covariance[(n, n)].sqrt() / norms[n])
}

/// Calibrates many noisy measurements and compares errors and stated deviations with the bound.
fn reaches_the_bound(what: &str, truth: &Truth, points: &[DVec3], request: &Request) {
    assert!(
        points.iter().all(|point| truth.shows(*point)),
        "{what}: a point is not in the picture"
    );
    let free = free(request);
    let bound = bound(truth, points, &free);
    let at = numbers(truth);
    let mut random = Random(11);
    let count = free.len();
    let (mut squares, mut stated, mut within) =
        (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for _ in 0..REALISATIONS {
        let pairs = truth.pairs(points, SIGMA, &mut random);
        let calibration = calibrate(&pairs, SIZE, request).unwrap();
        assert!(calibration.rejected.is_empty(), "{what}: {:?}", calibration.rejected);
        let doubted = calibration.warnings.0.iter().any(|w| w.starts_with("find the"));
        assert!(!doubted, "{what}: {:?}", calibration.warnings);
        let found = found(&calibration);
        for (n, &number) in free.iter().enumerate() {
            let std = found[number].std.expect("free numbers have a deviation");
            let error = found[number].value - at[number];
            squares[n] += error * error / REALISATIONS as f64;
            stated[n] += std / REALISATIONS as f64;
            within[n] += f64::from(error.abs() < std) / REALISATIONS as f64;
        }
        let held = (0..found.len()).filter(|number| !free.contains(number));
        held.for_each(|number| assert_eq!(found[number].std, None));
    }
    let ratio = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(bound.iter()).map(|(value, bound)| value / bound).collect()
    };
    let errors = ratio(&squares.iter().map(|square| square.sqrt()).collect::<Vec<_>>());
    let stated = ratio(&stated);
    println!(
        "{what}: error / bound {errors:.2?}; stated / bound {stated:.2?}; within {within:.2?}"
    );
    for n in 0..count {
        assert!(errors[n] < ABOVE_BOUND, "{what}, number {}: {}", free[n], errors[n]);
        assert!((stated[n] - 1.0).abs() < 0.15, "{what}, number {}: {}", free[n], stated[n]);
        // 68 % of normal errors, somewhat less for the few equations that sigma comes from; three standard
        // deviations of the share of so many.
        assert!((0.54..0.81).contains(&within[n]), "{what}, number {}: {}", free[n], within[n]);
    }
}

/// Points on the walls, the floor and the furniture of a room, seen from inside it.
fn room(count: usize, truth: &Truth) -> Vec<DVec3> {
    let mut random = Random(5);
    let mut points = Vec::new();
    while points.len() < count {
        let mut within = |low, high| random.within(low, high);
        let point = match points.len() % 5 {
            0 => DVec3::new(-2.0, within(0.0, 2.6), within(-2.5, 1.0)),
            1 => DVec3::new(2.0, within(0.0, 2.6), within(-2.5, 1.0)),
            2 => DVec3::new(within(-2.0, 2.0), within(0.0, 2.6), -2.5),
            3 => DVec3::new(within(-2.0, 2.0), 0.0, within(-2.5, 1.0)),
            _ => DVec3::new(within(-1.5, 1.5), within(0.0, 1.0), within(-2.0, 0.5)),
        };
        if truth.shows(point) {
            points.push(point);
        }
    }
    points
}

fn view() -> Truth {
    Truth { roll: 0.03, ..Truth::pinhole([0.4, 1.6, 2.3], [-0.2, 1.1, -1.0], 1100.0) }
}

/// A square grid on the floor, seen from beyond a corner of it.
fn floor(side: usize) -> Vec<DVec3> {
    let spacing = 1.4 / (side - 1) as f64;
    let at = |n: usize| DVec3::new((n % side) as f64, 0.0, (n / side) as f64);
    (0..side * side).map(|n| spacing * at(n)).collect()
}

fn floor_view() -> Truth {
    Truth { roll: -0.1, ..Truth::pinhole([2.6, 1.5, 2.4], [0.7, 0.0, 0.7], 1300.0) }
}

#[test]
fn pose_alone() {
    let (truth, points) = (view(), room(8, &view()));
    let focal = Focal::Known(truth.focal);
    reaches_the_bound("pose", &truth, &points, &Request { focal, ..Request::default() });
}

#[test]
fn pose_and_focal_length() {
    reaches_the_bound("focal", &view(), &room(12, &view()), &Request::default());
}

#[test]
fn everything_at_once() {
    let truth = Truth { principal_point: DVec2::new(21.0, -14.0), k: [-0.12, 0.03], ..view() };
    let request = Request { principal_point: true, distortion: true, ..Request::default() };
    reaches_the_bound("all", &truth, &room(40, &truth), &request);
}

#[test]
fn a_plane_tells_pose_and_focal_length() {
    let (truth, points) = (floor_view(), floor(4));
    reaches_the_bound("plane", &truth, &points, &Request::default());
}

#[test]
fn a_plane_tells_distortion_too() {
    let truth = Truth { k: [-0.2, 0.08], ..floor_view() };
    let request = Request { distortion: true, ..Request::default() };
    reaches_the_bound("plane, distorted", &truth, &floor(6), &request);
}
