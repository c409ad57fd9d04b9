//! Registration of the model with the photograph, before anything is recovered: its displacement, the pixels
//! at edges that are invalid for that, and the camera that fits better.

use crate::Job;
use crate::problem::with_problem;
use crate::registered::RegisteredModel;
use crate::sketch;
use unrender_recover::{Options, RecoverError};
use unrender_register::{Registration, margin};
use unrender_render::Tracer;
use unrender_scene::{Camera, Warnings};

/// How to treat a displaced model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Alignment {
    /// Move the camera if a sketch is then nearer to the photograph, and leave out the pixels that
    /// are still doubtful.
    #[default]
    Auto,
    /// Move the camera to where the edges fit.
    RefineCamera,
    /// Keep the camera, and leave out the pixels that are doubtful for it.
    KeepCamera,
    /// Ignore it: assume that the model fits to the pixel.
    Ignore,
}

/// The decision about the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// It stays, and may be wrong.
    Kept,
    /// It stays, since it is right, although some edges of the photograph differ.
    Right,
    /// It moves to where the edges fit.
    Moved,
}

/// A displacement from this one on is reported to the user, pixels.
pub(crate) const CLEAR: f32 = 0.75;
/// A displacement of fewer standard deviations is not significant. At half of it every photograph is
/// sketched twice, at double small errors of the camera stay.
const NOTABLE: f32 = 2.0;
/// Sketches decide between two cameras if one is nearer to the photograph by this many standard deviations.
const PREFERRED: f64 = 3.0;
/// The tolerated displacement of a single object, pixels.
pub(crate) const OBJECT_NOTABLE: f32 = 1.5;

/// Registers the model of `job` with its photograph.
pub(crate) fn register(job: &Job, tracer: &Tracer, alignment: Alignment) -> RegisteredModel {
    let values = &job.photo.radiance;
    let geometry_of = |camera: &Camera, width, height| tracer.geometry(camera, width, height);
    let found = match alignment {
        Alignment::Ignore => None,
        _ => unrender_register::register(values, &job.camera, &geometry_of),
    };
    let verdict = match (&found, alignment) {
        (Some(_), Alignment::RefineCamera) => Verdict::Moved,
        (Some(found), Alignment::Auto) => judge(job, tracer, found),
        _ => Verdict::Kept,
    };
    RegisteredModel {
        warnings: warnings(job, found.as_ref(), alignment, verdict),
        ..registered(job, tracer, found, verdict)
    }
}

/// The model with the camera that `verdict` chooses.
fn registered(
    job: &Job,
    tracer: &Tracer,
    found: Option<Registration>,
    verdict: Verdict,
) -> RegisteredModel {
    let moved = found.as_ref().filter(|_| verdict == Verdict::Moved);
    let camera = moved.map_or(&job.camera, |found| &found.camera).clone();
    let (width, height) = (job.photo.radiance.width(), job.photo.radiance.height());
    let geometry = tracer.geometry(&camera, width, height);
    let remaining = match verdict {
        Verdict::Kept => found.clone(),
        Verdict::Right | Verdict::Moved => found.clone().map(Registration::taken),
    };
    let margins = margin::margins(&geometry, remaining.as_ref());
    RegisteredModel { camera, margins, registration: found, warnings: Warnings::default() }
}

/// Decides between the given camera and the one where the edges fit: the one whose sketch is nearer to
/// the photograph.
fn judge(job: &Job, tracer: &Tracer, found: &Registration) -> Verdict {
    if found.displacement <= NOTABLE * found.uncertainty {
        return Verdict::Kept;
    }
    match preference(job, tracer, found) {
        Ok(preference) if preference > PREFERRED => Verdict::Moved,
        Ok(preference) if preference < -PREFERRED => Verdict::Right,
        // If a sketch cannot be made, the recovery fails too, and reports why.
        Ok(_) | Err(_) => Verdict::Kept,
    }
}

/// The number of standard deviations by which the sketch with the camera that was `found` is nearer to the
/// photograph than with the given one.
fn preference(job: &Job, tracer: &Tracer, found: &Registration) -> Result<f64, RecoverError> {
    let (width, height) = (job.photo.radiance.width(), job.photo.radiance.height());
    let geometries =
        [&job.camera, &found.camera].map(|camera| tracer.geometry(camera, width, height));
    let pixels = sketch::edge_pixels(geometries.each_ref());
    let differences = |verdict: Verdict| {
        let registered = registered(job, tracer, Some(found.clone()), verdict);
        with_problem(job, tracer, std::slice::from_ref(&registered), (&[], None), |problem| {
            sketch::differences(problem, &Options::default(), &pixels)
        })
    };
    let (kept, moved) = (differences(Verdict::Kept)?, differences(Verdict::Moved)?);
    Ok(sketch::preference(&kept, &moved, &pixels, width))
}

fn warnings(
    job: &Job,
    found: Option<&Registration>,
    alignment: Alignment,
    verdict: Verdict,
) -> Warnings {
    let mut warnings = Warnings::default();
    let Some(found) = found else {
        if alignment == Alignment::RefineCamera {
            warnings.push(
                "too few of the model's edges are found in the photo to refine the camera; it was \
                 kept as it is",
            );
        }
        return warnings;
    };
    let in_photograph = |pixels: f32| job.side as f32 * pixels;
    let is_off = found.displacement > CLEAR && verdict != Verdict::Right;
    if is_off || verdict == Verdict::Moved && alignment == Alignment::Auto {
        let done = if verdict == Verdict::Moved {
            "the camera was moved there; --keep-camera keeps it"
        } else {
            "pixels that close to an edge are left out; --refine-camera moves the camera"
        };
        warnings.push(format!(
            "the model's edges lie {:.2} pixels from the photo's (in the median; the place where \
             they fit is known to {:.2} pixels): {done}",
            in_photograph(found.displacement),
            in_photograph(found.uncertainty)
        ));
    }
    for (object, &off) in job.scene.objects.iter().zip(&found.own) {
        if off > OBJECT_NOTABLE {
            warnings.push(format!(
                "object \"{}\" lies {:.1} pixels from its place in the photo; pixels that close to \
                 its edges are left out",
                object.name,
                in_photograph(off)
            ));
        }
    }
    warnings
}
