//! The rooms of the corpus, photographed again: from two and four places, and twice from one place with lamps
//! switched.
//!
//! Each set of photographs is a project with `[[photos]]` beside that of the single photograph, recovered by the
//! command under test and scored in the same way. Standard deviations are compared by their ratios for the parameters
//! that both runs have under the right hypothesis.

use super::generate::Plan;
use super::photograph::{self, SampleBudget};
use super::recover::{self, Subject};
use super::score::{self, GroupScore, Verdict, wilson};
use super::spoil::Dial;
use super::store::{Folder, Format, Meta};
use super::{make, photograph::Photograph, summary};
use crate::Failure;
use crate::table::Table;
use crate::{machine, page};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use unrender::formats::{atomic, picture};
use unrender::scene::{Camera, Rgb, Scene};

/// The noise to which the further photographs are rendered, and the most samples: those of the
/// corpus.
const BUDGET: SampleBudget = SampleBudget { noise: 0.02, spp_max: 320 };

/// One of several photographs: its file, its camera, and the lamp that is off.
#[derive(Clone)]
struct Shot {
    file: String,
    camera: String,
    off: Option<String>,
}

/// A set of photographs.
struct Set {
    name: &'static str,
    shots: Vec<Shot>,
}

/// One set, recovered and scored.
pub(crate) struct Row {
    pub(crate) seed: u64,
    pub(crate) set: &'static str,
    pub(crate) photographs: usize,
    pub(crate) seconds: f64,
    pub(crate) groups: Vec<GroupScore>,
    /// The median, over the parameters of right groups, of the standard deviation over that with one
    /// photograph.
    pub(crate) shrunk: Option<f64>,
    pub(crate) failure: Option<String>,
}

/// Photographs the room of `plan` again, recovers from each set by `subject`, and scores the results.
///
/// # Errors
/// If a renderer fails, or a file cannot be read or written.
pub(crate) fn run(
    plan: &Plan,
    folder: &Folder,
    meta: &Meta,
    subject: &Subject,
) -> Result<Vec<Row>, Failure> {
    let cameras = cameras(plan);
    write_cameras(plan, folder, &cameras)?;
    let taken = make::kept(folder, meta)?;
    let mut rows = Vec::new();
    let mut alone = None;
    for set in sets(plan, &cameras) {
        for shot in &set.shots {
            take(plan, folder, shot, &cameras)?;
        }
        let row = recovered(plan, (folder, meta), subject, (&set, &taken), alone.as_deref())?;
        if set.shots.len() == 1 {
            alone = Some(run_folder(folder, subject, &set));
        }
        eprintln!("{}", row.text());
        rows.push(row);
    }
    Ok(rows)
}

impl Row {
    /// The line that is printed.
    pub(crate) fn text(&self) -> String {
        let (right, all) = summary::right(self.groups.iter());
        let (within, numbers) = summary::covered(self.groups.iter());
        let shrunk = self.shrunk.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
        format!(
            "{} {}: {right} of {all} right, {within} of {numbers} parameters within two \
             deviations, deviations {shrunk} of those with one photograph, {:.1} s{}",
            self.seed,
            self.set,
            self.seconds,
            self.failure.as_ref().map_or(String::new(), |why| format!(", failed: {why}"))
        )
    }
}

const HEAD: &str = "# Several photographs

Rooms of [the corpus](corpus.md), photographed again by Mitsuba: from two and four places, and twice from one place with
a lamp off the second time. Each set is a project with `[[photos]]`. Right groups and errors are counted among the
groups that the first photograph of a room shows, so that the rows are comparable. `deviations` is the median, over the
parameters of right groups, of the standard deviation over that with one photograph. The noise of each photograph and
the scores are as in the corpus.

```console
cargo run --release -p unrender-benches -- corpus --several --seeds 881003..881006 \\
    --renderer mitsuba --out several --page docs/validation/several.md
```
";

