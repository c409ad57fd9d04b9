//! The numbers of the camera that a project asks for, `response = "auto"` and `vignetting = "auto"`:
//! where they start, what they do to the photograph, and what came out.
//!
//! `crates/recover` finds how far they are from the values that the photograph was developed with;
//! here it is developed anew.

use crate::Job;
use crate::project::{Project, ResponseChoice, VignettingChoice};
use unrender_formats::materials::{PhotographEntry, PhotographStd};
use unrender_photo::vignetting::{DARKEST, Law};
use unrender_photo::{Response, Transfer};
use unrender_recover::{PhotometricEstimate, PhotometricParameter};
use unrender_scene::{Rgb, RgbImage};

/// What there is to say where nothing was refined.
const NOT_ASKED: &str = "without the joint refinement, what is \"auto\" stays where it begins";

/// One number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    /// The gamma of all channels.
    Gamma,
    /// The coefficient of r^2, r^4 or r^6 of vignetting.
    Vignetting(usize),
}

/// The gamma to begin with, and its prior mean: most pictures are made for screens.
pub(crate) const GAMMA: f32 = 2.2;
/// A gamma whose standard deviation is larger is said to be open: it moves middle grey by 7 % ...
const GAMMA_OPEN: f64 = 0.1;
/// ... and so is a fall-off whose share of light in the corners has a larger one.
const CORNER_OPEN: f64 = 0.05;
/// Derivatives are central differences of this width to both sides.
const STEP: f32 = 0.01;
/// No gamma is beyond these.
const GAMMAS: [f32; 2] = [0.5, 5.0];

impl Number {
    /// Its prior mean, with its standard deviation, and how far its
    /// derivative holds.
    fn prior(self) -> (f32, f64, f64) {
        match self {
            Self::Gamma => (GAMMA, 0.5, 0.5),
            Self::Vignetting(_) => (0.0, 1.0, 0.5),
        }
    }

    fn of(self, transfer: &Transfer) -> f32 {
        match (self, &transfer.response, &transfer.vignetting) {
            (Self::Gamma, Response::Gamma(gamma), _) => *gamma,
            (Self::Vignetting(k), _, Some(vignetting)) => match vignetting.law {
                Law::Radial(coefficients) => coefficients[k],
                Law::Cos4 => 0.0,
            },
            _ => self.prior().0,
        }
    }

    fn add(self, transfer: &mut Transfer, step: f32) {
        match (self, &mut transfer.response, &mut transfer.vignetting) {
            (Self::Gamma, Response::Gamma(gamma), _) => {
                *gamma = (*gamma + step).clamp(GAMMAS[0], GAMMAS[1]);
            }
            (Self::Vignetting(k), _, Some(vignetting)) => {
                if let Law::Radial(coefficients) = &mut vignetting.law {
                    coefficients[k] += step;
                }
            }
            _ => {}
        }
    }
}

/// The numbers that the project asks for.
pub(crate) fn asked(project: &Project) -> Vec<Number> {
    let mut asked = Vec::new();
    if project.response == Some(ResponseChoice::Auto) {
        asked.push(Number::Gamma);
    }
    if project.vignetting == Some(VignettingChoice::Auto) {
        asked.extend((0..3).map(Number::Vignetting));
    }
    asked
}

/// What each of `numbers` does to the photograph of `job` as it is developed now.
pub(crate) fn photometric_parameters(job: &Job, numbers: &[Number]) -> Vec<PhotometricParameter> {
    let one = |number: &Number| {
        let (middle, deviation, reach) = number.prior();
        let moved = |step: f32| {
            let mut transfer = job.transfer.clone();
            number.add(&mut transfer, step);
            job.developed(&transfer).radiance
        };
        let [above, below] = [moved(STEP), moved(-STEP)];
        let difference = above.pixels().iter().zip(below.pixels());
        let derivative = difference.map(|(a, b)| (*a - *b) / (2.0 * STEP)).collect();
        PhotometricParameter {
            derivative: RgbImage::new(above.width(), above.height(), derivative),
            prior_mean: f64::from(middle - number.of(&job.transfer)),
            deviation,
            reach,
        }
    };
    numbers.iter().map(one).collect()
}

