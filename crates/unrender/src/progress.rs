//! Shows the progress of a command on stderr: a bar on a terminal, otherwise lines from time to
//! time.

use crate::global::Global;
use crate::listener::{Console, Listener};
use crate::output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use unrender_recover::IterationRecord;
use unrender_scene::Warnings;

/// The longest time without a line, so that users see that work goes on.
const BETWEEN_LINES: Duration = Duration::from_secs(2);
const BAR_STEPS: u64 = 1000;
/// No remaining time is told before this share is done: a recovery of 39 s was said to take 750 s longer at 0.4 %, 460 s at
/// 1 % and 99 s at 4 %. At half of it hundreds of seconds may still be told; double was not tried.
const FORESEEABLE: f64 = 0.05;

/// Shows the progress of one piece of work; any thread may report it.
pub(crate) struct Progress {
    sink: Sink,
    console: Console,
}

enum Sink {
    Silent,
    Bar(ProgressBar),
    Lines(Lines),
    Listener(Arc<dyn Listener>),
}

impl Progress {
    /// Starts the clock of the work called `what`.
    pub(crate) fn new(what: &str, global: &Global) -> Self {
        let console = global.console.clone();
        let sink = if let Some(listener) = console.listener() {
            Sink::Listener(Arc::clone(listener))
        } else if global.quiet {
            Sink::Silent
        } else if std::io::stderr().is_terminal() {
            Sink::Bar(bar(what))
        } else {
            Sink::Lines(Lines::new(what))
        };
        Self { sink, console }
    }

    /// Reports `warnings`.
    pub(crate) fn warn(&self, warnings: &Warnings) {
        self.console.warn(warnings);
    }

    /// Whether a listener requests an end; Ctrl-C is not checked.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.console.is_cancelled()
    }

    /// Whether there is a listener, which may request an end at any time.
    pub(crate) fn has_listener(&self) -> bool {
        self.console.listener().is_some()
    }

    /// Passes the record of a recovery's iteration to a listener.
    pub(crate) fn iteration(&self, record: &IterationRecord) {
        if let Sink::Listener(listener) = &self.sink {
            listener.iteration(record);
        }
    }

    /// Reports what has just been done, with the share done by then.
    pub(crate) fn say(&self, what: String, done: f64) {
        match &self.sink {
            Sink::Silent => {}
            Sink::Bar(bar) => bar.set_message(what),
            Sink::Listener(listener) => {
                return listener.progress(Some(&what), done.clamp(0.0, 1.0));
            }
            Sink::Lines(lines) => {
                let mut said = lines.ticking.said();
                said.reach(done.clamp(0.0, 1.0));
                said.tell(&what);
            }
        }
        self.set(done);
    }

    /// Reports what is being done, with the share done before it, if nothing was reported for a
    /// while.
    pub(crate) fn work_on(&self, what: &str, done: f64) {
        match &self.sink {
            Sink::Silent | Sink::Listener(_) => {}
            Sink::Bar(bar) => bar.set_message(what.to_owned()),
            Sink::Lines(lines) => what.clone_into(&mut lines.ticking.said().what),
        }
        self.set(done);
    }

    /// Reports that the share `done` (0 to 1) of the work is done.
    pub(crate) fn set(&self, done: f64) {
        let done = done.clamp(0.0, 1.0);
        match &self.sink {
            Sink::Silent => {}
            Sink::Bar(bar) => bar.set_position((done * BAR_STEPS as f64) as u64),
            Sink::Listener(listener) => listener.progress(None, done),
            Sink::Lines(lines) => lines.ticking.said().reach(done),
        }
    }
}

impl Drop for Progress {
    /// Removes the bar, so that the next text on stderr starts on a line of its own.
    fn drop(&mut self) {
        if let Sink::Bar(bar) = &self.sink {
            bar.finish_and_clear();
        }
    }
}

/// A line for each message, and one with the present stage if there was no message for a while.
struct Lines {
    ticking: Arc<Ticking>,
    ticker: Option<JoinHandle<()>>,
}

/// The data that the timer thread shares with the workers.
struct Ticking {
    said: Mutex<Said>,
    ended: Condvar,
}

/// The last message.
struct Said {
    started: Instant,
    last: Instant,
    what: String,
    done: f64,
    is_over: bool,
}

impl Lines {
    fn new(what: &str) -> Self {
        let started = Instant::now();
        let said =
            Said { started, last: started, what: what.to_owned(), done: 0.0, is_over: false };
        let ticking = Arc::new(Ticking { said: Mutex::new(said), ended: Condvar::new() });
        let shared = Arc::clone(&ticking);
        let ticker = std::thread::spawn(move || shared.run());
        Self { ticking, ticker: Some(ticker) }
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        self.ticking.said().is_over = true;
        self.ticking.ended.notify_all();
        if let Some(ticker) = self.ticker.take() {
            // All its messages were printed.
            let _ = ticker.join();
        }
    }
}

impl Ticking {
    fn said(&self) -> MutexGuard<'_, Said> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self) {
        let mut said = self.said();
        while !said.is_over {
            let left = BETWEEN_LINES.saturating_sub(said.last.elapsed());
            if left.is_zero() {
                let what = said.what.clone();
                said.tell(&what);
            } else {
                let waited = self.ended.wait_timeout(said, left);
                said = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

impl Said {
    /// Threads report their shares in any order.
    fn reach(&mut self, done: f64) {
        self.done = self.done.max(done);
    }

    fn tell(&mut self, what: &str) {
        self.last = Instant::now();
        output::tell(&line(what, self.started.elapsed(), self.done));
    }
}

fn bar(what: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {elapsed}, {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.enable_steady_tick(Duration::from_secs(1));
    bar.with_style(style).with_message(what.to_owned())
}

fn line(what: &str, elapsed: Duration, done: f64) -> String {
    let elapsed = elapsed.as_secs_f64();
    let percent = 100.0 * done;
    if done >= FORESEEABLE {
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
        assert_eq!(line("render", Duration::from_secs(1), 0.04), "render: 1 s, 4 %");
    }
}
