//! Checks of the input: finds what would spoil a recovery before it is begun.
//!
//! Each module looks at one part of the input and returns findings: a sentence with the problem and what to do, and how
//! much of the result it spoils. `unrender check` lists all of them; a recovery names the gravest before it begins. The
//! limits are loose on purpose: a finding suggests a look, it proves nothing.

mod camera;
mod coplanar;
mod edges;
mod finding;
mod flux;
mod glass;
mod groups;
mod identifiability;
mod lamps;
mod light_units;
mod lights;
mod photograph;
mod picture;
mod sides;
mod sky;
mod smooth;
mod table;
pub(crate) mod uvs;

pub use edges::{Edge, EdgeKind, Edges};
pub use finding::{Finding, Gravity};
pub use flux::lines as flux;
pub use groups::GroupCheck;
pub use picture::edge_picture;
pub(crate) use picture::{drawn_over, white};
pub use table::{json, table};

use crate::Job;
use crate::problem;
use crate::registered::RegisteredModel;
use crate::registration::{self, Alignment};
use crate::ungrouped;
use finding::Findings;
use glam::Vec3;
use identifiability::{Identifiability, identifiability};
use unrender_recover::observe::sample::Stage;
use unrender_recover::{GroupSpec, Observation, PixelStatus, Role, View};
use unrender_render::accel::Ray;
use unrender_render::surface::Surface;
use unrender_render::{GeometryBuffers, RadianceCache, Tracer};
use unrender_scene::color::luminance;
use unrender_scene::{Camera, Material, Rgb, Warnings};

/// The findings.
#[derive(Clone, Debug)]
pub struct Checkup {
    /// One entry per group of the scene, in its order.
    pub groups: Vec<GroupCheck>,
    /// The model's edges and where the photograph has them.
    pub edges: Edges,
    /// Warnings, with what to do; the gravest come first.
    pub warnings: Warnings,
    /// How many of them spoil the result, likely: the first ones.
    pub grave: usize,
    /// What lines of a project mend: a sentence, and the lines.
    pub remedies: Vec<(String, String)>,
    /// How many times as bright as the scene in middle grey the photograph is; none if its exposure is unknown.
    pub brightness: Option<f64>,
    /// Pixels are counted as squares with this side, pixels of the photograph.
    pub side: usize,
}

/// The reflectance of groups that are still to be recovered.
const GREY: Rgb = Rgb::splat(0.5);
/// Pixels that are examined, of all groups together.
const PIXELS: usize = 6000;
/// And of each group: the least and the most.
const PIXELS_OF_GROUP: [usize; 2] = [40, 400];

/// Checks all of `job`.
pub fn check(job: &Job) -> Checkup {
    let tracer = Tracer::new(&job.lit_in(0));
    let registered = registration::register(job, &tracer, Alignment::Auto);
    examined(job, &tracer, &registered, |subject| {
        let edges = edges::find(subject);
        let mut findings = findings(subject, &edges);
        // A recovery that moves the camera, or leaves out pixels at edges, says so itself.
        findings.extend(edges::displaced(subject, &edges));
        let remedies = findings.remedies();
        let (grave, warnings) = (findings.grave(), findings.with(&job.warnings));
        let brightness = photograph::factor(subject, subject.identifiabilities);
        let groups = groups::all(subject);
        Checkup { groups, edges, warnings, grave, remedies, brightness, side: job.side }
    })
}

/// What would spoil the recovery of `job`, whose model is registered with its first photograph; the gravest first.
pub(crate) fn before_recovery(
    job: &Job,
    tracer: &Tracer,
    registered: &RegisteredModel,
) -> Vec<Finding> {
    // The tracer of a recovery has all lamps on.
    let own = (!job.off.is_empty()).then(|| Tracer::new(&job.lit_in(0)));
    examined(job, own.as_ref().unwrap_or(tracer), registered, |subject| {
        findings(subject, &edges::find(subject)).gravest_first()
    })
}

/// All findings but those of displaced edges.
fn findings(subject: &Subject<'_>, edges: &Edges) -> Findings {
    let (job, seen) = (subject.job, (&subject.registered.camera, subject.geometry));
    let mut all = Findings::default();
    for found in [
        photograph::warnings(subject),
        camera::warnings(subject),
        edges::foreign(subject, edges),
        coplanar::warnings(job, subject.tracer, seen),
        clear(job, seen),
        sides::warnings(subject),
        lights::warnings(subject),
        light_units::warnings(subject),
        lamps::warnings(subject),
        sky::warnings(subject),
        glass::warnings(subject),
        smooth::warnings(subject),
        groups::warnings(subject),
    ] {
        all.extend(found);
    }
    all
}

/// What is seen of glass.
fn clear(job: &Job, (camera, geometry): (&Camera, &GeometryBuffers)) -> Findings {
    let told = ungrouped::told(job, camera, geometry);
    told.map(|sentence| Finding::new(Gravity::Part, sentence)).into_iter().collect()
}

