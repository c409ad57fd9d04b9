//! A box with measured walls: recovered reflectances of the red and the green wall relative to the
//! white ones, against spectrophotometer and in-box measurements.
//!
//! The level of the green wall is not scored: it disagrees with its measurement in all photographs
//! of the series by 35 to 70 %, cause unknown. Its colour R:G agrees.

use super::{Bench, Outcome, group};
use crate::Failure;
use crate::table::Table;
use serde_json::Value;
use std::path::{Path, PathBuf};
use unrender::formats::materials::MaterialsFile;
use unrender::formats::{Input, Limits, atomic, gltf, picture};
use unrender::render::Tracer;
use unrender::scene::{Image, Rgb};

const PHOTOGRAPHS: [&str; 3] = ["photo0", "photo1", "photo2"];
const WHITE: [&str; 3] = ["back_wall", "floor", "ceiling"];
/// The goal for the first photograph.
const ASKED: f64 = 0.11;
/// The goal for all three together.
const ASKED_TOGETHER: f64 = 0.08;
/// The object that stands elsewhere in each photograph.
const MOVED: &str = "chart";
/// Pixels around it that are not used either: it casts a shadow that the scene without it lacks.
const ABOUT: usize = 24;

const INTRODUCTION: &str = "## A box with measured walls

Three photographs of a box of 30 cm under a small lamp; the reflectances of its walls were measured.
Scored are red and green channel of the red wall relative to the white walls (the mean of back wall,
floor and ceiling), and the ratio R:G of the green wall. Blue, and the level of the green wall, are
not.
";

/// The scored errors of one photograph, relative.
struct Errors {
    red_r: f64,
    red_g: f64,
    green_colour: f64,
}

/// Recovers and scores.
///
/// # Errors
/// If the data is not as expected, or a recovery fails.
pub(super) fn measure(folder: &Path, bench: &Bench) -> Result<Option<Outcome>, Failure> {
    let path = folder.join("truth.json");
    let truth: Value = serde_json::from_slice(&std::fs::read(&path)?)?;
    if bench.command().is_none() {
        return Ok(None);
    }
    let mut table =
        Table::new(["photograph", "red wall, R", "red wall, G", "green wall, R:G", "worst"]);
    let mut worst = Vec::new();
    for name in PHOTOGRAPHS {
        let project = folder.join(name).join("project.toml");
        let file = bench.recover(&project, &bench.folder(name)?.join("result"))?;
        let errors = Errors::new(&file, &truth)?;
        table.push(errors.row(name));
        worst.push(errors.worst());
    }
    let project = write_together(folder, &bench.folder("together")?)?;
    let file = bench.recover(&project, &bench.folder("together")?.join("result"))?;
    let together = Errors::new(&file, &truth)?;
    table.push(together.row("all three"));
    let line = format!(
        "iset: photo0 {:.3} (asked {ASKED}), photo1 {:.3}, photo2 {:.3}, together {:.3} (asked {ASKED_TOGETHER})",
        worst[0],
        worst[1],
        worst[2],
        together.worst()
    );
    Ok(Some(Outcome { text: format!("{INTRODUCTION}\n{}\n`{line}`\n", table.text()), line }))
}

