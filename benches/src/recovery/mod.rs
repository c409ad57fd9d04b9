//! The time to recover Figure 8: ours, and that of a general differentiable renderer.
//!
//! Ours is the command from its start to its end, on the whole photograph. Mitsuba descends on the
//! photograph at half the size, which has a quarter of the pixels, and is told that all groups
//! except one are diffuse; its clock stops when its errors are within twice ours.

mod descent;

use crate::command::Unrender;
use crate::page::Section;
use crate::plot::{self, Axes, Curve};
use crate::scenes;
use crate::table::{Table, verdict};
use crate::{Effort, Failure, machine, peers, root};
use descent::Descent;
use std::path::Path;
use unrender::formats::materials::StatusEntry;
use unrender::formats::materials::{self, GroupEntry, MaterialsFile};
use unrender::formats::picture;
use unrender::run::{GroupIterationEntry, IterationEntry, Run};
use unrender::scene::Status;
use unrender::score::{self, GroupScore, Limits, Worst};

/// Recoveries may take this many renderings of [`SPP`].
const RENDERINGS: f64 = 6.0;
const SPP: u32 = 256;
/// The largest allowed share of Mitsuba's time.
const GOAL: f64 = 1.0 / 20.0;
/// The largest allowed errors; Mitsuba may have twice these.
pub(crate) const LIMITS: Limits =
    Limits { rho: Some(0.005), alpha_percent: Some(2.0), degrees: Some(0.5) };

/// The measurements of our recovery.
struct Ours {
    seconds: Vec<f64>,
    renderings: Vec<f64>,
    run: Run,
    worst: Worst,
    /// Whether the result is within [`LIMITS`].
    is_within: bool,
    /// The time from which on the estimates were within them, seconds.
    first_within: Option<f64>,
}

/// Measures, and returns the section.
///
/// # Errors
/// If our command fails.
pub(crate) fn measure(effort: Effort) -> Result<Section, Failure> {
    let command = Unrender::build()?;
    let folder = peers::work_folder("recovery");
    std::fs::create_dir_all(&folder)?;
    let mut ours = ours(&command, &folder, effort)?;
    let descents = match theirs(&folder, effort) {
        Ok(descents) => descents,
        Err(problem) => {
            eprintln!("not measured: {problem}");
            Vec::new()
        }
    };
    // Again after theirs, so that both used the machine at about the same time.
    if effort == Effort::Full {
        let again = self::ours(&command, &folder, effort)?;
        ours.seconds.extend(again.seconds);
        ours.renderings.extend(again.renderings);
    }
    let plot = draw(&ours, &descents)?;
    let text = text(&ours, &descents);
    Ok(Section { text, plots: vec![("performance-recovery.svg".to_owned(), plot)] })
}

/// A rendering, a recovery, and another rendering.
fn ours(command: &Unrender, folder: &Path, effort: Effort) -> Result<Ours, Failure> {
    let fig8 = root().join("examples/fig8");
    let truth_file = fig8.join("truth.json");
    let truth = materials::read(&truth_file)?;
    let photo = picture::read(&fig8.join("photo.exr"))?.0.values;
    let size = (photo.width(), photo.height());
    let truth_flag = truth_file.to_string_lossy().into_owned();
    let rendering = || {
        let out = folder.join("rendered.exr");
        let flags = ["--independent", "--materials", truth_flag.as_str()];
        command.render(&fig8.join("scene.glb"), size, SPP, &out, &flags)
    };
    let first = rendering()?;
    let out = folder.join("out");
    let flags: &[&str] = effort.pick(&["--no-refine"], &[]);
    let (seconds, run) = command.recover(&fig8.join("fig8.toml"), &out, flags)?;
    let renderings = vec![first, rendering()?];
    eprintln!("unrender: {seconds:.1} s; rendering {renderings:.1?} s");
    let found = materials::read(&out.join("materials.json"))?;
    let scores = score::score(&found, &out, &truth, &fig8)?;
    let is_close =
        |iteration: &IterationEntry| LIMITS.exceeded(&scores_of(iteration, &truth)).is_empty();
    Ok(Ours {
        seconds: vec![seconds],
        renderings,
        first_within: within_from(&run.iterations, is_close),
        worst: score::worst(&scores),
        is_within: LIMITS.exceeded(&scores).is_empty(),
        run,
    })
}

/// The time of the iteration from which on all are within the limits.
fn within_from(
    iterations: &[IterationEntry],
    is_close: impl Fn(&IterationEntry) -> bool,
) -> Option<f64> {
    let far = iterations.iter().rposition(|iteration| !is_close(iteration));
    iterations.get(far.map_or(0, |last| last + 1)).map(|iteration| iteration.seconds)
}

/// The largest error of a reflectance.
fn rho(worst: &Worst) -> Option<f64> {
    [worst.rho_d, worst.rho_s].into_iter().flatten().reduce(f64::max)
}

/// The state of a recovery after an iteration, compared with the truth.
fn scores_of(iteration: &IterationEntry, truth: &MaterialsFile) -> Vec<GroupScore> {
    let entry = |group: &GroupIterationEntry| GroupEntry {
        hypothesis: Some(group.hypothesis),
        status: Some(StatusEntry::Of(Status::Recovered)),
        rho_d: Some(group.rho_d),
        rho_s: Some(group.rho_s),
        alpha_x: Some(group.alpha_x),
        alpha_y: Some(group.alpha_y),
        theta_deg: Some(group.theta_deg),
        ..GroupEntry::default()
    };
    let groups =
        iteration.groups.iter().map(|(name, group)| (name.clone(), entry(group))).collect();
    let found = MaterialsFile { groups, ..MaterialsFile::default() };
    // Figure 8 has no textures; their files would be in these folders.
    let here = Path::new(".");
    let mut scores = score::score(&found, here, truth, here).unwrap_or_default();
    scores.retain(|score| iteration.groups.contains_key(&score.group));
    scores
}

