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
            findings.push(
                Gravity::All,
                format!(
                    "the photo shows lamp \"{}\" {}: check its strength, the exposure and the response, or let the recovery \
                     find it: [lights.{:?}] with unknown = true",
                    group.name,
                    factor.in_words(),
                    group.name
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

impl Factor {
    /// How the photograph shows the lamp.
    fn in_words(&self) -> String {
        let least = if self.is_least { "at least " } else { "" };
        let than = "than the scene has it";
        if self.value == 0.0 {
            "black, and the scene has it shining".into()
        } else if self.value > 1.0 {
            format!("{least}{:.1} times brighter {than}", self.value)
        } else {
            format!("{least}{:.1} times darker {than}", self.value.recip())
        }
    }
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

#[cfg(test)]
mod tests {
    use super::Factor;

    #[test]
    fn a_lamp_is_brighter_darker_or_black() {
        let said = |value, is_least| Factor { value, is_least }.in_words();
        assert_eq!(said(2.0, true), "at least 2.0 times brighter than the scene has it");
        assert_eq!(said(0.5, false), "2.0 times darker than the scene has it");
        assert_eq!(said(0.0, false), "black, and the scene has it shining");
    }
}
