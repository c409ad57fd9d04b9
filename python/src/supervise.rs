//! Runs work on its own thread, while the caller's thread receives its messages, handles Python's
//! signals and may request an end. The interpreter's lock is free meanwhile.

use crate::error;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use unrender::Error;
use unrender::listener::Listener;
use unrender::recover::IterationRecord;

/// The interval between two checks of Python's signals. Double of it would be noticeable after
/// Ctrl-C; half of it takes the interpreter's lock more often without a benefit.
const TICK: Duration = Duration::from_millis(50);
/// The time after Ctrl-C in which the work may end by itself with all of its results; after that, the
/// state of the last iteration is returned. With double of it, the end would be later than a second;
/// with half of it, more recoveries would be returned without their last picture.
const GRACE: Duration = Duration::from_millis(700);
/// The stack of the thread, bytes: the same as that of a main thread.
const STACK: usize = 8 << 20;

/// Requests the end of the work to which it was passed, from any thread.
#[pyclass(module = "unrender._unrender", frozen)]
#[derive(Default)]
pub(crate) struct Token {
    cancelled: Arc<AtomicBool>,
}

#[pymethods]
impl Token {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Requests the end.
    fn cancel(&self) {
        self.cancelled.store(true, Ordering::SeqCst);
    }

    /// Whether the end was requested.
    #[getter]
    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }
}

/// A message of the work.
enum Event {
    Warning(String),
    Progress(Option<String>, f64),
    Iteration(Box<IterationRecord>),
}

/// The messages of the work.
#[derive(Default)]
pub(crate) struct Heard {
    /// The command's standard output.
    pub(crate) text: String,
    /// The last iteration of a recovery.
    pub(crate) last: Option<IterationRecord>,
}

/// The listener on the side of the work.
struct Ear {
    events: Mutex<Sender<Event>>,
    heard: Arc<Mutex<Heard>>,
    /// The token of the caller, and the flag of Ctrl-C.
    cancelled: [Arc<AtomicBool>; 2],
}

impl Ear {
    fn send(&self, event: Event) {
        // The receiver may be gone.
        let _ = self.events.lock().unwrap_or_else(PoisonError::into_inner).send(event);
    }
}

impl Listener for Ear {
    fn warning(&self, sentence: &str) {
        self.send(Event::Warning(sentence.to_owned()));
    }

    fn progress(&self, what: Option<&str>, done: f64) {
        self.send(Event::Progress(what.map(str::to_owned), done));
    }

    fn result(&self, text: &str) {
        locked(&self.heard).text.push_str(text);
    }

    fn iteration(&self, record: &IterationRecord) {
        locked(&self.heard).last = Some(record.clone());
        self.send(Event::Iteration(Box::new(record.clone())));
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.iter().any(|flag| flag.load(Ordering::SeqCst))
    }
}

fn locked<T>(of: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The end of the work.
pub(crate) struct Ended<T> {
    /// Its result; none if Ctrl-C was pressed and the work did not end within [`GRACE`].
    pub(crate) result: Option<T>,
    /// Its messages.
    pub(crate) heard: Heard,
    /// Whether Ctrl-C was pressed.
    pub(crate) signalled: bool,
}

/// The caller's control of the work.
#[derive(FromPyObject)]
pub(crate) struct Control<'py> {
    /// A [`Token`], or none.
    token: Option<Bound<'py, Token>>,
    /// Has the methods `warning(text)`, `progress(message, done)` and `iteration(text)`.
    handler: Bound<'py, PyAny>,
    /// The number of threads; none means one per core.
    threads: Option<usize>,
}

/// Runs `work` on its own thread and waits for it.
pub(crate) fn supervise<T: Send + 'static>(
    py: Python<'_>,
    control: &Control<'_>,
    work: impl FnOnce(Arc<dyn Listener>) -> Result<T, Error> + Send + 'static,
) -> PyResult<Ended<T>> {
    supervise_recovery(py, control, &|_| None, work)
}

