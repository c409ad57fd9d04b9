//! Compares a run with the truth, group by group.

pub(crate) mod entry;
mod parameters;
pub(crate) mod simpler;
pub(crate) mod wilson;

pub(crate) use parameters::Errors;

use super::family::Family;
use super::generate::Plan;
use super::photograph::Photograph;
use super::store::{Folder, Format, Meta};
use crate::Failure;
use entry::{Entry, Materials};
use serde::{Deserialize, Serialize};
use std::path::Path;
use unrender::formats::{materials, picture};
use unrender::render::{GeometryBuffers, Tracer};
use unrender::scene::{Rgb, RgbImage, Texture, Wrap};

/// Groups of fewer valid pixels are not scored.
pub(crate) const LEAST: usize = 200;
/// A group whose error is above this share of its brightness is wrong at any noise.
const ERROR_MAX: f64 = 0.3;
/// Noise does not explain the error of a group that is above this many times its noise floor.
const FLOORS_MAX: f64 = 5.0;

/// Whether the hypothesis is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    /// That of the truth.
    Right,
    /// A simpler one that the photograph cannot distinguish from the truth.
    Simpler,
    /// Another one.
    Wrong,
}

impl Verdict {
    /// Whether it counts as right.
    pub(crate) fn is_right(self) -> bool {
        self != Self::Wrong
    }
}

/// A group of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct GroupScore {
    pub(crate) group: String,
    /// Pixels inside the group that are not clipped.
    pub(crate) pixels: usize,
    pub(crate) truth: String,
    pub(crate) found: String,
    pub(crate) status: String,
    pub(crate) verdict: Verdict,
    pub(crate) errors: Errors,
    /// The re-rendering's error, relative, against the photograph.
    pub(crate) error: f64,
    /// The same for a rendering with the true materials.
    pub(crate) floor: f64,
}

impl GroupScore {
    /// Whether the command marks the group as doubtful.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.status == "doubtful"
    }

    /// Whether the group is badly re-rendered without being marked.
    pub(crate) fn is_silent_failure(&self) -> bool {
        let is_bad = self.error > ERROR_MAX || self.error > FLOORS_MAX * self.floor;
        is_bad && !self.is_doubtful()
    }
}

/// The photograph of the recovery, and the picture that a recovery without errors would give.
struct Evidence<'a> {
    plan: &'a Plan,
    geometry: GeometryBuffers,
    /// As in the recovery, in radiance.
    photo: RgbImage,
    rerendered: RgbImage,
    /// The picture with the true materials, with as many paths as the recovery's.
    ideal: RgbImage,
}

/// Scores the results in `run` of the photograph in `format`.
///
/// # Errors
/// If the results cannot be read.
pub(crate) fn score(
    plan: &Plan,
    scene: &Folder,
    meta: &Meta,
    format: Format,
    run: &Path,
    photograph: &Photograph,
) -> Result<Vec<GroupScore>, Failure> {
    let found = Materials::read(&run.join("materials.json"))?;
    let truth = Materials::read(&scene.path("truth.json"))?;
    let built = plan.scene();
    let tracer = Tracer::new(&built);
    let geometry = tracer.geometry(&plan.cameras[0], plan.size.0, plan.size.1);
    let exposure = if format == Format::Exr { 1.0 } else { meta.exposure };
    let given = picture::read(&scene.path(format.file()))?.0;
    let clipped: Vec<bool> = match given.depth.max_code() {
        Some(_) => given.values.pixels().iter().map(|v| v.max_element() >= 1.0).collect(),
        None => vec![false; given.values.pixels().len()],
    };
    let evidence = Evidence {
        plan,
        photo: given.to_linear().map(|value| *value * exposure),
        rerendered: picture::read(&run.join("rerendered.exr"))?.0.values,
        ideal: match plan.style.family {
            Family::InModel => super::verify::once(plan),
            Family::Foreign => photograph.halves[0].clone(),
        },
        geometry,
    };
    let mut scores = Vec::new();
    for (index, group) in plan.groups.iter().enumerate() {
        let pixels = evidence.inside(index, &clipped);
        let wanted = truth.groups.get(&group.name).cloned().unwrap_or_default();
        if pixels.len() < LEAST || wanted.status.as_deref() == Some("known") {
            continue;
        }
        let entry = found.groups.get(&group.name).cloned().unwrap_or_default();
        let seen = simpler::Observed {
            scene: &built,
            tracer: &tracer,
            camera: &plan.cameras[0],
            size: plan.size,
            group: index,
            pixels: &pixels,
            noise: &|level| noise(meta, format, level),
        };
        let mut errors = parameters::errors(&entry, &wanted);
        if errors.rho_d.is_none() {
            errors.rho_d = texture_error(&evidence, &pixels, (&entry, run), index)?;
        }
        let verdict = verdict(plan.style.family, &entry, &wanted, &seen);
        if verdict != Verdict::Right {
            errors.in_std.clear();
        }
        let (error, floor) = evidence.errors(&pixels, photograph);
        scores.push(GroupScore {
            group: group.name.clone(),
            pixels: pixels.len(),
            truth: wanted.kind().to_owned(),
            found: entry.kind().to_owned(),
            status: entry.status.clone().unwrap_or_default(),
            verdict,
            errors,
            error,
            floor,
        });
    }
    Ok(scores)
}

