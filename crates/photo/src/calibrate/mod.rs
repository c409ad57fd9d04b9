//! Camera calibration: pose, focal length and lens from points of the scene and their image points.
//!
//! The paper uses the method of DeMenthon and Davis and a downhill simplex [Boivin and Gagalowicz
//! 2002, section 3.1]. This module begins with the same method and finds the minimum by least squares,
//! which also give the standard deviation of each parameter. One file per step:
//!
//! 1. `posit`: pose from few points by iterated scaled orthography, also for points in one plane;
//!    `start` does so for one focal length after the other, where that is unknown;
//! 2. `robust`: least trimmed squares over random subsets finds the inliers;
//! 3. `refine`: least squares by Levenberg-Marquardt, and the covariance of the estimate; `answer`
//!    converts both to angles, pixels and metres.
//!
//! [`calibrate`] runs all steps. [`calibrate_lines`] runs the last two on lines along the axes of the scene, with starts
//! from their vanishing points (`lines`). Input with a wrong sign (left-handed axes, y counted from the
//! bottom) fits a mirrored world only; that is tested and reported.

mod answer;
mod doubt;
mod error;
mod layout;
mod lines;
mod model;
mod posit;
mod refine;
mod robust;
mod start;

pub use answer::{Calibration, Estimate, Rejected};
pub use doubt::doubtful_pairs;
pub use error::CalibrateError;
pub use lines::{LinesRequest, calibrate_lines, sort_to_axes, straight_lines};

use layout::Layout;
use model::{Free, Model, Observed, Sight};
use nalgebra::{Matrix3, Vector2, Vector3};
use robust::{Agreement, LEAST_SIGMA, agree, greatest_chance, select};
use unrender_scene::Pair;

/// The world is reported as mirrored if mirrored pairs fit this many times better ...
const MIRRORED_BETTER: f64 = 4.0;
/// ... and unmirrored ones fit worse than this share of the picture's diagonal.
const DOUBTFUL: f64 = 1e-3;
/// No camera fits pairs that are farther off than this share of the picture's diagonal.
const SENSELESS: f64 = 0.02;
/// Another pose fits nearly as well up to this many times the sum of squared residuals.
const NEARLY: f64 = 4.0;
/// Degrees of freedom needed before a parameter that was held fixed is tested.
const LEAST_FREEDOM: usize = 6;
/// A focal length whose relative standard deviation is above this is not determined.
const VAGUE: f64 = 0.5;

/// Prior knowledge of the focal length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Focal {
    /// None.
    #[default]
    Unknown,
    /// About this many pixels, as the photograph's EXIF data say.
    Near(f64),
    /// Exactly this many pixels; it is held fixed.
    Known(f64),
}

impl Focal {
    /// The focal length if it is known, and about what it is otherwise, pixels.
    fn known_or_near(self) -> (Option<f64>, Option<f64>) {
        match self {
            Self::Unknown => (None, None),
            Self::Near(focal) => (None, Some(focal)),
            Self::Known(focal) => (Some(focal), None),
        }
    }
}

/// The parameters to estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Request {
    /// The focal length.
    pub focal: Focal,
    /// Whether to estimate the principal point, else it is the picture's centre.
    pub principal_point: bool,
    /// Whether to estimate the radial distortion k1 and k2, else there is none.
    pub distortion: bool,
    /// The seed of the random subsets; the same seed gives the same bits.
    pub seed: u64,
}

impl Request {
    fn free(&self) -> Free {
        Free {
            position: true,
            focal: !matches!(self.focal, Focal::Known(_)),
            principal_point: self.principal_point,
            distortion: self.distortion,
        }
    }
}

