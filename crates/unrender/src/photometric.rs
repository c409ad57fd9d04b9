//! The photometric parameters that a project leaves open, `response = "auto"`, `vignetting = "auto"`, and the
//! exposures of further photographs: their initial values, their effect on the photograph, and the results.
//!
//! `crates/recover` estimates their steps from the values with which the photograph was developed;
//! here it is developed again.

use crate::Job;
use crate::project::{Project, ResponseChoice, VignettingChoice};
use unrender_formats::materials::{PhotographEntry, PhotographStd};
use unrender_photo::vignetting::{DARKEST, Law};
use unrender_photo::{Exposure, Response, Transfer};
use unrender_recover::{
    GroupSpec, PhotometricEstimate, PhotometricParameter, Problem, Recovery, Role,
};
use unrender_render::Settings;
use unrender_scene::{Material, Rgb, RgbImage};

/// The note if nothing was refined.
const NOT_ASKED: &str =
    "without the joint refinement, \"auto\" parameters keep their initial values";

/// One photometric parameter of a photograph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    photograph: usize,
    kind: Kind,
}

/// The kind of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The gamma of all channels.
    Gamma,
    /// The coefficient of r^2, r^4 or r^6 of vignetting.
    Vignetting(usize),
    /// The exposure of a channel, as a multiple of its present value.
    Exposure(usize),
}

/// The initial gamma, and its prior mean: most pictures are made for screens.
pub(crate) const GAMMA: f32 = 2.2;
/// A gamma with a larger standard deviation than this causes a note: it changes middle grey by 7 %
/// ...
const GAMMA_OPEN: f64 = 0.1;
/// ... and so does a vignetting whose share of light in the corners has a larger one than this.
const CORNER_OPEN: f64 = 0.05;
/// Derivatives are central differences with this step to each side.
const STEP: f32 = 0.01;
/// The range of gammas.
const GAMMAS: [f32; 2] = [0.5, 5.0];

impl Kind {
    /// Its prior mean, with its standard deviation, and the range in which its derivative is valid.
    fn prior(self) -> (f32, f64, f64) {
        match self {
            Self::Gamma => (GAMMA, 0.5, 0.5),
            Self::Vignetting(_) => (0.0, 1.0, 0.5),
            // The photograph is proportional to it: it must not reach zero.
            Self::Exposure(_) => (1.0, 1.0, 0.9),
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
            (Self::Exposure(channel), ..) => transfer.exposure[channel] *= 1.0 + step,
            _ => {}
        }
    }
}

/// The parameters that the project leaves open, photograph by photograph.
pub(crate) fn asked(project: &Project) -> Vec<Number> {
    let mut asked = Vec::new();
    for (photograph, taken) in project.photographs().enumerate() {
        let mut ask = |kind| asked.push(Number { photograph, kind });
        if taken.response == Some(ResponseChoice::Auto) {
            ask(Kind::Gamma);
        }
        if taken.vignetting == Some(VignettingChoice::Auto) {
            (0..3).for_each(|k| ask(Kind::Vignetting(k)));
        }
        if is_relative(photograph, taken.exposure) {
            (0..3).for_each(|channel| ask(Kind::Exposure(channel)));
        }
    }
    asked
}

/// Whether the exposure of a photograph is estimated relative to that of the first, which is not a
/// parameter of the camera, but belongs to the scene's scale.
fn is_relative(photograph: usize, exposure: Exposure) -> bool {
    photograph > 0 && exposure == Exposure::Auto
}

/// Whether the photograph is linear in all of `numbers`, so that it need not be developed again during the
/// estimation.
pub(crate) fn are_linear(numbers: &[Number]) -> bool {
    numbers.iter().all(|number| matches!(number.kind, Kind::Exposure(_)))
}

/// The effect of each of `numbers` on its photograph of `job` as developed now.
pub(crate) fn photometric_parameters(job: &Job, numbers: &[Number]) -> Vec<PhotometricParameter> {
    let one = |number: &Number| {
        let (middle, deviation, reach) = number.kind.prior();
        let transfer = job.transfer_of(number.photograph);
        let moved = |step: f32| {
            let mut moved = transfer.clone();
            number.kind.add(&mut moved, step);
            job.developed(number.photograph, &moved).radiance
        };
        let [above, below] = [moved(STEP), moved(-STEP)];
        let difference = above.pixels().iter().zip(below.pixels());
        let derivative = difference.map(|(a, b)| (*a - *b) / (2.0 * STEP)).collect();
        PhotometricParameter {
            photograph: number.photograph,
            derivative: RgbImage::new(above.width(), above.height(), derivative),
            prior_mean: f64::from(middle - number.kind.of(transfer)),
            deviation,
            reach,
        }
    };
    numbers.iter().map(one).collect()
}

