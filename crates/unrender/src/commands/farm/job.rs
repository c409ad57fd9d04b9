//! A rendering cut into parts for many machines: its command lines, as data.
//!
//! A task renders a range of samples, `unrender render ... --samples A..B`; the last task merges the
//! parts, `unrender merge`. Samples are numbered, and their sums exact integers, so the picture does
//! not depend on the cuts.

use crate::commands::render;
use crate::global::Global;
use crate::{Error, result_folder};
use std::ops::Range;
use std::path::{Path, PathBuf, absolute};
use unrender_formats::FileError;

/// A rendering, cut into parts.
pub(super) struct Job {
    /// The picture's name, without characters that a job's name cannot have.
    pub(super) name: String,
    /// The words of each task after `unrender render`, without samples and output.
    pub(super) words: Vec<Word>,
    /// The samples of the tasks.
    pub(super) samples: Vec<Range<u32>>,
    /// The folder of the job and its parts.
    pub(super) folder: PathBuf,
    /// The picture.
    pub(super) out: PathBuf,
}

/// A word of a command line.
pub(super) enum Word {
    /// As it stands.
    Plain(String),
    /// An input file, with its role.
    Input(&'static str, PathBuf),
}

impl Job {
    /// The job that renders `args` in `parts` parts, with its files in `folder`.
    pub(super) fn new(
        args: &render::Args,
        global: &Global,
        parts: u32,
        folder: &Path,
    ) -> Result<Self, Error> {
        let sampling = &args.sampling;
        let refused = [
            ("--time", sampling.time.is_some()),
            ("--noise", sampling.noise.is_some()),
            ("--adaptive", sampling.adaptive),
            ("--samples", sampling.samples.is_some()),
            ("--checkpoint", sampling.checkpoint.is_some()),
        ];
        if let Some((flag, _)) = refused.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Error::Request(format!(
                "{flag} cannot be cut into parts; state the samples by --spp instead"
            )));
        }
        let name = args.out.file_stem().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect(),
            words: words(args, global)?,
            samples: cut(sampling.goal().samples.end, parts),
            folder: whole(folder)?,
            out: whole(&args.out)?,
        })
    }

    /// The name of a task's part in the folder.
    pub(super) fn part(samples: &str) -> String {
        format!("part_{samples}.exr")
    }

    /// The name of a task's checkpoint in the folder, from which an interrupted task continues.
    pub(super) fn checkpoint(samples: &str) -> String {
        format!("checkpoint_{samples}.exr")
    }
}

/// The longest name of a picture in a job's name: Open Job Description takes 128 characters, and we
/// add some.
const LONGEST_NAME: usize = 100;

/// `samples` samples in at most `parts` ranges, whose lengths differ by one sample at most.
fn cut(samples: u32, parts: u32) -> Vec<Range<u32>> {
    let parts = u64::from(parts.min(samples).max(1));
    let edge = |k: u64| (u64::from(samples) * k / parts) as u32;
    (0..parts).map(|k| edge(k)..edge(k + 1)).collect()
}

/// The command line of `args`, with absolute paths.
fn words(args: &render::Args, global: &Global) -> Result<Vec<Word>, Error> {
    let mut words = Vec::new();
    let mut input = |flag: &str, what, path: &Option<PathBuf>| {
        if let Some(path) = path {
            if !flag.is_empty() {
                words.push(Word::Plain(flag.to_owned()));
            }
            words.push(Word::Input(what, whole(path)?));
        }
        Ok::<(), Error>(())
    };
    input("", "Scene", &args.scene)?;
    input("--project", "Project", &args.project)?;
    // Tasks are given files.
    let materials = args.materials.as_deref().map(result_folder::materials).transpose()?;
    input("--materials", "Materials", &materials)?;
    input("--environment", "Environment", &args.environment)?;
    let sampling = &args.sampling;
    let is_lit = args.environment.is_some();
    let values = [
        ("environment-rotation", is_lit.then(|| args.environment_rotation.to_string())),
        ("environment-scale", is_lit.then(|| args.environment_scale.to_string())),
        ("light-units", args.light_units.map(|units| units.to_string())),
        ("camera", args.camera.clone()),
        ("width", args.width.map(|n| n.to_string())),
        ("height", args.height.map(|n| n.to_string())),
        ("seed", Some(sampling.seed.to_string())),
        ("bounces", sampling.bounces.map(|n| n.to_string())),
        ("threads", global.threads.map(|n| n.to_string())),
        ("input-memory", global.input_memory.map(|gib| gib.to_string())),
    ];
    let values =
        values.into_iter().filter_map(|(flag, value)| Some(format!("--{flag}={}", value?)));
    words.extend(values.map(Word::Plain));
    let switches = [
        ("independent", sampling.independent),
        ("allow-outside", global.allow_outside),
        ("allow-missing", global.allow_missing),
    ];
    let switches = switches.into_iter().filter(|(_, is_on)| *is_on);
    words.extend(switches.map(|(flag, _)| Word::Plain(format!("--{flag}"))));
    Ok(words)
}

/// `path` as an absolute path, so that it is valid wherever a task is started.
fn whole(path: &Path) -> Result<PathBuf, Error> {
    let path = absolute(path).map_err(|error| FileError::because(path, "is no path", error))?;
    if path.to_str().is_none() {
        let problem = "is not UTF-8, which jobs are written in; rename it";
        return Err(FileError::new(&path, problem).into());
    }
    Ok(path)
}

/// `path` as text; [`whole`] has checked that it is.
pub(super) fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_all_samples_and_nothing_twice() {
        for (samples, parts) in [(1, 1), (1, 16), (16, 16), (1000, 7), (u32::MAX, 1000)] {
            let cut = cut(samples, parts);
            assert_eq!(cut.len(), parts.min(samples) as usize);
            assert_eq!((cut[0].start, cut[cut.len() - 1].end), (0, samples));
            assert!(cut.windows(2).all(|pair| pair[0].end == pair[1].start));
            let lengths = cut.iter().map(|r| r.end - r.start);
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1);
        }
    }
}
