//! The model's edges on the photograph: where they fit, where they are off, and where the photograph
//! shows none; the search is in [`unrender_register`].

use super::finding::{Findings, Gravity};
use super::{Subject, some};
use crate::registration::{CLEAR, OBJECT_NOTABLE};
use glam::Vec2;
use serde::Serialize;
use unrender_register::edges::{Edgel, edgels, finer};
use unrender_register::offset::EdgePicture;
use unrender_scene::Camera;

/// Edges that are off by no more than this fit, pixels.
const FITS: f32 = 1.0;
/// The photograph's edges are searched up to this distance, pixels.
const REACH: f32 = 4.0;
/// The offset of an edge point is wrong if its neighbours contradict it: neighbours are within this
/// distance, pixels ...
const NEIGHBOURS: f32 = 6.0;
/// ... and agree up to this, pixels.
const AGREE: f32 = 0.75;
/// With a smaller share of edges in place than this, the model does not belong to the photograph.
const FITTING: f32 = 0.15;
/// Fewer edge pixels than this are not evaluated.
const PIXELS_MIN: usize = 60;

/// How an edge of the model lies on the photograph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// The photograph has it too.
    Fits,
    /// The photograph has it elsewhere.
    Off,
    /// The photograph shows none there.
    Unseen,
}

/// A point on an edge of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Where the model has it, pixels from the top left.
    pub at: Vec2,
    /// How it lies.
    pub kind: EdgeKind,
    /// Where the photograph has it, if that is elsewhere.
    pub there: Option<Vec2>,
}

/// The edges of the model.
#[derive(Clone, Debug, Serialize)]
pub struct Edges {
    /// Its points, up to three a pixel of their length.
    #[serde(skip)]
    pub points: Vec<Edge>,
    /// The share of them that fits, 0 to 1.
    pub fit: f32,
    /// The share that is off.
    pub off: f32,
    /// How far the model is off on the median, pixels of the photograph; none if too few edges are found.
    pub displacement_px: Option<f32>,
    /// Whether a recovery would move the camera.
    pub camera_is_off: bool,
}

/// Finds the edges of the model on the photograph.
pub(super) fn find(subject: &Subject<'_>) -> Edges {
    let (job, registered) = (subject.job, subject.registered);
    let (width, height) = (job.photo.radiance.width(), job.photo.radiance.height());
    let finer = finer((width, height));
    let geometry = subject.tracer.geometry(&job.camera, finer * width, finer * height);
    let found = edgels(&geometry, &job.camera, finer);
    let camera_is_off = registered.camera != job.camera;
    let picture = EdgePicture::new(&job.photo.radiance);
    let offsets: Vec<Option<f32>> =
        found.iter().map(|edgel| picture.offset(edgel, REACH)).collect();
    let points: Vec<Edge> = if camera_is_off {
        let project = |edgel: &Edgel| moved(edgel, &registered.camera, (width, height));
        found.iter().map(|edgel| edge(edgel.at, project(edgel))).collect()
    } else {
        let offsets = agreed(&found, &offsets, width);
        // An edge in place fits, even if there are others as clear beside it.
        let here = |edgel: &Edgel| picture.has_edge(edgel, FITS).then_some(edgel.at);
        let there = |(edgel, offset): (&Edgel, &Option<f32>)| {
            let there = offset.map(|offset| edgel.at + edgel.across * offset);
            edge(edgel.at, here(edgel).or(there))
        };
        found.iter().zip(&offsets).map(there).collect()
    };
    let share = |kind: EdgeKind| {
        points.iter().filter(|p| p.kind == kind).count() as f32 / points.len().max(1) as f32
    };
    Edges {
        fit: share(EdgeKind::Fits),
        off: share(EdgeKind::Off),
        displacement_px: registered
            .registration
            .as_ref()
            .map(|found| job.side as f32 * found.displacement),
        camera_is_off,
        points,
    }
}

fn edge(at: Vec2, there: Option<Vec2>) -> Edge {
    match there {
        None => Edge { at, kind: EdgeKind::Unseen, there: None },
        Some(there) if there.distance(at) <= FITS => Edge { at, kind: EdgeKind::Fits, there: None },
        Some(there) => Edge { at, kind: EdgeKind::Off, there: Some(there) },
    }
}

