//! The flux and the intensity of lamps, in lumens and candela, for projects that count in these units.
//!
//! A lumen is 1/683 W of each channel: `lm = 683 * luminance(strength) * steradians`.

use crate::Job;
use std::fmt::Write;
use unrender_formats::LightUnits;
use unrender_scene::color::luminance;
use unrender_scene::{LUMENS_PER_WATT, Light, LightKind};

/// A line for each light without a surface; none if neither the project nor a lamp of the scene counts in lumens.
pub fn lines(job: &Job) -> String {
    let project = &job.project;
    let is_profiled = |light: &Light| matches!(light.kind, LightKind::Profiled { .. });
    let is_photometric = project.light_units == Some(LightUnits::BlenderStandard)
        || project.light_edits.iter().any(|edit| edit.photometric.is_some())
        || job.scene.lights.iter().any(is_profiled);
    let mut text = String::new();
    for light in job.scene.lights.iter().filter(|_| is_photometric) {
        let candela = LUMENS_PER_WATT * f64::from(luminance(light.kind.strength()));
        let name = &light.name;
        let _ = match light.kind.steradians() {
            Some(steradians) => writeln!(
                text,
                "light \"{name}\": {:.0} lm, at most {candela:.0} cd",
                candela * steradians
            ),
            None => writeln!(text, "light \"{name}\": {candela:.0} lx"),
        };
    }
    text
}
