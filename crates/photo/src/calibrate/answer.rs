//! The calibrated camera in angles, pixels and metres, each with its standard deviation.

use super::layout::Layout;
use super::model::{Free, Model, Sight};
use super::refine::Certainty;
use super::robust::distance;
use glam::{DVec3, Vec3};
use nalgebra::{DVector, Matrix3, RowDVector, Vector2, Vector3};
use unrender_scene::{Camera, Lens, Pair, Warnings};

/// Errors of the pixels above this share of the picture's diagonal cause a warning.
const UNUSUAL: f64 = 0.004;

/// A parameter with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation; none for a parameter that was held fixed.
    pub std: Option<f64>,
}

/// An outlier.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rejected {
    /// The index of the pair.
    pub index: usize,
    /// The pair's name.
    pub name: String,
    /// The reprojection error, pixels; infinite behind the camera.
    pub distance_px: f64,
}

/// A calibrated camera.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Calibration {
    /// The camera's centre, metres, world space.
    pub eye: [Estimate; 3],
    /// Heading, degrees from world -z about +y: positive towards +x.
    pub heading_deg: Estimate,
    /// Pitch, degrees upwards from the horizontal.
    pub pitch_deg: Estimate,
    /// Roll, degrees: positive if the right side is raised.
    pub roll_deg: Estimate,
    /// Focal length in pixels.
    pub focal_px: Estimate,
    /// Full vertical field of view of the centred pinhole, degrees.
    pub fov_y_deg: Estimate,
    /// Principal point, pixels from the top left corner.
    pub principal_point_px: [Estimate; 2],
    /// Radial distortion.
    pub k1: Estimate,
    /// Radial distortion.
    pub k2: Estimate,
    /// The root mean square reprojection error of the inliers, pixels.
    pub rms_px: f64,
    /// The standard deviation of one image coordinate, estimated from the inliers.
    pub sigma_px: f64,
    /// The outliers, the largest error last.
    pub rejected: Vec<Rejected>,
    /// A point on the optical axis, at the depth of the points, world space.
    pub target: [f64; 3],
    /// Upwards in the picture, world space.
    pub up: [f64; 3],
    /// Warnings.
    pub warnings: Warnings,
    /// The photograph's width and height, pixels.
    pub size: (usize, usize),
}

impl Calibration {
    /// The principal point as [`Lens`] has it, in heights of the picture from its centre.
    pub fn principal_point(&self) -> [f32; 2] {
        let (width, height) = (self.size.0 as f64, self.size.1 as f64);
        let [x, y] = self.principal_point_px.map(|estimate| estimate.value);
        [((x - 0.5 * width) / height) as f32, ((y - 0.5 * height) / height) as f32]
    }

    /// The camera, called `name`.
    pub fn camera(&self, name: &str) -> Camera {
        let single = |point: [f64; 3]| DVec3::from_array(point).as_vec3();
        let eye: Vec3 = single(self.eye.map(|estimate| estimate.value));
        let fov_y_rad = (self.fov_y_deg.value as f32).to_radians();
        let camera = Camera::look_at(name, eye, single(self.target), single(self.up), fov_y_rad);
        let lens = Lens {
            principal_point: self.principal_point(),
            k1: self.k1.value as f32,
            k2: self.k2.value as f32,
            ..Lens::default()
        };
        let aspect = Some(self.size.0 as f32 / self.size.1 as f32);
        Camera { lens, aspect, ..camera }
    }
}

