//! Pictures at equal time: the error of each renderer against the picture to which it converges
//! itself, so that differences between the models do not count.
//!
//! In each round every renderer makes its pictures, from fast to slow. The time of a picture
//! excludes reading the scene, building its tree, and compiling before the first picture. Our error
//! at another's time is interpolated between our own pictures in logarithms, and extrapolated by
//! `error ~ time^(-1/2)`.

mod contender;
mod curve;
mod lineup;
mod reference;

use crate::page::Section;
use crate::plot::{self, Axes};
use crate::scenes::{self, Room};
use crate::statistics::median;
use crate::table::{Table, verdict};
use crate::{Effort, Failure, machine};
use contender::Contender;
use curve::{Curve, Point};
use lineup::Lineup;
use reference::References;
use std::collections::BTreeSet;
use unrender::scene::{Scene, WardModel};

/// A scene to render, and the other renderers for it.
struct Subject {
    name: &'static str,
    /// Its name in file names.
    file: &'static str,
    scene: Scene,
    /// If Radiance has its lobe: the rays in a row of a pixel, in the picture to which it
    /// converges.
    radiance: Option<usize>,
}

/// The pictures that one renderer made of a subject.
struct Measured {
    name: String,
    goal: f64,
    /// For each setting its name, and a point per round.
    settings: Vec<(String, Vec<Point>)>,
}

/// Measures, and returns the section.
///
/// # Errors
/// If Figure 8 is not there, or a program that was there failed.
pub(crate) fn measure(effort: Effort) -> Result<Section, Failure> {
    let side = effort.pick(48, 128);
    let mut versions = Vec::new();
    let (mut results, mut plots) = (Vec::new(), Vec::new());
    for subject in subjects(effort)? {
        eprintln!("{}, {side} x {side}", subject.name);
        let mut lineup = Lineup::new(&subject, side, effort);
        let measured = rounds(&mut lineup.here, effort)?;
        let used = lineup.here.iter().skip(1).map(|contender| contender.version());
        versions.extend(
            used.filter(|v| !v.is_empty() && !versions.contains(v)).collect::<BTreeSet<_>>(),
        );
        plots.push((
            format!("performance-rendering-{}.svg", subject.file),
            draw(&subject, &measured)?,
        ));
        results.push((subject, measured, lineup.missing));
    }
    Ok(Section { text: text(&results, side, &versions), plots })
}

fn subjects(effort: Effort) -> Result<Vec<Subject>, Failure> {
    let fig8 = scenes::figure8()?;
    let read_as_gmd = Scene { brdf: WardModel::WardGmd.into(), ..fig8.clone() };
    let triangles = effort.pick(10_000, 1_000_000);
    Ok(vec![
        Subject { name: "Figure 8", file: "fig8", scene: fig8, radiance: None },
        Subject {
            name: "Figure 8, read as ward-gmd",
            file: "fig8-gmd",
            scene: read_as_gmd,
            radiance: Some(effort.pick(2, 4)),
        },
        Subject {
            name: if triangles < 1_000_000 { "room" } else { "room, 1M triangles" },
            file: "room",
            scene: scenes::room(Room { triangles, panels: 1 }),
            // Twice as many would take a quarter of an hour.
            radiance: Some(2),
        },
    ])
}

/// All make their pictures in each round; the first round is not counted.
fn rounds(contenders: &mut [Box<dyn Contender>], effort: Effort) -> Result<Vec<Measured>, Failure> {
    let mut references = References::default();
    let mut results: Vec<Measured> = contenders
        .iter()
        .map(|contender| Measured {
            name: contender.name(),
            goal: contender.goal(),
            settings: contender.settings().into_iter().map(|s| (s, Vec::new())).collect(),
        })
        .collect();
    for (contender, result) in contenders.iter_mut().zip(&mut results) {
        references.add(&mut **contender)?;
        // The first picture of a setting compiles it.
        for setting in 0..result.settings.len() {
            if contender.compiles() {
                contender.render(setting, u32::MAX)?;
            }
        }
    }
    for round in 0..effort.pick(1, 2) {
        for (contender, result) in contenders.iter_mut().zip(&mut results) {
            for (setting, (name, points)) in result.settings.iter_mut().enumerate() {
                let (picture, seconds) = contender.render(setting, round)?;
                let error = references.error(&contender.truth(), &picture);
                eprintln!("{}, {name}: {seconds:.3} s, RMSE {error:.6}", result.name);
                points.push(Point { seconds, error });
            }
        }
    }
    Ok(results)
}

