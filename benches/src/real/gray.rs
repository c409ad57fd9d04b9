//! A gray sphere under twelve lamps: twelve recoveries of one albedo.
//!
//! The photographs are linear, of 8 bits. The direction to each lamp is that of its highlight on a
//! chrome sphere: l = 2 (n . v) n - v, with n the normal at the highlight and v the direction to the
//! camera. The lamps are assumed to be equally bright.

use super::sphere::{Circle, GROUP, Lamp};
use super::{Bench, Outcome, group, hypothesis, three};
use crate::Failure;
use crate::table::Table;
use glam::Vec3;
use std::f32::consts::PI;
use std::path::Path;
use unrender::formats::picture::{self, Depth};
use unrender::scene::{Image, Rgb};

/// The spheres' images: the middle and half the sides of their masks' bounding boxes, pixels.
const CHROME: Circle = Circle { x: 254.0, y: 148.5, radius: 119.25 };
const GRAY: Circle = Circle { x: 245.0, y: 145.0, radius: 108.0 };
/// The crop of the gray sphere that is used: its left and top pixel, and its side.
const LEFT: usize = 129;
const TOP: usize = 29;
const SIDE: usize = 232;
/// The crop of the chrome sphere.
const CHROME_LEFT: usize = 134;
const CHROME_TOP: usize = 28;
const CHROME_SIDE: usize = 240;
const PHOTOGRAPHS: usize = 12;
/// A pixel of the highlight: a code of 250 of 255 or more in every channel. At half of that, as at
/// 200 or 254, no direction changes by more than 0.5 degrees. Double is above the largest code.
const HIGHLIGHT: f32 = 250.0 / 255.0;
/// The irradiance of every lamp. The true one is unknown; this makes a white diffuse surface that
/// faces the lamp have radiance one, so that albedos are codes over cosines. Another value scales all
/// albedos equally, and does not change their spread.
const IRRADIANCE: f32 = PI;
/// The goal: a relative standard deviation of the twelve albedos of 1 %.
const ASKED: f64 = 0.01;

const INTRODUCTION: &str = "## A gray sphere: twelve lamps, one albedo

A sphere of one gray paint was photographed under 12 lamps. From each photograph its diffuse
reflectance is recovered; all twelve should agree. Directions to the lamps come from their
highlights on a chrome sphere; their brightness is unknown and assumed to be equal, so the unit of
the reflectance is arbitrary. `least squares` is the equal-weight fit of Lambert's law without a
renderer: its spread is that of the photographs, of the directions and of the lamps. The spread is
the standard deviation of the twelve over their mean; `range` is the greatest minus the least, over
the mean.
";

/// Writes the projects, recovers and scores.
///
/// # Errors
/// If the data is not as expected, or a recovery fails.
pub(super) fn measure(folder: &Path, bench: &Bench) -> Result<Option<Outcome>, Failure> {
    let mut fitted = Vec::new();
    for number in 0..PHOTOGRAPHS {
        let towards = direction(&folder.join(format!("chrome/chrome.{number}.png")))?;
        let lamp = Lamp { towards, irradiance: Rgb::splat(IRRADIANCE) };
        let photograph =
            super::cut(&folder.join(format!("gray/gray.{number}.png")), LEFT, TOP, SIDE)?;
        let project = bench.folder(&format!("photo{number:02}"))?;
        picture::write_png_codes(&project.join("photo.png"), &photograph, Depth::Eight)?;
        super::write_sphere(&project, GRAY.within(LEFT, TOP), SIDE, lamp)?;
        fitted.push((towards, least_squares(&photograph, towards)));
    }
    if bench.command().is_none() {
        return Ok(None);
    }
    let mut table =
        Table::new(["photograph", "to the lamp", "hypothesis", "rho_d", "least squares"]);
    let mut albedos = Vec::new();
    for (number, (towards, albedo)) in fitted.iter().enumerate() {
        let project = bench.folder(&format!("photo{number:02}"))?;
        let file = bench.recover(&project.join("project.toml"), &project.join("result"))?;
        let entry = group(&file, GROUP)?;
        let rho_d = entry.rho_d.ok_or_else(|| format!("photograph {number} has no rho_d"))?;
        albedos.push(rho_d.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0);
        let direction = three(Some(towards.to_array()), 3);
        let fit = format!("{albedo:.4}");
        table.push([number.to_string(), direction, hypothesis(entry), three(entry.rho_d, 3), fit]);
    }
    let plain: Vec<f64> = fitted.iter().map(|(_, albedo)| *albedo).collect();
    let line =
        format!("gray: {} (asked {ASKED}), least squares {}", spread(&albedos), spread(&plain));
    Ok(Some(Outcome { text: format!("{INTRODUCTION}\n{}\n`{line}`\n", table.text()), line }))
}

