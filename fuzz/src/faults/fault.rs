//! The faults.

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

/// What happens to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fault {
    /// SIGKILL at a random moment.
    Kill,
    /// SIGTERM at a random moment.
    Terminate,
    /// Files cannot grow beyond a random size.
    Full,
    /// What is there is write-protected.
    ReadOnly,
    /// Standard output and error are closed at a random moment, or are full from the beginning.
    Closed,
    /// The same command once more at a random moment.
    Two,
    /// No terminal, no input, a session of its own.
    NoTerminal,
}

/// How a command ended.
#[derive(Default)]
pub(crate) struct Told {
    /// Whether it said that all went well.
    pub(crate) succeeded: bool,
    pub(crate) problems: Vec<String>,
}

/// A command that has not ended after this time hangs.
const PATIENCE: Duration = Duration::from_secs(300);
/// The size beyond which files cannot grow is below this, bytes: most results are smaller.
const LARGEST: usize = 60_000;

impl Fault {
    /// Kills come twice: they are what most is asked about.
    pub(crate) const ALL: [Self; 8] = [
        Self::Kill,
        Self::Kill,
        Self::Terminate,
        Self::Full,
        Self::ReadOnly,
        Self::Closed,
        Self::Two,
        Self::NoTerminal,
    ];

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
            Self::Kill => {
                let mut running = command.spawn()?;
                sleep(moment);
                // It may have ended by itself.
                let _ = running.kill();
                self.ended(running, &[0])
            }
            Self::Terminate => {
                let running = command.spawn()?;
                sleep(moment);
                let _ = kill(Pid::from_raw(running.id() as i32), Signal::SIGTERM);
                self.ended(running, &[0, 143])
            }
            Self::Full => {
                let running = with_limit(random.below(LARGEST) as u64, &mut command)?;
                self.ended(running, &[0, 1])
            }
            Self::ReadOnly => {
                protect(&folder.join(work.out), true)?;
                let told = self.ended(command.spawn()?, &[0, 1]);
                protect(&folder.join(work.out), false)?;
                told
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
                let mut session = Command::new("setsid");
                session.arg("--wait").arg(command.get_program()).args(command.get_args());
                session.current_dir(folder).env(super::work::AS_COMMAND, "1").env_remove("TERM");
                session.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
                self.ended(session.spawn()?, &[0])
            }
        }
    }

    /// Waits for the end of `running`, which is one of `codes`, or its death by the signal.
    fn ended(self, mut running: Child, codes: &[i32]) -> io::Result<Told> {
        let stderr = running.stderr.take();
        let said = std::thread::spawn(|| {
            let mut said = String::new();
            // What is no text is left out.
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
            // SIGTERM may come before the program can hear it.
            None => matches!(self, Self::Kill | Self::Terminate),
        };
        if !is_expected || said.contains("panicked") {
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

/// Starts `command` with files that cannot grow beyond `bytes`. The limit is inherited; here nothing is
/// written meanwhile.
fn with_limit(bytes: u64, command: &mut Command) -> io::Result<Child> {
    let (soft, hard) = getrlimit(Resource::RLIMIT_FSIZE)?;
    setrlimit(Resource::RLIMIT_FSIZE, bytes.min(hard), hard)?;
    let running = command.spawn();
    setrlimit(Resource::RLIMIT_FSIZE, soft, hard)?;
    running
}

/// Protects what lies at `path` from writing, or lifts that.
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
