//! Work on a thread of its own, while the caller's thread hears of it, lets Python's signals through
//! and may ask for an end. The interpreter's lock is free meanwhile.

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

/// How often Python's signals are looked at. Twice of it would be felt after Ctrl-C; half of it takes
/// the interpreter's lock more often than anybody notices.
const TICK: Duration = Duration::from_millis(50);
/// How long after Ctrl-C the work may take to end by itself with all of its results; after that, what
/// was known by the last iteration is handed out. With double of it, the end would be later than a
/// second; with half of it, more recoveries would be handed out without their last picture.
const GRACE: Duration = Duration::from_millis(700);
/// The stack of the thread, bytes: as much as a main thread has.
const STACK: usize = 8 << 20;

/// Asks for an end of the work that it was given to, from any thread.
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

    /// Asks for an end.
    fn cancel(&self) {
        self.cancelled.store(true, Ordering::SeqCst);
    }

    /// Whether somebody has asked for an end.
    #[getter]
    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::SeqCst)
    }
}

/// What the work has to say.
enum Event {
    Warning(String),
    Progress(Option<String>, f64),
    Iteration(Box<IterationRecord>),
}

/// What is known of the work besides its result.
#[derive(Default)]
pub(crate) struct Heard {
    /// What the command printed on standard output.
    pub(crate) text: String,
    /// The last iteration of a recovery.
    pub(crate) last: Option<IterationRecord>,
}

/// Listens on the side of the work.
struct Ear {
    events: Mutex<Sender<Event>>,
    heard: Arc<Mutex<Heard>>,
    /// The token of the caller, and the flag of Ctrl-C.
    cancelled: [Arc<AtomicBool>; 2],
}

impl Ear {
    fn send(&self, event: Event) {
        // Nobody may be waiting any more.
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

/// How work came to its end.
pub(crate) struct Ended<T> {
    /// Its result; none if Ctrl-C was pressed and the work did not end within [`GRACE`].
    pub(crate) result: Option<T>,
    /// What it said.
    pub(crate) heard: Heard,
    /// Whether Ctrl-C was pressed.
    pub(crate) signalled: bool,
}

/// What the caller wants of the work besides its result.
#[derive(FromPyObject)]
pub(crate) struct Control<'py> {
    /// A [`Token`], or none.
    token: Option<Bound<'py, Token>>,
    /// Has the methods `warning(text)`, `progress(message, done)` and `iteration(text)`.
    handler: Bound<'py, PyAny>,
    /// How many threads may work; none means one a core.
    threads: Option<usize>,
}

/// Does `work` on a thread of its own and waits for it.
pub(crate) fn supervise<T: Send + 'static>(
    py: Python<'_>,
    control: &Control<'_>,
    work: impl FnOnce(Arc<dyn Listener>) -> Result<T, Error> + Send + 'static,
) -> PyResult<Ended<T>> {
    supervise_recovery(py, control, &|_| None, work)
}

/// As [`supervise`]; of iterations, `describe` says what the handler hears.
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
    // Its end is waited for without the interpreter's lock, which wants what threads may share.
    let handed = Mutex::new(handed);
    let on_threads = move || {
        let result = with_threads(threads, || work(Arc::new(ear)));
        // Nobody may be waiting any more.
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
    /// What the handler hears of an iteration.
    describe: &'a dyn Fn(&IterationRecord) -> Option<String>,
    events: Receiver<Event>,
    signal: Arc<AtomicBool>,
    /// When Ctrl-C was pressed.
    signalled: Option<Instant>,
    /// What a callback of the caller has raised; it ends the work, as Ctrl-C does.
    failed: Option<PyErr>,
}

impl Watch<'_, '_> {
    /// Tells the caller's handler what there was; of progress and iterations only the latest.
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

    /// What a callback has raised ends the work.
    fn fail(&mut self, told: PyResult<Bound<'_, PyAny>>) {
        if let Err(raised) = told {
            self.end_by(raised);
        }
    }

    /// Ends the work: by Ctrl-C, which may come in the middle of a callback too, or by an exception of
    /// the caller's own.
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