impl Measured {
    /// The median over the rounds.
    fn point(&self, setting: usize) -> Point {
        let points = &self.settings[setting].1;
        Point {
            seconds: median(points.iter().map(|p| p.seconds)),
            error: median(points.iter().map(|p| p.error)),
        }
    }

    /// Our error over theirs in the time of one of their settings, the median over the rounds.
    fn ratio(&self, setting: usize, ours: &Self) -> f64 {
        let in_round = |(round, theirs): (usize, &Point)| {
            ours.curve(round).error_at(theirs.seconds) / theirs.error
        };
        median(self.settings[setting].1.iter().enumerate().map(in_round))
    }

    fn curve(&self, round: usize) -> Curve {
        Curve::new(self.settings.iter().map(|(_, points)| points[round]))
    }

    /// The ratio at the setting that is best for them.
    fn best_ratio(&self, ours: &Self) -> f64 {
        (0..self.settings.len()).map(|s| self.ratio(s, ours)).fold(f64::NAN, f64::max)
    }
}

fn draw(subject: &Subject, measured: &[Measured]) -> Result<String, Failure> {
    let curve = |m: &Measured| {
        let points = (0..m.settings.len()).map(|s| m.point(s));
        plot::Curve {
            label: m.name.clone(),
            points: points.map(|p| (p.seconds, p.error)).collect(),
        }
    };
    let curves: Vec<plot::Curve> = measured.iter().map(curve).collect();
    let axes = Axes { title: subject.name, x: "seconds on all cores", y: "RMSE, W/(sr m^2)" };
    plot::svg(&axes, &curves)
}

fn text(
    results: &[(Subject, Vec<Measured>, Vec<String>)],
    side: usize,
    versions: &[String],
) -> String {
    let mut claims = Table::new(["claim", "goal", "measured", "held"]);
    let mut rows =
        Table::new(["scene", "renderer", "setting", "seconds", "RMSE", "ours / theirs, same time"]);
    let mut pictures = String::new();
    for (subject, measured, missing) in results {
        let (name, file) = (subject.name, subject.file);
        let ours = &measured[0];
        for one in measured {
            for (setting, (label, _)) in one.settings.iter().enumerate() {
                let point = one.point(setting);
                let is_ours = std::ptr::eq(one, ours);
                let ratio = if is_ours {
                    "-".to_owned()
                } else {
                    format!("{:.2}", one.ratio(setting, ours))
                };
                rows.push([
                    name,
                    &one.name,
                    label,
                    &format!("{:.3}", point.seconds),
                    &format!("{:.5}", point.error),
                    &ratio,
                ]);
            }
        }
        for one in measured.iter().filter(|one| one.goal.is_finite()) {
            let ratio = one.best_ratio(ours);
            let [found, held] = verdict(ratio, ratio <= one.goal);
            let claim = format!("{name}: our RMSE of that of {}", one.name);
            claims.push([claim, format!("<= {}", one.goal), found, held]);
        }
        for other in missing {
            claims.push([&format!("{name}: our RMSE of that of {other}"), "", "-", "not measured"]);
        }
        pictures.push_str(&format!("\n![{name}](images/performance-rendering-{file}.svg)\n"));
    }
    format!(
        "## Pictures at equal time\n\n`rendering`. {}\n\n{}\n{EXPLANATION}\n{}{pictures}",
        machine::sentence(versions),
        claims.text(),
        rows.text()
    )
    .replace("SIDE", &side.to_string())
}

const EXPLANATION: &str =
    "Pictures of SIDE x SIDE pixels with a box filter, on all cores. RMSE is \
over all pixels and channels, against the picture to which the same renderer converges with the \
same model; its remaining noise, known from its two halves, is subtracted. Our pixels share paths \
where that pays, as by default, or do not (`--independent`); both are compared with the picture to \
which the default converges. Medians of the rounds. A ratio is our error in the time of the \
other's setting over the other's error; the claim is for the setting that is best for the other. \
Mitsuba: integrator `path` without a limit of depth, and its own Russian roulette; `ward` is our \
lobe as a plugin in Python (`benches/peers/ward.py`, compiled by LLVM), `beckmann` the lobe that \
`unrender export` writes for it; reading and compiling are not counted. Its variant `llvm_ad_rgb` \
needs a shared library of LLVM (Debian's `libllvm19`). Radiance: `rtrace` on all cores with \
irradiance caching (`-aa`) or without; N x N rays a pixel; reading is not counted. In the room it \
converges to 2 x 2 rays a pixel, whose places are fixed, which flatters its own 2 x 2 there and \
makes its 4 x 4 look worse.
";
