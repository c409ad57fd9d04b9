//! The faults that strike commands.

use super::work::{Bench, Work};
use crate::random::Random;
use nix::sys::resource::{Resource, getrlimit, setrlimit};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A fault of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fault {
    /// SIGKILL at a random moment.
    Kill,
    /// SIGTERM at a random moment.
    Terminate,
    /// SIGINT, which is Ctrl-C, at a random moment.
    Interrupt,
    /// Files cannot grow beyond a random size.
    Limited,
    /// The disk is full after a random number of bytes.
    Full,
    /// The existing result is write-protected, or also the folder around it.
    ReadOnly,
    /// Standard output and error are closed at a random moment, or are full from the beginning.
    Closed,
    /// The same command is started again at a random moment.
    Two,
    /// No terminal, no input, in its own session.
    NoTerminal,
}

/// How a command ended.
#[derive(Default)]
pub(crate) struct Told {
    /// Whether it reported success.
    pub(crate) succeeded: bool,
    pub(crate) problems: Vec<String>,
}

/// A command that has not ended after this time hangs.
const PATIENCE: Duration = Duration::from_secs(300);
/// The size beyond which files cannot grow is below this, bytes: most results are smaller.
const LARGEST: usize = 60_000;

impl Fault {
    /// Kills come twice, as they are the most important.
    pub(crate) const ALL: [Self; 10] = [
        Self::Kill,
        Self::Kill,
        Self::Terminate,
        Self::Interrupt,
        Self::Limited,
        Self::Full,
        Self::ReadOnly,
        Self::Closed,
        Self::Two,
        Self::NoTerminal,
    ];

