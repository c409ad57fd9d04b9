//! Renderings as jobs for many machines: their results equal those of one run, to the bit.

use crate::kit::example::beside_crates;
use crate::kit::folder::{Folder, is_refused, stderr, succeeds};
use std::path::Path;
use std::process::{Command, Output};

/// A small Figure 8, with a name that a shell would split.
fn job(folder: &Folder, to: &str, flags: &[&str]) -> Output {
    let scene = folder.path("the scene.glb");
    std::fs::copy(beside_crates("examples/fig8/scene.glb"), scene).unwrap();
    let truth = beside_crates("examples/fig8/truth.json");
    let words = ["farm", "the scene.glb", "--materials", truth.to_str().unwrap()];
    let rest = ["--height", "24", "--seed", "3", "--out", "it's.exr", "--to", to];
    folder.run(&[&words[..], &rest, flags].concat())
}

/// A stand-in for Slurm that gives each task two processors: it runs a submitted job at once, task by task, and
/// prints a number.
const SBATCH: &str = r#"#!/bin/bash
echo "$*" >> sbatch.log
first=0 last=-1
while [[ $1 == --* ]]; do
    case $1 in --array=*) range=${1#--array=}; first=${range%-*} last=${range#*-} ;; esac
    shift
done
if [ "$last" -lt 0 ]; then "$@" 1>&2; fi
for ((k = first; k <= last; k++)); do
    SLURM_CPUS_ON_NODE=2 SLURM_ARRAY_TASK_ID=$k bash "$@" 1>&2 || exit 1
done
echo 17
"#;

/// The command; it records with how many threads it was started.
const COUNTED: &str = r#"#!/bin/bash
echo "$1 ${RAYON_NUM_THREADS:-all}" >> threads.log
exec "$COMMAND" "$@"
"#;

#[test]
fn slurm_makes_the_picture_of_one_run() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let told = job(&folder, "slurm", &["--spp", "7", "--parts", "3"]);
    succeeds(&told);
    let start = stderr(&told);
    assert!(start.contains(r"start them by: bash './it'\''s_job/job.sh'"), "{start}");
    let script = folder.path("it's_job/job.sh");
    succeeds(&Command::new("bash").arg("-n").arg(&script).output().unwrap());
    let bin = folder.path("bin");
    std::fs::create_dir(&bin).unwrap();
    let executable = std::fs::Permissions::from_mode(0o755);
    for (name, text) in [("sbatch", SBATCH), ("counted", COUNTED)] {
        std::fs::write(bin.join(name), text).unwrap();
        std::fs::set_permissions(bin.join(name), executable.clone()).unwrap();
    }
    std::fs::set_permissions(&script, executable).unwrap();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let mut submit = Command::new("bash");
    submit.current_dir(folder.root()).arg(&script).arg("--cpus-per-task=2");
    submit.env("PATH", path).env("UNRENDER", bin.join("counted"));
    submit.env("COMMAND", env!("CARGO_BIN_EXE_unrender")).env_remove("RAYON_NUM_THREADS");
    succeeds(&submit.output().unwrap());
    let log = folder.text("sbatch.log");
    let [array, merge] = log.lines().collect::<Vec<_>>()[..] else { panic!("{log}") };
    assert!(array.contains("--array=0-2") && array.contains("--cpus-per-task=2"), "{array}");
    assert!(merge.contains("--dependency=afterok:17"), "{merge}");
    let threads = folder.text("threads.log");
    assert_eq!(threads, "render 2\nrender 2\nrender 2\nmerge all\n");
    is_the_picture_of_one_run(&folder);
}

fn is_the_picture_of_one_run(folder: &Folder) {
    let truth = beside_crates("examples/fig8/truth.json");
    let words = ["render", "the scene.glb", "--materials", truth.to_str().unwrap()];
    let rest = ["--height", "24", "--seed", "3", "--spp", "7", "--out", "whole.exr"];
    succeeds(&folder.run(&[&words[..], &rest].concat()));
    assert!(folder.bytes("it's.exr") == folder.bytes("whole.exr"), "the job's picture differs");
}

#[test]
fn a_template_of_open_job_description_names_inputs_and_depends() {
    let folder = Folder::new();
    succeeds(&job(&folder, "openjd", &["--spp", "100", "--job", "."]));
    let text = folder.text("template.json");
    let template: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(template["specificationVersion"], "jobtemplate-2023-09");
    let parameters = template["parameterDefinitions"].as_array().unwrap();
    let named = |name: &str| parameters.iter().find(|p| p["name"] == name).unwrap();
    assert_eq!(named("Scene")["default"], "the scene.glb");
    assert_eq!(named("Materials")["default"], serde_json::Value::Null);
    let text = folder.text("parameters.json");
    let values: serde_json::Map<_, _> = serde_json::from_str(&text).unwrap();
    assert_eq!(values.keys().collect::<Vec<_>>(), ["Materials"]);
    assert!(Path::new(values["Materials"].as_str().unwrap()).is_absolute());
    assert_eq!(named("Picture")["default"], "it's.exr");
    let [render, merge] = &template["steps"].as_array().unwrap()[..] else { panic!("{text}") };
    let samples = &render["parameterSpace"]["taskParameterDefinitions"][0]["range"];
    assert_eq!(samples.as_array().unwrap().len(), 16);
    assert_eq!((&samples[0], &samples[15]), (&"0..6".into(), &"93..100".into()));
    assert_eq!(merge["dependencies"][0]["dependsOn"], "Render");
}

#[test]
fn what_cannot_be_cut_beforehand_is_refused() {
    let folder = Folder::new();
    for (flags, problem) in [
        (&["--noise", "0.1"][..], "--noise cannot be cut into parts"),
        (&["--checkpoint", "c.exr"], "--checkpoint cannot be cut"),
        (&["--adaptive"], "--adaptive cannot be cut"),
        (&["--parts", "1001"], "1001 is not in 1..=1000"),
    ] {
        let output = job(&folder, "openjd", flags);
        is_refused(&output, problem);
        assert!(!folder.path("it's_job").exists());
    }
}
