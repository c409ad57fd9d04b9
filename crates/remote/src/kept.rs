//! The paths that a worker keeps: the last ones, within a budget of memory.

use super::wire;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use unrender_render::{Query, StoredPaths};

/// The memory that paths may take, bytes. At half of it large pictures trace their paths again in every
/// step; double is more than workers on small machines have.
const BUDGET: usize = 1 << 30;

/// Paths by what they depend on, the oldest first.
#[derive(Default)]
pub(super) struct Kept(Mutex<VecDeque<(Vec<u8>, Arc<StoredPaths>)>>);

impl Kept {
    /// The paths of `query`: kept ones, or those that `trace` finds.
    pub(super) fn paths(
        &self,
        query: &Query<'_>,
        trace: impl FnOnce() -> StoredPaths,
    ) -> Arc<StoredPaths> {
        let Query { appearance, pixels, parameters, settings, seen } = *query;
        let valid = seen.map(|seen| &seen.valid);
        let materials = (appearance.materials, appearance.lights);
        let name = wire::encode(&(materials, pixels, parameters, settings, valid));
        if let Some((_, paths)) = self.lock().iter().find(|(known, _)| *known == name) {
            return Arc::clone(paths);
        }
        let paths = Arc::new(trace());
        let mut kept = self.lock();
        kept.push_back((name, Arc::clone(&paths)));
        while kept.iter().map(|(_, paths)| paths.bytes()).sum::<usize>() > BUDGET {
            kept.pop_front();
        }
        paths
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(Vec<u8>, Arc<StoredPaths>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