    /// The reason why the machine cannot have this fault; none if it can.
    pub(crate) fn missing(self, bench: &Bench) -> Option<&'static str> {
        match self {
            Self::ReadOnly if !bench.user.is_held_back() => {
                Some("root may write everywhere, and no other user can run this program")
            }
            Self::Full if !bench.has_disks() => {
                Some("only root has file systems of a few kilobytes")
            }
            _ => None,
        }
    }

    /// Runs `work` in `folder` with this fault after `moment`.
    ///
    /// # Errors
    /// If the command cannot be run.
    pub(crate) fn strike(
        self,
        bench: &Bench,
        work: &Work,
        folder: &Path,
        moment: Duration,
        random: &mut Random,
    ) -> io::Result<Told> {
        let mut command = bench.command(folder, &work.words);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        match self {
            Self::Kill => self.signalled(command.spawn()?, moment, Signal::SIGKILL, &[0]),
            Self::Terminate => self.signalled(command.spawn()?, moment, Signal::SIGTERM, &[0, 143]),
            Self::Interrupt => self.signalled(command.spawn()?, moment, Signal::SIGINT, &[0, 130]),
            Self::Limited => {
                let running = with_limit(random.below(LARGEST) as u64, &mut command)?;
                self.ended(running, &[0, 1])
            }
            // The disk is full as `folder` was prepared.
            Self::Full => self.ended(command.spawn()?, &[0, 1]),
            Self::ReadOnly => {
                let result = folder.join(work.out);
                let is_all = random.below(2) == 0 || !result.exists();
                let place = if is_all { folder.to_owned() } else { result };
                protect(&place, true)?;
                let told = self.ended(command.spawn()?, &[0, 1]);
                protect(&place, false)?;
                let mut told = told?;
                if is_all && told.succeeded {
                    told.problems.push("it wrote into a folder that is write-protected".into());
                }
                Ok(told)
            }
            Self::Closed if random.below(2) == 0 => {
                let full = || OpenOptions::new().write(true).open("/dev/full");
                let running = command.stdout(full()?).stderr(full()?).spawn()?;
                self.ended(running, &[0])
            }
            Self::Closed => {
                let mut running = command.stdout(Stdio::piped()).spawn()?;
                sleep(moment);
                drop((running.stdout.take(), running.stderr.take()));
                self.ended(running, &[0])
            }
            Self::Two => {
                let first = command.spawn()?;
                sleep(moment);
                let second = command.spawn()?;
                let (first, second) = (self.ended(first, &[0, 1])?, self.ended(second, &[0, 1])?);
                let mut problems = [first.problems, second.problems].concat();
                let succeeded = first.succeeded || second.succeeded;
                if !succeeded {
                    problems.push("neither of the two succeeded".into());
                }
                Ok(Told { succeeded, problems })
            }
            Self::NoTerminal => {
                let mut session = bench.in_session(folder, &work.words);
                session.stdout(Stdio::null()).stderr(Stdio::piped());
                self.ended(session.spawn()?, &[0])
            }
        }
    }

    /// Sends `signal` after `moment`, and waits for the end.
    fn signalled(
        self,
        running: Child,
        moment: Duration,
        signal: Signal,
        codes: &[i32],
    ) -> io::Result<Told> {
        sleep(moment);
        // It may have ended by itself.
        let _ = kill(Pid::from_raw(running.id() as i32), signal);
        self.ended(running, codes)
    }

    /// Waits for the end of `running`, with one of the exit `codes`, or killed by the signal.
    fn ended(self, mut running: Child, codes: &[i32]) -> io::Result<Told> {
        let stderr = running.stderr.take();
        let said = std::thread::spawn(|| {
            let mut said = String::new();
            // Output that is not text is ignored.
            let _ = stderr.map(|mut stderr| stderr.read_to_string(&mut said));
            said
        });
        let mut problems = Vec::new();
        let status = match patiently(&mut running)? {
            Some(status) => status,
            None => {
                problems.push(format!("it did not end within {} s", PATIENCE.as_secs()));
                running.kill()?;
                running.wait()?
            }
        };
        let said = said.join().unwrap_or_default();
        let is_expected = match status.code() {
            Some(code) => codes.contains(&code),
            // Signals may come before the program handles them.
            None => matches!(self, Self::Kill | Self::Terminate | Self::Interrupt),
        };
        // With closed outputs there is no message.
        let says_why = self == Self::Closed || status.code() != Some(1) || said.contains("error");
        if !is_expected || !says_why || said.contains("panicked") {
            problems.push(format!("{status}: {}", said.trim()));
        }
        Ok(Told { succeeded: status.success(), problems })
    }
}

fn patiently(running: &mut Child) -> io::Result<Option<ExitStatus>> {
    let started = Instant::now();
    while started.elapsed() < PATIENCE {
        if let Some(status) = running.try_wait()? {
            return Ok(Some(status));
        }
        sleep(Duration::from_millis(2));
    }
    Ok(None)
}

/// Starts `command` with files that cannot grow beyond `bytes`. It inherits the limit; this process
/// writes nothing meanwhile.
fn with_limit(bytes: u64, command: &mut Command) -> io::Result<Child> {
    let (soft, hard) = getrlimit(Resource::RLIMIT_FSIZE)?;
    setrlimit(Resource::RLIMIT_FSIZE, bytes.min(hard), hard)?;
    let running = command.spawn();
    setrlimit(Resource::RLIMIT_FSIZE, soft, hard)?;
    running
}

/// Sets or removes the write protection of `path` and of all files in it.
fn protect(path: &Path, protected: bool) -> io::Result<()> {
    if File::open(path).is_err() {
        return Ok(());
    }
    if path.is_dir() {
        if !protected {
            fs::set_permissions(path, Permissions::from_mode(0o755))?;
        }
        for entry in fs::read_dir(path)? {
            protect(&entry?.path(), protected)?;
        }
        if protected {
            fs::set_permissions(path, Permissions::from_mode(0o555))?;
        }
        return Ok(());
    }
    fs::set_permissions(path, Permissions::from_mode(if protected { 0o444 } else { 0o644 }))
}