/// The relative standard deviation, and the relative difference of the greatest and the least.
fn spread(values: &[f64]) -> String {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value / mean - 1.0).powi(2)).sum();
    let deviation = (squares / (values.len() as f64 - 1.0)).sqrt();
    let (least, greatest) = values
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(least, greatest), v| (least.min(*v), greatest.max(*v)));
    format!("{deviation:.4} (range {:.4})", (greatest - least) / mean)
}

/// The direction from the chrome sphere to the lamp.
fn direction(path: &Path) -> Result<Vec3, Failure> {
    let picture = super::cut(path, CHROME_LEFT, CHROME_TOP, CHROME_SIDE)?;
    let chrome = CHROME.within(CHROME_LEFT, CHROME_TOP);
    let bright = |index: &usize| {
        picture.pixels()[*index].min_element() >= HIGHLIGHT
            && at(&chrome, CHROME_SIDE, *index).is_some()
    };
    let (mut x, mut y, mut count) = (0.0, 0.0, 0.0);
    for index in (0..picture.pixels().len()).filter(bright) {
        x += (index % CHROME_SIDE) as f32 + 0.5;
        y += (index / CHROME_SIDE) as f32 + 0.5;
        count += 1.0;
    }
    let normal = chrome.normal(x / count, y / count);
    let normal = normal.ok_or_else(|| format!("{}: no highlight", path.display()))?;
    Ok(2.0 * normal.z * normal - Vec3::Z)
}

/// The normal at the centre of a pixel.
fn at(circle: &Circle, side: usize, index: usize) -> Option<Vec3> {
    circle.normal((index % side) as f32 + 0.5, (index / side) as f32 + 0.5)
}

/// The equal-weight fit of Lambert's law to the mean of the channels, without the outermost 2
/// pixels.
fn least_squares(photograph: &Image<Rgb>, towards: Vec3) -> f64 {
    let circle = GRAY.within(LEFT, TOP);
    let inner = Circle { radius: circle.radius - 2.0, ..circle };
    let (mut products, mut squares) = (0.0, 0.0);
    for (index, code) in photograph.pixels().iter().enumerate() {
        let Some(normal) = at(&circle, SIDE, index) else { continue };
        if at(&inner, SIDE, index).is_none() {
            continue;
        }
        let cosine = f64::from(normal.dot(towards).max(0.0));
        products += cosine * f64::from(code.element_sum() / 3.0);
        squares += cosine * cosine;
    }
    products / squares * f64::from(PI / IRRADIANCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_find_the_albedo_of_a_lambertian_sphere() {
        let towards = Vec3::new(0.3, 0.4, 0.86).normalize();
        let circle = GRAY.within(LEFT, TOP);
        let picture = Image::from_fn(SIDE, SIDE, |x, y| {
            let normal = circle.normal(x as f32 + 0.5, y as f32 + 0.5);
            Rgb::splat(normal.map_or(0.0, |n| 0.7 * n.dot(towards).max(0.0)))
        });
        assert!((least_squares(&picture, towards) - 0.7).abs() < 1e-6);
    }

    #[test]
    fn the_spread_is_relative() {
        assert_eq!(spread(&[0.99, 1.0, 1.01]), "0.0100 (range 0.0200)");
    }
}
