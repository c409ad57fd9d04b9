//! Checks of the camera's place and the units: what fills the picture, and how far away it is.

use super::finding::{Findings, Gravity};
use super::{Subject, length, some};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use unrender_render::NOTHING;
use unrender_scene::Camera;

/// A picture that shows nothing of the model in more than this share of its pixels is doubtful.
const EMPTY: f32 = 0.5;
/// An object that fills this share of the picture from behind is around the camera.
const AROUND: f32 = 0.98;
/// Something nearer than this share of the scene's diagonal is in the way ...
const NEAR: f32 = 0.01;
/// ... if it fills this share of the picture.
const IN_THE_WAY: f32 = 0.25;
/// The part of an indoor scene in a photograph is between these sizes, metres.
const SIZES: [f32; 2] = [0.02, 100.0];

/// Warnings of what the camera sees.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let pixels = subject.geometry.pixels();
    let share = |count: usize| count as f32 / pixels.len().max(1) as f32;
    let empty = share(pixels.iter().filter(|p| p.object == NOTHING).count());
    if empty > EMPTY {
        found.push(Gravity::All, format!(
            "{:.0} % of the picture show nothing of the model: does the camera stand in the right \
             place and look the right way? See `unrender calibrate`",
            100.0 * empty
        ));
    }
    found.extend(in_the_way(subject));
    found.extend(cut_away(subject));
    found.extend(units(subject));
    found
}

/// What the near clipping plane of the camera cuts away.
fn cut_away(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let (camera, seen) = (&subject.registered.camera, subject.geometry);
    if camera.near == 0.0 {
        return found;
    }
    let whole = Camera { near: 0.0, ..camera.clone() };
    let whole = subject.tracer.geometry(&whole, seen.width(), seen.height());
    let pairs = whole.pixels().iter().zip(seen.pixels());
    let cut = pairs.filter(|(whole, seen)| whole.object != seen.object).map(|(whole, _)| whole);
    let names: BTreeSet<&str> = cut.map(|whole| subject.object_name(whole.object)).collect();
    if !names.is_empty() {
        let names: Vec<&str> = names.into_iter().collect();
        found.push(Gravity::Note, format!(
            "what is nearer than the camera's near clipping plane, {}, is not seen: parts of {}",
            length(camera.near),
            some(&names)
        ));
    }
    found
}

fn in_the_way(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let pixels = subject.geometry.pixels();
    let [low, high] = subject.bounds();
    let near = NEAR * low.distance(high);
    // For each object: pixels, those from behind, those that are near.
    let mut counts: BTreeMap<u32, [usize; 3]> = BTreeMap::new();
    for pixel in pixels.iter().filter(|p| p.object != NOTHING) {
        let [all, behind, close] = counts.entry(pixel.object).or_default();
        *all += 1;
        *behind += usize::from(!pixel.front);
        *close += usize::from(pixel.depth < near);
    }
    let much = |count: usize, share: f32| count as f32 > share * pixels.len() as f32;
    for (&object, &[_, behind, close]) in &counts {
        let name = subject.object_name(object);
        if much(behind, AROUND) && subject.job.scene.objects.len() > 1 {
            found.push(Gravity::All, format!(
                "the picture shows little but object \"{name}\" from behind: does the camera stand \
                 inside it?"
            ));
        } else if much(close, IN_THE_WAY) {
            found.push(Gravity::All, format!(
                "object \"{name}\" fills much of the picture from less than {} away: does it stand \
                 in the camera's way, or the camera inside it?",
                length(near)
            ));
        }
    }
    found
}

/// Scenes of a size that no room has.
fn units(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let Some(size) = seen_size(subject) else { return found };
    let [least, most] = SIZES;
    if size > most || size < least {
        let unit = if size > most { "centimetres or millimetres" } else { "another unit" };
        found.push(Gravity::Part, format!(
            "the part of the scene in the picture is {} across; scenes are in metres. If it was \
             modelled in {unit}, export it scaled to metres: point and spot lights and the \
             camera's place depend on it",
            length(size)
        ));
    }
    found
}

/// The size of the visible part of the scene along its longest side, without a tenth of the pixels
/// at each end.
fn seen_size(subject: &Subject<'_>) -> Option<f32> {
    let (camera, geometry) = (&subject.registered.camera, subject.geometry);
    let (width, height) = (geometry.width(), geometry.height());
    let points: Vec<Vec3> = (0..width * height)
        .filter(|&i| geometry.pixels()[i].object != NOTHING)
        .map(|i| {
            let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            camera.origin() + camera.direction(x, y, width, height) * geometry.pixels()[i].depth
        })
        .collect();
    let side = |axis: usize| -> Option<f32> {
        let mut places: Vec<f32> = points.iter().map(|p| p[axis]).collect();
        places.sort_unstable_by(f32::total_cmp);
        let tenth = places.len() / 10;
        Some(places.get(places.len().checked_sub(tenth + 1)?)? - places.get(tenth)?)
    };
    [side(0)?, side(1)?, side(2)?].into_iter().reduce(f32::max)
}