/// The camera that saw `pairs` in a photograph of `size` (width, height) pixels.
///
/// ```
/// use glam::Vec3;
/// use unrender_photo::calibrate::{Request, calibrate};
/// use unrender_scene::{Camera, Pair};
///
/// // The corners of a box of one metre, and a camera that sees them.
/// let truth = Camera::look_at("truth", Vec3::new(2.0, 1.5, 4.0), Vec3::splat(0.5), Vec3::Y, 0.6);
/// let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
/// let pairs: Vec<Pair> = (0..8)
///     .map(|i| {
///         let (x, y) = truth.project(corner(i), 640, 480).unwrap();
///         let point = corner(i).as_dvec3().to_array();
///         Pair { name: i.to_string(), pixel: [x.into(), y.into()], point }
///     })
///     .collect();
/// let found = calibrate(&pairs, (640, 480), &Request::default())?;
/// assert!(found.camera("found").origin().distance(truth.origin()) < 0.01);
/// # Ok::<(), unrender_photo::calibrate::CalibrateError>(())
/// ```
///
/// # Errors
/// If the pairs are too few, do not determine the requested parameters, or contradict each other.
pub fn calibrate(
    pairs: &[Pair],
    size: (usize, usize),
    request: &Request,
) -> Result<Calibration, CalibrateError> {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let centre = Vector2::new(0.5 * width, 0.5 * height);
    let sight = |pair: &Pair| Sight {
        image: Vector2::from(pair.pixel) - centre,
        point: Vector3::from(pair.point),
    };
    let sights: Vec<Sight> = pairs.iter().map(sight).collect();
    let free = request.free();
    check_layout(&sights, free)?;
    let (known, guess) = request.focal.known_or_near();
    let focals = start::focals(known, guess, width.max(height));
    let agreed = agree_on(&sights, &focals, free, request.seed);
    let agreed = check_agreement(agreed, &sights, &focals, request, width.hypot(height))?;
    let chosen = select(&sights, &agreed.inlier);
    check_layout(&chosen, free)?;
    let mut model = refine::refine(&agreed.model, &chosen, free, refine::FINAL);
    let mut other = other_pose(&model, &chosen, free);
    if let Some(better) = other.as_mut().filter(|o| o.cost(&chosen) < model.cost(&chosen)) {
        std::mem::swap(better, &mut model);
    }
    // Residuals of a hundredth of a pixel do not distinguish poses.
    let floor = 1e-4 * chosen.len() as f64;
    let alike = |other: &Model| other.cost(&chosen) < NEARLY * model.cost(&chosen).max(floor);
    let other = other.filter(alike);
    let certainty = refine::certainty(&model, &chosen, free).map_err(|n| undetermined(n, free))?;
    if let Some(column) = free.of_focal().filter(|column| certainty.std(*column) > VAGUE) {
        return Err(undetermined(column, free));
    }
    let missed = missed(&model, &chosen, free);
    let found = answer::FittedCamera { model, certainty, inlier: agreed.inlier, other, missed };
    Ok(answer::answer(pairs, &sights, size, free, &found))
}

fn agree_on(sights: &[Sight], focals: &[f64], free: Free, seed: u64) -> Option<Agreement> {
    agree(sights, free, seed, &|subset| start::starts(subset, focals, free.without_lens()))
}

fn check_layout(sights: &[Sight], free: Free) -> Result<(), CalibrateError> {
    let needed = Sight::fewest(sights, free);
    if sights.len() < needed {
        let hint = if free.focal {
            ", or state the field of view if you know it: the pose alone needs 4"
        } else {
            ""
        };
        return Err(CalibrateError::TooFew {
            there: sights.len(),
            needed,
            numbers: in_words(free),
            unknowns: free.count(),
            hint: hint.into(),
        });
    }
    let layout = Layout::of(sights);
    if layout.is_line() {
        let [length, width, _] = layout.spread;
        return Err(CalibrateError::Collinear { length, width });
    }
    if layout.is_planar() && free.principal_point && free.focal {
        return Err(CalibrateError::CoplanarPrincipalPoint);
    }
    Ok(())
}

fn in_words(free: Free) -> String {
    let parts = [
        (true, "pose"),
        (free.focal, "focal length"),
        (free.principal_point, "principal point"),
        (free.distortion, "distortion"),
    ];
    let asked: Vec<&str> = parts.iter().filter(|(is, _)| *is).map(|(_, name)| *name).collect();
    match asked.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => asked.concat(),
    }
}

