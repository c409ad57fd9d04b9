//! `unrender view`: a page on which one plays with the lamps and colours of a result.

use crate::global::Global;
use crate::report::{self, ExactCommand};
use crate::{Error, interrupt, output, playable, result_folder};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use unrender_formats::atomic;
use unrender_render::Settings;

/// Makes a page on which lamps are dimmed and groups recoloured at once, without a network.
///
/// Lamps are exact: the picture is the sum of their light. Colours are of first order with all interreflections, and the
/// page says how far that is off; it gives the command that renders the same exactly.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender view out\n  \
    unrender view out --project room.toml --spp 256 --out room.html --no-open")]
pub struct Args {
    /// A folder that recover wrote.
    #[arg(value_name = "RESULT")]
    pub result: PathBuf,
    /// The project of the result [default: the one that it names, else the result's own scene.glb and photograph].
    #[arg(long, value_name = "FILE.toml")]
    pub project: Option<PathBuf>,
    /// The page [default: view.html in the folder].
    #[arg(long, value_name = "FILE.html")]
    pub out: Option<PathBuf>,
    /// Do not open the page in a browser.
    #[arg(long)]
    pub no_open: bool,
    /// Samples per pixel of the picture; its parts get half as many.
    #[arg(long, value_name = "N", default_value_t = 64)]
    #[arg(value_parser = clap::value_parser!(u32).range(8..))]
    pub spp: u32,
    /// Chooses the noise; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

/// Runs the command.
///
/// # Errors
/// If the folder has no results, their scene cannot be read, or the page cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let out = args.out.clone().unwrap_or_else(|| args.result.join(report::VIEW));
    result_folder::check(&args.result)?;
    output::check_file(&out, &["html", "htm"], "end the name of the page in .html")?;
    output::check_inputs(&out, args.project.as_deref())?;
    let settings = Settings { spp: args.spp, seed: args.seed, ..Settings::default() };
    let play = playable::play(&args.result, args.project.as_deref(), &settings, global)?;
    let command = ExactCommand::of(&args.result, &play);
    let page = report::view(&args.result, &play, &command)?;
    let _until_written = interrupt::writing();
    atomic::write(&out, page.as_bytes())?;
    if args.out.is_none() {
        result_folder::note(&args.result, report::VIEW, "recover")?;
        // Its report leads to the page from now on.
        report::write(&args.result)?;
        result_folder::note(&args.result, report::FILE, "recover")?;
    }
    let is_shown = !args.no_open && open(&out);
    if !global.quiet {
        let how = if is_shown {
            "is written, and opens in the browser"
        } else {
            "is written: open it in a browser"
        };
        global.console.tell(&format!("{} {how}", out.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Opens `page` with the system's program for it; whether there was one.
fn open(page: &Path) -> bool {
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let silent = |command: &mut Command| {
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().is_ok()
    };
    silent(Command::new(opener).arg(page))
}
