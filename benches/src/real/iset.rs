//! A box with measured walls: recovered reflectances of the red and the green wall relative to the
//! white ones, against spectrophotometer and in-box measurements.
//!
//! The level of the green wall is not scored: it disagrees with its measurement in all photographs
//! of the series by 35 to 70 %, cause unknown. Its colour R:G agrees.

use super::{Bench, Outcome, group};
use crate::Failure;
use crate::table::Table;
use serde_json::Value;
use std::path::Path;
use unrender::formats::materials::MaterialsFile;

const PHOTOGRAPHS: [&str; 3] = ["photo0", "photo1", "photo2"];
const WHITE: [&str; 3] = ["back_wall", "floor", "ceiling"];
/// What is asked for in the first photograph.
const ASKED: f64 = 0.11;

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
/// If the data is not what it should be, or a recovery fails.
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
        let percent = |error: f64| format!("{:+.1} %", 100.0 * error);
        let row = [errors.red_r, errors.red_g, errors.green_colour].map(percent);
        let [a, b, c] = row;
        table.push([name.to_owned(), a, b, c, format!("{:.1} %", 100.0 * errors.worst())]);
        worst.push(errors.worst());
    }
    let line = format!(
        "iset: photo0 {:.3} (asked {ASKED}), photo1 {:.3}, photo2 {:.3}",
        worst[0], worst[1], worst[2]
    );
    Ok(Some(Outcome { text: format!("{INTRODUCTION}\n{}\n`{line}`\n", table.text()), line }))
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
