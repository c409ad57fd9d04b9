//! What a recovery costs, in renderings: `cargo bench -p unrender --bench recovery_cost`.
//!
//! Recovers Figure 8 with the built command, then renders its view once with the true materials and
//! 256 paths a pixel, and prints both times, their ratio and the recovery's peak memory. Nothing is
//! asserted: times depend on the machine, and on what else it does.

use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

const SPP: u32 = 256;
/// The recovery is compared with this many renderings.
const RENDERINGS: f64 = 6.0;

fn main() -> Result<(), Box<dyn Error>> {
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("skipped: this takes minutes; run it by `cargo bench`");
        return Ok(());
    }
    let fig8 = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fig8");
    let folder = Folder::new()?;
    let photo = unrender::formats::picture::read(&fig8.join("photo.exr"))?.0.values;
    let (width, height) = (photo.width(), photo.height());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("Figure 8, {width} x {height}, {threads} threads");

    // The recovery comes first: the peak is the highest of all commands so far.
    let recover: [OsString; 5] = [
        "recover".into(),
        fig8.join("fig8.toml").into(),
        "--out".into(),
        folder.0.join("out").into(),
        "--quiet".into(),
    ];
    let recovery = run(&recover)?;
    let peak = children::peak_memory();
    tell("recovery", &recovery.to_string());

    let render: [OsString; 13] = [
        "render".into(),
        fig8.join("scene.glb").into(),
        "--materials".into(),
        fig8.join("truth.json").into(),
        "--width".into(),
        width.to_string().into(),
        "--height".into(),
        height.to_string().into(),
        "--spp".into(),
        SPP.to_string().into(),
        "--out".into(),
        folder.0.join("rendered.exr").into(),
        "--quiet".into(),
    ];
    let rendering = run(&render)?;
    tell(&format!("rendering, {SPP} spp"), &rendering.to_string());

    let ratio = |f: fn(&Cost) -> Option<Duration>| {
        let seconds = |cost: &Cost| f(cost).map(|time| time.as_secs_f64());
        let ratio = seconds(&recovery)? / (RENDERINGS * seconds(&rendering)?);
        Some(format!("{ratio:.2}"))
    };
    let [by_clock, by_cpu] = [ratio(|c| Some(c.elapsed)), ratio(|c| c.cpu)].map(or_unknown);
    let compared = format!("{by_clock} (processor time: {by_cpu})");
    tell(&format!("recovery / {RENDERINGS} renderings"), &compared);
    let peak = peak.map(|bytes| format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20)));
    tell("recovery's peak memory", &or_unknown(peak));
    Ok(())
}

fn tell(what: &str, value: &str) {
    println!("{what:<24}  {value}");
}

fn or_unknown(value: Option<String>) -> String {
    value.unwrap_or_else(|| "unknown".to_owned())
}

/// What a command took.
struct Cost {
    elapsed: Duration,
    /// Processor time of all its threads, where the system tells.
    cpu: Option<Duration>,
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let cpu = self.cpu.map(|cpu| format!("{:.1} s", cpu.as_secs_f64()));
        write!(f, "{:.1} s (processor time: {})", self.elapsed.as_secs_f64(), or_unknown(cpu))
    }
}

/// Runs the built command to its end.
fn run(arguments: &[OsString]) -> Result<Cost, Box<dyn Error>> {
    let before = children::processor_time();
    let started = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_unrender")).args(arguments).status()?;
    let elapsed = started.elapsed();
    if !status.success() {
        return Err(format!("unrender {arguments:?} ended with {status}").into());
    }
    let cpu = children::processor_time().zip(before).map(|(after, before)| after - before);
    Ok(Cost { elapsed, cpu })
}

/// What the system knows of the commands that have ended.
#[cfg(unix)]
mod children {
    use nix::sys::resource::{Usage, UsageWho, getrusage};
    use std::time::Duration;

    fn usage() -> Option<Usage> {
        getrusage(UsageWho::RUSAGE_CHILDREN).ok()
    }

    /// Processor time of all of them together.
    pub(super) fn processor_time() -> Option<Duration> {
        let usage = usage()?;
        let spent = |time: nix::sys::time::TimeVal| {
            Duration::from_secs(time.tv_sec() as u64) + Duration::from_micros(time.tv_usec() as u64)
        };
        Some(spent(usage.user_time()) + spent(usage.system_time()))
    }

    /// The largest memory that one of them held at a time, bytes.
    pub(super) fn peak_memory() -> Option<u64> {
        let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
        u64::try_from(usage()?.max_rss()).ok().map(|rss| unit * rss)
    }
}

/// Other systems tell nothing of this kind.
#[cfg(not(unix))]
mod children {
    pub(super) fn processor_time() -> Option<std::time::Duration> {
        None
    }

    pub(super) fn peak_memory() -> Option<u64> {
        None
    }
}

/// A folder of its own among the temporary files; it goes with the value.
struct Folder(PathBuf);

impl Folder {
    fn new() -> std::io::Result<Self> {
        let path = std::env::temp_dir().join(format!("unrender-bench-{}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        Ok(Self(path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that is left behind in the temporary files does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
