//! A script for Slurm: an array of jobs, and a job that waits for it. [Slurm manual, sbatch]
//!
//! The script is also the jobs: without one of its two flags it submits itself twice.

use super::job::{Job, Word, text};
use crate::shell_word::quoted;
use std::fmt::Write;

/// The script of `job`, for bash.
pub(super) fn script(job: &Job) -> String {
    let mut samples = String::new();
    for range in &job.samples {
        let _ = write!(samples, " {range:?}");
    }
    let words = job.words.iter().map(|word| match word {
        Word::Plain(word) => quoted(word),
        Word::Input(_, path) => quoted(&text(path)),
    });
    let words: Vec<String> = words.collect();
    // The name of a value is between two marks.
    let pieces = SCRIPT.split('§').enumerate().map(|(k, piece)| match (k % 2, piece) {
        (0, text) => text.to_owned(),
        (_, "PARTS") => job.samples.len().to_string(),
        (_, "LAST") => (job.samples.len() - 1).to_string(),
        (_, "SAMPLES") => samples.trim_start().to_owned(),
        (_, "PART") => Job::part("$range"),
        (_, "CHECKPOINT") => Job::checkpoint("$range"),
        (_, "NAME") => quoted(&format!("unrender {}", job.name)),
        (_, "FOLDER") => quoted(&text(&job.folder)),
        (_, "OUT") => quoted(&text(&job.out)),
        (_, _) => words.join(" "),
    });
    pieces.collect()
}

/// The script, with marks for what differs.
const SCRIPT: &str = r#"#!/bin/bash
# Renders in §PARTS§ parts on Slurm, and puts them together:
#
#     bash job.sh [FLAGS OF sbatch, as --cpus-per-task=16 --partition=long]
#
# The variable UNRENDER names the command where it is not on the machines' path. A task that is ended
# early goes on where it stood when it is started again.
set -euo pipefail

unrender=${UNRENDER:-unrender}
name=§NAME§
folder=§FOLDER§
picture=§OUT§
samples=(§SAMPLES§)

case "${1:-}" in
--render)
    range=${samples[$SLURM_ARRAY_TASK_ID]}
    # Not every Slurm binds a task to its processors.
    export RAYON_NUM_THREADS=${SLURM_CPUS_ON_NODE:-0}
    exec "$unrender" render §WORDS§ --quiet \
        --samples "$range" --checkpoint "$folder/§CHECKPOINT§" --out "$folder/§PART§"
    ;;
--merge)
    parts=()
    for range in "${samples[@]}"; do
        parts+=("$folder/§PART§")
    done
    exec "$unrender" merge --quiet --out "$picture" "${parts[@]}"
    ;;
*)
    log=$folder/slurm-%A_%a.txt
    array=$(sbatch --parsable --job-name="$name" --array=0-§LAST§ --requeue --output="$log" \
        "$@" "$0" --render)
    sbatch --job-name="$name" --dependency="afterok:${array%%;*}" --kill-on-invalid-dep=yes \
        --output="$folder/slurm-%j.txt" "$@" "$0" --merge
    ;;
esac
"#;