/// One descent per learning rate.
fn theirs(folder: &Path, effort: Effort) -> Result<Vec<Descent>, Failure> {
    let rates: &[f64] = effort.pick(&[0.02], &[0.02, 0.04]);
    let scene = scenes::figure8()?;
    let python = peers::mitsuba::python()?;
    let give_up = effort.pick(20.0, 900.0);
    rates.iter().map(|rate| descent::run(&python, &scene, folder, *rate, give_up)).collect()
}

/// The seconds that the best descent took, and whether it arrived.
fn best(descents: &[Descent]) -> Option<(f64, bool)> {
    let arrived = descents.iter().filter_map(|d| d.arrived).reduce(f64::min);
    match arrived {
        Some(seconds) => Some((seconds, true)),
        None => descents.iter().map(|d| (d.gave_up(), false)).next(),
    }
}

fn draw(ours: &Ours, descents: &[Descent]) -> Result<String, Failure> {
    let truth = materials::read(&root().join("examples/fig8/truth.json"))?;
    let worst = |iteration: &IterationEntry| -> Option<(f64, f64)> {
        let worst = score::worst(&scores_of(iteration, &truth));
        let share = descent::share(rho(&worst)?, worst.alpha_percent?, worst.degrees?);
        Some((iteration.seconds, share))
    };
    let mut curves = vec![Curve {
        label: "unrender".to_owned(),
        points: ours.run.iterations.iter().filter_map(worst).collect(),
    }];
    curves.extend(descents.iter().map(|descent| Curve {
        label: format!("Mitsuba, Adam at {}", descent.rate),
        points: descent.errors.clone(),
    }));
    curves.retain(|curve| !curve.points.is_empty());
    let axes = Axes {
        title: "Recovery of Figure 8",
        x: "seconds",
        y: "worst error, of the one asked for",
    };
    plot::svg(&axes, &curves)
}

fn text(ours: &Ours, descents: &[Descent]) -> String {
    let median = |values: &[f64]| crate::statistics::median(values.iter().copied());
    let seconds = median(&ours.seconds);
    let rendering = median(&ours.renderings);
    let mut claims = Table::new(["claim", "goal", "measured", "held"]);
    let renderings = seconds / rendering;
    let [found, held] = verdict(renderings, renderings < RENDERINGS && ours.is_within);
    claims.push([
        format!("recovery, in our own renderings of {SPP} spp"),
        format!("< {RENDERINGS}"),
        found,
        held,
    ]);
    let best = best(descents);
    for (claim, seconds) in [
        (
            "recovery until it is and stays within the errors asked for, of Mitsuba's time",
            ours.first_within,
        ),
        ("recovery to its end, of Mitsuba's time", Some(seconds).filter(|_| ours.is_within)),
    ] {
        let share = best.zip(seconds).map_or(f64::NAN, |((theirs, _), ours)| ours / theirs);
        let [_, held] = verdict(share, share <= GOAL);
        let found = if share.is_finite() { format!("{share:.3}") } else { "-".to_owned() };
        claims.push([claim.to_owned(), "<= 0.05".to_owned(), found, held]);
    }
    let mut rows = Table::new(["", "pixels", "seconds", "rho", "alpha", "direction"]);
    let number = |value: Option<f64>, unit: &str| {
        value.map_or("-".to_owned(), |value| format!("{value:.4}{unit}"))
    };
    let pixels = format!("{} x {}", ours.run.input.width, ours.run.input.height);
    rows.push([
        "unrender, to its end".to_owned(),
        pixels.clone(),
        format!("{seconds:.1}"),
        number(rho(&ours.worst), ""),
        number(ours.worst.alpha_percent, " %"),
        number(ours.worst.degrees, " deg"),
    ]);
    let first = ours.first_within.map_or("never".to_owned(), |seconds| format!("{seconds:.1}"));
    let asked = ["<= 0.005", "<= 2 %", "<= 0.5 deg"].map(str::to_owned);
    rows.push(["unrender, within".to_owned(), pixels, first].into_iter().chain(asked));
    for descent in descents {
        rows.push(descent.row());
    }
    let versions: Vec<String> = descents.first().map(|d| d.version.clone()).into_iter().collect();
    format!(
        "## Recovery\n\n`recovery`. {}\n\n{}\n{EXPLANATION}\n{}\n\
         A rendering of the photograph's view with {SPP} paths a pixel took {rendering:.1} s; the \
         recovery's most memory was {:.0} MiB.\n\n![Recovery of Figure 8](images/performance-recovery.svg)\n",
        machine::sentence(&versions),
        claims.text(),
        rows.text(),
        ours.run.peak_memory_bytes.unwrap_or(0) as f64 / f64::from(1 << 20),
    )
}

const EXPLANATION: &str = "The largest errors of all groups against the truth. Ours is `unrender \
recover examples/fig8/fig8.toml` as a process, from reading its files to the report; `within` is \
the time in `run.json` from which on its estimates were that close; it continues, since without \
the truth this is not known. Mitsuba (`prb`, `llvm_ad_rgb`, Adam; \
`benches/peers/mitsuba_recover.py`) has the photograph at half the size, 16 paths a pixel, our \
lobe for the floor and diffuse reflectances elsewhere, and begins with reflectances of 0.5 (twice \
0.25 for the floor), roughnesses of 0.1 and 0.12, and a direction 20 degrees off. Its clock runs \
without reading, compiling and the comparison with the truth, until it is within twice our limits: \
0.01, 4 % and 1 degree. The plot has the worst of the three errors, each in units of our limit.
";
