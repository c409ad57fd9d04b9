//! Ctrl-C: the program ends at once with exit code 130, but never in the middle of writing.
//!
//! The signal is handled on a thread of its own. It waits for results that are just being written,
//! so that a folder of results is complete or was not begun, and then ends the process.

use crate::Error;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What shells expect of a program that SIGINT ended: 128 + 2.
const EXIT_CODE: i32 = 130;

static WRITING: Mutex<()> = Mutex::new(());

/// From here on Ctrl-C ends the program as described above.
pub(crate) fn install() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        let _no_more_writing = writing();
        eprintln!("\ninterrupted");
        std::process::exit(EXIT_CODE);
    })
    .map_err(|error| Error::Request(format!("Ctrl-C cannot be handled: {error}")))
}

/// Holds Ctrl-C back until the guard is dropped; taken around the writing of results.
pub(crate) fn writing() -> MutexGuard<'static, ()> {
    // Nothing is behind the lock that a panic could have left in disorder.
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}
