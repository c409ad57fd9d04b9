//! Receivers of messages instead of the terminal: programs that call the commands as functions,
//! such as the Python module.

use crate::output;
use std::fmt;
use std::sync::Arc;
use unrender_recover::IterationRecord;
use unrender_scene::Warnings;

/// Receives the messages of one command. Calls come from any thread, and should return at once.
pub trait Listener: Send + Sync {
    /// A warning: a sentence without a final full stop.
    fn warning(&self, sentence: &str);
    /// The share `done`, 0 to 1, of the work is done; `what` was done last, if that is new.
    fn progress(&self, what: Option<&str>, done: f64);
    /// What the command prints on standard output.
    fn result(&self, text: &str);
    /// A recovery has re-rendered its scene once more.
    fn iteration(&self, record: &IterationRecord);
    /// Whether to stop with the results so far.
    fn is_cancelled(&self) -> bool;
}

/// Where the messages of a command go: to a [`Listener`], or by default to the terminal.
#[derive(Clone, Default)]
pub struct Console(Option<Arc<dyn Listener>>);

impl Console {
    /// A console that passes everything on to `listener`.
    pub fn new(listener: Arc<dyn Listener>) -> Self {
        Self(Some(listener))
    }

    /// Who listens; none means the terminal.
    pub(crate) fn listener(&self) -> Option<&Arc<dyn Listener>> {
        self.0.as_ref()
    }

    /// Reports `warnings`, on the terminal one per line on stderr.
    pub(crate) fn warn(&self, warnings: &Warnings) {
        for warning in &warnings.0 {
            match &self.0 {
                Some(listener) => listener.warning(warning),
                None => output::tell(&format!("warning: {warning}")),
            }
        }
    }

    /// Prints the result `text`, on the terminal on stdout.
    pub(crate) fn print(&self, text: &str) {
        match &self.0 {
            Some(listener) => listener.result(text),
            None => output::print(text),
        }
    }

    /// Prints the line `text` on stderr, if there is no listener: programs get the same as values.
    pub(crate) fn tell(&self, text: &str) {
        if self.0.is_none() {
            output::tell(text);
        }
    }

    /// Whether the listener requests an end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.0.as_ref().is_some_and(|listener| listener.is_cancelled())
    }
}

impl fmt::Debug for Console {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Console(listener)" } else { "Console(terminal)" })
    }
}
