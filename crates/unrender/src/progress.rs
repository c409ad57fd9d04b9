//! How far a command has come, on stderr: a bar on a terminal, now and then a line elsewhere.

use crate::global::Global;
use crate::listener::{Console, Listener};
use crate::output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use unrender_recover::IterationRecord;
use unrender_scene::Warnings;

const BETWEEN_LINES: Duration = Duration::from_secs(2);
const BAR_STEPS: u64 = 1000;

/// Shows the progress of one piece of work; any thread may tell it.
pub(crate) struct Progress {
    what: String,
    started: Instant,
    sink: Sink,
    console: Console,
}

enum Sink {
    Silent,
    Bar(ProgressBar),
    /// The time of the last line.
    Lines(Mutex<Instant>),
    Listener(Arc<dyn Listener>),
}

impl Progress {
    /// Starts the clock of the work called `what`.
    pub(crate) fn new(what: &str, global: &Global) -> Self {
        let started = Instant::now();
        let console = global.console.clone();
        let sink = if let Some(listener) = console.listener() {
            Sink::Listener(Arc::clone(listener))
        } else if global.quiet {
            Sink::Silent
        } else if std::io::stderr().is_terminal() {
            Sink::Bar(bar(what))
        } else {
            Sink::Lines(Mutex::new(started))
        };
        Self { what: what.to_owned(), started, sink, console }
    }

    /// Tells `warnings`.
    pub(crate) fn warn(&self, warnings: &Warnings) {
        self.console.warn(warnings);
    }

    /// Whether a listener asks for an end; Ctrl-C is not looked at.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.console.is_cancelled()
    }

    /// Whether somebody else than the terminal listens, who may ask for an end at any time.
    pub(crate) fn has_listener(&self) -> bool {
        self.console.listener().is_some()
    }

    /// Hands out the record of a recovery's iteration to a listener.
    pub(crate) fn iteration(&self, record: &IterationRecord) {
        if let Sink::Listener(listener) = &self.sink {
            listener.iteration(record);
        }
    }

    /// Tells what has just been done, with the share done by then.
    pub(crate) fn say(&self, what: String, done: f64) {
        match &self.sink {
            Sink::Silent => {}
            Sink::Bar(bar) => bar.set_message(what),
            Sink::Listener(listener) => {
                return listener.progress(Some(&what), done.clamp(0.0, 1.0));
            }
            Sink::Lines(last) => {
                *last.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
                output::tell(&line(&what, self.started.elapsed(), done.clamp(0.0, 1.0)));
            }
        }
        self.set(done);
    }

    /// Tells that the share `done` (0 to 1) of the work is done.
    pub(crate) fn set(&self, done: f64) {
        let done = done.clamp(0.0, 1.0);
        match &self.sink {
            Sink::Silent => {}
            Sink::Bar(bar) => bar.set_position((done * BAR_STEPS as f64) as u64),
            Sink::Listener(listener) => listener.progress(None, done),
            Sink::Lines(last) => {
                let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
                if last.elapsed() >= BETWEEN_LINES {
                    *last = Instant::now();
                    output::tell(&line(&self.what, self.started.elapsed(), done));
                }
            }
        }
    }
}

impl Drop for Progress {
    /// Removes the bar, so that what follows on stderr starts on a line of its own.
    fn drop(&mut self) {
        if let Sink::Bar(bar) = &self.sink {
            bar.finish_and_clear();
        }
    }
}

fn bar(what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {elapsed}, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style).with_message(what.to_owned())
}

fn line(what: &str, elapsed: Duration, done: f64) -> String {
    let elapsed = elapsed.as_secs_f64();
    let percent = 100.0 * done;
    if done > 0.0 {
        let left = elapsed * (1.0 - done) / done;
        format!("{what}: {elapsed:.0} s, {percent:.0} %, about {left:.0} s left")
    } else {
        format!("{what}: {elapsed:.0} s, {percent:.0} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_elapsed_time_share_and_time_left() {
        let text = line("render", Duration::from_secs(10), 0.25);
        assert_eq!(text, "render: 10 s, 25 %, about 30 s left");
        assert_eq!(line("render", Duration::from_secs(1), 0.0), "render: 1 s, 0 %");
    }
}
