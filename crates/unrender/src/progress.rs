//! Shows the progress of a command on stderr: a bar on a terminal, otherwise lines from time to
//! time.

use crate::global::Global;
use crate::listener::{Console, Listener};
use crate::output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;
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
/// So many seconds of work count as if an ordinary machine had done them: a machine of a quarter of its speed is taken for
/// one of half of it after four seconds, at half of this after two, at double after eight.
const ORDINARY: f64 = 3.0;

/// Shows the progress of one piece of work; any thread may report it.
pub(crate) struct Progress {
    sink: Sink,
    console: Console,
}

enum Sink {
    Silent,
    Bar(ProgressBar, Arc<Mutex<Clock>>),
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
            let clock = Arc::new(Mutex::new(Clock::new()));
            Sink::Bar(bar(what, Arc::clone(&clock)), clock)
        } else {
            Sink::Lines(Lines::new(what))
        };
        Self { sink, console }
    }

    /// Reports `warnings`, above the bar.
    pub(crate) fn warn(&self, warnings: &Warnings) {
        match &self.sink {
            Sink::Bar(bar, _) => bar.suspend(|| self.console.warn(warnings)),
            _ => self.console.warn(warnings),
        }
    }

    /// Tells something that is no progress, above the bar; a listener does not hear it.
    pub(crate) fn tell(&self, text: &str) {
        match &self.sink {
            Sink::Silent | Sink::Listener(_) => {}
            Sink::Bar(bar, _) => bar.suspend(|| output::tell(text)),
            Sink::Lines(_) => output::tell(text),
        }
    }

    /// Reports the seconds that the work takes on an ordinary machine.
    pub(crate) fn expect(&self, seconds: f64) {
        match &self.sink {
            Sink::Silent | Sink::Listener(_) => {}
            Sink::Bar(_, clock) => locked(clock).expected = Some(seconds),
            Sink::Lines(lines) => lines.ticking.said().clock.expected = Some(seconds),
        }
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
            Sink::Bar(bar, _) => bar.set_message(what),
            Sink::Listener(listener) => {
                return listener.progress(Some(&what), done.clamp(0.0, 1.0));
            }
            Sink::Lines(lines) => {
                let mut said = lines.ticking.said();
                said.clock.reach(done.clamp(0.0, 1.0));
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
            Sink::Bar(bar, _) => bar.set_message(what.to_owned()),
            Sink::Lines(lines) => what.clone_into(&mut lines.ticking.said().what),
        }
        self.set(done);
    }

    /// Reports that the share `done` (0 to 1) of the work is done.
    pub(crate) fn set(&self, done: f64) {
        let done = done.clamp(0.0, 1.0);
        match &self.sink {
            Sink::Silent => {}
            Sink::Bar(bar, clock) => {
                // The bar may be drawn here, and asks the clock then: it has to be free.
                let reached = locked(clock).reach(done);
                bar.set_position((reached * BAR_STEPS as f64) as u64);
            }
            Sink::Listener(listener) => listener.progress(None, done),
            Sink::Lines(lines) => {
                lines.ticking.said().clock.reach(done);
            }
        }
    }
}

impl Drop for Progress {
    /// Removes the bar, so that the next text on stderr starts on a line of its own.
    fn drop(&mut self) {
        if let Sink::Bar(bar, _) = &self.sink {
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
    clock: Clock,
    last: Instant,
    what: String,
    is_over: bool,
}

/// How long the work has taken, and how long it will take.
#[derive(Debug)]
struct Clock {
    started: Instant,
    /// When the work was last at its beginning: preparations, of which no share is known, tell nothing of its speed.
    begun: Instant,
    done: f64,
    /// The seconds that it takes on an ordinary machine, if that is known before.
    expected: Option<f64>,
}

impl Clock {
    fn new() -> Self {
        let now = Instant::now();
        Self { started: now, begun: now, done: 0.0, expected: None }
    }

    /// The share `done` is done, as one thread says; others may have said more. Returns the share of all.
    fn reach(&mut self, done: f64) -> f64 {
        self.done = self.done.max(done);
        if self.done == 0.0 {
            self.begun = Instant::now();
        }
        self.done
    }

    /// Elapsed time, the share done, and the time left, in words.
    fn in_words(&self) -> String {
        let (elapsed, percent) = (self.started.elapsed().as_secs_f64(), 100.0 * self.done);
        let worked = if self.done > 0.0 { self.begun.elapsed().as_secs_f64() } else { 0.0 };
        match seconds_left(worked, self.done, self.expected) {
            Some(left) => {
                let left = left.ceil();
                format!("{elapsed:.0} s, {percent:.0} %, about {left:.0} s left")
            }
            None => format!("{elapsed:.0} s, {percent:.0} %"),
        }
    }
}

/// The seconds left after so many seconds of work, of which the share `done` is done. Where it is known what the work
/// takes on an ordinary machine, this one counts as ordinary until it has worked for a while.
fn seconds_left(worked: f64, done: f64, expected: Option<f64>) -> Option<f64> {
    match expected {
        Some(expected) => {
            let slowness = (worked + ORDINARY) / (expected * done + ORDINARY);
            Some(slowness * expected * (1.0 - done))
        }
        None => (done >= FORESEEABLE).then(|| worked * (1.0 - done) / done),
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Lines {
    fn new(what: &str) -> Self {
        let clock = Clock::new();
        let said = Said { last: clock.started, clock, what: what.to_owned(), is_over: false };
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
        locked(&self.said)
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
    fn tell(&mut self, what: &str) {
        self.last = Instant::now();
        output::tell(&format!("{what}: {}", self.clock.in_words()));
    }
}

/// A bar whose message, the present step, stays in sight in narrow terminals too.
fn bar(what: &str, clock: Arc<Mutex<Clock>>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{wide_msg} {bar:10} {clock}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .with_key("clock", move |_: &ProgressState, text: &mut dyn Write| {
            // A text that is made in memory cannot fail to be written.
            let _ = text.write_str(&locked(&clock).in_words());
        });
    let bar = bar.with_style(style).with_message(what.to_owned());
    // It draws the bar at once.
    bar.enable_steady_tick(Duration::from_secs(1));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_the_work_done() {
        assert_eq!(seconds_left(10.0, 0.25, None), Some(30.0));
        assert_eq!(seconds_left(1.0, 0.0, None), None);
        assert_eq!(seconds_left(1.0, 0.04, None), None);
    }

    #[test]
    fn what_is_expected_counts_until_the_work_has_shown_how_fast_it_is() {
        let left = |worked, done| seconds_left(worked, done, Some(100.0)).unwrap();
        assert_eq!((left(0.0, 0.0), left(50.0, 0.5), left(77.0, 1.0)), (100.0, 50.0, 0.0));
        // A machine that is four times as slow: half the way there after some seconds, soon all of it.
        assert!((200.0..250.0).contains(&left(8.0, 0.02)), "{}", left(8.0, 0.02));
        assert!((290.0..360.0).contains(&left(40.0, 0.1)), "{}", left(40.0, 0.1));
    }

    #[test]
    fn preparations_tell_nothing_of_the_time_left() {
        let mut clock = Clock::new();
        std::thread::sleep(Duration::from_millis(2));
        clock.reach(0.0);
        assert!(clock.begun > clock.started);
        let begun = clock.begun;
        clock.reach(0.1);
        clock.reach(0.0);
        assert_eq!((clock.begun, clock.done), (begun, 0.1));
        assert_eq!(clock.in_words(), "0 s, 10 %, about 1 s left");
    }
}