/// The result of the estimation.
pub(super) struct FittedCamera {
    pub(super) model: Model,
    pub(super) certainty: Certainty,
    /// For each pair whether it is an inlier.
    pub(super) inlier: Vec<bool>,
    /// Another camera that fits nearly as well.
    pub(super) other: Option<Model>,
    /// A parameter that should not be held fixed, and the residual after freeing it.
    pub(super) missed: Vec<(&'static str, f64)>,
}

/// Converts the result; `sights` are the `pairs` in the picture's own frame.
pub(super) fn answer(
    pairs: &[Pair],
    sights: &[Sight],
    size: (usize, usize),
    free: Free,
    found: &FittedCamera,
) -> Calibration {
    let FittedCamera { model, certainty, inlier, .. } = found;
    let good = super::robust::select(sights, inlier);
    let depths = good.iter().map(|sight| model.in_camera(&sight.point).z);
    let depth = depths.sum::<f64>() / good.len().max(1) as f64;
    let mut calibration = Calibration {
        rms_px: (model.cost(&good) / good.len().max(1) as f64).sqrt(),
        rejected: rejected(pairs, sights, inlier, model),
        ..numbers(model, certainty, free, size, depth)
    };
    doubts(&mut calibration, found, &good);
    calibration
}

/// The parameters of `model` with their standard deviations. `depth` is that of what the camera looks at, metres; a
/// calibration without residuals, rejections and warnings.
pub(super) fn numbers(
    model: &Model,
    certainty: &Certainty,
    free: Free,
    size: (usize, usize),
    depth: f64,
) -> Calibration {
    let (width, height) = (size.0 as f64, size.1 as f64);
    let centre = Vector2::new(0.5 * width, 0.5 * height);
    let deviations = Deviations { certainty, free };
    let focal = model.ln_focal.exp();
    let half = 0.5 * height / focal;
    let angles = angles(&model.camera_from_world);
    let angle_std = |which: usize| deviations.of_angle(model, which);
    let to_degrees = |value: f64, std: Option<f64>| Estimate {
        value: value.to_degrees(),
        std: std.map(f64::to_degrees),
    };
    let focal_std = deviations.of(free.of_focal());
    let axes = model.camera_from_world;
    let forward = axes.row(2).transpose();
    let up = -axes.row(1).transpose();
    let axis = model.principal_point + centre;
    Calibration {
        eye: [0, 1, 2]
            .map(|n| Estimate { value: model.eye[n], std: deviations.of(free.of_eye(n)) }),
        heading_deg: to_degrees(angles[0], angle_std(0)),
        pitch_deg: to_degrees(angles[1], angle_std(1)),
        roll_deg: to_degrees(angles[2], angle_std(2)),
        focal_px: Estimate { value: focal, std: focal_std.map(|std| std * focal) },
        fov_y_deg: to_degrees(
            2.0 * half.atan(),
            focal_std.map(|std| std * 2.0 * half / (1.0 + half * half)),
        ),
        principal_point_px: [0, 1]
            .map(|n| Estimate { value: axis[n], std: deviations.of(free.of_principal_point(n)) }),
        k1: Estimate { value: model.k[0], std: deviations.of(free.of_distortion(0)) },
        k2: Estimate { value: model.k[1], std: deviations.of(free.of_distortion(1)) },
        rms_px: 0.0,
        sigma_px: certainty.sigma,
        rejected: Vec::new(),
        target: (model.eye + depth * forward).into(),
        up: up.into(),
        warnings: Warnings::default(),
        size,
    }
}

fn rejected(pairs: &[Pair], sights: &[Sight], inlier: &[bool], model: &Model) -> Vec<Rejected> {
    let out = (0..pairs.len()).filter(|index| !inlier[*index]);
    let mut out: Vec<Rejected> = out
        .map(|index| Rejected {
            index,
            name: pairs[index].name.clone(),
            distance_px: distance(model, &sights[index]),
        })
        .collect();
    out.sort_by(|a, b| a.distance_px.total_cmp(&b.distance_px));
    out
}

fn doubts(calibration: &mut Calibration, found: &FittedCamera, good: &[Sight]) {
    let warnings = &mut calibration.warnings;
    let (width, height) = calibration.size;
    let diagonal = (width as f64).hypot(height as f64);
    if calibration.sigma_px > UNUSUAL * diagonal {
        warnings.push(format!(
            "the pairs are {:.1} px off in each coordinate, more than measured points should be; \
             check them",
            calibration.sigma_px
        ));
    }
    for (name, rms_px) in &found.missed {
        warnings.push(format!(
            "find the {name} too: with it the pairs fit to {rms_px:.2} px instead of {:.2} px rms, \
             and a wrong fixed value makes the other numbers wrong",
            calibration.rms_px
        ));
    }
    if let Some(other) = &found.other {
        let [x, y, z] = other.eye.into();
        warnings.push(format!(
            "the points lie nearly in one plane, and a camera at ({x:.3}, {y:.3}, {z:.3}) explains \
             them nearly as well; measure points off the plane"
        ));
    }
    if let Some(doubt) = wrong_side(&found.model, good) {
        warnings.push(doubt);
    }
    if !calibration.camera("").covers(width, height) {
        calibration.warnings.push(
            "the distortion folds over before the picture's corners; measure points there, or \
             leave it out",
        );
    }
}

/// Mirrored measurements of points in a plane fit as well as correct ones, but the camera sees the
/// plane from its other side: a warning if that is implausible.
fn wrong_side(model: &Model, good: &[Sight]) -> Option<&'static str> {
    /// How level a floor or a ceiling is, the cosine of its slope.
    const LEVEL: f64 = 0.8;
    let (centre, normal) = Layout::plane(good)?;
    // The camera's second axis points downwards in the picture.
    if model.camera_from_world[(1, 1)] > 0.0 {
        return Some(
            "the camera hangs upside down: if yours did not, it sees the plane of the points from \
             the wrong side; y_px counts from the top, and the points' axes are right-handed",
        );
    }
    let below = normal.y.abs() > LEVEL && model.eye.y < centre.y;
    below.then_some(
        "the camera is below the points, as below a ceiling: if they are on a floor, it sees that \
         from the wrong side; y_px counts from the top, and the points' axes are right-handed",
    )
}

struct Deviations<'a> {
    certainty: &'a Certainty,
    free: Free,
}

impl Deviations<'_> {
    fn of(&self, column: Option<usize>) -> Option<f64> {
        column.map(|column| self.certainty.std(column))
    }

    /// The standard deviation of one of [`angles`], radians.
    fn of_angle(&self, model: &Model, which: usize) -> Option<f64> {
        const STEP: f64 = 1e-6;
        let mut slope = RowDVector::zeros(self.free.count());
        for axis in 0..3 {
            let turned = |by: f64| {
                let mut step = DVector::zeros(self.free.count());
                step[axis] = by;
                let turned = model.moved(step.as_slice(), self.free);
                angles(&turned.camera_from_world)[which]
            };
            let difference = turned(STEP) - turned(-STEP);
            slope[axis] = nearest_turn(difference) / (2.0 * STEP);
        }
        let variance = (&slope * &self.certainty.inverse * slope.transpose())[0];
        Some(self.certainty.sigma * variance.sqrt())
    }
}

/// The same angle between -pi and pi.
fn nearest_turn(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

/// Heading, pitch and roll, radians, as [`Calibration`] describes them.
fn angles(camera_from_world: &Matrix3<f64>) -> [f64; 3] {
    let right = camera_from_world.row(0).transpose();
    let forward = camera_from_world.row(2).transpose();
    let level = forward.cross(&Vector3::y());
    let level = level.try_normalize(1e-12).unwrap_or_else(Vector3::x);
    let above = level.cross(&forward);
    [
        forward.x.atan2(-forward.z),
        forward.y.clamp(-1.0, 1.0).asin(),
        right.dot(&above).atan2(right.dot(&level)),
    ]
}