/// Writes the page at `path`.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(path: &Path, rows: &[Row]) -> Result<(), Failure> {
    let mut rooms = Table::new(["room", "photographs", "groups right", "deviations", "seconds"]);
    for row in rows {
        let (right, all) = summary::right(row.groups.iter());
        rooms.push([
            row.seed.to_string(),
            row.set.to_owned(),
            row.failure.clone().unwrap_or_else(|| format!("{right} of {all}")),
            row.shrunk.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
            format!("{:.0}", row.seconds),
        ]);
    }
    let text = format!("{}\n\n{}\n{}", machine::origin(), table(rows), rooms.text());
    let name = "several";
    let before = std::fs::read_to_string(path).unwrap_or_default();
    // The text below the section is written by hand.
    let below = before.split_once("<!-- end of several -->\n").map_or("", |(_, below)| below);
    let page = page::replace(HEAD, &before, &[name.to_owned()], name, &text);
    Ok(atomic::write(path, format!("{page}{below}").as_bytes())?)
}

/// The results of all rooms, a line per set.
fn table(rows: &[Row]) -> String {
    let mut table = Table::new([
        "photographs",
        "rooms",
        "groups right",
        "rho_d off, median and 95 %",
        "within two deviations",
        "deviations, of those with one",
        "seconds, of those with one",
    ]);
    let alone = |seed: u64| rows.iter().find(|row| row.seed == seed && row.photographs == 1);
    for set in ["one", "two", "four", "switched"] {
        let of_set = || rows.iter().filter(|row| row.set == set);
        let groups = || of_set().flat_map(|row| &row.groups);
        let (right, all) = summary::right(groups());
        let (within, numbers) = summary::covered(groups());
        let rho_d = summary::rho_d(groups().filter(|group| group.verdict.is_right()));
        let times = of_set().filter_map(|row| Some(row.seconds / alone(row.seed)?.seconds));
        let shrunk: Vec<f64> = of_set().filter_map(|row| row.shrunk).collect();
        let at = |values: &[f64], share: f64, digits: usize| {
            let value = wilson::quantile(values, share);
            value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
        };
        table.push([
            set.to_owned(),
            of_set().count().to_string(),
            format!("{right} of {all}"),
            format!("{}, {}", at(&rho_d, 0.5, 4), at(&rho_d, 0.95, 3)),
            wilson::text(within, numbers),
            at(&shrunk, 0.5, 2),
            at(&times.collect::<Vec<_>>(), 0.5, 2),
        ]);
    }
    table.text().to_owned()
}

/// The plan's two cameras, one between them and higher, and one that is nearer to the first one's target.
fn cameras(plan: &Plan) -> Vec<Camera> {
    let [first, second] = &plan.cameras;
    let (a, b) = (first.origin(), second.origin());
    let forward = first.world_from_camera.transform_vector3(-glam::Vec3::Z).normalize();
    let target = a + 2.0 * forward;
    let from = |name: &str, eye: glam::Vec3| {
        let looking = Camera::look_at(name, eye, target, glam::Vec3::Y, first.fov_y_rad);
        Camera { aspect: first.aspect, ..looking }
    };
    let between = 0.5 * (a + b) + 0.25 * glam::Vec3::Y;
    let nearer = a + 0.3 * forward + 0.15 * (a - b).normalize_or_zero();
    vec![
        first.clone(),
        second.clone(),
        from("third_camera", between),
        from("fourth_camera", nearer),
    ]
}

fn sets(plan: &Plan, cameras: &[Camera]) -> Vec<Set> {
    let shot = |k: usize| Shot {
        file: if k == 0 { Format::Exr.file().to_owned() } else { format!("photo_{}.exr", k + 1) },
        camera: cameras[k].name.clone(),
        off: None,
    };
    let mut sets = vec![
        Set { name: "one", shots: vec![shot(0)] },
        Set { name: "two", shots: vec![shot(0), shot(1)] },
        Set { name: "four", shots: (0..4).map(shot).collect() },
    ];
    let lamps = &plan.lights.lamps;
    if let [one, _, ..] = &lamps[..] {
        let off = Shot {
            file: "photo_off.exr".to_owned(),
            camera: cameras[0].name.clone(),
            off: Some(one.name.clone()),
        };
        sets.push(Set { name: "switched", shots: vec![shot(0), off] });
    }
    sets
}

/// The scene file has the corpus' cameras; a copy of it has the further ones too.
fn write_cameras(plan: &Plan, folder: &Folder, cameras: &[Camera]) -> Result<(), Failure> {
    let mut scene = plan.scene();
    scene.cameras = cameras.to_vec();
    super::store::write_neutral(&folder.path("scene_several.glb"), &scene)
}

