//! The messages of a recovery to the terminal or a listener, and Ctrl-C, which ends it with the
//! results so far.

use crate::engine::Follower;
use crate::growing_picture::GrowingPicture;
use crate::interrupt::Pausable;
use crate::progress::Progress;
use crate::recovery_journal::RecoveryJournal;
use unrender_recover::{IterationRecord, Observer};
use unrender_scene::{RgbImage, Warnings};

/// Passes on the progress of a recovery.
pub(crate) struct RecoveryProgress<'a> {
    pub(crate) progress: &'a Progress,
    /// Whether the recovery is by the paper's method.
    pub(crate) is_papers: bool,
    /// The share of the recovery in the whole work.
    pub(crate) share: f64,
    pub(crate) pausable: Pausable,
    /// The journal of the recovery, if it has one.
    pub(crate) journal: Option<&'a RecoveryJournal>,
    /// The picture that is shown while it works, if there is one.
    pub(crate) growing: Option<GrowingPicture<'a>>,
}

impl Follower for RecoveryProgress<'_> {
    fn expected(&self, seconds: f64) {
        self.progress.expect(seconds / self.share);
    }

    fn warning(&self, sentence: &str) {
        self.progress.warn(&Warnings(vec![sentence.to_owned()]));
    }
}

impl Observer for RecoveryProgress<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.progress.iteration(record);
        self.progress.say(sentence(record, self.is_papers), self.share * record.done);
    }

    fn working(&self, what: &str, done: f64) {
        self.progress.work_on(what, self.share * done);
    }

    fn wants_picture(&self) -> bool {
        self.growing.as_ref().is_some_and(GrowingPicture::is_due)
    }

    fn picture(&mut self, rough: RgbImage) {
        if let Some(told) = self.growing.as_mut().and_then(|growing| growing.show(&rough)) {
            self.progress.tell(&told);
        }
    }

    fn is_cancelled(&self) -> bool {
        let is_asked = self.pausable.is_asked() || self.progress.is_cancelled();
        if is_asked && let Some(journal) = self.journal {
            // The next steps differ from those of a recovery that is not interrupted.
            journal.close();
        }
        is_asked
    }
}

/// The work that `record` ended, in words.
fn sentence(record: &IterationRecord, is_papers: bool) -> String {
    let number = record.iteration;
    if is_papers {
        let open = match record.open_groups.len() {
            0 => "none".to_owned(),
            n if n <= 4 => record.open_groups.join(", "),
            n => format!("{n} groups"),
        };
        return format!("paper's ladder, iteration {number}, still open: {open}");
    }
    let what = if record.refining { "refining" } else { "fitting" };
    format!("{what} all groups together, iteration {number}")
}
