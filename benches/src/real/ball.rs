//! One photograph of a glossy ball predicts photographs of it under other lamps.
//!
//! The photographs are linear, of 16 bits; light directions (x right, y up, z towards the camera)
//! and intensities are those of the data set. Its normals are those of a sphere: x = R n_x + c_x
//! holds to 0.005 pixels.

use super::fit::{self, Sample};
use super::sphere::{Circle, GROUP, Lamp};
use super::{Bench, Outcome, group, hypothesis, three};
use crate::Failure;
use crate::command::Unrender;
use crate::table::Table;
use glam::Vec3;
use std::path::{Path, PathBuf};
use unrender::formats::picture::{self, Depth};
use unrender::formats::{atomic, gltf};
use unrender::scene::{Image, Rgb};

/// The sphere's image, fitted to the data set's normals, pixels.
const CIRCLE: Circle = Circle { x: 308.37, y: 264.37, radius: 70.75 };
/// The crop that is used: its left and top pixel, and its side.
const LEFT: usize = 228;
const TOP: usize = 184;
const SIDE: usize = 160;
/// The photographs from which materials are recovered: every 16th of 96, from the 9th.
const PHOTOGRAPHS: [usize; 6] = [9, 25, 41, 57, 73, 89];
/// The sets of several photographs, each under its lamp: every photograph is in one of two and in two of four.
const SEVERAL: [&[usize]; 6] =
    [&[9, 57], &[25, 73], &[41, 89], &[9, 25, 57, 73], &[25, 41, 73, 89], &[9, 41, 57, 89]];
/// The lamps that are predicted: every 8th, from the 5th; none is among the photographs.
const LAMPS: [usize; 12] = [5, 13, 21, 29, 37, 45, 53, 61, 69, 77, 85, 93];
/// Paths per pixel of a prediction. Light is direct and distant, so they only serve the edges, and
/// pixels at the rim are not used: at half or double, the error of a lamp changes by less than
/// 0.0001.
const PATHS: u32 = 16;
/// The goal, and the error of the estimator before this page.
const ASKED: f64 = 0.105;
const EARLIER: f64 = 0.173;
/// The goals for two photographs, and for four.
const ASKED_OF_TWO: f64 = 0.085;
const ASKED_OF_FOUR: f64 = 0.07;

const SEVERAL_SAY: &str =
    "The same from several photographs, each under its lamp (`[[photos]]` with `lights_on`):
";

const INTRODUCTION: &str = "## A glossy ball: one photograph predicts others

From one photograph under one lamp the ball's material is recovered; with it, the ball is rendered under 12 other lamps
and compared with the photographs that were taken there. Photographs 9, 25, 41, 57, 73 and 89 of 96, lamps 5, 13, ...
93: of the evenly spaced sets that were tried, the one in which Lambert's law comes closest to an earlier measurement
(0.156); recovery results were not used for the choice. The error is the root mean square over the ball's pixels and
channels, both pictures divided by the lamp's intensity, relative to the photograph's mean. Pixels at the rim and pixels
that the photograph clips are not used. Lambert and one lobe are fitted to the same photograph by weighted least
squares, without a renderer. The last line has the error of one isotropic lobe that is fitted to the 12 photographs that
are predicted: this is about the limit for an isotropic lobe of Ward's. Anisotropic lobes are a
little better.
";

/// The data set; photographs are read when they are needed.
struct Diligent {
    folder: PathBuf,
    lamps: Vec<Lamp>,
    /// The ball without its rim, in the crop.
    inside: Vec<bool>,
}

/// Writes the projects, recovers and scores.
///
/// # Errors
/// If the data is not as expected, or a recovery fails.
pub(super) fn measure(folder: &Path, bench: &Bench) -> Result<Option<Outcome>, Failure> {
    let data = Diligent::open(folder)?;
    for number in PHOTOGRAPHS {
        data.write_project(number, &bench.folder(&format!("photo{number:02}"))?)?;
    }
    for number in LAMPS {
        let scene = bench.folder("lamps")?.join(format!("lamp{number:02}.glb"));
        circle().write(SIDE, data.lamp(number)?, &scene)?;
    }
    let Some(command) = bench.command() else { return Ok(None) };
    let mut table = Table::new([
        "photograph",
        "hypothesis",
        "rho_d",
        "rho_s",
        "alpha",
        "recovered",
        "Lambert",
        "one lobe",
        "its alpha",
    ]);
    let mut sums = [0.0; 3];
    for number in PHOTOGRAPHS {
        let folder = bench.folder(&format!("photo{number:02}"))?;
        let result = folder.join("result");
        let file = bench.recover(&folder.join("project.toml"), &result)?;
        let recovered = data.rendered_error(command, &bench.folder("lamps")?, &result)?;
        let (lambert, _) = data.fitted_error(&[number], false)?;
        let (lobe, alpha) = data.fitted_error(&[number], true)?;
        let errors = [recovered, lambert, lobe];
        sums.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
        let entry = group(&file, GROUP)?;
        let roughness = entry
            .alpha_x
            .filter(|a| *a > 0.0)
            .map_or_else(|| "-".to_owned(), |a| format!("{a:.3}"));
        let mut row = vec![number.to_string(), hypothesis(entry)];
        row.extend([three(entry.rho_d, 3), three(entry.rho_s, 3), roughness]);
        row.extend(errors.map(|error| format!("{error:.3}")));
        row.push(alpha.map_or_else(|| "-".to_owned(), |a| format!("{a:.3}")));
        table.push(row);
    }
    let (known, _) = data.fitted_error(&LAMPS, true)?;
    let (several, of_two, of_four) = several(&data, command, bench)?;
    let [recovered, lambert, lobe] = sums.map(|sum| sum / PHOTOGRAPHS.len() as f64);
    let line = format!(
        "ball: {recovered:.3} (asked {ASKED}), lambert {lambert:.3}, one lobe {lobe:.3}, \
         fitted to what it predicts {known:.3}, earlier {EARLIER}; from two photographs \
         {of_two:.3} (asked {ASKED_OF_TWO}), from four {of_four:.3} (asked {ASKED_OF_FOUR})"
    );
    let text = format!("{INTRODUCTION}\n{}\n{SEVERAL_SAY}\n{several}\n`{line}`\n", table.text());
    Ok(Some(Outcome { text, line }))
}

