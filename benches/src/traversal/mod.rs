//! Measures rays per second on the same triangles and the same rays, with our tree and with
//! Embree's.
//!
//! Each kernel converts the rays into its own form, and the answers are compared: Embree's fast
//! mode lets rays pass between triangles, so some may differ.

mod embree;
mod kernel;
mod rays;
mod rounds;

use crate::page::Section;
use crate::scenes::{self, Room};
use crate::table::{Table, verdict};
use crate::{Effort, Failure, machine, peers};
use embree::{Embree, Mode};
use kernel::{Kernel, Ours};
use rounds::Row;
use std::path::PathBuf;
use std::process::Command;
use unrender::scene::Scene;

/// The least share of Embree's rays per second.
const GOAL: f64 = 0.9;
/// The goal for the time to build the tree over a million triangles, seconds.
const BUILD_GOAL: f64 = 2.0;

/// Measures, and returns the section.
///
/// # Errors
/// If Figure 8 is not there.
pub(crate) fn measure(effort: Effort) -> Result<Section, Failure> {
    let embree = library().and_then(|path| Embree::load(&path));
    if let Err(problem) = &embree {
        eprintln!("Embree is not available here: {problem}");
    }
    let embree = embree.ok();
    let room = |triangles| scenes::room(Room { triangles, panels: 1 });
    let mut scenes = vec![("Figure 8".to_owned(), scenes::figure8()?)];
    scenes.push(("room, 100k".to_owned(), room(100_000)));
    if effort == Effort::Full {
        scenes.push(("room, 1M".to_owned(), room(1_000_000)));
    }
    let (mut rows, mut builds) = (Vec::new(), Vec::new());
    for (name, scene) in &scenes {
        let (measured, build) = one_scene(name, scene, embree.as_ref(), effort);
        rows.extend(measured);
        builds.push(build);
    }
    let text = text(&rows, &builds, embree.as_ref());
    Ok(Section { text, plots: Vec::new() })
}

/// Embree's library in its Python package from PyPI.
fn library() -> Result<PathBuf, String> {
    let python = peers::python("embreex", &["embreex==4.4.0.post1"])?;
    let code = "import sysconfig; print(sysconfig.get_paths()['platlib'])";
    let packages = PathBuf::from(peers::said(Command::new(python).args(["-c", code]))?);
    let folder = packages.join("embreex.libs");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let is_embree = |path: &PathBuf| path.to_string_lossy().contains("libembree");
    let mut files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    files.find(is_embree).ok_or_else(|| format!("{} has no Embree", folder.display()))
}

/// The time that trees took to build.
struct Build {
    scene: String,
    triangles: usize,
    /// Seconds: ours, then Embree's as in [`Mode::ALL`], if it is available.
    seconds: Vec<f64>,
}

fn one_scene(
    name: &str,
    scene: &Scene,
    embree: Option<&Embree>,
    effort: Effort,
) -> (Vec<Row>, Build) {
    let triangles = scenes::triangles(scene);
    let rounds = effort.pick(2, 9);
    eprintln!("{name}: {} triangles", triangles.len());
    let mut kernels: Vec<Box<dyn Kernel + '_>> = Vec::new();
    let mut seconds = vec![Vec::new(); 1 + embree.map_or(0, |_| Mode::ALL.len())];
    for _ in 0..rounds {
        kernels.clear();
        let (ours, taken) = rounds::timed(|| Ours::build(&triangles));
        seconds[0].push(taken);
        kernels.push(Box::new(ours));
        for (i, mode) in Mode::ALL.into_iter().enumerate() {
            let Some(embree) = embree else { continue };
            let (theirs, taken) = rounds::timed(|| embree.build(&triangles, mode));
            seconds[1 + i].push(taken);
            kernels.push(Box::new(theirs));
        }
    }
    let side = effort.pick(256, 1024);
    let sets = rays::sets(scene, &triangles, side);
    let rows = rounds::measure(name, &sets, &kernels, rounds);
    let seconds = seconds.into_iter().map(crate::statistics::median).collect();
    (rows, Build { scene: name.to_owned(), triangles: triangles.len(), seconds })
}

fn text(rows: &[Row], builds: &[Build], embree: Option<&Embree>) -> String {
    let versions: Vec<String> =
        embree.map(|e| format!("Embree {}", e.version())).into_iter().collect();
    format!(
        "## Rays per second\n\n\
         `traversal`. {}\n\n{}\n\
         Millions of rays per second, the median of the rounds, and the median ratio of the rounds. \
         `primary` are rays through a million points of a picture, in its order; `bounce` are \
         scattered once where those arrive, by the cosine; `shadow` go from there to the lamp and \
         ask only whether something is in between. Embree comes from the package embreex of PyPI \
         and is asked ray by ray (`rtcIntersect1`, `rtcOccluded1`), with trees of medium quality. \
         Its robust mode is the one that lets hardly any ray through between triangles; ours lets \
         none. `differ`: rays of a million that were answered otherwise by its fast and its robust \
         mode than by us, hit for miss or a distance off by a thousandth.\n\n{}\n\
         Seconds to build the trees, on all cores:\n\n{}",
        machine::sentence(&versions),
        verdicts(rows, builds).text(),
        speeds(rows).text(),
        build_times(builds).text()
    )
}

/// The claims, and whether they hold.
fn verdicts(rows: &[Row], builds: &[Build]) -> Table {
    let mut table = Table::new(["claim", "goal", "measured", "held"]);
    for set in rays::NAMES {
        for (mode, column) in Mode::ALL.into_iter().zip(0..) {
            let ratios = rows.iter().filter(|row| row.set == set).filter_map(|r| r.ratio(column));
            let mean = crate::statistics::geometric_mean(ratios);
            let [measured, held] = verdict(mean, mean >= GOAL);
            let claim = format!("{set} rays, of Embree's ({mode}), geometric mean");
            table.push([claim, format!(">= {GOAL}"), measured, held]);
        }
    }
    if let Some(build) = builds.iter().find(|build| build.triangles >= 1_000_000) {
        let [measured, held] = verdict(build.seconds[0], build.seconds[0] < BUILD_GOAL);
        let claim = "seconds to build the tree over a million triangles".to_owned();
        table.push([claim, format!("< {BUILD_GOAL}"), measured, held]);
    }
    table
}

fn speeds(rows: &[Row]) -> Table {
    let mut table = Table::new([
        "scene",
        "rays",
        "threads",
        "ours",
        "Embree, fast",
        "Embree, robust",
        "ours / fast",
        "ours / robust",
        "differ",
    ]);
    for row in rows {
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.2}"));
        let speed = |kernel: usize| number(row.speed(kernel));
        let differ: Vec<String> = row.differ.iter().map(|share| format!("{share:.0}")).collect();
        table.push([
            row.scene.clone(),
            row.set.to_owned(),
            row.threads.to_string(),
            speed(0),
            speed(1),
            speed(2),
            number(row.ratio(0)),
            number(row.ratio(1)),
            differ.join(", "),
        ]);
    }
    table
}

fn build_times(builds: &[Build]) -> Table {
    let mut table = Table::new(["scene", "triangles", "ours", "Embree, fast", "Embree, robust"]);
    for build in builds {
        let seconds = |kernel: usize| {
            build.seconds.get(kernel).map_or("-".to_owned(), |seconds| format!("{seconds:.3}"))
        };
        let triangles = build.triangles.to_string();
        table.push([build.scene.clone(), triangles, seconds(0), seconds(1), seconds(2)]);
    }
    table
}