/// Develops the photograph of `job` anew with `numbers` moved by `steps`. Returns by what share that
/// changed it.
pub(crate) fn apply(job: &mut Job, numbers: &[Number], steps: &[f64]) -> f64 {
    // A fit that has broken down says nothing. Halving a step that is not a number, as below, would never end.
    if steps.iter().any(|step| !(*step as f32).is_finite()) {
        return 0.0;
    }
    let before = job.photo.radiance.clone();
    let mut share = 1.0;
    // A step too far would put a part of the picture into the dark: half of it is one in the same
    // direction. After 150 halves the step is zero in single precision.
    let transfer = loop {
        let mut moved = job.transfer.clone();
        for (number, step) in numbers.iter().zip(steps) {
            number.add(&mut moved, share * *step as f32);
        }
        if moved.vignetting.as_ref().is_none_or(|v| v.darkest() >= DARKEST) {
            break moved;
        }
        if share == 0.0 {
            return 0.0;
        }
        share *= 0.5;
    };
    job.photo = job.developed(&transfer);
    job.transfer = transfer;
    let sum = |f: &dyn Fn(Rgb, Rgb) -> Rgb| {
        let pixels = before.pixels().iter().zip(job.photo.radiance.pixels());
        pixels.map(|(a, b)| f64::from(f(*a, *b).element_sum())).sum::<f64>()
    };
    sum(&|a, b| (a - b).abs()) / sum(&|a, _| a).max(f64::MIN_POSITIVE)
}

/// What came out: the numbers of `job` as it is developed now, and how well they are known.
pub(crate) fn found(
    job: &Job,
    numbers: &[Number],
    photometric: &PhotometricEstimate,
) -> PhotographEntry {
    let covariance = &photometric.covariance;
    let place = |number| numbers.iter().position(|n| *n == number);
    let refined = covariance.len() == numbers.len();
    let std = |k: usize| refined.then(|| covariance[k][k].max(0.0).sqrt());
    let coefficients: Option<Vec<usize>> = (0..3).map(|k| place(Number::Vignetting(k))).collect();
    let vignetting = coefficients
        .as_ref()
        .map(|_| [0, 1, 2].map(|k| f64::from(Number::Vignetting(k).of(&job.transfer))));
    let of_corner = coefficients.as_ref().filter(|_| refined).map(|list| {
        let pairs = list.iter().flat_map(|i| list.iter().map(move |j| (*i, *j)));
        pairs.map(|(i, j)| covariance[i][j]).sum::<f64>().max(0.0).sqrt()
    });
    let gamma = place(Number::Gamma);
    let std = PhotographStd {
        gamma: gamma.and_then(std),
        vignetting: coefficients
            .filter(|_| refined)
            .map(|list| [0, 1, 2].map(|k| std(list[k]).unwrap_or(0.0))),
        corner: of_corner,
    };
    PhotographEntry {
        gamma: gamma.map(|_| f64::from(Number::Gamma.of(&job.transfer))),
        corner: vignetting.map(|a| 1.0 + a.iter().sum::<f64>()),
        vignetting,
        note: if refined { doubt(&std) } else { Some(NOT_ASKED.to_owned()) },
        std: refined.then_some(std),
    }
}

/// What the photograph hardly determines.
fn doubt(std: &PhotographStd) -> Option<String> {
    let gamma = std.gamma.filter(|std| *std > GAMMA_OPEN).map(|std| {
        format!("the photograph hardly determines its gamma (std {std:.2}): state the response")
    });
    let corner = std.corner.filter(|std| *std > CORNER_OPEN).map(|std| {
        format!(
            "the photograph hardly determines how the light falls off (std {std:.2} in the corners): \
             state the vignetting"
        )
    });
    let doubts: Vec<String> = gamma.into_iter().chain(corner).collect();
    (!doubts.is_empty()).then(|| doubts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_photo::vignetting::Vignetting;

    #[test]
    fn steps_that_are_no_numbers_change_nothing_and_end() {
        let project = "../../examples/corpus/isotropic/project.toml";
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(project);
        let (project, warnings) = Project::read(&path).unwrap();
        let mut job = Job::load(project, warnings).unwrap();
        let size = (job.photo.radiance.width(), job.photo.radiance.height());
        let law = Law::Radial([0.0; 3]);
        job.transfer.vignetting = Some(Vignetting { law, camera: job.camera.clone(), size });
        let before = job.photo.radiance.clone();
        let numbers = [0, 1, 2].map(Number::Vignetting);
        for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX] {
            // Halving such a step never makes it finite, so that the search must end by itself.
            assert_eq!(apply(&mut job, &numbers, &[0.01, bad, 0.0]), 0.0);
            assert!(job.photo.radiance == before);
        }
        assert!(apply(&mut job, &numbers, &[-0.01, 0.0, 0.0]) > 0.0);
    }
}
