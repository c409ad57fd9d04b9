//! Camera calibration from lines along the axes of the scene, in one photograph of which no model exists yet.
//!
//! Two or three vanishing directions give the focal length and the rotation, with three also the principal point. The
//! estimate is that of least squares over all lines ([`segment`]), robust as the one from points, and so are its
//! standard deviations. A known length, or the camera's height, gives the position ([`place`]).

mod detect;
mod frame;
mod place;
mod segment;
mod start;

pub use detect::straight_lines;

use super::answer::{Calibration, Estimate, Rejected, numbers};
use super::error::CalibrateError;
use super::model::{Free, Model, Observed};
use super::refine::{Certainty, FINAL, certainty, refine};
use super::robust::{Agreement, agree, distance, select};
use super::start::focals;
use super::{Focal, SENSELESS};
use nalgebra::Vector2;
use segment::Segment;
use unrender_scene::{AxisLine, Warnings};

/// The standard deviation of the end of a line that somebody clicks, pixels. At half and double of it the standard
/// deviations of a camera from four lines halve and double; from twenty lines on it does not matter.
const CLICK_SIGMA: f64 = 1.0;
/// This expectation counts as so many lines more than the camera needs. At half of it the standard deviations from
/// five lines vary by a factor of two, at double they hardly follow the lines' own residuals.
const CLICK_FREEDOM: f64 = 4.0;
/// A focal length whose relative standard deviation is above this is not determined: vanishing points are far outside
/// the picture then, and the errors of what follows from them are not normal. At half of it rooms with two lines an axis
/// are refused; at double one of eleven rendered views came out with a focal length 18 times too long.
const VAGUE: f64 = 0.15;
/// The camera's height where nothing says how large the scene is, metres: that of a photographer's eyes. Only the
/// scale of the scene depends on it.
const ASSUMED_HEIGHT: f64 = 1.6;

/// Of the photograph's EXIF data, focal lengths are right up to this factor: they are rounded, and change with focus. At
/// half of it crops lose their camera, at double the data say nothing.
const NEAR_FACTOR: f64 = 1.3;

/// What to estimate, and what is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinesRequest {
    /// The focal length.
    pub focal: Focal,
    /// Whether to estimate the principal point, which needs three axes; else it is the picture's centre.
    pub principal_point: bool,
    /// The camera's height above the origin, metres; the origin is below the camera then.
    pub height_m: Option<f64>,
    /// The seed of the random subsets; the same seed gives the same bits.
    pub seed: u64,
}

/// The camera that saw `lines` in a photograph of `size` (width, height) pixels.
///
/// The origin is the first end of the first line with a length. Without one it is below the camera.
///
/// ```
/// use glam::Vec3;
/// use unrender_photo::calibrate::{LinesRequest, calibrate_lines};
/// use unrender_scene::{AxisLine, Camera};
///
/// // The edges of a box of one metre, and a camera that sees them.
/// let truth = Camera::look_at("truth", Vec3::new(2.0, 1.5, 4.0), Vec3::splat(0.5), Vec3::Y, 0.6);
/// let seen = |point: Vec3| {
///     let (x, y) = truth.project(point, 640, 480).unwrap();
///     [x.into(), y.into()]
/// };
/// let lines: Vec<AxisLine> = (0..12)
///     .map(|i| {
///         let (axis, a, b) = (i / 4, (i / 2 % 2) as f32, (i % 2) as f32);
///         let mut begin = Vec3::ZERO;
///         (begin[(axis + 1) % 3], begin[(axis + 2) % 3]) = (a, b);
///         let ends = [seen(begin), seen(begin + Vec3::AXES[axis])];
///         let length_m = (i == 0).then_some(1.0);
///         AxisLine { name: i.to_string(), axis, is_directed: true, ends, length_m }
///     })
///     .collect();
/// let found = calibrate_lines(&lines, (640, 480), &LinesRequest::default())?;
/// assert!(found.camera("found").origin().distance(truth.origin()) < 0.01);
/// # Ok::<(), unrender_photo::calibrate::CalibrateError>(())
/// ```
///
/// # Errors
/// If the lines are too few, do not determine the requested parameters, or contradict each other.
pub fn calibrate_lines(
    lines: &[AxisLine],
    size: (usize, usize),
    request: &LinesRequest,
) -> Result<Calibration, CalibrateError> {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let centre = Vector2::new(0.5 * width, 0.5 * height);
    let segments: Vec<Segment> = lines
        .iter()
        .map(|line| Segment {
            ends: line.ends.map(|end| Vector2::from(end) - centre),
            axis: line.axis,
        })
        .collect();
    let free = free(request);
    check_directions(&segments, free)?;
    let agreed = agreed(&segments, size, free, request)?;
    let chosen = select(&segments, &agreed.inlier);
    check_directions(&chosen, free)?;
    let model = refine(&agreed.model, &chosen, free, FINAL);
    let certainty = certainty(&model, &chosen, free).map_err(|column| {
        // Where the lines fix the direction once the focal length is held, that is what they do not tell.
        let held = Free { focal: false, ..free };
        let is_focal = certainty(&model, &chosen, held).is_ok();
        undetermined(free.of_focal().filter(|_| is_focal).unwrap_or(column), free)
    })?;
    let certainty = expecting_clicks(certainty);
    if let Some(column) = free.of_focal().filter(|column| certainty.std(*column) > VAGUE) {
        return Err(undetermined(column, free));
    }
    let directed = lines.iter().zip(&segments).zip(&agreed.inlier);
    let directed = directed
        .filter(|((line, _), inlier)| **inlier && (line.is_directed || line.length_m.is_some()));
    let directed: Vec<Segment> = directed.map(|((_, segment), _)| *segment).collect();
    let model = place::oriented(&model, &directed);
    let mut found = Calibration {
        rms_px: (model.cost(&chosen) / chosen.len() as f64).sqrt(),
        rejected: rejected(lines, &segments, &agreed.inlier, &model),
        ..placed(&model, &certainty, lines, &segments, size, free, request)?
    };
    found.warnings.extend(doubts(lines, &segments, &agreed.inlier, &model));
    Ok(found)
}

