//! A step that changes the state, kept in the journal as the parts of the state that it changed.

use super::State;
use crate::photometric::PhotometricEstimate;
use crate::record::LightResult;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use unrender_scene::Rgb;

/// What a step may change that belongs to no group.
#[derive(Serialize, Deserialize)]
struct Common {
    lights: Vec<Rgb>,
    exposure: Rgb,
    exposure_std: Option<Rgb>,
    light_results: Vec<LightResult>,
    photometric: PhotometricEstimate,
}

/// The parts of a state that a step changed, by their numbers, and what it found.
#[derive(Serialize, Deserialize)]
struct Change<T> {
    parts: Vec<(usize, Vec<u8>)>,
    found: T,
}

impl State<'_> {
    /// The result of `work`, which may change the state; from the journal if that has it.
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
            photometric: self.photometric.clone(),
        };
        // Plain data without maps: it can always be written.
        let materials = self.materials.iter().map(|m| postcard::to_stdvec(m).unwrap_or_default());
        let groups = self.groups.iter().map(|g| postcard::to_stdvec(g).unwrap_or_default());
        let mut parts: Vec<Vec<u8>> = materials.chain(groups).collect();
        parts.push(postcard::to_stdvec(&common).unwrap_or_default());
        parts
    }

    /// Takes over parts that a step has changed; none if one of them is not understood: then the state does not change.
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
            self.photometric = common.photometric;
        }
        Some(())
    }
}
