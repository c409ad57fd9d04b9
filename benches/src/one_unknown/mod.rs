//! An experiment in seconds: `cargo run --release -p unrender-benches -- one-unknown PROJECT TRUTH`.
//!
//! All groups of a project but one are held at the truth, each group in turn is the one that is asked for, and
//! one line says what came out of it. [`choice`] says which groups are asked for, [`ask`] recovers one,
//! [`row`] makes its line, and [`summary`] the last lines: whether the photograph contradicts the truth, so that
//! the light is wrong, or a group's own choice of a hypothesis is. `docs/contributing.md` says how to read them.

mod ask;
mod choice;
mod request;
mod row;
mod summary;

pub(crate) use request::OneUnknownRequest;

use crate::Failure;
use ask::Experiment;
use row::Table;
use std::time::Instant;

/// Asks for one group after the other.
///
/// # Errors
/// If project or truth cannot be used, or a group that is named cannot be asked for.
pub(crate) fn run(request: &OneUnknownRequest) -> Result<(), Failure> {
    let started = Instant::now();
    let mut experiment = Experiment::load(request)?;
    let asked = choice::choose(&experiment.candidates, &request.groups)?;
    let table = Table::new(asked.iter().map(|group| experiment.candidates[*group].name.as_str()));
    let errors_at_truth = experiment.errors_at_truth()?;
    println!("{}", table.head());
    let mut rows = Vec::new();
    for group in asked {
        for seed in 0..request.seeds {
            let row = experiment.ask(group, seed, errors_at_truth[group])?;
            println!("{}", table.line(&row));
            rows.push(row);
        }
    }
    println!("{}", summary::text(&rows, started.elapsed().as_secs_f64()));
    Ok(())
}
