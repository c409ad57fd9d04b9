//! The journal of a recovery: the results of its expensive steps, so that a killed recovery
//! continues where it was, and ends with the same bits.
//!
//! A recovery depends on nothing but its problem and its options: run twice, it makes the same steps
//! and decisions. So only what takes time is kept: the result of each rendering with the arithmetic on it, one record a
//! step, in order. To continue, the recovery begins again with these records: a step whose result is in the journal
//! takes it from there (*deterministic replay*); everything else, the state of the loops and all that later decisions
//! depend on, is computed again.
//!
//! The steps are: an iteration of the paper's method, the exposure by the anchor, the candidates of one group, a
//! verification, a pass of the joint refinement, and each of the last tasks after it. Numbers are kept as
//! their bits.
//!
//! To add a step: wrap it into `Steps::value`. A step that is not wrapped is done again, which costs only time.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Keeps what steps have found, in order.
///
/// Once the observer has said that the recovery is cancelled, the journal must not change: the
/// steps after that are not those of a recovery that continues.
pub trait Journal: Sync {
    /// Gives `understand` the result of the next step in an earlier run, and returns whether it was understood; false
    /// if that run did not get so far. A record that was not understood is dropped, with all after it.
    fn recall(&self, understand: &mut dyn FnMut(&[u8]) -> bool) -> bool;
    /// Keeps what the next step has found now.
    fn keep(&self, found: &[u8]);
}

/// The steps of a recovery, with its journal if it has one.
#[derive(Clone, Copy, Default)]
pub(crate) struct Steps<'a>(pub(crate) Option<&'a dyn Journal>);

impl Steps<'_> {
    /// The result of `work`, now or in an earlier run. `name` distinguishes kinds of steps.
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
