//! Runs the built command on an example and checks the score of its result against limits.

use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::scene::{Image, Rgb, RgbImage};

/// The largest errors that an example's result may have.
pub(crate) struct Limits {
    pub(crate) rho: f64,
    pub(crate) alpha_percent: f64,
    pub(crate) degrees: f64,
}

/// The folder `name` beside the crates.
pub(crate) fn beside_crates(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// The picture with pixels `times` by `times` as large: their radiance is the mean.
pub(crate) fn shrunk(picture: &RgbImage, times: usize) -> RgbImage {
    Image::from_fn(picture.width() / times, picture.height() / times, |x, y| {
        let at = |i: usize| *picture.at(times * x + i % times, times * y + i / times);
        let count = times * times;
        (0..count).map(at).sum::<Rgb>() / count as f32
    })
}

/// Recovers the project `file` in `folder`, with `flags`, and scores it against the folder's
/// truth.json.
///
/// # Panics
/// If the recovery fails, a hypothesis is wrong, or an error is above `limits`.
pub(crate) fn recovers(folder: &Path, file: &str, flags: &[&str], limits: &Limits) {
    let mut limited = Vec::new();
    for (flag, limit) in [
        ("--max-rho", limits.rho),
        ("--max-alpha-percent", limits.alpha_percent),
        ("--max-degrees", limits.degrees),
    ] {
        limited.extend([flag.to_owned(), limit.to_string()]);
    }
    println!("{file}\n{}", scored(folder, file, flags, &limited));
}

/// The largest errors of the same over its groups.
///
/// # Panics
/// If the recovery fails or a hypothesis is wrong.
pub(crate) fn errors_of(folder: &Path, file: &str, flags: &[&str]) -> Limits {
    let scored = scored(folder, file, flags, &["--json".to_owned()]);
    let scored: serde_json::Value = serde_json::from_str(&scored).unwrap();
    let groups = scored["groups"].as_array().unwrap();
    for of in groups {
        assert_eq!(of["hypothesis"], of["true_hypothesis"], "{file}: {}", of["group"]);
    }
    let largest = |what: &str| groups.iter().filter_map(|of| of[what].as_f64()).fold(0.0, f64::max);
    let rho = largest("rho_d").max(largest("rho_s"));
    Limits { rho, alpha_percent: largest("alpha_percent"), degrees: largest("degrees") }
}

/// What `score` with these flags prints of the recovery.
fn scored(folder: &Path, file: &str, flags: &[&str], of_score: &[String]) -> String {
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("out");
    let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
    recover.arg("recover").arg(folder.join(file)).arg("--out").arg(&out).arg("--quiet");
    recover.args(flags);
    assert!(recover.status().unwrap().success(), "{file} was not recovered");
    let mut score = Command::new(env!("CARGO_BIN_EXE_unrender"));
    score.arg("score").arg(&out).arg(folder.join("truth.json")).args(of_score);
    let scored = score.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (table, wrong) = (text(&scored.stdout), text(&scored.stderr));
    assert!(scored.status.success(), "{file}:\n{table}\n{wrong}");
    table
}
