//! Lights in the units of another Lighting Mode of Blender's export: by the brightness of the photograph under each
//! reading, or, where that decides nothing, by the power of real lamps.

use super::finding::{Findings, Gravity};
use super::{Subject, capitalised, identifiabilities, photograph};
use crate::readings::{self, Reading};
use unrender_recover::View;
use unrender_render::Tracer;

/// Photograph and grey rendering agree up to this factor: half of the least step between two readings.
const NEAR: f64 = 3.5;

/// Warnings of the units of the lights.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let job = subject.job;
    let others = readings::others(job);
    if others.is_empty() {
        return found;
    }
    match photograph::factor(subject, subject.identifiabilities) {
        Some(factor) if is_near(factor) => {}
        Some(factor) => {
            let fits =
                others.iter().filter_map(|reading| Some((reading, by_photo(subject, reading)?)));
            let nearest = fits.min_by(|a, b| a.1.ln().abs().total_cmp(&b.1.ln().abs()));
            // A reading that changes less than half a step decides nothing.
            let is_nearer = |then: f64| factor.ln().abs() - then.ln().abs() > NEAR.ln();
            let nearest = nearest.filter(|(_, then)| is_near(*then) && is_nearer(*then));
            if let Some((reading, then)) = nearest {
                let units = reading.units;
                found.push(Gravity::All, format!(
                    "read as \"{units}\", the lights fit the photo: in middle grey the photo is {} times as \
                     bright as the scene is now, and would be {then:.1} times as bright; {}. {}",
                    if factor >= 1.0 { format!("{factor:.0}") } else { format!("{factor:.4}") },
                    reading.lamp(job),
                    capitalised(&readings::remedy(units))
                ));
            }
        }
        None => {
            for reading in others.iter().filter(|reading| reading.is_plausible(job)) {
                let units = reading.units;
                found.push(Gravity::All, format!(
                    "as the lights are read, each is too bright or too faint for a real lamp; as \"{units}\" all are plausible: \
                     {}. {}",
                    reading.lamp(job),
                    capitalised(&readings::remedy(units))
                ));
            }
        }
    }
    found
}

fn is_near(factor: f64) -> bool {
    (1.0 / NEAR..=NEAR).contains(&factor)
}

/// The brightness of the photograph over that of the grey scene with its lights read like this.
fn by_photo(subject: &Subject<'_>, reading: &Reading) -> Option<f64> {
    let scene = reading.scene(subject.job);
    let tracer = Tracer::new(&scene);
    let (width, height) = (subject.geometry.width(), subject.geometry.height());
    let view = View::new(&tracer, &subject.registered.camera, (width, height), scene.brdf);
    photograph::factor(subject, &identifiabilities(&view, subject.observation, subject.specs))
}