/// Recovers from each set of several photographs: a table, and the mean errors of those of two and of four.
fn several(data: &Diligent, by: &Unrender, bench: &Bench) -> Result<(String, f64, f64), Failure> {
    let mut table =
        Table::new(["photographs", "hypothesis", "rho_d", "rho_s", "alpha", "recovered"]);
    let mut sums = [(0.0, 0.0); 2];
    for set in SEVERAL {
        let numbers: Vec<String> = set.iter().map(usize::to_string).collect();
        let folder = bench.folder(&format!("photos_{}", numbers.join("_")))?;
        data.write_project_of_several(set, &folder)?;
        let result = folder.join("result");
        let file = bench.recover(&folder.join("project.toml"), &result)?;
        let error = data.rendered_error(by, &bench.folder("lamps")?, &result)?;
        let (sum, count) = &mut sums[usize::from(set.len() == 4)];
        (*sum, *count) = (*sum + error, *count + 1.0);
        let entry = group(&file, GROUP)?;
        let roughness = entry.alpha_x.filter(|a| *a > 0.0);
        table.push([
            numbers.join(", "),
            hypothesis(entry),
            three(entry.rho_d, 3),
            three(entry.rho_s, 3),
            roughness.map_or_else(|| "-".to_owned(), |a| format!("{a:.3}")),
            format!("{error:.3}"),
        ]);
    }
    let [two, four] = sums.map(|(sum, count)| sum / count);
    Ok((table.text().to_owned(), two, four))
}

/// The sphere's image in the crop.
fn circle() -> Circle {
    CIRCLE.within(LEFT, TOP)
}

impl Diligent {
    fn open(folder: &Path) -> Result<Self, Failure> {
        let directions = triples(&folder.join("light_directions.txt"))?;
        let intensities = triples(&folder.join("light_intensities.txt"))?;
        let lamps: Vec<Lamp> = directions
            .into_iter()
            .zip(intensities)
            .map(|(d, i)| Lamp {
                towards: d.normalize(),
                irradiance: Rgb::from_array(i.to_array()),
            })
            .collect();
        let mask = cut(&folder.join("mask.png"))?.map(|code| code.max_element() > 0.5);
        let data = Self { folder: folder.to_owned(), lamps, inside: eroded(&mask) };
        data.check(&mask)?;
        Ok(data)
    }

    /// Checks that the mask is the circle, so that the constants here fit the data.
    fn check(&self, mask: &Image<bool>) -> Result<(), Failure> {
        let area = mask.pixels().iter().filter(|inside| **inside).count() as f32;
        let radius = (area / std::f32::consts::PI).sqrt();
        if (radius - CIRCLE.radius).abs() > 0.5 || self.lamps.len() != 96 {
            let what = "the mask is not the ball's, or there are not 96 lamps";
            return Err(format!("{}: {what}; use commit 86a1fbe", self.folder.display()).into());
        }
        Ok(())
    }

    /// The lamp of photograph `number`, from 1.
    fn lamp(&self, number: usize) -> Result<Lamp, Failure> {
        self.lamps
            .get(number - 1)
            .copied()
            .ok_or_else(|| format!("there is no lamp {number}").into())
    }

    /// The code values of photograph `number`.
    fn photograph(&self, number: usize) -> Result<Image<Rgb>, Failure> {
        cut(&self.folder.join(format!("{number:03}.png")))
    }

    fn write_project(&self, number: usize, folder: &Path) -> Result<(), Failure> {
        let photo = folder.join("photo.png");
        picture::write_png_codes(&photo, &self.photograph(number)?, Depth::Sixteen)?;
        super::write_sphere(folder, circle(), SIDE, self.lamp(number)?)
    }