/// Sorts straight lines of a photograph of `size` (width, height) pixels, as [`straight_lines`] finds them, to the axes
/// of the scene: y is the most upright direction, and the camera looks along z rather than x. Lines along none of them
/// are left out.
///
/// # Errors
/// If no two perpendicular directions are found.
pub fn sort_to_axes(
    lines: &[[[f64; 2]; 2]],
    size: (usize, usize),
    request: &LinesRequest,
) -> Result<Vec<AxisLine>, CalibrateError> {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let centre = Vector2::new(0.5 * width, 0.5 * height);
    let (known, guess) = request.focal.known_or_near();
    let range = guess.map_or(0.0..f64::INFINITY, |guess| guess / NEAR_FACTOR..guess * NEAR_FACTOR);
    let focals = frame::Focals { known: known.into_iter().collect(), range };
    let seen: Vec<_> =
        lines.iter().map(|ends| ends.map(|end| Vector2::from(end) - centre)).collect();
    let free = free(request);
    let axes = frame::axes(&seen, free, &focals, (width, height), request.seed)
        .filter(|axes| axes.iter().any(Option::is_some))
        .ok_or(CalibrateError::NoDirections { there: lines.len() })?;
    let sorted = lines.iter().zip(axes).enumerate().filter_map(|(index, (ends, axis))| {
        let name = format!("line {}", index + 1);
        Some(AxisLine { name, axis: axis?, is_directed: false, ends: *ends, length_m: None })
    });
    Ok(sorted.collect())
}

fn free(request: &LinesRequest) -> Free {
    Free {
        position: false,
        focal: !matches!(request.focal, Focal::Known(_)),
        principal_point: request.principal_point,
        distortion: false,
    }
}

/// Checks that two axes have two lines each (three for the principal point), and that there are as many lines as
/// unknowns.
fn check_directions(segments: &[Segment], free: Free) -> Result<(), CalibrateError> {
    if Segment::suffice(segments, free) {
        return Ok(());
    }
    let needed = segment::axes_needed(free);
    let (counts, lines) = (segment::counts(segments), free.count().max(2 * needed));
    Err(CalibrateError::FewDirections { counts, needed, lines })
}

/// The camera with which most lines agree.
fn agreed(
    segments: &[Segment],
    size: (usize, usize),
    free: Free,
    request: &LinesRequest,
) -> Result<Agreement, CalibrateError> {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let longer_side = width.max(height);
    let (known, guess) = request.focal.known_or_near();
    let focals = focals(known, guess, longer_side);
    let agreed = agree(segments, free, request.seed, &|subset| {
        start::starts(subset, &focals, known.is_some(), longer_side)
    });
    let (agreeing, scale) = agreed.as_ref().map_or((0, f64::INFINITY), |agreed| {
        (agreed.inlier.iter().filter(|inlier| **inlier).count(), agreed.scale)
    });
    let needed = (segments.len() / 2 + 1).max(free.count());
    match agreed {
        Some(agreed) if agreeing >= needed && scale < SENSELESS * width.hypot(height) => Ok(agreed),
        _ => Err(CalibrateError::LinesDisagree {
            agreeing,
            there: segments.len(),
            needed,
            scale_px: scale,
        }),
    }
}

