//! `unrender report`: makes the pages of finished recoveries from their files.

use crate::global::Global;
use crate::{Error, interrupt, output, report, result_folder};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::atomic;

/// Makes the page of a recovery again, or one that compares several.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender report out\n  \
    unrender report out_default out_paper --out compare.html")]
pub struct Args {
    /// Folders that recover wrote.
    #[arg(required = true, value_name = "DIR")]
    pub runs: Vec<PathBuf>,
    /// The page [default, for a single folder: its report.html].
    #[arg(long, value_name = "FILE.html")]
    pub out: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// If a folder has no results or the page cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let out = match (&args.out, &args.runs[..]) {
        (Some(out), _) => out.clone(),
        (None, [run]) => run.join(report::FILE),
        (None, _) => {
            let problem = "several folders are compared on one page: name it with --out FILE.html";
            return Err(Error::Request(problem.to_owned()));
        }
    };
    output::check_file(&out, &["html", "htm"], "end the name of the page in .html")?;
    for run in &args.runs {
        result_folder::check(run)?;
    }
    let page = match &args.runs[..] {
        [run] => report::page(run)?,
        runs => report::comparison(runs)?,
    };
    let _until_written = interrupt::writing();
    atomic::write(&out, page.as_bytes())?;
    if let (None, [run]) = (&args.out, &args.runs[..]) {
        result_folder::note(run, report::FILE, "recover")?;
    }
    if !global.quiet {
        global.console.tell(&format!("{} is written", out.display()));
    }
    Ok(ExitCode::SUCCESS)
}
