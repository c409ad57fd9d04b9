//! The model laid onto the photograph, before anything is recovered: how far it is off, what that
//! makes of the pixels at edges, and the camera that fits better.

use crate::Job;
use unrender_recover::register::{Registration, margin, register};
use unrender_recover::{Observation, Picture};
use unrender_render::{GeometryBuffers, Tracer};
use unrender_scene::{Camera, Image, Warnings};

/// What to do about a model that is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum Alignment {
    /// Move the camera if it is clearly off, and leave out the pixels that are doubtful still.
    #[default]
    Auto,
    /// Move the camera, however little.
    RefineCamera,
    /// Keep the camera, and leave out the pixels that it makes doubtful.
    KeepCamera,
    /// Nothing: take the model as if it fitted to the pixel.
    Ignore,
}

impl Alignment {
    /// Whether to move the camera to where `found` says.
    fn moves(self, found: &Registration) -> bool {
        match self {
            Self::Auto => {
                let off = found.displacement;
                off > CLEAR && off > CERTAIN * found.uncertainty && off > found.deviation
            }
            Self::RefineCamera => true,
            Self::KeepCamera | Self::Ignore => false,
        }
    }
}

/// How the model lies, and with what camera the recovery goes on.
pub(crate) struct Laid {
    /// That camera.
    pub(crate) camera: Camera,
    /// How close to an edge no pixel is valid.
    pub(crate) margins: Image<f32>,
    /// How the model lies under the camera as given, if the photograph shows it.
    pub(crate) registration: Option<Registration>,
    /// What the user should know.
    pub(crate) warnings: Warnings,
}

impl Laid {
    /// The photograph of `job` sorted by the groups of `geometry`, which is what the camera sees.
    pub(crate) fn observe(&self, job: &Job, geometry: &GeometryBuffers) -> Observation {
        let mut picture = Picture {
            values: job.photo.radiance.clone(),
            valid: job.photo.valid.clone(),
            saturated: job.photo.saturated.clone(),
            quantum: job.photo.quantisation_step.clone(),
        };
        for (index, counts) in job.counts(geometry).into_iter().enumerate() {
            // What does not count is no lower bound either.
            picture.valid.pixels_mut()[index] &= counts;
            picture.saturated.pixels_mut()[index] &= counts;
        }
        Observation::with_margins(picture, geometry, &self.margins, job.scene.groups.len())
    }
}

/// A camera is clearly off from this displacement on, pixels ...
pub(crate) const CLEAR: f32 = 0.75;
/// ... if that is so many times what is uncertain of it.
const CERTAIN: f32 = 5.0;
/// An object by itself may be off by this much, pixels.
pub(crate) const OBJECT_NOTABLE: f32 = 1.5;

/// Lays the model of `job` onto its photograph.
pub(crate) fn lay(job: &Job, tracer: &Tracer, alignment: Alignment) -> Laid {
    let values = &job.photo.radiance;
    let (width, height) = (values.width(), values.height());
    let geometry_of = |camera: &Camera, width, height| tracer.geometry(camera, width, height);
    let found = match alignment {
        Alignment::Ignore => None,
        _ => register(values, &job.camera, &geometry_of),
    };
    let warnings = warnings(job, found.as_ref(), alignment);
    let moved = found.as_ref().filter(|found| alignment.moves(found));
    let camera = moved.map_or(&job.camera, |found| &found.camera).clone();
    let geometry = tracer.geometry(&camera, width, height);
    let remaining = match moved {
        Some(found) => Some(found.clone().taken()),
        None => found.clone(),
    };
    let margins = margin::margins(&geometry, remaining.as_ref());
    Laid { camera, margins, registration: found, warnings }
}

fn warnings(job: &Job, found: Option<&Registration>, alignment: Alignment) -> Warnings {
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
    if found.displacement > CLEAR {
        let done = if alignment.moves(found) {
            "the camera was moved there; --keep-camera leaves it"
        } else {
            "pixels that close to an edge do not count; --refine-camera moves the camera"
        };
        warnings.push(format!(
            "the model's edges lie {:.1} pixels from the photo's (on the median; the place where \
             they fit is known to {:.2} pixels): {done}",
            found.displacement, found.uncertainty
        ));
    }
    for (object, &off) in job.scene.objects.iter().zip(&found.own) {
        if off > OBJECT_NOTABLE {
            warnings.push(format!(
                "object \"{}\" lies {off:.1} pixels from where the photo has it; pixels that close \
                 to its edges do not count",
                object.name
            ));
        }
    }
    warnings
}