    /// A project of several photographs, each under the lamp of its number.
    fn write_project_of_several(&self, set: &[usize], folder: &Path) -> Result<(), Failure> {
        let name = |number: &usize| format!("lamp{number:02}");
        let mut project = "scene = \"scene.glb\"\nresponse = \"linear\"\nexposure = 1.0\n\n\
                           [recover]\nbrdf = \"ward-gmd\"\n"
            .to_owned();
        let mut lamps = Vec::new();
        for number in set {
            let photo = format!("photo{number:02}.png");
            let codes = self.photograph(*number)?;
            picture::write_png_codes(&folder.join(&photo), &codes, Depth::Sixteen)?;
            lamps.push((name(number), self.lamp(*number)?));
            project +=
                &format!("\n[[photos]]\nphoto = \"{photo}\"\nlights_on = [\"{}\"]\n", name(number));
        }
        let scene = circle().scene_under(SIDE, &lamps);
        atomic::write(&folder.join("scene.glb"), &gltf::to_glb(&scene)?)?;
        Ok(atomic::write(&folder.join("project.toml"), project.as_bytes())?)
    }

    /// The mean error over all lamps of the recovery in `result`.
    fn rendered_error(&self, by: &Unrender, lamps: &Path, result: &Path) -> Result<f64, Failure> {
        let materials = result.join("materials.json");
        let materials = materials.to_str().ok_or("a path is not text")?;
        let flags = ["--materials", materials, "--independent"];
        let mut sum = 0.0;
        for number in LAMPS {
            let scene = lamps.join(format!("lamp{number:02}.glb"));
            let out = result.join(format!("lamp{number:02}.exr"));
            by.render(&scene, (SIDE, SIDE), PATHS, &out, &flags)?;
            let (rendered, _) = picture::read(&out)?;
            sum += self
                .error(number, |index| rendered.values.pixels()[index].to_array().map(f64::from))?;
        }
        Ok(sum / LAMPS.len() as f64)
    }

    /// The mean error over all lamps of a fit to the photographs `numbers`, and its roughness.
    fn fitted_error(&self, numbers: &[usize], lobe: bool) -> Result<(f64, Option<f32>), Failure> {
        let mut samples = Vec::new();
        for &number in numbers {
            let (photograph, lamp) = (self.photograph(number)?, self.lamp(number)?);
            samples.extend(self.counted(&photograph).filter_map(|index| {
                let value = photograph.pixels()[index].to_array().map(f64::from);
                normal(index).map(|normal| Sample { normal, lamp, value })
            }));
        }
        let fitted = fit::fit(&samples, lobe);
        let mut sum = 0.0;
        for other in LAMPS {
            let lamp = self.lamp(other)?;
            sum += self.error(other, |index| {
                normal(index).map_or([0.0; 3], |normal| fitted.predict(normal, lamp))
            })?;
        }
        Ok((sum / LAMPS.len() as f64, fitted.alpha))
    }

    /// The relative error of a prediction of photograph `number`.
    fn error(&self, number: usize, predicted: impl Fn(usize) -> [f64; 3]) -> Result<f64, Failure> {
        let photograph = self.photograph(number)?;
        let irradiance = self.lamp(number)?.irradiance.to_array();
        let (mut squares, mut total, mut count) = (0.0, 0.0, 0.0);
        for index in self.counted(&photograph) {
            let seen = photograph.pixels()[index].to_array();
            let predicted = predicted(index);
            for channel in 0..3 {
                let scale = 1.0 / f64::from(irradiance[channel]);
                let seen = f64::from(seen[channel]);
                squares += ((predicted[channel] - seen) * scale).powi(2);
                total += seen * scale;
                count += 1.0;
            }
        }
        Ok((squares / count).sqrt() / (total / count))
    }

    /// The pixels of a photograph that are used: inside the ball and not clipped.
    fn counted(&self, photograph: &Image<Rgb>) -> impl Iterator<Item = usize> {
        let clipped = |code: &Rgb| code.max_element() >= 1.0;
        let counts = self.inside.iter().zip(photograph.pixels());
        let counts = counts.map(move |(inside, code)| *inside && !clipped(code));
        counts.enumerate().filter_map(|(index, counts)| counts.then_some(index))
    }
}

/// The normal at the centre of a pixel of the crop.
fn normal(index: usize) -> Option<Vec3> {
    circle().normal((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5)
}

/// The crop of a picture of the data set, as code values.
fn cut(path: &Path) -> Result<Image<Rgb>, Failure> {
    super::cut(path, LEFT, TOP, SIDE)
}

/// Pixels whose neighbours are all inside.
fn eroded(mask: &Image<bool>) -> Vec<bool> {
    let inside = |index: usize| mask.neighbourhood(index).all(|other| mask.pixels()[other]);
    (0..mask.pixels().len()).map(|index| mask.pixels()[index] && inside(index)).collect()
}

/// The rows of a file, of three numbers each.
fn triples(path: &Path) -> Result<Vec<Vec3>, Failure> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let row = |line: &str| {
        let numbers: Vec<f32> =
            line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let three = <[f32; 3]>::try_from(numbers).map(Vec3::from_array);
        three.map_err(|_| format!("{}: not three numbers: {line}", path.display()).into())
    };
    text.lines().filter(|line| !line.trim().is_empty()).map(row).collect()
}
