//! Other meanings of the intensities of a glTF file's lights. The *Lighting Mode* of Blender's export is not in the
//! file; the power of the lamps under each reading, and the photograph, show which one is plausible.

use crate::Job;
use std::f64::consts::PI;
use unrender_formats::{LightUnits, gltf};
use unrender_scene::{Light, LightKind, Rgb, Scene};

/// The power of real bulbs, watts, from a small LED to a floodlight. A tenth of the least, a watch's light, does not
/// light a scene; at ten times the most, all modes of a dim scene are plausible.
const WATTS: [f64; 2] = [0.5, 5000.0];
/// Suns, from one behind clouds to one in space, W/m^2; with room as for [`WATTS`].
const SUNS: [f64; 2] = [0.05, 3000.0];

/// A way to read the lights of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// The units, as in projects and flags.
    pub(crate) units: LightUnits,
    /// The factors on the present brightness of point and spot lights, and of directional ones.
    factors: [f64; 2],
}

/// Other readings of the lights of `job` than the present one; none if no other is possible.
pub(crate) fn others(job: &Job) -> Vec<Reading> {
    let path = &job.project.scene;
    let is_gltf = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("glb") || end.eq_ignore_ascii_case("gltf"));
    if !is_gltf || own_lights(job).next().is_none() {
        return Vec::new();
    }
    let stated = job.project.light_units;
    let Some(now) = stated.or_else(|| gltf::light_units(job.project.scene_input()).ok()) else {
        return Vec::new();
    };
    let scales = |units: LightUnits| [false, true].map(|sun| units.radiometric(sun));
    let mut found: Vec<Reading> = Vec::new();
    for units in LightUnits::ALL {
        let factors = [0, 1].map(|kind| scales(units)[kind] / scales(now)[kind]);
        // Two names of the same numbers are one reading.
        if factors != [1.0; 2] && found.iter().all(|other| other.factors != factors) {
            found.push(Reading { units, factors });
        }
    }
    found
}

/// The lights that come from the file and not from the project.
fn own_lights(job: &Job) -> impl Iterator<Item = &Light> {
    let edits = &job.project.light_edits;
    job.scene.lights.iter().filter(move |light| edits.iter().all(|edit| edit.name != light.name))
}

impl Reading {
    /// The factor on the present brightness of `light`.
    fn factor(&self, light: &Light) -> f64 {
        self.factors[usize::from(matches!(light.kind, LightKind::Directional { .. }))]
    }

    /// The scene of `job`, its lights read like this.
    pub(crate) fn scene(&self, job: &Job) -> Scene {
        let mut scene = job.scene.clone();
        let own: Vec<&str> = own_lights(job).map(|light| light.name.as_str()).collect();
        for light in scene.lights.iter_mut().filter(|light| own.contains(&light.name.as_str())) {
            let factor = self.factor(light) as f32;
            *light.kind.strength_mut() *= factor;
        }
        scene
    }

    /// The brightest lamp now and under this reading, in words.
    pub(crate) fn lamp(&self, job: &Job) -> String {
        let brightest = own_lights(job).max_by(|a, b| power(a).total_cmp(&power(b)));
        brightest.map_or(String::new(), |light| {
            let unit = match light.kind {
                LightKind::Directional { .. } => "W/m^2",
                _ => "W",
            };
            let name = &light.name;
            let [now, then] = [power(light), power(light) * self.factor(light)].map(short);
            format!("light \"{name}\" has {now} {unit}, and would have {then} {unit}")
        })
    }

    /// Whether all lamps would be real ones under this reading, and now none is.
    pub(crate) fn is_plausible(&self, job: &Job) -> bool {
        let is_lamp = |light: &Light, factor: f64| {
            let [least, most] = match light.kind {
                LightKind::Directional { .. } => SUNS,
                _ => WATTS,
            };
            (least..=most).contains(&(power(light) * factor))
        };
        let mut lit = own_lights(job).filter(|light| power(light) > 0.0).peekable();
        lit.peek().is_some() && lit.all(|l| !is_lamp(l, 1.0) && is_lamp(l, self.factor(l)))
    }

    /// Whether this reading explains that all light is off by the factor `off`.
    pub(crate) fn explains(&self, job: &Job, off: Rgb) -> bool {
        let Some(light) = own_lights(job).max_by(|a, b| power(a).total_cmp(&power(b))) else {
            return false;
        };
        // Half of the least step between two readings, from watts to watts per steradian.
        let near = (4.0 * PI).sqrt();
        let mean = f64::from(off.element_sum()) / 3.0;
        let share = mean / self.factor(light);
        mean.is_finite() && (1.0 / near..=near).contains(&share)
    }
}

/// The watts of a lamp; for a sun, per square metre.
fn power(light: &Light) -> f64 {
    let strength = f64::from(light.kind.strength().element_sum()) / 3.0;
    match &light.kind {
        LightKind::Directional { .. } => strength,
        // As Blender counts them: a spot's watts are those of the whole bulb.
        LightKind::Point { .. } | LightKind::Spot { .. } => 4.0 * PI * strength,
        LightKind::Profiled { profile, .. } => profile.steradians() * strength,
    }
}

/// A number with two digits.
fn short(value: f64) -> String {
    let digits = (1.0 - value.max(1e-9).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// How to state another reading, as the end of a sentence.
pub(crate) fn remedy(units: LightUnits) -> String {
    format!(
        "if the file was exported in that Lighting Mode, say light_units = \"{units}\" in the project"
    )
}
