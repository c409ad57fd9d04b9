//! One run with its scores, kept beside its results.

use super::family::Renderer;
use super::generate::Plan;
use super::make;
use super::recover::{self, Outcome, Wanted};
use super::relight::{self, Relit};
use super::score::{self, GroupScore};
use super::spoil::Dial;
use super::store::{Folder, Format, Meta};
use crate::Failure;
use serde::{Deserialize, Serialize};
use unrender::formats::atomic;

/// Scores of other versions are computed again.
const VERSION: u32 = 1;

/// A run, scored.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Scored {
    version: u32,
    pub(crate) seed: u64,
    pub(crate) renderer: Renderer,
    pub(crate) brdf: String,
    pub(crate) format: Format,
    pub(crate) dial: Dial,
    pub(crate) noise: f64,
    pub(crate) outcome: Outcome,
    pub(crate) groups: Vec<GroupScore>,
    /// The tests in new light and from a new viewpoint, if requested.
    pub(crate) relit: Option<Relit>,
}

/// Recovers from one photograph and scores the results; both are kept.
///
/// # Errors
/// If files cannot be read or the command cannot be started.
pub(crate) fn run(
    plan: &Plan,
    scene: &Folder,
    meta: &Meta,
    (format, dial): (Format, Dial),
    wanted: Wanted<'_>,
) -> Result<Scored, Failure> {
    let (folder, outcome) = recover::recover(scene, wanted.subject, (format, dial), wanted.again)?;
    let record = folder.join("score.json");
    let known = std::fs::read_to_string(&record).ok();
    let known = known.and_then(|text| serde_json::from_str::<Scored>(&text).ok());
    let is_whole =
        |known: &Scored| known.version == VERSION && (known.relit.is_some() || !wanted.relight);
    if let Some(known) = known.filter(is_whole) {
        return Ok(known);
    }
    let photograph = make::kept(scene, meta)?;
    let groups = match &outcome.failure {
        None => score::score(plan, scene, meta, format, &folder, &photograph)?,
        Some(_) => Vec::new(),
    };
    let relit = match (&outcome.failure, wanted.relight) {
        (None, true) => Some(relight::relight(plan, scene, (format, dial), wanted, &folder)?),
        _ => None,
    };
    let scored = Scored {
        version: VERSION,
        seed: plan.seed,
        renderer: plan.style.renderer,
        brdf: meta.brdf.clone(),
        format,
        dial,
        noise: meta.rendering_noise,
        outcome,
        groups,
        relit,
    };
    atomic::write(&record, serde_json::to_string_pretty(&scored)?.as_bytes())?;
    Ok(scored)
}

#[cfg(test)]
impl Scored {
    /// A run for tests.
    pub(crate) fn example(
        (seed, renderer, format, dial): (u64, Renderer, Format, Dial),
        outcome: Outcome,
        groups: Vec<GroupScore>,
    ) -> Self {
        let (brdf, relit) = ("ward-gmd".to_owned(), None);
        let noise = 0.02;
        Self { version: VERSION, seed, renderer, brdf, format, dial, noise, outcome, groups, relit }
    }
}