fn take(plan: &Plan, folder: &Folder, shot: &Shot, cameras: &[Camera]) -> Result<(), Failure> {
    let path = folder.path(&shot.file);
    if path.exists() {
        return Ok(());
    }
    let mut scene: Scene = plan.scene();
    for group in &mut scene.groups {
        if Some(&group.name) == shot.off.as_ref() {
            group.emission = Rgb::ZERO;
        }
    }
    let Some(camera) = cameras.iter().find(|camera| camera.name == shot.camera) else {
        return Err(format!("there is no camera {}", shot.camera).into());
    };
    let work = folder.path("work");
    let taken = photograph::take(plan, &scene, camera, plan.style.renderer, BUDGET, &work)?;
    picture::write_exr(&path, &taken.mean())?;
    let _ = std::fs::remove_dir_all(&work);
    Ok(())
}

fn run_folder(folder: &Folder, subject: &Subject, set: &Set) -> std::path::PathBuf {
    folder.path("runs").join(format!("several_{}_{}", set.name, subject.key))
}

fn recovered(
    plan: &Plan,
    (folder, meta): (&Folder, &Meta),
    subject: &Subject,
    (set, taken): (&Set, &Photograph),
    alone: Option<&Path>,
) -> Result<Row, Failure> {
    let project = folder.path(&format!("several_{}.toml", set.name));
    atomic::write(&project, text(plan, set).as_bytes())?;
    let run = run_folder(folder, subject, set);
    let outcome = recover::recover_at(&project, &run, subject, false)?;
    let mut groups = Vec::new();
    if outcome.failure.is_none() {
        // The score uses the first photograph.
        let rerendered = run.join("rerendered_1.exr");
        if rerendered.exists() && !run.join("rerendered.exr").exists() {
            std::fs::copy(&rerendered, run.join("rerendered.exr"))?;
        }
        groups = score::score(plan, folder, meta, Format::Exr, &run, taken)?;
    }
    let shrunk = match alone {
        Some(alone) if outcome.failure.is_none() => shrunk(&groups, alone, &run)?,
        _ => None,
    };
    Ok(Row {
        seed: plan.seed,
        set: set.name,
        photographs: set.shots.len(),
        seconds: outcome.seconds,
        groups,
        shrunk,
        failure: outcome.failure,
    })
}

/// The project of a set: that of the single photograph, with the set's photographs in its place.
fn text(plan: &Plan, set: &Set) -> String {
    let one = super::store::project(plan, &plan.given(), Format::Exr, Dial::Exact, 1.0);
    let is_of_photograph =
        |line: &&str| ["scene =", "photo =", "camera ="].iter().any(|key| line.starts_with(key));
    let rest: Vec<&str> = one.lines().filter(|line| !is_of_photograph(line)).collect();
    let mut text = format!("scene = \"scene_several.glb\"\n{}\n", rest.join("\n"));
    for shot in &set.shots {
        let _ =
            write!(text, "\n[[photos]]\nphoto = \"{}\"\ncamera = \"{}\"\n", shot.file, shot.camera);
        if let Some(off) = &shot.off {
            let _ = writeln!(text, "lights_off = [\"{off}\"]");
        }
    }
    text
}

/// The median of the ratios of the standard deviations in `run` to those in `alone`, of groups that are right in the first
/// and have the same hypothesis in both.
fn shrunk(groups: &[GroupScore], alone: &Path, run: &Path) -> Result<Option<f64>, Failure> {
    let read = |folder: &Path| -> Result<Value, Failure> {
        Ok(serde_json::from_str(&std::fs::read_to_string(folder.join("materials.json"))?)?)
    };
    let [before, after] = [read(alone)?, read(run)?];
    let mut ratios = Vec::new();
    for group in groups.iter().filter(|group| group.verdict == Verdict::Right) {
        let [a, b] = [&before, &after].map(|file| &file["groups"][&group.group]);
        if a["hypothesis"] != b["hypothesis"] {
            continue;
        }
        for key in ["rho_d", "rho_s", "alpha_x", "alpha_y", "theta_deg"] {
            let numbers = |entry: &Value| match &entry["std"][key] {
                Value::Array(list) => list.iter().filter_map(Value::as_f64).collect(),
                one => Vec::from_iter(one.as_f64()),
            };
            let both = numbers(a).into_iter().zip(numbers(b));
            ratios.extend(both.filter(|(a, b)| *a > 0.0 && *b > 0.0).map(|(a, b)| b / a));
        }
    }
    Ok(wilson::quantile(&ratios, 0.5))
}
