//! The journal of a recovery: what its expensive steps have found, so that one that was killed goes
//! on where it was, and ends with the same bits.
//!
//! A recovery depends on nothing but its problem and its options: run twice, it makes the same steps
//! and decisions. So what has to be kept is what takes time: the result of each rendering with the
//! arithmetic on it, one record a step, in the order in which they are made. To go on is to begin
//! again with the records at hand: where the journal knows what a step found, it is taken from there
//! (*deterministic replay*); everything between the steps, where the recovery stands in its loops and
//! all that later decisions depend on, comes about again by itself.
//!
//! The steps are: an iteration of fits, the exposure by the anchor, the candidates of one group, a
//! verification, a pass of the joint refinement, and each of the last tasks after it. A step that
//! changes the state is kept as the parts of the state that it changed. Numbers are kept as their
//! bits.
//!
//! To add a step: wrap it into `Steps::value` if it only finds something, or `State::step` if it
//! changes materials, groups, lights, exposure or the camera's numbers. It must change nothing else
//! of the state. What is not wrapped is done again, and costs time alone.

use crate::correction::Corrected;
use crate::record::LightResult;
use crate::state::State;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// Keeps what steps have found, in order.
///
/// Once the observer has said that the recovery is cancelled, the journal has to stay as it is: the
/// steps after that are not those of a recovery that goes on.
pub trait Journal: Sync {
    /// Shows `understand` what the next step found in an earlier run, and says whether it understood.
    /// False if that run did not come so far. What was not understood is dropped, with all after it.
    fn recall(&self, understand: &mut dyn FnMut(&[u8]) -> bool) -> bool;
    /// Keeps what the next step has found now.
    fn keep(&self, found: &[u8]);
}

/// The steps of a recovery, with its journal if it has one.
#[derive(Clone, Copy, Default)]
pub(crate) struct Steps<'a>(pub(crate) Option<&'a dyn Journal>);

impl Steps<'_> {
    /// What `work` finds, or found in an earlier run. `name` tells kinds of steps from each other.
    pub(crate) fn value<T: Serialize + DeserializeOwned>(
        self,
        name: &str,
        work: impl FnOnce() -> T,
    ) -> T {
        let Some(journal) = self.0 else { return work() };
        let mut recalled = None;
        journal.recall(&mut |bytes| {
            let record = postcard::from_bytes::<(&str, T)>(bytes).ok();
            recalled = record.filter(|(kind, _)| *kind == name).map(|(_, found)| found);
            recalled.is_some()
        });
        if let Some(found) = recalled {
            return found;
        }
        let found = work();
        if let Ok(bytes) = postcard::to_stdvec(&(name, &found)) {
            journal.keep(&bytes);
        }
        found
    }
}

/// What a step may change that belongs to no group.
#[derive(Serialize, Deserialize)]
struct Common {
    lights: Vec<Rgb>,
    exposure: Rgb,
    exposure_std: Option<Rgb>,
    light_results: Vec<LightResult>,
    corrected: Corrected,
}

/// The parts of a state that a step changed, by their numbers, and what it found.
#[derive(Serialize, Deserialize)]
struct Change<T> {
    parts: Vec<(usize, Vec<u8>)>,
    found: T,
}

impl State<'_> {
    /// What `work` finds, which may change the state; from the journal if that has it.
    pub(crate) fn step<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &str,
        work: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let Some(journal) = self.steps.0 else { return work(self) };
        let mut recalled = None;
        journal.recall(&mut |bytes| {
            let record = postcard::from_bytes::<(&str, Change<T>)>(bytes).ok();
            recalled = record
                .filter(|(kind, change)| *kind == name && self.take_parts(&change.parts).is_some())
                .map(|(_, change)| change.found);
            recalled.is_some()
        });
        if let Some(found) = recalled {
            return found;
        }
        let before = self.parts();
        let found = work(self);
        let after = self.parts().into_iter().enumerate();
        let parts = after.filter(|(i, part)| before.get(*i) != Some(part)).collect();
        let change = Change { parts, found };
        if let Ok(bytes) = postcard::to_stdvec(&(name, &change)) {
            journal.keep(&bytes);
        }
        change.found
    }

    /// What a step may change, part by part: materials, groups, and what belongs to none.
    fn parts(&self) -> Vec<Vec<u8>> {
        let common = Common {
            lights: self.lights.clone(),
            exposure: self.exposure,
            exposure_std: self.exposure_std,
            light_results: self.light_results.clone(),
            corrected: self.corrected.clone(),
        };
        // Plain data without maps: it can always be written.
        let materials = self.materials.iter().map(|m| postcard::to_stdvec(m).unwrap_or_default());
        let groups = self.groups.iter().map(|g| postcard::to_stdvec(g).unwrap_or_default());
        let mut parts: Vec<Vec<u8>> = materials.chain(groups).collect();
        parts.push(postcard::to_stdvec(&common).unwrap_or_default());
        parts
    }

    /// Takes over parts that a step has changed; none if one of them is not understood, and the state
    /// is as it was then.
    fn take_parts(&mut self, parts: &[(usize, Vec<u8>)]) -> Option<()> {
        let (count, mut materials, mut groups) = (self.materials.len(), vec![], vec![]);
        let mut common: Option<Common> = None;
        for (part, bytes) in parts {
            match *part {
                i if i < count => materials.push((i, postcard::from_bytes(bytes).ok()?)),
                i if i < 2 * count => groups.push((i - count, postcard::from_bytes(bytes).ok()?)),
                i if i == 2 * count => common = Some(postcard::from_bytes(bytes).ok()?),
                _ => return None,
            }
        }
        materials.into_iter().for_each(|(i, material)| self.materials[i] = material);
        groups.into_iter().for_each(|(i, group)| self.groups[i] = group);
        if let Some(common) = common {
            self.lights = common.lights;
            self.exposure = common.exposure;
            self.exposure_std = common.exposure_std;
            self.light_results = common.light_results;
            self.corrected = common.corrected;
        }
        Some(())
    }
}
