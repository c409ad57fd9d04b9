//! `unrender completions`: the completion script of a shell, from the command's own definition.

use crate::Error;
use crate::output::print;
use clap_complete::Shell;
use std::process::ExitCode;

/// Prints the completion script of a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender completions bash > ~/.local/share/bash-completion/completions/unrender\n  \
    unrender completions zsh > ~/.zfunc/_unrender\n  \
    unrender completions fish > ~/.config/fish/completions/unrender.fish")]
pub struct Args {
    /// The shell.
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Runs the command; `definition` is that of the whole command line.
///
/// # Errors
/// None today; all subcommands have one signature.
pub fn run(args: &Args, mut definition: clap::Command) -> Result<ExitCode, Error> {
    let name = definition.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut definition, name, &mut script);
    print(&String::from_utf8_lossy(&script));
    Ok(ExitCode::SUCCESS)
}