/// Develops the photographs of `job` again with `numbers` moved by `steps`. Returns the largest
/// relative change of a photograph.
pub(crate) fn apply(job: &mut Job, numbers: &[Number], steps: &[f64]) -> f64 {
    let mut most = 0.0f64;
    for photograph in 0..job.photographs() {
        let all = numbers.iter().zip(steps);
        let (numbers, steps): (Vec<Kind>, Vec<f64>) = all
            .filter(|(number, _)| number.photograph == photograph)
            .map(|(number, step)| (number.kind, *step))
            .unzip();
        if !numbers.is_empty() {
            most = most.max(apply_to(job, photograph, &numbers, &steps));
        }
    }
    most
}

/// Develops one photograph of `job` again with its `numbers` moved by `steps`. Returns its relative change.
fn apply_to(job: &mut Job, photograph: usize, numbers: &[Kind], steps: &[f64]) -> f64 {
    // Steps of a failed fit are ignored. Halving a step that is not a number, as below, would never end.
    if steps.iter().any(|step| !(*step as f32).is_finite()) {
        return 0.0;
    }
    let before = job.photo_of(photograph).radiance.clone();
    let mut share = 1.0;
    // Too large a step would make a part of the picture black, so it is halved. After 150 halves
    // the step is zero in single precision.
    let transfer = loop {
        let mut moved = job.transfer_of(photograph).clone();
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
    job.develop_again(photograph, transfer);
    let after = &job.photo_of(photograph).radiance;
    let sum = |f: &dyn Fn(Rgb, Rgb) -> Rgb| {
        let pixels = before.pixels().iter().zip(after.pixels());
        pixels.map(|(a, b)| f64::from(f(*a, *b).element_sum())).sum::<f64>()
    };
    sum(&|a, b| (a - b).abs()) / sum(&|a, _| a).max(f64::MIN_POSITIVE)
}

/// The results: the parameters of each photograph of `job` as developed now, with standard deviations; none for
/// photographs without open parameters.
pub(crate) fn found(
    job: &Job,
    numbers: &[Number],
    recovery: &Recovery,
) -> Vec<Option<PhotographEntry>> {
    let of = |photograph: usize| {
        let is_asked = numbers.iter().any(|number| number.photograph == photograph);
        is_asked.then(|| {
            let mut transfer = job.transfer_of(photograph).clone();
            if job.project.exposure == Exposure::Auto {
                transfer.exposure *= recovery.exposure;
            }
            found_of(&transfer, (photograph, numbers), &recovery.photometric)
        })
    };
    (0..job.photographs()).map(of).collect()
}

fn found_of(
    transfer: &Transfer,
    (photograph, numbers): (usize, &[Number]),
    photometric: &PhotometricEstimate,
) -> PhotographEntry {
    let covariance = &photometric.covariance;
    let place = |kind| numbers.iter().position(|n| *n == Number { photograph, kind });
    let refined = covariance.len() == numbers.len();
    let std = |k: usize| refined.then(|| covariance[k][k].max(0.0).sqrt());
    let coefficients: Option<Vec<usize>> = (0..3).map(|k| place(Kind::Vignetting(k))).collect();
    let vignetting = coefficients
        .as_ref()
        .map(|_| [0, 1, 2].map(|k| f64::from(Kind::Vignetting(k).of(transfer))));
    let of_corner = coefficients.as_ref().filter(|_| refined).map(|list| {
        let pairs = list.iter().flat_map(|i| list.iter().map(move |j| (*i, *j)));
        pairs.map(|(i, j)| covariance[i][j]).sum::<f64>().max(0.0).sqrt()
    });
    let gamma = place(Kind::Gamma);
    let exposures: Option<Vec<usize>> = (0..3).map(|c| place(Kind::Exposure(c))).collect();
    let exposure = exposures.as_ref().map(|_| transfer.exposure.to_array());
    let of_exposure = |list: Vec<usize>| {
        [0, 1, 2].map(|c| std(list[c]).unwrap_or(0.0) as f32 * transfer.exposure[c])
    };
    let std = PhotographStd {
        gamma: gamma.and_then(std),
        vignetting: coefficients
            .filter(|_| refined)
            .map(|list| [0, 1, 2].map(|k| std(list[k]).unwrap_or(0.0))),
        corner: of_corner,
        exposure: exposures.filter(|_| refined).map(of_exposure),
    };
    PhotographEntry {
        gamma: gamma.map(|_| f64::from(Kind::Gamma.of(transfer))),
        corner: vignetting.map(|a| 1.0 + a.iter().sum::<f64>()),
        vignetting,
        exposure,
        note: if refined { doubt(&std) } else { Some(NOT_ASKED.to_owned()) },
        std: refined.then_some(std),
    }
}

/// Initial exposures of further photographs, with which a scene of half grey would be as bright in
/// them as in the first, judged by groups that both show; `problem` is that of `job`.
pub(crate) fn relative_exposures(job: &Job, problem: &Problem<'_>) -> Vec<Option<Rgb>> {
    let brightness = brightness(problem);
    let of = |photograph: usize| {
        let exposure = project_exposure(job, photograph);
        is_relative(photograph, exposure).then(|| {
            let ratio = |channel: usize| {
                let groups = brightness[0].iter().zip(&brightness[photograph]);
                let ratios = groups.filter_map(|(first, other)| {
                    let ratio = (*first)?[channel] / (*other)?[channel];
                    (ratio.is_finite() && ratio > 0.0).then_some(ratio)
                });
                let mut ratios: Vec<f32> = ratios.collect();
                ratios.sort_by(f32::total_cmp);
                ratios.get(ratios.len() / 2).copied().unwrap_or(1.0)
            };
            Rgb::from_array([0, 1, 2].map(ratio))
        })
    };
    (0..job.photographs()).map(of).collect()
}

fn project_exposure(job: &Job, photograph: usize) -> Exposure {
    let further = photograph.checked_sub(1).map(|k| &job.further[k].project);
    further.unwrap_or(&job.project).exposure
}

/// For each photograph and group: the photograph over the rendering of a scene of half grey; none if too few pixels
/// show the group.
fn brightness(problem: &Problem<'_>) -> Vec<Vec<Option<Rgb>>> {
    /// Pixels of a group that are used, and the least number of them: the result only starts a refinement. Half and
    /// double of them were not tried.
    const PIXELS: usize = 200;
    const FEW: usize = 20;
    let material = |spec: &GroupSpec| match spec.role {
        Role::Unknown => Material::diffuse(Rgb::splat(0.5)),
        Role::Known | Role::Emitter => spec.material.clone(),
    };
    let materials: Vec<Material> = problem.groups.iter().map(material).collect();
    let observation = problem.observation;
    let settings = Settings { spp: 16, ..Settings::default() };
    let of = |photograph: usize, group: usize| {
        let all = observation.pixels_of_group[group].iter();
        let here = all.filter(|pixel| observation.sheet.photograph_of(**pixel) == photograph);
        let pixels: Vec<u32> = here.copied().collect();
        if pixels.len() < FEW || problem.groups[group].role == Role::Emitter {
            return None;
        }
        let step = pixels.len().div_ceil(PIXELS);
        let pixels: Vec<u32> = pixels.into_iter().step_by(step).collect();
        let shown = problem.renderer.rerender((&materials).into(), &pixels, &settings);
        let values = &observation.picture.values;
        let seen: Rgb = pixels.iter().map(|pixel| values.pixels()[*pixel as usize]).sum();
        Some(seen / shown.into_iter().sum::<Rgb>())
    };
    let of_photograph = |k: usize| (0..problem.groups.len()).map(|group| of(k, group)).collect();
    (0..observation.sheet.photographs()).map(of_photograph).collect()
}

/// A note on parameters that the photograph hardly determines.
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
        let numbers = [0, 1, 2].map(|k| Number { photograph: 0, kind: Kind::Vignetting(k) });
        for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX] {
            // Halving such a step never makes it finite, so it must be ignored.
            assert_eq!(apply(&mut job, &numbers, &[0.01, bad, 0.0]), 0.0);
            assert!(job.photo.radiance == before);
        }
        assert!(apply(&mut job, &numbers, &[-0.01, 0.0, 0.0]) > 0.0);
    }
}
