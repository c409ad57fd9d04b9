//! Lamps that the photograph shows with another brightness than the scene gives them.

use super::finding::{Findings, Gravity};
use super::{Subject, median};
use unrender_photo::Exposure;
use unrender_scene::color::luminance;

/// Fewer pixels of a lamp say nothing: half of them are its rim, double of them a lamp across a room does not have.
const PIXELS_MIN: usize = 30;
/// The lamp is another one from this factor on. At the square root of it a shade that is brighter in its middle counts, at
/// its square an exporter's factor of pi does not.
const FACTOR: f32 = 1.7;

/// The findings of such lamps.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut findings = Findings::default();
    let job = subject.job;
    if job.project.exposure == Exposure::Auto {
        return findings;
    }
    for (index, group) in job.scene.groups.iter().enumerate() {
        if group.is_emitter()
            && !job.unknown_lights.contains(&index)
            && let Some(factor) = factor(subject, index)
        {
            let (by, than) = if factor.value > 1.0 {
                (factor.value, "brighter")
            } else {
                (factor.value.recip(), "darker")
            };
            let least = if factor.is_least { "at least " } else { "" };
            findings.push(
                Gravity::All,
                format!(
                    "the photo shows lamp \"{}\" {least}{by:.1} times {than} than the scene has it: check its strength, the \
                     exposure and the response, or let the recovery find it: [lights.{:?}] with unknown = true",
                    group.name, group.name
                ),
            );
        }
    }
    findings
}

/// How bright a lamp is in the photograph beside the scene.
struct Factor {
    value: f32,
    /// Whether the photograph is clipped there, so that it may be more.
    is_least: bool,
}

/// That of the lamp of this group; none if it is as bright as it should be, or not seen well enough.
fn factor(subject: &Subject<'_>, group: usize) -> Option<Factor> {
    let emission = luminance(subject.job.scene.groups[group].emission);
    let observation = subject.observation;
    let front = |pixel: &&u32| subject.geometry.pixels()[**pixel as usize].front;
    let light = |pixel: &u32| luminance(observation.picture.values.pixels()[*pixel as usize]);
    let of = |pixels: &[u32]| {
        let seen: Vec<f32> = pixels.iter().filter(front).map(light).collect();
        (seen.len() >= PIXELS_MIN).then(|| median(seen.into_iter())).flatten()
    };
    let saturated = observation.picture.saturated.pixels();
    let clipped: Vec<u32> = (observation.all_pixels_of_group[group].iter().copied())
        .filter(|pixel| saturated[*pixel as usize])
        .collect();
    if let Some(least) = of(&clipped) {
        let value = least / emission;
        return (value > FACTOR).then_some(Factor { value, is_least: true });
    }
    let value = of(&observation.pixels_of_group[group])? / emission;
    (value.max(value.recip()) > FACTOR).then_some(Factor { value, is_least: false })
}
