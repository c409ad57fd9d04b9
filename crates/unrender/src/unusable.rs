//! Why no pixel of a photograph can be used, although it shows the scene.

use crate::{Job, check, ungrouped};
use unrender_render::{NOTHING, Tracer};

/// Why a pixel cannot be used, in the order in which reasons are looked for.
const REASONS: [(&str, &str); 6] = [
    ("belong to groups that the project ignores", "take `ignore` away from one of them"),
    ("are masked", "check the mask: black leaves a pixel out, white keeps it"),
    ("lie behind glass", "leave it out of the scene"),
    ("are clipped, or beside such a pixel", "take a photo with a shorter exposure"),
    ("lie in the noise near black, or have no measurement", "take a photo with a longer exposure"),
    ("are too close to an edge of the model, or outliers", "use a larger photo"),
];

/// The sentence about the photographs of `job`; none if their cameras do not see the scene.
pub(crate) fn why(job: &Job) -> Option<String> {
    let tracer = Tracer::new(&job.scene);
    let mut counts = [0usize; REASONS.len()];
    for k in 0..job.photographs() {
        let alone = job.alone(k);
        for reason in reasons(&alone, &tracer) {
            counts[reason] += 1;
        }
    }
    let all: usize = counts.iter().sum();
    let most = (0..REASONS.len()).max_by_key(|reason| counts[*reason])?;
    let told = |(count, (what, _)): (&usize, &(&str, &str))| match count {
        0 => None,
        count if *count == all => Some(format!("all {all} that show the scene {what}")),
        count => Some(format!("{count} of the {all} that show the scene {what}")),
    };
    let told: Vec<String> = counts.iter().zip(&REASONS).filter_map(told).collect();
    let photo = if job.photographs() == 1 { "the photo" } else { "the photos" };
    (all > 0).then(|| {
        format!(
            "no pixel of {photo} can be used: {}. {}",
            told.join(", "),
            check::capitalised(REASONS[most].1)
        )
    })
}

/// For each pixel that shows the scene, the reason why it cannot be used.
fn reasons(job: &Job, tracer: &Tracer) -> Vec<usize> {
    let photo = &job.photo;
    let geometry = tracer.geometry(&job.camera, photo.radiance.width(), photo.radiance.height());
    let apart = ungrouped::materials(&job.scene, &job.camera, &geometry);
    let apart = |index: usize| apart.as_ref().and_then(|apart| apart[index]);
    let is_ignored = |index: usize, group: u32| {
        let name = apart(index).unwrap_or(&job.scene.groups[group as usize].name);
        job.project.ignored.contains(name)
    };
    let is_clipped = |index: usize| {
        let saturated = photo.saturated.pixels();
        saturated[index] || photo.saturated.neighbourhood(index).any(|near| saturated[near])
    };
    let reason = |index: usize, group: u32| match index {
        _ if is_ignored(index, group) => 0,
        _ if job.mask.as_ref().is_some_and(|mask| !mask.pixels()[index]) => 1,
        _ if apart(index).is_some() => 2,
        _ if photo.valid.pixels()[index] => 5,
        _ if is_clipped(index) => 3,
        _ => 4,
    };
    let shown = geometry.pixels().iter().enumerate().filter(|(_, pixel)| pixel.group != NOTHING);
    shown.map(|(index, pixel)| reason(index, pixel.group)).collect()
}
