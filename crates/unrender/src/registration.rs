//! Registration of the model with the photograph, before anything is recovered: how far it is off, what that
//! makes of the pixels at edges, and the camera that fits better.

use crate::Job;
use crate::problem::with_problem;
use crate::registered::RegisteredModel;
use unrender_recover::{Options, RecoverError, sketch};
use unrender_register::{Registration, margin};
use unrender_render::Tracer;
use unrender_scene::{Camera, Warnings};

/// What to do about a model that is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Alignment {
    /// Move the camera if a sketch is nearer to the photograph for it, and leave out the pixels that
    /// are doubtful still.
    #[default]
    Auto,
    /// Move the camera to where the edges fit.
    RefineCamera,
    /// Keep the camera, and leave out the pixels that it makes doubtful.
    KeepCamera,
    /// Nothing: take the model as if it fitted to the pixel.
    Ignore,
}

/// What became of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// It stays, and may be off.
    Kept,
    /// It stays, since it is not off, whatever some edges of the photograph say.
    Right,
    /// It moves to where the edges fit.
    Moved,
}

/// A user wants to know of a displacement from this one on, pixels.
pub(crate) const CLEAR: f32 = 0.75;
/// A displacement of fewer standard deviations is none. At half of it every photograph is sketched twice, at
/// double small errors of the camera stay.
const NOTABLE: f32 = 2.0;
/// The pictures decide between two cameras if one is nearer to the photograph by so many standard deviations.
const PREFERRED: f64 = 3.0;
/// An object by itself may be off by this much, pixels.
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

/// The model under the camera that `verdict` says.
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

/// Whether the camera is where it is given or where the edges fit: where the sketch of the photograph is
/// nearer to it.
fn judge(job: &Job, tracer: &Tracer, found: &Registration) -> Verdict {
    if found.displacement <= NOTABLE * found.uncertainty {
        return Verdict::Kept;
    }
    match preference(job, tracer, found) {
        Ok(preference) if preference > PREFERRED => Verdict::Moved,
        Ok(preference) if preference < -PREFERRED => Verdict::Right,
        // What keeps a sketch from being made keeps the recovery from it too, which says so.
        Ok(_) | Err(_) => Verdict::Kept,
    }
}

/// By how many standard deviations the photograph's sketch with the camera that was `found` is nearer to it
/// than with the given one.
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
                "too few of the model's edges are found in the photo to refine the camera by; \
                 it was kept as it is",
            );
        }
        return warnings;
    };
    let in_photograph = |pixels: f32| job.side as f32 * pixels;
    let is_off = found.displacement > CLEAR && verdict != Verdict::Right;
    if is_off || verdict == Verdict::Moved && alignment == Alignment::Auto {
        let done = if verdict == Verdict::Moved {
            "the camera was moved there; --keep-camera leaves it"
        } else {
            "pixels that close to an edge do not count; --refine-camera moves the camera"
        };
        warnings.push(format!(
            "the model's edges lie {:.2} pixels from the photo's (on the median; the place where \
             they fit is known to {:.2} pixels): {done}",
            in_photograph(found.displacement),
            in_photograph(found.uncertainty)
        ));
    }
    for (object, &off) in job.scene.objects.iter().zip(&found.own) {
        if off > OBJECT_NOTABLE {
            warnings.push(format!(
                "object \"{}\" lies {:.1} pixels from where the photo has it; pixels that close \
                 to its edges do not count",
                object.name,
                in_photograph(off)
            ));
        }
    }
    warnings
}