/// Whether the found hypothesis is right. In the foreign family no hypothesis is that of the truth:
/// diffuse groups have to be found diffuse, glossy ones glossy, textured ones textured.
fn verdict(family: Family, found: &Entry, truth: &Entry, seen: &simpler::Observed<'_>) -> Verdict {
    let kind = |entry: &Entry| match (family, entry.kind()) {
        (Family::InModel, kind) => kind.to_owned(),
        (Family::Foreign, "diffuse") => "diffuse".to_owned(),
        (Family::Foreign, kind) if kind.starts_with("textured") => "textured".to_owned(),
        (Family::Foreign, _) => "glossy".to_owned(),
    };
    if kind(found) == kind(truth) {
        Verdict::Right
    } else if simpler::explains(seen, found.kind()) {
        Verdict::Simpler
    } else {
        Verdict::Wrong
    }
}

/// The standard deviation of the photograph at a radiance: rendering, camera, and steps of 8 bits.
fn noise(meta: &Meta, format: Format, level: f64) -> f64 {
    let exposure = f64::from(meta.exposure);
    let rendering = meta.rendering_noise * level;
    let camera = f64::from(meta.camera_noise) * (0.18 * exposure * level.max(0.0)).sqrt();
    // A step of a code is about 2.2 x^(1.2/2.2) / 255 wide at the linear value x.
    let linear = (level / exposure).clamp(1e-4, 1.0);
    let step = exposure * 2.2 * linear.powf(1.2 / 2.2) / 255.0;
    let rounding = match format {
        Format::Exr => 0.0,
        Format::Png => step / 12f64.sqrt(),
        // Its coefficients are quantised by a table: about two codes.
        Format::Jpeg => 2.0 * step,
    };
    rendering.hypot(camera).hypot(rounding)
}

impl Evidence<'_> {
    /// The pixels of a group whose neighbours show it too and which are not clipped.
    fn inside(&self, group: usize, clipped: &[bool]) -> Vec<u32> {
        let shows = |i: usize| self.geometry.pixels()[i].group as usize == group;
        (0..clipped.len())
            .filter(|&i| !clipped[i] && self.geometry.neighbourhood(i).all(shows))
            .map(|i| i as u32)
            .collect()
    }

    /// The relative error of the re-rendering over `pixels`, and that of the ideal picture.
    fn errors(&self, pixels: &[u32], photograph: &Photograph) -> (f64, f64) {
        let square = |rgb: Rgb| f64::from(rgb.length_squared());
        let sum =
            |of: &dyn Fn(usize) -> f64| -> f64 { pixels.iter().map(|&i| of(i as usize)).sum() };
        let at = |picture: &RgbImage, i: usize| picture.pixels()[i];
        let level = sum(&|i| square(at(&self.photo, i))).max(1e-30);
        let error = sum(&|i| square(at(&self.photo, i) - at(&self.rerendered, i)));
        let floor = match self.plan.style.family {
            Family::InModel => sum(&|i| square(at(&self.photo, i) - at(&self.ideal, i))),
            // The noise of the camera, that of the rendering, and as much again for that of the
            // re-rendering.
            Family::Foreign => {
                let clean = photograph.mean();
                let added = sum(&|i| square(at(&self.photo, i) - at(&clean, i)));
                let [a, b] = &photograph.halves;
                added + 2.0 * sum(&|i| 0.25 * square(at(a, i) - at(b, i)))
            }
        };
        ((error / level).sqrt(), (floor / level).sqrt())
    }
}

/// The mean error of rho_d over the pixels of a group that is textured here or in truth.
fn texture_error(
    evidence: &Evidence<'_>,
    pixels: &[u32],
    (found, run): (&Entry, &Path),
    group: usize,
) -> Result<Option<f64>, Failure> {
    let truth = &evidence.plan.groups[group].material;
    let texture = match &found.texture {
        Some(path) => {
            let image = materials::read_texture(&run.join(path))?.0;
            Some(Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat })
        }
        None => None,
    };
    let flat = found.rho_d.map(|rho| Rgb::from_array(rho.map(|v| v as f32)));
    let mut sum = [0.0; 3];
    for &pixel in pixels {
        let uv = evidence.geometry.pixels()[pixel as usize].uv;
        let sampled = texture.as_ref().map(|texture| texture.sample(uv));
        let Some(value) = sampled.or(flat) else { return Ok(None) };
        let error = (value - truth.rho_d_at(uv)).abs();
        (0..3).for_each(|c| sum[c] += f64::from(error[c]));
    }
    Ok(sum.into_iter().reduce(f64::max).map(|sum| sum / pixels.len().max(1) as f64))
}
