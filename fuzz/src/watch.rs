//! Watches a worker: passes its lines on, ends it when it is silent for too long, and says what killed it.

use std::io::{self, BufRead, BufReader, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// The most clock time of a case, in times of its processor time: a machine may have ten times the load. With half of it,
/// such machines report false findings; with double, a reader that waits without end costs four minutes.
const PATIENCE: u32 = 12;

/// Runs this program as a worker with `words`, which may take so many `seconds` of a processor between two lines, and
/// passes each of its lines to `each`; returns what was wrong with its end, if anything.
///
/// # Errors
/// If the worker cannot be started or stopped.
pub(crate) fn watch(
    words: &[String],
    seconds: u32,
    mut each: impl FnMut(&str),
) -> io::Result<Option<String>> {
    let patience = Duration::from_secs(u64::from(PATIENCE * seconds));
    let mut running = Command::new(std::env::current_exe()?)
        .args(words)
        // One thread: the limit of processor time is then one of time as well.
        .env("RAYON_NUM_THREADS", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (sender, receiver) = mpsc::channel();
    let lines = running.stdout.take().map(BufReader::new);
    let reader = std::thread::spawn(move || {
        for line in lines.into_iter().flat_map(BufRead::lines).map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let said = running.stderr.take().map(|stderr| std::thread::spawn(|| told(stderr)));
    let mut problem = None;
    loop {
        match receiver.recv_timeout(patience) {
            Ok(line) => each(&line),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                running.kill()?;
                problem = Some(format!("took more than {} s", patience.as_secs()));
                break;
            }
        }
    }
    let status = running.wait()?;
    // It ends with the pipe.
    let _ = reader.join();
    let said = said.and_then(|said| said.join().ok()).unwrap_or_default();
    Ok(problem.or_else(|| (!status.success()).then(|| death(status, &said, seconds))))
}

/// What ended a process that failed with `status` and `said` this, and had so many `seconds` of a processor.
fn death(status: ExitStatus, said: &str, seconds: u32) -> String {
    let ended = status.to_string();
    if ended.contains("SIGXCPU") {
        return format!("took more than {seconds} s of a processor");
    }
    let line = said.lines().find(|line| line.contains("panicked") || line.contains("memory"));
    format!("{ended}: {}", line.unwrap_or(said.trim()))
}

/// The output on `stderr` without warnings, of which there may be many. It need not be text.
fn told(stderr: impl Read) -> String {
    let lines = BufReader::new(stderr).split(b'\n').map_while(Result::ok);
    let lines = lines.map(|line| String::from_utf8_lossy(&line).into_owned());
    lines.filter(|line| !line.starts_with("warning:")).collect::<Vec<_>>().join("\n")
}
