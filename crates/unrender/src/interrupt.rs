//! Ctrl-C: the program ends at once with exit code 130, but never in the middle of writing, and
//! without losing work that it knows how to keep.
//!
//! The signal is handled on a thread of its own. It waits for results that are just being written,
//! so that a folder of results is complete or was not begun, and then ends the process. Work that
//! holds a [`Pausable`] is only told the first time: it stops by itself at the next good place,
//! saves what there is and returns [`code`].

use crate::Error;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What shells expect of a program that SIGINT ended: 128 + 2.
const EXIT_CODE: u8 = 130;

static WRITING: Mutex<()> = Mutex::new(());
static PAUSABLE: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C ends the program as described above.
pub(crate) fn install() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        if PAUSABLE.load(Ordering::SeqCst) && !ASKED.swap(true, Ordering::SeqCst) {
            eprintln!("\nstopping after this pass; Ctrl-C again stops at once");
            return;
        }
        let _no_more_writing = writing();
        eprintln!("\ninterrupted");
        std::process::exit(i32::from(EXIT_CODE));
    })
    .map_err(|error| Error::Request(format!("Ctrl-C cannot be handled: {error}")))
}

/// Holds Ctrl-C back until the guard is dropped; taken around the writing of results.
pub(crate) fn writing() -> MutexGuard<'static, ()> {
    // Nothing is behind the lock that a panic could have left in disorder.
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While it lives, the first Ctrl-C only asks for an end: see [`Pausable::is_asked`].
pub(crate) struct Pausable(());

impl Pausable {
    /// Promises to look at [`Pausable::is_asked`] now and then.
    pub(crate) fn new() -> Self {
        PAUSABLE.store(true, Ordering::SeqCst);
        Self(())
    }

    /// Whether Ctrl-C was pressed.
    pub(crate) fn is_asked(&self) -> bool {
        ASKED.load(Ordering::SeqCst)
    }
}

impl Drop for Pausable {
    fn drop(&mut self) {
        PAUSABLE.store(false, Ordering::SeqCst);
    }
}

/// The exit code of work that has stopped because it was asked to.
pub(crate) fn code() -> ExitCode {
    ExitCode::from(EXIT_CODE)
}
