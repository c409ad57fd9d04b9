//! The `unrender` command: everything is in the library, see `unrender::cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    unrender::cli::run()
}
