//! Recovery by Mitsuba: gradient descent on all parameters.

use super::LIMITS;
use crate::Failure;
use crate::peers::mitsuba::{self, Lobe};
use crate::peers::{Shot, Worker};
use serde_json::{Value, json};
use std::path::Path;
use unrender::formats::picture;
use unrender::scene::{Material, Rgb, RgbImage, Scene};

/// The errors that Mitsuba may have, as a multiple of ours.
const FACTOR: f64 = 2.0;
const SPP: u32 = 16;
/// The ceiling is not in the picture, and both are given its material.
const KNOWN: &str = "ceil";
const START_DEG: f64 = 20.0;

/// A descent with one learning rate.
pub(crate) struct Descent {
    pub(crate) rate: f64,
    pub(crate) version: String,
    /// Seconds until the errors were small enough.
    pub(crate) arrived: Option<f64>,
    /// Seconds, and the largest error in units of our limit.
    pub(crate) errors: Vec<(f64, f64)>,
    size: (usize, usize),
    last: Value,
}

/// The largest of three errors, each in units of our limit.
pub(crate) fn share(rho: f64, alpha_percent: f64, degrees: f64) -> f64 {
    let of = |error: f64, limit: Option<f64>| error / limit.unwrap_or(f64::INFINITY);
    of(rho, LIMITS.rho)
        .max(of(alpha_percent, LIMITS.alpha_percent))
        .max(of(degrees, LIMITS.degrees))
}

/// Descends on the photograph of Figure 8 for at most `give_up` seconds.
///
/// # Errors
/// If Mitsuba fails here.
pub(crate) fn run(
    python: &Path,
    truth: &Scene,
    folder: &Path,
    rate: f64,
    give_up: f64,
) -> Result<Descent, Failure> {
    let photo = picture::read(&crate::root().join("examples/fig8/photo.exr"))?.0.values;
    let photo = halved(&photo);
    let size = (photo.width(), photo.height());
    let mut start = truth.clone();
    let is_asked = |group: &&mut unrender::scene::Group| !group.is_emitter() && group.name != KNOWN;
    for group in start.groups.iter_mut().filter(is_asked) {
        group.material = if group.material.is_glossy() {
            let quarter = Rgb::splat(0.25);
            Material { alpha_y: 0.12, ..Material::isotropic(quarter, quarter, 0.1) }
        } else {
            Material::diffuse(Rgb::splat(0.5))
        };
    }
    let shot = Shot { scene: &start, camera: &start.cameras[0], size };
    let scene = mitsuba::write(&shot, &folder.join("mitsuba"), Lobe::Ward, "independent")?;
    let photo_file = folder.join("mitsuba/photo.exr");
    picture::write_exr(&photo_file, &photo)?;
    let asked = asked(truth, &scene, &photo_file, rate, give_up);
    let asked_file = folder.join("mitsuba/asked.json");
    std::fs::write(&asked_file, asked.to_string())?;
    let arguments = [asked_file.display().to_string()];
    let mut worker = Worker::start(python, "mitsuba_recover.py", arguments)?;
    let version = format!("Mitsuba {}", worker.greeting["version"].as_str().unwrap_or("3"));
    let mut descent =
        Descent { rate, version, arrived: None, errors: Vec::new(), size, last: Value::Null };
    while descent.arrived.is_none() && descent.gave_up() < give_up {
        let line = worker.hear()?;
        let number = |key: &str| line[key].as_f64().unwrap_or(f64::INFINITY);
        let seconds = number("seconds");
        let error = share(number("rho"), 100.0 * number("alpha"), number("degrees"));
        if number("iteration") % 20.0 == 1.0 {
            eprintln!("Mitsuba, rate {rate}: {line}");
        }
        descent.errors.push((seconds, error));
        descent.arrived = (error <= FACTOR).then_some(seconds);
        descent.last = line;
    }
    Ok(descent)
}

/// The request to the script.
fn asked(truth: &Scene, scene: &Path, photo: &Path, rate: f64, give_up: f64) -> Value {
    let asked: Vec<_> =
        truth.groups.iter().filter(|g| !g.is_emitter() && g.name != KNOWN).collect();
    let names = |glossy: bool| -> Vec<&str> {
        let of_kind = asked.iter().filter(|g| g.material.is_glossy() == glossy);
        of_kind.map(|g| g.name.as_str()).collect()
    };
    let numbers = |m: &Material| {
        json!({
            "rho_d": m.rho_d.to_array(),
            "rho_s": m.rho_s.to_array(),
            "alpha_x": m.alpha_x,
            "alpha_y": m.alpha_y,
        })
    };
    let numbers: serde_json::Map<String, Value> =
        asked.iter().map(|g| (g.name.clone(), numbers(&g.material))).collect();
    json!({
        "scene": scene,
        "photo": photo,
        "diffuse": names(false),
        "glossy": names(true),
        "truth": numbers,
        "theta": START_DEG.to_radians(),
        "spp": SPP,
        "rate": rate,
        "seconds": give_up,
    })
}

/// The means over squares of two by two pixels.
fn halved(picture: &RgbImage) -> RgbImage {
    RgbImage::from_fn(picture.width() / 2, picture.height() / 2, |x, y| {
        let at = |dx: usize, dy: usize| *picture.at(2 * x + dx, 2 * y + dy);
        0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))
    })
}

impl Descent {
    /// The seconds that have been spent.
    pub(crate) fn gave_up(&self) -> f64 {
        self.errors.last().map_or(0.0, |last| last.0)
    }

    /// Its row of the table.
    pub(crate) fn row(&self) -> [String; 6] {
        let number = |key: &str| self.last[key].as_f64().unwrap_or(f64::NAN);
        let end = if self.arrived.is_some() { "within twice" } else { "gave up" };
        [
            format!("Mitsuba, learning rate {}, {end}", self.rate),
            format!("{} x {}", self.size.0, self.size.1),
            format!("{:.1}", self.gave_up()),
            format!("{:.4}", number("rho")),
            format!("{:.1} %", 100.0 * number("alpha")),
            format!("{:.2} deg", number("degrees")),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_error_is_the_one_furthest_from_what_is_asked() {
        assert_eq!(share(0.005, 1.0, 0.1), 1.0);
        assert_eq!(share(0.0, 0.0, 1.5), 3.0);
        assert_eq!(share(0.001, 8.0, 0.5), 4.0);
    }
}