/// The same with a standard deviation that few residuals cannot make too small: they count beside those of
/// [`CLICK_FREEDOM`] more lines with [`CLICK_SIGMA`].
fn expecting_clicks(certainty: Certainty) -> Certainty {
    let freedom = certainty.freedom as f64;
    let squares = certainty.sigma.powi(2) * freedom + CLICK_SIGMA.powi(2) * CLICK_FREEDOM;
    Certainty { sigma: (squares / (freedom + CLICK_FREEDOM)).sqrt(), ..certainty }
}

/// The calibration of `model`, whose position follows from the line with a length or from the height.
fn placed(
    model: &Model,
    certainty: &Certainty,
    lines: &[AxisLine],
    segments: &[Segment],
    size: (usize, usize),
    free: Free,
    request: &LinesRequest,
) -> Result<Calibration, CalibrateError> {
    let measured = lines.iter().zip(segments);
    let mut measured =
        measured.filter_map(|(line, s)| line.length_m.map(|length| (line, s, length)));
    if let Some((line, segment, length)) = measured.next() {
        let place = place::place(model, free, certainty, segment, length)
            .ok_or_else(|| CalibrateError::LineBehind { name: line.name.clone() })?;
        let eye =
            [0, 1, 2].map(|axis| Estimate { value: place.eye[axis], std: Some(place.std[axis]) });
        let model = Model { eye: place.eye, ..*model };
        return Ok(Calibration { eye, ..numbers(&model, certainty, free, size, place.depth) });
    }
    let height = request.height_m.unwrap_or(ASSUMED_HEIGHT);
    let mut standing = *model;
    standing.eye.y = height;
    let mut found = numbers(&standing, certainty, free, size, height);
    if request.height_m.is_none() {
        found.warnings.push(format!(
            "the size of the scene is not known: the camera was put {height} m above the origin; give one line a \
             length_m, or state the camera's height"
        ));
    }
    Ok(found)
}

fn rejected(
    lines: &[AxisLine],
    segments: &[Segment],
    inlier: &[bool],
    model: &Model,
) -> Vec<Rejected> {
    let mut out: Vec<Rejected> = (0..lines.len())
        .filter(|index| !inlier[*index])
        .map(|index| Rejected {
            index,
            name: lines[index].name.clone(),
            distance_px: distance(model, &segments[index]),
        })
        .collect();
    out.sort_by(|a, b| a.distance_px.total_cmp(&b.distance_px));
    out
}

fn doubts(lines: &[AxisLine], segments: &[Segment], inlier: &[bool], model: &Model) -> Warnings {
    let mut warnings = Warnings::default();
    let each = || lines.iter().zip(segments).zip(inlier);
    let against = each().filter(|((line, segment), inlier)| {
        **inlier && line.is_directed && !segment.runs_along(model)
    });
    let names: Vec<&str> = against.map(|((line, _), _)| line.name.as_str()).collect();
    if !names.is_empty() {
        warnings.push(format!(
            "lines that run against the direction of the others of their axis: {}; the axes are right-handed",
            names.join(", ")
        ));
    }
    if let Some(((line, _), _)) =
        each().find(|((line, _), inlier)| !**inlier && line.length_m.is_some())
    {
        warnings.push(format!(
            "line \"{}\", whose length is known, was rejected, yet the camera's position follows from it; check its \
             ends",
            line.name
        ));
    }
    warnings
}

fn undetermined(column: usize, free: Free) -> CalibrateError {
    let (what, remedy) = if Some(column) == free.of_focal() {
        (
            "the focal length",
            "in two of three directions the lines are nearly parallel in the picture; add lines that converge, or \
             state the field of view",
        )
    } else if column >= 3 {
        ("the principal point", "add lines that converge in all three directions, or leave it out")
    } else {
        ("the camera's direction", "add longer lines, and some of another direction")
    };
    CalibrateError::Undetermined { what: what.into(), remedy: remedy.into() }
}
