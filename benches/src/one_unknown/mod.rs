//! Recovers one group at a time, in seconds:
//! `cargo run --release -p unrender-benches -- one-unknown PROJECT TRUTH`.
//!
//! Each group of a project in turn is recovered while all others are held at the truth, with one line per
//! result. [`choice`] chooses the groups, [`ask`] recovers one, [`row`] makes its line, and [`summary`] the last
//! lines: whether the photograph contradicts the truth, so that the light is wrong, or whether a group's own
//! choice of a hypothesis is wrong. `docs/contributing.md` describes them.

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

/// Recovers one group after the other.
///
/// # Errors
/// If project or truth cannot be used, or a named group cannot be recovered.
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
