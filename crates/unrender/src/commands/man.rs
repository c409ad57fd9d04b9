//! `unrender man`: manual pages, from the command's own definition.

use crate::global::Global;
use crate::{Error, interrupt, output};
use clap_mangen::Man;
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::{FileError, atomic};

/// Writes the manual pages: unrender.1, and one for every subcommand.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    unrender man --out ~/.local/share/man/man1\n  \
    man unrender-recover")]
pub struct Args {
    /// The folder for the pages; pages of the same name there are replaced.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the command; `definition` is that of the whole command line.
///
/// # Errors
/// If a page cannot be written.
pub fn run(args: &Args, global: &Global, definition: clap::Command) -> Result<ExitCode, Error> {
    output::prepare_folder(&args.out)?;
    let _until_written = interrupt::writing();
    let pages = pages(definition).map_err(|error| FileError::new(&args.out, error))?;
    for (name, page) in &pages {
        atomic::write(&args.out.join(name), page)?;
    }
    if !global.quiet {
        output::tell(&format!("{} pages in {}", pages.len(), args.out.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// The pages of `definition` by the names of their files, that of the whole command first.
fn pages(mut definition: clap::Command) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    definition.build();
    let shown = definition.get_subcommands().filter(|sub| sub.get_name() != "help").cloned();
    let all = std::iter::once(definition.clone()).chain(shown.collect::<Vec<_>>());
    let page = |definition: clap::Command| {
        let man = Man::new(definition);
        let mut text = Vec::new();
        man.render(&mut text)?;
        Ok((man.get_filename(), text))
    };
    all.map(page).collect()
}
