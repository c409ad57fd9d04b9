//! Checks of fronts and backs: objects that are inside out, and lamps that turn their dark side to
//! the camera.

use super::finding::{Findings, Gravity};
use super::{Subject, some};
use unrender_render::NOTHING;

/// An object is seen from behind if this share of its pixels shows its back.
const BEHIND: f32 = 0.9;
/// Objects of fewer pixels are not examined.
const PIXELS_MIN: usize = 30;

/// Warnings of objects that are seen from the wrong side.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let scene = &subject.job.scene;
    let mut counts = vec![[0usize; 2]; scene.objects.len()];
    for pixel in subject.geometry.pixels().iter().filter(|p| p.object != NOTHING) {
        counts[pixel.object as usize][usize::from(pixel.front)] += 1;
    }
    let is_behind = |[back, front]: [usize; 2]| {
        back + front >= PIXELS_MIN && back as f32 > BEHIND * (back + front) as f32
    };
    let behind = |emits: bool| -> Vec<&str> {
        let seen = scene.objects.iter().zip(&counts);
        let from_behind = seen.filter(|(object, count)| {
            scene.groups[object.group].is_emitter() == emits && is_behind(**count)
        });
        from_behind.map(|(object, _)| object.name.as_str()).collect()
    };
    let (lamps, others) = (behind(true), behind(false));
    if !lamps.is_empty() {
        found.push(Gravity::All, format!(
            "the picture shows {} from behind, where area lights are black: flip the faces, so that \
             the normals point to where the light goes",
            some(&lamps)
        ));
    }
    if !others.is_empty() {
        found.push(Gravity::Note, format!(
            "the picture shows {} from behind. Surfaces reflect alike on both sides, but a solid \
             whose faces point inwards is likely a mistake, and anisotropy directions count from the \
             front: flip the faces",
            some(&others)
        ));
    }
    found
}
