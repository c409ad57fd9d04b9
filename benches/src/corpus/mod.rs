//! The corpus: random scenes from seeds, photographed by other renderers, recovered and scored.
//!
//! `cargo run --release -p unrender-benches -- corpus --seeds 0..60 --family in-model --out DIR`.
//! [`generate`] makes the scene of a seed, [`photograph`] has another renderer photograph it, [`spoil`]
//! makes the errors of the model, [`make`] writes all files, and [`verify`] compares each photograph
//! with our own rendering. [`recover`] runs the command under test, [`score`] compares its results with
//! the truth, [`relight`] tests them in other light and from another viewpoint, [`several`] photographs
//! it again from other places, [`summary`] and [`page`] report the results.

mod dice;
mod family;
pub(crate) mod generate;
mod make;
mod page;
mod photograph;
pub(crate) mod recover;
mod relight;
mod request;
mod result;
pub(crate) mod score;
mod several;
mod spoil;
mod store;
mod summary;
mod tiny;
mod verify;

pub(crate) use request::CorpusRequest;

use crate::Failure;
use crate::command::Unrender;
use generate::Plan;
use recover::{Subject, Wanted};
use result::Scored;
use std::time::Duration;
use store::{Folder, Meta};

/// Runs `request`.
///
/// # Errors
/// If a scene fails, unless `keep_going` is set.
pub(crate) fn run(request: &CorpusRequest) -> Result<(), Failure> {
    if request.tiny {
        return tiny::make(&request.out);
    }
    if request.verify {
        return each(request, |plan, folder, _| make::verify(plan, folder).map(|_| ()));
    }
    if request.photographs {
        return each(request, |_, _, _| Ok(()));
    }
    let command = match &request.command {
        Some(path) => path.clone(),
        None => Unrender::build()?.path().to_owned(),
    };
    let limit = Duration::from_secs(request.limit);
    let words: Vec<String> = request.recover_args.split_whitespace().map(str::to_owned).collect();
    let subject = Subject::new(&command, &words, limit)?;
    if request.several {
        let mut rows = Vec::new();
        each(request, |plan, folder, meta| {
            rows.extend(several::run(plan, folder, meta, &subject)?);
            Ok(())
        })?;
        return match &request.page {
            Some(path) => several::write(path, &rows),
            None => Ok(()),
        };
    }
    let relight = request.relight || request.family == family::Family::Foreign;
    let plain = if !relight {
        None
    } else if subject.knows("--max-rung") {
        Some(subject.with(&["--max-rung", "diffuse"])?)
    } else {
        eprintln!("the command has no --max-rung: there is no comparison with diffuse materials");
        None
    };
    let wanted = Wanted { subject: &subject, plain: plain.as_ref(), again: request.again, relight };
    let mut runs: Vec<Scored> = Vec::new();
    each(request, |plan, folder, meta| {
        if !make::is_sound(plan, folder)? {
            eprintln!("seed {}: its photograph does not agree with its truth; left out", plan.seed);
            return Ok(());
        }
        for way in request.ways(plan) {
            let scored = result::run(plan, folder, meta, way, wanted)?;
            tell(&scored);
            runs.push(scored);
        }
        Ok(())
    })?;
    let said = std::env::args().skip(1).collect::<Vec<_>>().join(" ");
    let section = page::section(request.family, &runs, &said);
    println!("{section}");
    if let Some(path) = &request.page {
        page::write(path, request.family, &runs, &said)?;
    }
    println!("{}", summary::line(request.family, &runs));
    Ok(())
}

/// Makes the requested scenes, and applies a function to each.
fn each(
    request: &CorpusRequest,
    mut act: impl FnMut(&Plan, &Folder, &Meta) -> Result<(), Failure>,
) -> Result<(), Failure> {
    for seed in request.seeds.clone() {
        let folder = Folder::new(&request.out, request.family, seed, request.renderer);
        let plan = make::plan(seed, request.family, request.renderer, request.picture_size());
        let done = make::photographs(&plan, &folder, request.quick)
            .and_then(|meta| act(&plan, &folder, &meta));
        if let Err(problem) = done {
            if !request.keep_going {
                return Err(problem);
            }
            eprintln!("seed {seed}: {problem}");
        }
    }
    Ok(())
}

/// Prints a line for a run, and one for each wrong group.
fn tell(scored: &Scored) {
    let (right, all) = summary::right(scored.groups.iter());
    let outcome = &scored.outcome;
    let failure = outcome.failure.as_ref().map_or(String::new(), |f| format!(", failed: {f}"));
    eprintln!(
        "seed {} {} {}: {right} of {all} right, {:.0} s, {} iterations{failure}",
        scored.seed,
        scored.format.name(),
        scored.dial.name(),
        outcome.seconds,
        outcome.iterations
    );
    for group in &scored.groups {
        let silent = if group.is_silent_failure() { ", a silent failure" } else { "" };
        if !group.verdict.is_right() || !silent.is_empty() {
            eprintln!(
                "  {} ({} pixels): {} for {}, rho_d {:.4} off, error {:.1} % over a floor of {:.1} %{silent}",
                group.group,
                group.pixels,
                group.found,
                group.truth,
                group.errors.rho_d.unwrap_or(f64::NAN),
                100.0 * group.error,
                100.0 * group.floor
            );
        }
    }
}