/// Writes the project of all three photographs into `to`. The box and the camera are the same in all of them, except
/// for a chart that was moved: the scene is without it, and pixels that show it are not used.
fn write_together(folder: &Path, to: &Path) -> Result<PathBuf, Failure> {
    let mut project = "scene = \"scene.glb\"\nresponse = \"srgb\"\nexposure = \"auto\"\n\n\
                       [anchor]\ngroup = \"back_wall\"\nrho_d = [0.885, 0.885, 0.885]\n\n\
                       [recover]\nbrdf = \"ward-gmd\"\n"
        .to_owned();
    for name in PHOTOGRAPHS {
        let path = folder.join(name).join("scene.glb");
        let (mut scene, _) = unrender::formats::load_model(Input::new(&path, Limits::default()))?;
        let photo = picture::read(&folder.join(name).join("photo.png"))?.0.values;
        let tracer = Tracer::new(&scene);
        let seen = tracer.geometry(&scene.cameras[0], photo.width(), photo.height());
        let moved = scene.objects.iter().position(|object| object.name == MOVED);
        let shows = |x: usize, y: usize| Some(seen.at(x, y).object as usize) == moved;
        let mask = Image::from_fn(photo.width(), photo.height(), |x, y| {
            let columns = x.saturating_sub(ABOUT)..(x + ABOUT + 1).min(photo.width());
            let rows = y.saturating_sub(ABOUT)..(y + ABOUT + 1).min(photo.height());
            let is_near = rows.into_iter().any(|y| columns.clone().any(|x| shows(x, y)));
            Rgb::splat(if is_near { 0.0 } else { 1.0 })
        });
        picture::write_png_srgb(&to.join(format!("{name}_mask.png")), &mask)?;
        std::fs::copy(folder.join(name).join("photo.png"), to.join(format!("{name}.png")))?;
        scene.objects.retain(|object| object.name != MOVED);
        atomic::write(&to.join("scene.glb"), &gltf::to_glb(&scene)?)?;
        project += &format!("\n[[photos]]\nphoto = \"{name}.png\"\nmask = \"{name}_mask.png\"\n");
    }
    let path = to.join("project.toml");
    atomic::write(&path, project.as_bytes())?;
    Ok(path)
}

impl Errors {
    fn new(file: &MaterialsFile, truth: &Value) -> Result<Self, Failure> {
        let mut white = [0.0; 2];
        for name in WHITE {
            let rho = two(file, name)?;
            (0..2).for_each(|channel| white[channel] += rho[channel] / WHITE.len() as f64);
        }
        let red = two(file, "left_wall")?;
        let green = two(file, "right_wall")?;
        let measured = |wall: &str, channel: usize| {
            let number = truth[wall]["truth"][channel].as_f64();
            number.ok_or_else(|| format!("truth.json has no {wall}.truth"))
        };
        let green_truth = measured("green_over_white", 0)? / measured("green_over_white", 1)?;
        let colour = (green[0] / white[0]) / (green[1] / white[1]);
        Ok(Self {
            red_r: red[0] / white[0] / measured("red_over_white", 0)? - 1.0,
            red_g: red[1] / white[1] / measured("red_over_white", 1)? - 1.0,
            green_colour: colour / green_truth - 1.0,
        })
    }

    /// The row of the table called `name`.
    fn row(&self, name: &str) -> [String; 5] {
        let percent = |error: f64| format!("{:+.1} %", 100.0 * error);
        let [a, b, c] = [self.red_r, self.red_g, self.green_colour].map(percent);
        [name.to_owned(), a, b, c, format!("{:.1} %", 100.0 * self.worst())]
    }

    fn worst(&self) -> f64 {
        self.red_r.abs().max(self.red_g.abs()).max(self.green_colour.abs())
    }
}

/// Red and green of a group's diffuse reflectance.
fn two(file: &MaterialsFile, name: &str) -> Result<[f64; 2], Failure> {
    let rho_d = group(file, name)?.rho_d.ok_or_else(|| format!("{name} has no rho_d"))?;
    Ok([f64::from(rho_d[0]), f64::from(rho_d[1])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::formats::materials::GroupEntry;

    #[test]
    fn errors_are_relative_to_the_measured_ratios() {
        let mut file = MaterialsFile::default();
        let mut add = |name: &str, rho_d: [f32; 3]| {
            let entry = GroupEntry { rho_d: Some(rho_d), ..GroupEntry::default() };
            file.groups.insert(name.to_owned(), entry);
        };
        WHITE.iter().for_each(|name| add(name, [0.8; 3]));
        add("left_wall", [0.44, 0.16, 0.1]);
        add("right_wall", [0.1, 0.2, 0.2]);
        let truth = serde_json::json!({
            "red_over_white": {"truth": [0.5, 0.2, 0.1]},
            "green_over_white": {"truth": [0.2, 0.4, 0.2]},
        });
        let errors = Errors::new(&file, &truth).unwrap();
        assert!((errors.red_r - 0.1).abs() < 1e-6 && errors.red_g.abs() < 1e-6);
        assert!(errors.green_colour.abs() < 1e-6 && (errors.worst() - 0.1).abs() < 1e-6);
    }
}
