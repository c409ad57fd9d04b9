//! `unrender plan`: which photograph to take next.

use crate::commands::recover::Effort;
use crate::global::Global;
use crate::interrupt::Pausable;
use crate::plan::{Prediction, RecoveredJob, candidates};
use crate::progress::Progress;
use crate::project::CameraTable;
use crate::{Error, Job, Project, interrupt, result_folder, text_table};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::{Input, materials};
use unrender_recover::{IterationRecord, Observer, Options};

/// Suggests which photograph to take next, after a recovery.
///
/// Candidates are the scene's cameras that took no photograph yet, a ring of cameras about what the first photograph
/// shows, and that photograph again with a lamp off. Each is rendered with the recovered materials, gets the noise of
/// the first photograph, and joins the others in one refinement: its standard deviations over the present ones say
/// what it would add. The prediction is only as right as the recovered materials.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender plan room/project.toml --recovered room/result\n  \
    unrender plan room/project.toml --recovered room/result --json")]
pub struct Args {
    /// The project file.
    pub project: PathBuf,
    /// The folder with the results of `recover`.
    #[arg(long, value_name = "DIR")]
    pub recovered: PathBuf,
    /// How much work to spend on each candidate.
    #[arg(long, value_enum, default_value_t = Effort::Draft)]
    pub effort: Effort,
    /// Chooses the noise of the renderings; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let (mut project, warnings) = Project::read(&args.project)?;
    project.limits = global.limits();
    let path = result_folder::materials(&args.recovered)?;
    let mut job = Job::load(project, warnings)?;
    let input = Input::new(&path, global.limits());
    let noted = materials::apply_from(input, &mut job.scene)?;
    global.console.warn(&job.warnings);
    global.console.warn(&noted);
    let found = materials::read(input)?;
    let recovered = RecoveredJob::new(job, &found);
    let options =
        Options { seed: args.seed, effort: args.effort.of_recovery(), ..Options::default() };
    let (progress, pausable) = (Progress::new("plan", global), Pausable::new());
    let candidates = candidates(&recovered);
    let steps = candidates.len() as f64 + 1.0;
    let mut step = Step { progress: &progress, pausable: &pausable, done: 0.0, steps };
    let now = recovered.known_now(&options, &mut step)?;
    let mut predictions = Vec::with_capacity(candidates.len());
    for (k, candidate) in candidates.into_iter().enumerate() {
        step.done = k as f64 + 1.0;
        let with = recovered.known_with(&candidate, &options, &mut step)?;
        if step.is_cancelled() {
            return Ok(interrupt::code());
        }
        predictions.push(Prediction::new(candidate, &now, &with));
    }
    drop(progress);
    predictions.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let text = if args.json { as_json(&recovered, &predictions)? } else { table(&predictions) };
    global.console.print(&text);
    Ok(ExitCode::SUCCESS)
}

/// One refinement of several.
struct Step<'a> {
    progress: &'a Progress,
    pausable: &'a Pausable,
    done: f64,
    steps: f64,
}

impl Observer for Step<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.working("refining with it", record.done);
    }

    fn working(&self, what: &str, done: f64) {
        self.progress.work_on(what, (self.done + done) / self.steps);
    }

    fn is_cancelled(&self) -> bool {
        self.pausable.is_asked() || self.progress.is_cancelled()
    }
}

/// The candidates, the best first; and for each group the one that would determine it best.
fn table(predictions: &[Prediction]) -> String {
    if predictions.is_empty() {
        return "there are no candidates: no other camera in the scene, no free place around it, and only one lamp\n"
            .to_owned();
    }
    let mut rows = vec![["photograph", "deviations, of now", "tells most of"].map(str::to_owned)];
    for prediction in predictions {
        let mut groups: Vec<_> =
            prediction.groups.iter().filter_map(|g| Some((g.ratio?, g.name.as_str()))).collect();
        groups.sort_by(|a, b| a.0.total_cmp(&b.0));
        let most: Vec<String> =
            groups.iter().take(3).map(|(ratio, name)| format!("{name} {ratio:.2}")).collect();
        rows.push([
            prediction.candidate.name.clone(),
            format!("{:.2}", prediction.ratio),
            most.join(", "),
        ]);
    }
    let mut text = text_table::table(&rows);
    let groups = predictions[0].groups.iter().map(|group| &group.name);
    for name in groups {
        let of = |prediction: &Prediction| {
            let group = prediction.groups.iter().find(|group| group.name == *name)?.clone();
            Some((group, prediction.candidate.name.clone()))
        };
        let all: Vec<_> = predictions.iter().filter_map(of).collect();
        if let Some((_, what)) = all.iter().find(|(group, _)| group.is_new) {
            text.push_str(&format!("{name}: no photograph shows it; {what} would\n"));
            continue;
        }
        let ratio = |of: &&(crate::plan::GroupPrediction, String)| of.0.ratio.unwrap_or(1.0);
        let best = all.iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        if let Some(of) = best.filter(|of| ratio(of) < 1.0) {
            text.push_str(&format!(
                "{name}: {} brings most, {:.2} of its deviations\n",
                of.1,
                ratio(&of)
            ));
        }
    }
    text
}

fn as_json(recovered: &RecoveredJob, predictions: &[Prediction]) -> Result<String, Error> {
    let origin = recovered.job().scene.origin;
    let names: Vec<(usize, String)> =
        recovered.job().scene.sources().map(|s| (s.index, s.name.to_owned())).collect();
    let one = |prediction: &Prediction| -> Value {
        let camera = CameraTable::of(&prediction.candidate.camera, 1.0, origin);
        let is_off = |index: &usize| prediction.candidate.off.contains(&(*index as u32));
        let off: Vec<&String> =
            names.iter().filter(|(index, _)| is_off(index)).map(|(_, name)| name).collect();
        let groups = prediction.groups.iter().map(|group| {
            (group.name.clone(), json!({ "ratio": group.ratio, "is_new": group.is_new }))
        });
        json!({
            "name": prediction.candidate.name,
            "ratio": prediction.ratio,
            "camera": {
                "eye": camera.eye.to_array(),
                "target": camera.target.to_array(),
                "up": camera.up.to_array(),
                "fov_y_deg": camera.fov_y_deg,
            },
            "lights_off": off,
            "groups": groups.collect::<serde_json::Map<String, Value>>(),
        })
    };
    let all: Vec<Value> = predictions.iter().map(one).collect();
    let text = serde_json::to_string_pretty(&json!({ "candidates": all }));
    let text = text.map_err(|error| Error::Request(format!("the plan cannot be written: {error}")));
    Ok(text? + "\n")
}
