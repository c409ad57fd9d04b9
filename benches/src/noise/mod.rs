//! Measures the noise of our light: `cargo run --release --bin performance -- noise`.
//!
//! Each scene is rendered twice with its true materials, by independent paths and with independent
//! random numbers. The difference of the two pictures is only noise: no reference is needed, and a bias
//! is not seen. [`cases`] names the scenes, [`made`] builds those that are hard for a path tracer,
//! [`measure`] renders one, [`statistics`] computes the noise from the two pictures, [`table`] prints
//! its lines, [`summary`] the last one, [`compare`] compares them with an earlier run ([`record`]), and
//! [`explain`] finds the paths that cause the noise. `docs/contributing.md` describes the output.

pub(crate) mod cases;
mod compare;
mod explain;
mod made;
pub(crate) mod measure;
mod record;
mod request;
mod stage;
mod statistics;
mod summary;
mod table;

pub(crate) use request::NoiseRequest;

use crate::{Failure, machine};
use compare::Before;
use measure::{Paths, Shot};
use record::Record;
use summary::Summary;
use table::Table;

/// Measures one scene after the other, and prints each line at once.
///
/// # Errors
/// If there is no scene of a name, a scene cannot be loaded, or a file cannot be read or written.
pub(crate) fn run(request: &NoiseRequest) -> Result<(), Failure> {
    let all = cases::all(request.corpus.as_deref())?;
    let chosen = cases::choose(all, &request.cases)?;
    let before = request.against.as_deref().map(Before::read).transpose()?;
    if let Some(before) = &before {
        println!("{}", before.sentence());
    }
    let table = Table::new(chosen.iter().map(|case| case.name.as_str()), before.is_some());
    println!("{}", table.head());
    let paths = Paths { spp: request.spp, seed: request.seed };
    let mut record = Record::new(machine::origin());
    let mut missing = Vec::new();
    let mut summary = Summary::default();
    for case in &chosen {
        let in_case = |problem: Failure| -> Failure { format!("{}: {problem}", case.name).into() };
        let shot: Shot = case.load().map_err(in_case)?;
        let (noise, pictures) = measure::measure(&shot, paths).map_err(in_case)?;
        let compared = before.as_ref().and_then(|before| before.compare(&case.name, &noise));
        summary.add(&case.name, &noise, compared.as_ref());
        if compared.is_none() {
            missing.push(case.name.as_str());
        }
        table.lines(&case.name, &noise, compared.as_ref()).iter().for_each(|l| println!("{l}"));
        if request.explain {
            explain::lines(&shot, paths, &pictures).iter().for_each(|line| println!("    {line}"));
        }
        record.scenes.insert(case.name.clone(), noise);
        if let Some(file) = &request.save {
            // Written after every scene, so that an interrupted run keeps its results.
            record.write(file)?;
        }
    }
    if let Some(said) = before.as_ref().and_then(|before| before.without(&missing)) {
        println!("{said}");
    }
    println!("{}", summary.line());
    Ok(())
}