/// Where a point of the model lies under the camera that fits.
fn moved(edgel: &Edgel, camera: &Camera, (width, height): (usize, usize)) -> Option<Vec2> {
    camera.project(edgel.point, width, height).map(|(x, y)| Vec2::new(x, y))
}

/// The offsets without those that most neighbours of the same object contradict.
fn agreed(found: &[Edgel], offsets: &[Option<f32>], width: usize) -> Vec<Option<f32>> {
    let columns = (width as f32 / NEIGHBOURS) as usize + 1;
    let cell = |at: Vec2| (at.y / NEIGHBOURS) as usize * columns + (at.x / NEIGHBOURS) as usize;
    let mut cells: std::collections::BTreeMap<usize, Vec<usize>> =
        std::collections::BTreeMap::new();
    for (index, edgel) in found.iter().enumerate().filter(|(i, _)| offsets[*i].is_some()) {
        cells.entry(cell(edgel.at)).or_default().push(index);
    }
    let around = |at: Vec2| {
        let middle = cell(at);
        let rows = [middle.wrapping_sub(columns), middle, middle + columns];
        rows.into_iter().flat_map(|row| [row.wrapping_sub(1), row, row + 1])
    };
    let agrees = |index: usize, offset: f32| {
        let edgel = &found[index];
        let near = around(edgel.at).filter_map(|cell| cells.get(&cell)).flatten().filter(|&&n| {
            let other = &found[n];
            other.object == edgel.object
                && other.at.distance(edgel.at) < NEIGHBOURS
                && other.across.dot(edgel.across).abs() > 0.9
        });
        let (mut all, mut alike) = (0, 0);
        for &n in near {
            let along = offsets[n].unwrap_or(0.0) * found[n].across.dot(edgel.across);
            all += 1;
            alike += usize::from((along - offset).abs() < AGREE);
        }
        2 * alike > all
    };
    let keep = |(index, offset): (usize, &Option<f32>)| offset.filter(|&o| agrees(index, o));
    offsets.iter().enumerate().map(keep).collect()
}

/// The finding of a photograph that is not of this model.
pub(super) fn foreign(subject: &Subject<'_>, edges: &Edges) -> Findings {
    let mut findings = Findings::default();
    let size = (subject.geometry.width(), subject.geometry.height());
    let enough = edges.points.len() >= PIXELS_MIN * finer(size);
    if enough && edges.fit + edges.off < FITTING {
        findings.push(
            Gravity::All,
            "hardly any of the model's edges are found in the photo: is it the photo of this model, \
             and the camera right? `unrender calibrate` finds it from measured points",
        );
    }
    findings
}

/// The findings of a model that lies elsewhere than in the photograph.
pub(super) fn displaced(subject: &Subject<'_>, edges: &Edges) -> Findings {
    let mut findings = Findings::default();
    let Some(found) = &subject.registered.registration else { return findings };
    let side = subject.job.side as f32;
    if found.displacement > CLEAR {
        let done = if edges.camera_is_off {
            "a recovery moves the camera to where they fit, unless you keep it by --keep-camera"
        } else {
            "a quick rendering from there is not nearer to the photo, so a recovery keeps the camera"
        };
        let sentence = format!(
            "the model's edges lie {:.1} pixels from the photo's (on the median): {done}. \
             `unrender calibrate` with more points, or a lens with distortion, may do better",
            side * found.displacement
        );
        findings.push(Gravity::Part, sentence);
    }
    let off: Vec<String> = (subject.job.scene.objects.iter().zip(&found.own))
        .filter(|(_, off)| **off > OBJECT_NOTABLE)
        .map(|(object, off)| format!("{} ({:.1} pixels)", some(&[&object.name]), side * off))
        .collect();
    if !off.is_empty() {
        let sentence = format!(
            "these objects lie beside their place in the photo: {}. Move them in the model; pixels \
             that close to their edges do not count",
            off.join(", ")
        );
        findings.push(Gravity::Part, sentence);
    }
    findings
}
