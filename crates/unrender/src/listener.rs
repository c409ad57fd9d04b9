//! Who hears of the work instead of the terminal: a program that calls the commands as functions,
//! such as the Python module.

use crate::output;
use std::fmt;
use std::sync::Arc;
use unrender_recover::IterationRecord;
use unrender_scene::Warnings;

/// Hears of the work of one command. Calls come from any thread, and should return at once.
pub trait Listener: Send + Sync {
    /// Something is doubtful: a sentence without a final full stop.
    fn warning(&self, sentence: &str);
    /// The share `done`, 0 to 1, of the work is done; `what` was done last, where that is new.
    fn progress(&self, what: Option<&str>, done: f64);
    /// What the command prints on standard output.
    fn result(&self, text: &str);
    /// A recovery has re-rendered its scene once more.
    fn iteration(&self, record: &IterationRecord);
    /// Whether to stop with what there is.
    fn is_cancelled(&self) -> bool;
}

/// Where a command tells what it has to say: to a [`Listener`], or by default on the terminal.
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

    /// Tells `warnings`, on the terminal one a line on stderr.
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

    /// Prints the line `text` on stderr, if nobody listens: what programs need of it comes as values.
    pub(crate) fn tell(&self, text: &str) {
        if self.0.is_none() {
            output::tell(text);
        }
    }

    /// Whether the listener asks for an end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.0.as_ref().is_some_and(|listener| listener.is_cancelled())
    }
}

impl fmt::Debug for Console {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Console(listener)" } else { "Console(terminal)" })
    }
}