/// As [`supervise`]; `describe` gives the text of an iteration for the handler.
pub(crate) fn supervise_recovery<T: Send + 'static>(
    py: Python<'_>,
    control: &Control<'_>,
    describe: &dyn Fn(&IterationRecord) -> Option<String>,
    work: impl FnOnce(Arc<dyn Listener>) -> Result<T, Error> + Send + 'static,
) -> PyResult<Ended<T>> {
    let (send, events) = channel();
    let heard = Arc::new(Mutex::new(Heard::default()));
    let token = control.token.as_ref().map(|token| Arc::clone(&token.get().cancelled));
    let signal = Arc::new(AtomicBool::new(false));
    let ear = Ear {
        events: Mutex::new(send),
        heard: Arc::clone(&heard),
        cancelled: [token.unwrap_or_default(), Arc::clone(&signal)],
    };
    let threads = control.threads;
    let (hand_over, handed) = channel();
    // The wait for its end is without the interpreter's lock, which needs values that threads may
    // share.
    let handed = Mutex::new(handed);
    let on_threads = move || {
        let result = with_threads(threads, || work(Arc::new(ear)));
        // The receiver may be gone.
        let _ = hand_over.send(result);
    };
    thread::Builder::new().stack_size(STACK).spawn(on_threads)?;
    let mut watch = Watch { control, describe, events, signal, signalled: None, failed: None };
    let result = loop {
        match py.detach(|| locked(&handed).recv_timeout(TICK)) {
            Ok(result) => break Some(result),
            Err(RecvTimeoutError::Disconnected) => return Err(error::internal()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        watch.pass_on();
        watch.look_at_signals(py);
        if watch.signalled.is_some_and(|since| since.elapsed() > GRACE) {
            break None;
        }
    };
    watch.pass_on();
    if let Some(failed) = watch.failed {
        return Err(failed);
    }
    let result = result.transpose().map_err(|problem| error::exception(py, &problem))?;
    let signalled = watch.signalled.is_some();
    let heard = std::mem::take(&mut *locked(&heard));
    Ok(Ended { result, heard, signalled })
}

/// The side of the caller.
struct Watch<'a, 'py> {
    control: &'a Control<'py>,
    /// The text of an iteration for the handler.
    describe: &'a dyn Fn(&IterationRecord) -> Option<String>,
    events: Receiver<Event>,
    signal: Arc<AtomicBool>,
    /// The time when Ctrl-C was pressed.
    signalled: Option<Instant>,
    /// An exception from a callback of the caller; it ends the work, as Ctrl-C does.
    failed: Option<PyErr>,
}

impl Watch<'_, '_> {
    /// Passes the messages to the caller's handler; only the latest progress and iteration.
    fn pass_on(&mut self) {
        let mut latest: Option<(Option<String>, f64)> = None;
        let mut iteration = None;
        while let Ok(event) = self.events.try_recv() {
            match event {
                Event::Warning(text) => self.warn(&text),
                Event::Iteration(record) => iteration = Some(record),
                Event::Progress(what, done) => {
                    let before = latest.take().and_then(|(what, _)| what);
                    latest = Some((what.or(before), done));
                }
            }
        }
        if let Some((what, done)) = latest {
            self.progress(what, done);
        }
        if let Some(text) = iteration.and_then(|record| (self.describe)(&record)) {
            let told = self.control.handler.call_method1("iteration", (text,));
            self.fail(told);
        }
    }

    fn warn(&mut self, text: &str) {
        let told = self.control.handler.call_method1("warning", (text,));
        self.fail(told);
    }

    fn progress(&mut self, what: Option<String>, done: f64) {
        let told = self.control.handler.call_method1("progress", (what, done));
        self.fail(told);
    }

    /// An exception from a callback ends the work.
    fn fail(&mut self, told: PyResult<Bound<'_, PyAny>>) {
        if let Err(raised) = told {
            self.end_by(raised);
        }
    }

    /// Ends the work: by Ctrl-C, which may come in the middle of a callback too, or by an exception of
    /// the caller's code.
    fn end_by(&mut self, raised: PyErr) {
        self.stop();
        let py = self.control.handler.py();
        if !raised.is_instance_of::<PyKeyboardInterrupt>(py) {
            self.failed.get_or_insert(raised);
        }
    }

    fn stop(&mut self) {
        self.signalled.get_or_insert_with(Instant::now);
        self.signal.store(true, Ordering::SeqCst);
    }

    fn look_at_signals(&mut self, py: Python<'_>) {
        if self.signalled.is_some() {
            return;
        }
        if let Err(raised) = py.check_signals() {
            self.end_by(raised);
        }
    }
}

/// `work` with `threads` threads.
fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let failed = |error| Error::Request(format!("{threads} threads cannot be started: {error}"));
    pool.map_err(failed)?.install(work)
}