/// `look` at the data of `job`, whose model is `registered` with its first photograph.
fn examined<T>(
    job: &Job,
    tracer: &Tracer,
    registered: &RegisteredModel,
    look: impl FnOnce(&Subject<'_>) -> T,
) -> T {
    let size = (job.photo.radiance.width(), job.photo.radiance.height());
    let view = View::new(tracer, &registered.camera, size, job.scene.brdf);
    let geometry = unrender_recover::Renderer::geometry(&view);
    let observation = registered.observe((job, 0), geometry);
    let specs: Vec<GroupSpec> =
        (0..job.scene.groups.len()).map(|group| problem::spec(job, group)).collect();
    let identifiabilities = identifiabilities(&view, &observation, &specs);
    look(&Subject {
        job,
        tracer,
        registered,
        geometry,
        observation: &observation,
        specs: &specs,
        identifiabilities: &identifiabilities,
    })
}

/// The data that all parts of the check use.
struct Subject<'a> {
    job: &'a Job,
    tracer: &'a Tracer,
    registered: &'a RegisteredModel,
    /// The geometry that the registered camera sees.
    geometry: &'a GeometryBuffers,
    observation: &'a Observation,
    specs: &'a [GroupSpec],
    identifiabilities: &'a [Option<Identifiability>],
}

impl Subject<'_> {
    fn group_name(&self, group: usize) -> &str {
        &self.job.scene.groups[group].name
    }

    /// The corners of the box around the scene.
    fn bounds(&self) -> [Vec3; 2] {
        self.job.scene.bounds().unwrap_or([Vec3::INFINITY, Vec3::NEG_INFINITY])
    }

    fn object_name(&self, object: u32) -> &str {
        &self.job.scene.objects[object as usize].name
    }
}

/// The identifiability of every group that reflects; unknown ones are grey. Mirror images have the
/// colours of the photograph, scaled to the brightness of the grey scene.
fn identifiabilities(
    view: &View<'_>,
    observation: &Observation,
    specs: &[GroupSpec],
) -> Vec<Option<Identifiability>> {
    let in_grey = prospects_among(view, observation, specs, None);
    let sum =
        |f: &dyn Fn(&Identifiability) -> f32| -> f32 { in_grey.iter().flatten().map(f).sum() };
    let (grey, photo) = (sum(&|p| p.light * luminance(GREY)), sum(&|p| p.photo));
    if photo <= 0.0 {
        return in_grey;
    }
    let seen = RadianceCache {
        radiance: observation.picture.values.map(|value| *value * (grey / photo)),
        valid: observation.status.map(|status| *status == PixelStatus::Valid),
    };
    let in_colour = prospects_among(view, observation, specs, Some(&seen));
    let merged = in_grey.into_iter().zip(in_colour).map(|(grey, colour)| {
        grey.zip(colour).map(|(grey, colour)| Identifiability { image: colour.image, ..grey })
    });
    merged.collect()
}

fn prospects_among(
    view: &View<'_>,
    observation: &Observation,
    specs: &[GroupSpec],
    seen: Option<&RadianceCache>,
) -> Vec<Option<Identifiability>> {
    let material = |spec: &GroupSpec| match spec.role {
        Role::Unknown => Material::diffuse(GREY),
        Role::Known | Role::Emitter => spec.material.clone(),
    };
    let materials: Vec<Material> = specs.iter().map(material).collect();
    let stage = Stage { observation, camera: (&[], &[]), exposure: Rgb::ONE, renderer: view, seen };
    let [fewest, most] = PIXELS_OF_GROUP;
    let count = (PIXELS / specs.len().max(1)).clamp(fewest, most);
    let look = |(group, spec): (usize, &GroupSpec)| {
        let [valid, all] = [&observation.pixels_of_group, &observation.all_pixels_of_group];
        let pixels = if valid[group].is_empty() { &all[group] } else { &valid[group] };
        (spec.role != Role::Emitter)
            .then(|| identifiability(&stage, (&materials).into(), group, pixels, (count, 0)))
            .flatten()
    };
    specs.iter().enumerate().map(look).collect()
}

/// The surface behind the middle of a pixel.
fn surface_behind(
    tracer: &Tracer,
    camera: &Camera,
    (width, height): (usize, usize),
    pixel: u32,
) -> Option<Surface> {
    let (x, y) = (pixel as usize % width, pixel as usize / width);
    let towards = camera.direction(x as f32 + 0.5, y as f32 + 0.5, width, height);
    tracer.surface(&Ray::new(camera.start(towards), towards))
}

/// `names` in a sentence, no more than a few of them.
fn some(names: &[&str]) -> String {
    const MOST: usize = 4;
    let quoted: Vec<String> = names.iter().take(MOST).map(|name| format!("\"{name}\"")).collect();
    let rest = names.len().saturating_sub(MOST);
    let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    quoted.join(", ") + &rest
}

/// A length in the unit that reads best.
fn length(metres: f32) -> String {
    match metres {
        m if m >= 1.0 => format!("{m:.3} m"),
        m if m >= 0.01 => format!("{:.1} cm", 100.0 * m),
        m => format!("{:.2} mm", 1000.0 * m),
    }
}

/// The median; none of nothing.
fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    let mut values: Vec<f32> = values.collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// `text` with a capital letter.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
