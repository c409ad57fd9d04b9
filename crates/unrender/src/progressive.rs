//! A rendering in passes, until it has its samples, its time is over, its noise is low enough, or
//! Ctrl-C is pressed.
//!
//! Sums are exact, so the division into passes changes no bit of the picture. Passes take about
//! [`PASS`], so that a request to end does not wait. The noise is checked only at the sample counts
//! of [`next_check`]: the picture depends on the limit, and not on the clock or on interruptions.

use crate::interrupt::Pausable;
use crate::listener::Console;
use crate::progress::Progress;
use crate::progressive_render::ProgressiveRender;
use crate::shard::{self, Head, Identity, Shard};
use crate::{Error, interrupt};
use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use unrender_formats::FileError;
use unrender_render::Accumulator;
use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};

/// The intended duration of a pass.
const PASS: Duration = Duration::from_secs(2);
/// The intended duration if a listener may request an end, whose user should wait for a second at
/// most. With half of it the pilot of path reuse, with which each pass begins, would be a tenth of the
/// work.
const PASS_HEARD: Duration = Duration::from_millis(500);
/// The first number of samples per pixel at which the noise is checked.
const FIRST_CHECK: u32 = 16;
/// The time between two lines about the noise.
const BETWEEN_LINES: Duration = Duration::from_secs(2);
/// The time between two savings of the checkpoint.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(60);

/// When a rendering is done: when the first of these conditions holds.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// It has these samples.
    pub(crate) samples: Range<u32>,
    /// No further pass fits into this time.
    pub(crate) time: Option<Duration>,
    /// [`Accumulator::noise`] is at most this.
    pub(crate) noise: Option<f64>,
    /// The file to save samples to, and to continue from.
    pub(crate) checkpoint: Option<PathBuf>,
}

/// A rendering, and its identity.
pub(crate) struct Job<'a> {
    pub(crate) render: &'a dyn ProgressiveRender,
    /// Includes the picture's size, and whether sampling is adaptive.
    pub(crate) identity: Identity,
}

/// The state of a rendering.
pub(crate) struct Rendered {
    /// One for each of the rendering's layers.
    pub(crate) layers: Vec<Accumulator>,
    /// The numbers of its samples; with adaptive sampling, of a pixel of mean noise.
    pub(crate) samples: Range<u32>,
    /// Whether Ctrl-C ended it.
    pub(crate) interrupted: bool,
}

impl Rendered {
    /// Reports that the rendering was interrupted; returns the exit code for that.
    pub(crate) fn goodbye(&self, console: &Console) -> ExitCode {
        let end = self.samples.end;
        console.tell(&format!("stopped after sample {end}; the same command continues from there"));
        interrupt::code()
    }

    /// The head of a part with these samples.
    pub(crate) fn head(&self, job: &Job<'_>) -> Head {
        let layers = job.render.layers();
        Head { identity: job.identity.clone(), samples: self.samples.clone(), layers }
    }
}

/// A rendering in progress.
struct Run<'a> {
    job: &'a Job<'a>,
    goal: &'a Goal,
    adaptive: Option<AdaptiveSampling>,
    started: Instant,
    /// The time of a sample of all pixels in the last pass, seconds.
    sample_seconds: Option<f64>,
    /// When the noise was reported last.
    reported: Instant,
    /// The number of samples at which the noise should be low enough, by the last check.
    expected_end: Option<f64>,
    rendered: Rendered,
}

/// Renders until the goal is reached.
///
/// # Errors
/// If the checkpoint is of another rendering or cannot be written.
pub(crate) fn run(job: &Job<'_>, goal: &Goal, progress: &Progress) -> Result<Rendered, Error> {
    let rendered = begin(job, goal)?;
    let size = (job.identity.width, job.identity.height);
    let adaptive = job.identity.adaptive.then(|| job.render.adaptive_sampling(size));
    let (started, mut saved) = (Instant::now(), Instant::now());
    let (sample_seconds, expected_end) = (None, None);
    let mut run = Run {
        job,
        goal,
        adaptive,
        started,
        reported: started,
        sample_seconds,
        expected_end,
        rendered,
    };
    let pausable = goal.checkpoint.as_ref().map(|_| Pausable::new());
    while !run.is_done(progress) {
        let Some(end) = run.end_of_pass(progress) else { break };
        run.pass(end, progress);
        run.rendered.interrupted =
            pausable.as_ref().is_some_and(Pausable::is_asked) || progress.is_cancelled();
        if run.rendered.interrupted {
            break;
        }
        if saved.elapsed() >= BETWEEN_CHECKPOINTS {
            save(job, goal, &run.rendered)?;
            saved = Instant::now();
        }
    }
    save(job, goal, &run.rendered)?;
    Ok(run.rendered)
}

