//! Ctrl-C and SIGTERM: the program ends at once with exit code 130 or 143, but never in the middle of
//! writing, and without losing work that it can save.
//!
//! A signal is handled on a thread of its own. It waits for results that are being written, so that
//! a folder of results is complete or was not begun, and then ends the process. Work that holds a
//! [`Pausable`] is only asked to end the first time: it stops by itself at the next good place,
//! saves its state and returns [`code`].

use crate::{Error, output};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The exit code that shells expect after SIGINT: 128 + 2.
const INTERRUPTED: u8 = 130;
/// The same for SIGTERM: 128 + 15.
#[cfg(unix)]
const TERMINATED: u8 = 143;

static WRITING: Mutex<()> = Mutex::new(());
static PAUSABLE: AtomicBool = AtomicBool::new(false);
/// The exit code of the signal that requested the end; zero before.
static ASKED: AtomicU8 = AtomicU8::new(0);

/// From here on Ctrl-C and SIGTERM end the program as described above, and reaching the size limit
/// of files is an error like a full disk.
pub(crate) fn install() -> Result<(), Error> {
    let failed = |error: &dyn std::fmt::Display| {
        Error::Request(format!("signals cannot be handled: {error}"))
    };
    ctrlc::set_handler(|| asked(INTERRUPTED)).map_err(|error| failed(&error))?;
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGTERM, SIGXFSZ};
        // The handler does nothing: the write then fails, and its temporary file is removed.
        let flag = std::sync::Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGXFSZ, flag).map_err(|error| failed(&error))?;
        let mut signals =
            signal_hook::iterator::Signals::new([SIGTERM]).map_err(|error| failed(&error))?;
        std::thread::spawn(move || signals.forever().for_each(|_| asked(TERMINATED)));
    }
    Ok(())
}

/// Requests an end with the exit code `code`; the second time, ends at once.
fn asked(code: u8) {
    if PAUSABLE.load(Ordering::SeqCst) && ASKED.swap(code, Ordering::SeqCst) == 0 {
        output::tell("\nstopping after this pass; Ctrl-C again stops at once");
        return;
    }
    let _no_more_writing = writing();
    output::tell("\ninterrupted");
    std::process::exit(i32::from(code));
}

/// Holds Ctrl-C back until the guard is dropped; taken around the writing of results.
pub(crate) fn writing() -> MutexGuard<'static, ()> {
    // The lock guards no data that a panic could have left inconsistent.
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While it exists, the first Ctrl-C only requests an end: see [`Pausable::is_asked`].
pub(crate) struct Pausable(());

impl Pausable {
    /// The caller must check [`Pausable::is_asked`] regularly.
    pub(crate) fn new() -> Self {
        PAUSABLE.store(true, Ordering::SeqCst);
        Self(())
    }

    /// Whether Ctrl-C was pressed.
    pub(crate) fn is_asked(&self) -> bool {
        ASKED.load(Ordering::SeqCst) != 0
    }
}

impl Drop for Pausable {
    fn drop(&mut self) {
        PAUSABLE.store(false, Ordering::SeqCst);
    }
}

/// The exit code of work that has stopped on request.
pub(crate) fn code() -> ExitCode {
    match ASKED.load(Ordering::SeqCst) {
        0 => ExitCode::from(INTERRUPTED),
        code => ExitCode::from(code),
    }
}
