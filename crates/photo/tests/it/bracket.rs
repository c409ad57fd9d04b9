//! Brackets made of a known picture by a known camera: response, radiance, shifts, motion.

use unrender_photo::bracket::{Bracket, BracketError, Frame, Settings, merge};
use unrender_photo::{Response, Transfer, develop};
use unrender_scene::{Depth, Image, Picture, Rgb};

/// A camera: its curve from linear values to codes, and its noise in squares of white, `base + slope x`.
struct Camera {
    curve: fn(f64) -> f64,
    base: f64,
    slope: f64,
    depth: Depth,
}

fn gamma(x: f64) -> f64 {
    x.powf(1.0 / 2.2)
}

/// A toe and a shoulder on top of the gamma, as picture styles have them.
fn style(x: f64) -> f64 {
    let u = x.powf(1.0 / 2.2);
    0.4 * u + 0.6 * u * u * (3.0 - 2.0 * u)
}

fn linear(x: f64) -> f64 {
    x
}

const GAMMA: Camera = Camera { curve: gamma, base: 4e-7, slope: 1e-4, depth: Depth::Eight };
const STYLE: Camera = Camera { curve: style, ..GAMMA };

/// Standard normal numbers: sums of twelve hashed uniform ones, less six.
fn normal(seed: u64) -> f64 {
    let uniform = |k: u64| {
        let mut x = (12 * seed + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

impl Camera {
    /// The frame of a scene of `radiance` at (column, row) with an exposure; a stream of noise each.
    fn take(
        &self,
        size: (usize, usize),
        radiance: impl Fn(i64, i64) -> [f64; 3],
        exposure: f64,
        stream: u64,
    ) -> Frame {
        let value = |x: usize, y: usize| {
            let light = radiance(x as i64, y as i64);
            let code = |c: usize| {
                let level = light[c] * exposure;
                let seed = ((stream * 4096 + y as u64) * 4096 + x as u64) * 3 + c as u64;
                let noisy = level + (self.base + self.slope * level).sqrt() * normal(seed);
                let code = (self.curve)(noisy.clamp(0.0, 1.0));
                match self.depth.max_code() {
                    Some(max) => (code * f64::from(max)).round() as f32 / max,
                    None => noisy.min(1.0) as f32,
                }
            };
            Rgb::new(code(0), code(1), code(2))
        };
        let picture = Picture::new(Image::from_fn(size.0, size.1, value), self.depth);
        Frame { name: format!("{exposure}.jpg"), picture, exposure, gain: 1.0 }
    }

    /// The linear value of a code.
    fn inverse(&self, code: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *if (self.curve)(middle) < code { &mut low } else { &mut high } = middle;
        }
        low
    }
}

const SIZE: (usize, usize) = (240, 180);

/// Fields of many brightnesses with soft shading and an uneven grain: three decades of light.
fn room(x: i64, y: i64) -> [f64; 3] {
    let field = ((x.div_euclid(12) * 7919 + y.div_euclid(12) * 104_729).rem_euclid(1000)) as f64;
    let level = 4e-3 * 10f64.powf(2.9 * field / 1000.0);
    let shade = 1.0 + 0.1 * (0.11 * x as f64).sin() + 0.1 * (0.13 * y as f64).cos();
    [1.0, 0.8, 0.6].map(|colour| level * shade * colour)
}

const TIMES: [f64; 4] = [0.125, 0.5, 2.0, 8.0];

fn bracket(camera: &Camera) -> Vec<Frame> {
    (0..).zip(TIMES).map(|(k, t)| camera.take(SIZE, room, t, k)).collect()
}

fn merged(frames: &[Frame]) -> Bracket {
    merge(frames, &Settings::default()).unwrap()
}

/// Asserts that fitted curve and radiance are those of the camera.
fn is_found(camera: &Camera) {
    let frames = bracket(camera);
    let found = merged(&frames);
    let fit = found.report.fit.as_ref().unwrap();
    let truth: Vec<f64> = fit.codes.iter().map(|code| camera.inverse(*code)).collect();
    // White is beyond the samples: the unit follows from extrapolation, one factor for all channels.
    let is_covered = |code: f64| (fit.covered[0]..=fit.covered[1]).contains(&code);
    let (mut both, mut own) = (0.0, 0.0);
    for linear in &fit.linear {
        for ((code, l), t) in fit.codes.iter().zip(linear).zip(&truth) {
            if is_covered(*code) {
                both += l * t;
                own += l * l;
            }
        }
    }
    let factor = both / own;
    let (mut worst, mut beyond): (f64, f64) = (0.0, 0.0);
    for linear in &fit.linear {
        for ((code, l), t) in fit.codes.iter().zip(linear).zip(&truth) {
            let of = if is_covered(*code) { &mut worst } else { &mut beyond };
            *of = of.max((factor * l - t).abs());
        }
    }
    println!("unit {factor:.4}");
    println!(
        "response {worst:.5}, beyond {beyond:.5}, Mitsunaga and Nayar {:.5}",
        fit.disagreement
    );
    println!("covered {:?}, brightness {:?}", fit.covered, found.report.brightness);
    println!("noise {:?}, moved {}", found.report.noise, found.report.moved);
    assert!((factor - 1.0).abs() < 0.03 && beyond < 0.04, "unit: {factor}, white: {beyond}");
    let unit = frames[found.report.reference].exposure / factor;
    // Means over the fields that some frame shows well: the noise of their pixels is up to 3 %.
    let (mut errors, mut scatter, mut count) = (Vec::new(), 0.0, 0.0);
    let variance = &found.picture.merged.as_ref().unwrap().variance;
    for top in (0..SIZE.1).step_by(12) {
        for left in (0..SIZE.0).step_by(12) {
            let mut ratio = [0.0; 3];
            let mut good = true;
            // Beside pixels that are clipped in the long frames only the short ones count.
            for (x, y) in (0..100).map(|k| (left + 1 + k % 10, top + 1 + k / 10)) {
                let truth = room(x as i64, y as i64);
                for c in 0..3 {
                    let value = f64::from(found.picture.values.at(x, y)[c]) / unit;
                    let code = |t: f64| (camera.curve)((truth[c] * t).min(1.0));
                    good &= TIMES.iter().any(|t| (0.4..0.95).contains(&code(*t)));
                    ratio[c] += value / truth[c] / 100.0;
                    let deviation = f64::from(variance.at(x, y)[c]).sqrt() / unit;
                    if good && deviation > 0.0 {
                        scatter += ((value - truth[c]) / deviation).powi(2);
                        count += 1.0;
                    }
                }
            }
            if good {
                errors.extend(ratio.map(|r| (r - 1.0).abs()));
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let last = errors[errors.len() - 1];
    println!("{} fields: median {:.4}, worst {last:.4}", errors.len(), errors[errors.len() / 2]);
    println!("normalised residuals {:.3}", (scatter / count).sqrt());
    assert!(errors.len() > 600 && last < 0.01, "radiance: {last}");
    assert!(worst < 0.005, "response: {worst}");
    assert!((0.8..1.3).contains(&(scatter / count).sqrt()), "the variance is that of the errors");
    assert!(fit.disagreement < 0.02, "{}", fit.disagreement);
    assert!(found.report.moved < 0.001, "{}", found.report.moved);
    assert_eq!(found.report.shifts, [[0, 0]; 4]);
}

#[test]
fn a_gamma_is_found_and_undone() {
    is_found(&GAMMA);
}

#[test]
fn a_curve_with_toe_and_shoulder_is_found_and_undone() {
    is_found(&STYLE);
}

#[test]
fn noise_is_measured() {
    let camera = Camera { base: 4e-6, slope: 4e-4, curve: linear, depth: Depth::Sixteen };
    let settings = Settings { response: Some(Response::Linear), ..Settings::default() };
    let found = merge(&bracket(&camera), &settings).unwrap();
    let noise = found.report.noise.unwrap();
    for c in 0..3 {
        assert!((noise.slope[c] / 4e-4 - 1.0).abs() < 0.15, "{noise:?}");
        assert!((noise.base[c] / 4e-6 - 1.0).abs() < 0.5, "{noise:?}");
    }
    assert!(found.report.fit.is_none());
}

#[test]
fn shifts_are_found_and_undone() {
    let shifts = [[3, -2], [0, 0], [-5, 4], [7, 1]];
    let scene = |shift: [i64; 2]| move |x: i64, y: i64| room(x - shift[0], y - shift[1]);
    let frames: Vec<Frame> = (0..)
        .zip(TIMES)
        .zip(shifts)
        .map(|((k, t), s)| GAMMA.take(SIZE, scene([s[0].into(), s[1].into()]), t, k))
        .collect();
    let found = merged(&frames);
    let [x, y] = shifts[found.report.reference];
    let expected = shifts.map(|[a, b]| [a - x, b - y]);
    assert_eq!(found.report.shifts, expected);
    let unit = frames[found.report.reference].exposure;
    let variance = &found.picture.merged.as_ref().unwrap().variance;
    // At the borders the short frames may not cover pixels that the long ones clip: these have no
    // value.
    let invalid = &found.picture.invalid;
    assert!(invalid.len() < SIZE.0 * SIZE.1 / 20, "{}", invalid.len());
    let known = (0..SIZE.0 * SIZE.1).filter(|pixel| invalid.binary_search(pixel).is_err());
    for (column, row) in known.map(|i| (i % SIZE.0, i / SIZE.0)) {
        let truth = room(column as i64 - i64::from(x), row as i64 - i64::from(y))[1];
        let value = f64::from(found.picture.values.at(column, row).y) / unit;
        let deviation = f64::from(variance.at(column, row).y).sqrt() / unit;
        let off = (value - truth).abs();
        assert!(off < 6.0 * deviation + 0.03 * truth, "({column}, {row}): {value} of {truth}");
    }
}

#[test]
fn what_moved_is_left_out() {
    let inside = |x: i64, y: i64| (100..130).contains(&x) && (60..90).contains(&y);
    let with = |x: i64, y: i64| if inside(x, y) { [0.02, 0.03, 0.05] } else { room(x, y) };
    let mut frames = bracket(&STYLE);
    let still = merged(&frames);
    assert_eq!(still.report.reference, 2, "the object is in another frame");
    frames[3] = STYLE.take(SIZE, with, TIMES[3], 3);
    let found = merged(&frames);
    assert_eq!(found.report.reference, 2);
    let fit = found.report.fit.as_ref().unwrap();
    assert!(fit.disagreement < 0.02, "{}", fit.disagreement);
    let share = 900.0 / (SIZE.0 * SIZE.1) as f64;
    let left_out = found.report.ghosts[3];
    assert!((0.9 * share..1.4 * share).contains(&left_out), "{left_out} of {share}");
    let unit = frames[2].exposure;
    for (x, y) in (0..30 * 30).map(|k| (100 + k % 30, 60 + k / 30)) {
        for c in 0..3 {
            let truth = room(x as i64, y as i64)[c];
            let value = f64::from(found.picture.values.at(x, y)[c]) / unit;
            let deviation = f64::from(found.picture.merged.as_ref().unwrap().variance.at(x, y)[c])
                .sqrt()
                / unit;
            let off = (value - truth).abs();
            assert!(off < 5.0 * deviation + 0.04 * truth, "({x}, {y}): {value} of {truth}");
        }
    }
}

#[test]
fn clipped_everywhere_is_clipped() {
    let lamp = |x: i64, y: i64| if x < 20 && y < 20 { [99.0; 3] } else { room(x, y) };
    let frames: Vec<Frame> = (0..).zip(TIMES).map(|(k, t)| GAMMA.take(SIZE, lamp, t, k)).collect();
    let found = merged(&frames);
    let share = 400.0 / (SIZE.0 * SIZE.1) as f64;
    assert!((found.report.clipped / share - 1.0).abs() < 0.05, "{}", found.report.clipped);
    let white_level = found.picture.merged.as_ref().unwrap().white_level;
    assert_eq!(*found.picture.values.at(10, 10), white_level);
    let transfer = Transfer { white_level, ..Transfer::plain(Response::Linear, Rgb::ONE) };
    let photo = develop(&found.picture, &transfer);
    assert!(*photo.saturated.at(10, 10) && !*photo.valid.at(10, 10) && *photo.valid.at(40, 40));
    assert_eq!(photo.clipped as f64, (found.report.clipped * (SIZE.0 * SIZE.1) as f64).round());
    // The step represents the variance.
    let variance = found.picture.merged.as_ref().unwrap().variance.at(40, 40).x;
    let step = photo.quantisation_step.at(40, 40).x;
    assert!((step * step / 12.0 / variance - 1.0).abs() < 1e-4);
}

#[test]
fn the_result_is_the_same_again() {
    let frames = bracket(&STYLE);
    let (once, again) = (merged(&frames), merged(&frames));
    assert!(once == again);
}

#[test]
fn wrong_times_are_seen() {
    let camera = Camera { curve: linear, depth: Depth::Sixteen, ..GAMMA };
    let mut frames = bracket(&camera);
    frames[3].exposure *= 1.1;
    let settings = Settings { response: Some(Response::Linear), ..Settings::default() };
    let found = merge(&frames, &settings).unwrap();
    let brightness = &found.report.brightness;
    assert!(
        (brightness[2] - 1.1).abs() < 0.01 && (brightness[1] - 1.0).abs() < 0.01,
        "{brightness:?}"
    );
}

#[test]
fn frames_without_numbers_and_floats_are_merged() {
    let camera = Camera { curve: linear, depth: Depth::Float, ..GAMMA };
    let mut frames = bracket(&camera);
    let hole = 50 * SIZE.0 + 50;
    for frame in &mut frames {
        frame.picture.invalid.push(hole);
        frame.picture.values.pixels_mut()[hole] = Rgb::ZERO;
    }
    frames[0].picture.invalid.push(hole + 1);
    let settings = Settings { white_level: Rgb::splat(0.999), ..Settings::default() };
    let found = merge(&frames, &settings).unwrap();
    assert_eq!(found.picture.invalid, [hole]);
    assert_eq!(found.response, Response::Linear);
    assert!(found.picture.values.pixels().iter().all(|value| value.is_finite()));
}

#[test]
fn faults_are_named() {
    let frames = bracket(&GAMMA);
    let problem =
        |frames: &[Frame]| merge(frames, &Settings::default()).expect_err("a fault").to_string();
    assert!(problem(&[]).contains("there is 0"));
    assert!(problem(&frames[..1]).contains("there is 1"));
    let changed = |change: &dyn Fn(&mut Frame)| {
        let mut frames = frames.clone();
        change(&mut frames[1]);
        problem(&frames)
    };
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        assert!(changed(&|frame| frame.exposure = bad).contains("the exposure of 0.5.jpg is"));
    }
    let small = GAMMA.take((10, 10), room, 1.0, 0).picture;
    assert!(
        changed(&|frame| frame.picture = small.clone()).contains("10 x 10 pixels, but 0.125.jpg")
    );
    assert!(
        changed(&|frame| frame.picture.depth = Depth::Float).contains("another kind of pixels")
    );
    let equal: Vec<Frame> = (0..3).map(|k| GAMMA.take((40, 40), room, 0.5, k)).collect();
    assert!(problem(&equal).contains("same exposure"));
    let black: Vec<Frame> =
        [1u32, 2].map(|t| GAMMA.take((40, 40), |_, _| [0.0; 3], f64::from(t), t.into())).to_vec();
    let found = merge(&black, &Settings::default());
    assert!(matches!(found, Err(BracketError::EquallyBright { .. })), "{:?}", found.err());
}

#[test]
fn exposures_that_the_frames_cannot_have_are_refused() {
    let problem = |frames: &[Frame]| merge(frames, &Settings::default()).expect_err("a fault");
    for camera in [&GAMMA, &STYLE, &Camera { curve: linear, depth: Depth::Float, ..GAMMA }] {
        let frames = bracket(camera);
        // Every order of the times but the right one.
        for order in [[1, 0, 2, 3], [0, 2, 1, 3], [3, 1, 2, 0], [1, 2, 3, 0], [3, 2, 1, 0]] {
            let mut swapped = frames.clone();
            swapped.iter_mut().zip(order).for_each(|(frame, k)| frame.exposure = TIMES[k]);
            let BracketError::Order { found, stated, .. } = problem(&swapped) else {
                panic!("{order:?}: {}", problem(&swapped))
            };
            assert_eq!(found, "0.125.jpg, 0.5.jpg, 2.jpg, 8.jpg", "{order:?}");
            assert_ne!(stated, found);
        }
        let mut twice = frames.clone();
        twice[3].picture = twice[1].picture.clone();
        assert!(matches!(problem(&twice), BracketError::Twice { .. }), "{}", problem(&twice));
        // Another photograph with the same exposure.
        twice[3].picture = camera.take(SIZE, room, TIMES[2], 9).picture;
        let again = problem(&twice);
        assert!(matches!(again, BracketError::EquallyBright { ratio: 4.0, .. }), "{again}");
    }
    // Two photographs of one exposure, both stated so, are accepted, as are steps of a third of a stop in the
    // dark.
    let mut frames = bracket(&GAMMA);
    frames.push(GAMMA.take(SIZE, room, TIMES[2], 9));
    assert!(merge(&frames, &Settings::default()).is_ok());
    let dim = Camera { curve: linear, depth: Depth::Eight, base: 4e-5, slope: 1e-3 };
    let dark = |x: i64, y: i64| room(x, y).map(|light| 0.02 * light);
    let frames: Vec<Frame> =
        (0..).zip([1.0, 1.26, 1.59]).map(|(k, t)| dim.take(SIZE, dark, t, k)).collect();
    let settings = Settings { response: Some(Response::Linear), ..Settings::default() };
    assert!(merge(&frames, &settings).is_ok());
}