impl Run<'_> {
    /// Whether there are enough samples, or the noise is low enough.
    fn is_done(&mut self, progress: &Progress) -> bool {
        let end = self.rendered.samples.end;
        if end >= self.goal.samples.end {
            return true;
        }
        let Some(limit) = self.goal.noise.filter(|_| is_check(end)) else { return false };
        let noise = self.rendered.layers[0].noise();
        self.expected_end = Some(f64::from(end) * (noise / limit).powi(2));
        if self.reported.elapsed() >= BETWEEN_LINES {
            self.reported = Instant::now();
            progress.say(in_words(end, &self.rendered.layers[0]), self.share(end));
        }
        noise <= limit
    }

    /// Where the next pass should end; none if the time is over.
    fn end_of_pass(&self, progress: &Progress) -> Option<u32> {
        let done = self.rendered.samples.end;
        let mut end = self.goal.samples.end;
        if self.goal.noise.is_some() {
            end = end.min(next_check(done));
        }
        let heard = progress.has_listener();
        if self.goal.checkpoint.is_none() && self.goal.time.is_none() && !heard {
            return Some(end);
        }
        let Some(seconds) = self.sample_seconds else { return Some(end.min(done + 1)) };
        let pass = if heard { PASS_HEARD } else { PASS };
        let mut fit = (pass.as_secs_f64() / seconds).max(1.0);
        if let Some(time) = self.goal.time {
            let left = time.saturating_sub(self.started.elapsed()).as_secs_f64();
            fit = fit.min(left / seconds);
        }
        (fit >= 1.0).then(|| end.min(done.saturating_add(fit as u32)))
    }

    /// Adds the samples up to the number `end`.
    fn pass(&mut self, end: u32, progress: &Progress) {
        let (pass, samples) = (Instant::now(), self.rendered.samples.end..end);
        let (before, after) = (self.share(samples.start), self.share(samples.end));
        let Self { job, adaptive, rendered, .. } = self;
        let paths = match adaptive {
            Some(adaptive) => SampleAllocation::Adaptive(adaptive, samples.clone()),
            None => SampleAllocation::Uniform(samples.clone()),
        };
        let tell = |done: f64| progress.set(before + (after - before) * done);
        job.render.accumulate(&paths, &mut rendered.layers, &tell);
        rendered.samples.end = end;
        self.sample_seconds = Some(pass.elapsed().as_secs_f64() / samples.len() as f64);
    }

    /// The share of the work that is done with the samples up to the number `end`.
    fn share(&self, end: u32) -> f64 {
        let Range { start, end: last } = self.goal.samples;
        let last = self.expected_end.unwrap_or(f64::from(last)).min(f64::from(last));
        let of_samples = f64::from(end - start) / (last - f64::from(start)).max(1.0);
        let elapsed = self.started.elapsed().as_secs_f64();
        let of_time = self.goal.time.map_or(0.0, |time| elapsed / time.as_secs_f64());
        of_samples.max(of_time).min(1.0)
    }
}

/// The state of a picture with samples up to `end`, in words.
pub(crate) fn in_words(end: u32, accumulator: &Accumulator) -> String {
    match accumulator.noise() {
        noise if noise.is_finite() => {
            format!("{end} samples per pixel, relative standard error {:.3} %", 100.0 * noise)
        }
        _ => format!("{end} sample(s) per pixel"),
    }
}

/// The samples that the checkpoint holds, or none yet.
fn begin(job: &Job<'_>, goal: &Goal) -> Result<Rendered, Error> {
    let Range { start, end } = goal.samples;
    let Some(path) = goal.checkpoint.as_ref().filter(|path| path.exists()) else {
        let empty = |_: &String| Accumulator::new(job.identity.width, job.identity.height);
        let layers = job.render.layers().iter().map(empty).collect();
        return Ok(Rendered { layers, samples: start..start, interrupted: false });
    };
    let Shard { head, layers, .. } = shard::read(path)?;
    let problem = if let Err(problem) = check(job, &head) {
        format!("is the checkpoint of another rendering: {problem}")
    } else if head.samples.start != start {
        format!("begins with sample {}, not with {start}", head.samples.start)
    } else if head.samples.end > end {
        format!("has the samples up to {} already, more than the {end} asked for", head.samples.end)
    } else {
        return Ok(Rendered { layers, samples: head.samples, interrupted: false });
    };
    Err(FileError::new(path, problem + "; name another checkpoint, or remove it").into())
}

/// Checks that a part with this `head` has samples of `job`.
///
/// # Errors
/// The difference, if there is one.
pub(crate) fn check(job: &Job<'_>, head: &Head) -> Result<(), String> {
    if head.layers != job.render.layers() {
        let of = |layers: &[String]| layers.join(", ");
        let (there, here) = (of(&head.layers), of(&job.render.layers()));
        return Err(format!(
            "it has the sums of {there}, and this rendering has those of {here}; --denoise, --layers, \
             --aov and --composite must be as they were"
        ));
    }
    let difference = job.identity.difference(&head.identity);
    difference.map_or(Ok(()), |difference| Err(format!("this one has {difference}")))
}

/// Writes the checkpoint, if there is to be one.
fn save(job: &Job<'_>, goal: &Goal, rendered: &Rendered) -> Result<(), Error> {
    let Some(path) = &goal.checkpoint else { return Ok(()) };
    let _until_written = interrupt::writing();
    shard::write(path, &rendered.head(job), &rendered.layers)
}

/// The least number of samples above `done` at which the noise is checked: each is a quarter above
/// the one before.
fn next_check(done: u32) -> u32 {
    let mut check = FIRST_CHECK;
    while check <= done {
        check = check.saturating_add((check / 4).max(1));
        if check == u32::MAX {
            break;
        }
    }
    check
}

fn is_check(done: u32) -> bool {
    done > 0 && next_check(done - 1) == done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_looked_at_ever_more_rarely() {
        let mut checks = vec![next_check(0)];
        for _ in 0..5 {
            checks.push(next_check(checks[checks.len() - 1]));
        }
        assert_eq!(checks, [16, 20, 25, 31, 38, 47]);
        assert_eq!((next_check(17), next_check(u32::MAX - 1)), (20, u32::MAX));
        assert!(is_check(25) && !is_check(24) && !is_check(0));
    }
}