/// Checks that most pairs agree, without mirroring.
fn check_agreement(
    agreed: Option<Agreement>,
    sights: &[Sight],
    focals: &[f64],
    request: &Request,
    diagonal: f64,
) -> Result<Agreement, CalibrateError> {
    let free = request.free();
    let (agreeing, scale) = agreed.as_ref().map_or((0, f64::INFINITY), |agreed| {
        (agreed.inlier.iter().filter(|b| **b).count(), agreed.scale)
    });
    let needed = (sights.len() / 2 + 1).max(Sight::fewest(sights, free));
    let all_well = agreeing == sights.len() && scale < DOUBTFUL * diagonal;
    if !all_well && !Layout::of(sights).is_planar() {
        let mirror = |sight: &Sight| {
            let image = Vector2::new(-sight.image.x, sight.image.y);
            Sight { image, ..*sight }
        };
        let mirrored: Vec<Sight> = sights.iter().map(mirror).collect();
        let other = agree_on(&mirrored, focals, free, request.seed);
        let mirrored_px = other.map_or(f64::INFINITY, |other| other.scale);
        // No photograph is measured so accurately that a smaller residual is significant.
        if MIRRORED_BETTER * mirrored_px.max(0.01) < scale && scale > DOUBTFUL * diagonal {
            return Err(CalibrateError::Mirrored { mirrored_px, plain_px: scale });
        }
    }
    match agreed {
        Some(agreed) if agreeing >= needed && scale < SENSELESS * diagonal => Ok(agreed),
        _ => Err(CalibrateError::NoConsensus {
            agreeing,
            there: sights.len(),
            needed,
            scale_px: scale,
        }),
    }
}

fn undetermined(number: usize, free: Free) -> CalibrateError {
    let mut names = vec!["the camera's direction"; 3];
    names.extend(["the camera's position"; 3]);
    if free.focal {
        names.push("the focal length");
    }
    if free.principal_point {
        names.extend(["the principal point"; 2]);
    }
    if free.distortion {
        names.extend(["the distortion"; 2]);
    }
    let what = names.get(number).copied().unwrap_or("the camera").to_owned();
    let remedy = match number {
        6 if free.focal => {
            "seen from afar, or in a plane that faces the camera, a near short lens and a far long \
             one show the same; measure points at different depths, or state the field of view"
        }
        0..6 => "measure points farther apart, also in depth",
        _ => "measure points up to the picture's corners, or leave it out",
    };
    CalibrateError::Undetermined { what, remedy: remedy.into() }
}

/// A parameter that was held fixed although the pairs contradict it, with the root mean square
/// residual after freeing it, pixels: an F test of the decrease of the squares by two more
/// parameters.
fn missed(model: &Model, sights: &[Sight], free: Free) -> Vec<(&'static str, f64)> {
    let with_bend = Free { distortion: true, ..free };
    let with_shift = Free { principal_point: true, ..free };
    let mut missed = Vec::new();
    for (more, name) in [(with_bend, "distortion"), (with_shift, "principal point")] {
        let in_vain = more == free || check_layout(sights, more).is_err();
        if in_vain || 2 * sights.len() < more.count() + LEAST_FREEDOM {
            continue;
        }
        let better = refine::refine(model, sights, more, refine::FINAL);
        let (before, after) = (model.cost(sights), better.cost(sights));
        let freedom = 2 * sights.len() - more.count();
        let variance = (after / freedom as f64).max(LEAST_SIGMA.powi(2));
        if (before - after) / (2.0 * variance) > greatest_chance(freedom) {
            missed.push((name, (after / sights.len() as f64).sqrt()));
        }
    }
    missed
}

/// The second pose of nearly planar points (Necker reversal), whose projection from a distance is
/// nearly the same. Refined; none if it converges to the first.
fn other_pose(model: &Model, sights: &[Sight], free: Free) -> Option<Model> {
    let (centre, normal) = Layout::plane(sights)?;
    let in_camera = model.in_camera(&centre);
    let mirror = |axis: &Vector3<f64>| Matrix3::identity() - 2.0 * axis * axis.transpose();
    let turned = mirror(&in_camera.normalize()) * model.camera_from_world * mirror(&normal);
    let eye = centre - turned.transpose() * in_camera;
    let start = Model { camera_from_world: turned, eye, ..*model };
    let other = refine::refine(&start, sights, free, refine::FINAL);
    let apart = (other.eye - model.eye).norm() > 0.05 * in_camera.norm();
    (apart && sights.iter().all(|sight| sight.is_in_front(&other))).then_some(other)
}
