//! Rooms that artists made: `cargo run --release -p unrender-benches -- rooms FOLDER`.
//!
//! Mitsuba photographs a published scene, unrender recovers its materials from that photograph, and both are
//! compared group by group, in the photograph, from a new viewpoint and in new light. [`room`] has the list of
//! rooms, [`studio`] runs the scripts of `benches/rooms` that prepare, photograph and score, [`recover`] runs the
//! command under test, and [`one_texture`] measures three published tasks. [`score`] reads the scores, [`summary`]
//! and [`page`] report them.

mod one_texture;
mod page;
mod recover;
mod request;
mod room;
mod rows;
mod score;
mod studio;
mod summary;

pub(crate) use request::RoomsRequest;

use crate::Failure;
use crate::command::Unrender;
use crate::corpus::recover::{Outcome, Subject};
use recover::Given;
use request::Photo;
use room::{Room, Rooms};
use score::{Forward, Score};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;
use studio::{Folder, Studio};

/// What was measured.
#[derive(Default)]
pub(crate) struct Done {
    pub(crate) rooms: Vec<Measured>,
    pub(crate) textures: Vec<one_texture::Outcome>,
}

/// What was measured in one room.
pub(crate) struct Measured {
    pub(crate) room: String,
    /// Our pictures of the true materials, by name; empty if the command cannot read the scene.
    pub(crate) forward: BTreeMap<String, Forward>,
    /// The recoveries from the photograph in its formats.
    pub(crate) recoveries: Vec<Recovery>,
    /// Mitsuba's own inverse, with its seconds.
    pub(crate) inverse: Option<(f64, Score)>,
    /// A small picture, if the licence allows to show it.
    pub(crate) shown: Option<PathBuf>,
}

/// One recovery with its scores.
pub(crate) struct Recovery {
    pub(crate) photo: Photo,
    pub(crate) outcome: Outcome,
    pub(crate) score: Score,
    /// The same with diffuse materials alone.
    pub(crate) diffuse: Option<Score>,
}

/// Measures the requested rooms, prints a line for each, and writes the page.
///
/// # Errors
/// If Mitsuba or all trees are absent, or the page cannot be written. A room that fails is reported, and the
/// others go on.
pub(crate) fn run(request: &RoomsRequest) -> Result<(), Failure> {
    let rooms = Rooms::load(request.quick)?;
    let present = present(request, &rooms)?;
    let studio = Studio::open(request, &rooms)?;
    let command = match &request.command {
        Some(path) => Unrender::at(path)?,
        None => Unrender::build()?,
    };
    let mut done = Done::default();
    if request.one_texture {
        done.textures = one_texture::measure(request, &rooms, &studio, &command)?;
    }
    for room in present {
        match measure(room, request, &studio, &command) {
            Ok(measured) => done.rooms.push(measured),
            Err(problem) => eprintln!("{}: {problem}", room.name),
        }
    }
    let label = request.label();
    if let Some(path) = request.page() {
        page::write(&path, &rooms, &done, (&label, request.effort.name()))?;
        eprintln!("written to {}", path.display());
    }
    for line in summary::all(&done, &label, request.effort) {
        println!("{line}");
    }
    Ok(())
}

/// The requested rooms whose files are there; none if other tasks are requested.
fn present<'a>(request: &RoomsRequest, rooms: &'a Rooms) -> Result<Vec<&'a Room>, Failure> {
    if request.one_texture {
        return Ok(Vec::new());
    }
    let chosen = rooms.choose(&request.rooms)?;
    let present: Vec<&Room> =
        chosen.into_iter().filter(|room| room.is_present(&request.folder)).collect();
    if present.is_empty() {
        return Err(format!(
            "{}: none of the rooms is there; benches/rooms/take_out.py takes them out of fetched repositories \
             (docs/validation/rooms.md)",
            request.folder.display()
        )
        .into());
    }
    Ok(present)
}

/// Photographs, recovers and scores one room.
fn measure(
    room: &Room,
    request: &RoomsRequest,
    studio: &Studio,
    command: &Unrender,
) -> Result<Measured, Failure> {
    let folder = studio.photograph(room, &request.folder)?;
    let given = Given::new(room, &folder, request.input, request.brdf.as_deref())?;
    let limit = Duration::from_secs(request.limit);
    let subject = Subject::new(command.path(), &request.recover_words(), limit)?;
    let forward = match given.render_truth(command, &subject) {
        Ok(pictures) => studio.forward(&folder, &pictures)?,
        Err(problem) => {
            eprintln!("{}: the true materials cannot be rendered: {problem}", room.name);
            BTreeMap::new()
        }
    };
    let plain = subject.with(&[
        "--effort",
        request.effort.name(),
        "--allow-outside",
        "--max-rung",
        "diffuse",
    ])?;
    let (mut recoveries, mut shown) = (Vec::new(), None);
    for photo in request.photo.all() {
        let (run, outcome) = given.recover(&subject, photo, request.again)?;
        if let Some(problem) = &outcome.failure {
            eprintln!("{}, {}: {problem}", room.name, photo.name());
            continue;
        }
        let pictures = match request.materials_only {
            true => Vec::new(),
            false => given.render_result(command, &run)?,
        };
        let score = studio.score(&folder, &run, &pictures)?;
        if let (None, true, Some((_, relit))) = (&shown, room.may_be_shown(), pictures.last()) {
            shown = Some(studio.show(&folder, relit)?);
        }
        let diffuse = match request.materials_only {
            true => None,
            false => diffuse(&given, &plain, photo, (request, studio, command))?,
        };
        recoveries.push(Recovery { photo, outcome, score, diffuse });
    }
    let inverse = inverse(request, studio, &folder)?;
    Ok(Measured { room: room.name.clone(), forward, recoveries, inverse, shown })
}

/// The scores of diffuse materials alone, if they can be recovered.
fn diffuse(
    given: &Given<'_>,
    plain: &Subject,
    photo: Photo,
    (request, studio, command): (&RoomsRequest, &Studio, &Unrender),
) -> Result<Option<Score>, Failure> {
    let (run, outcome) = given.recover(plain, photo, request.again)?;
    if outcome.failure.is_some() {
        return Ok(None);
    }
    let pictures = given.render_result(command, &run)?;
    Ok(Some(studio.score(given.folder(), &run, &pictures)?))
}

/// Mitsuba's own inverse, if it is requested.
fn inverse(
    request: &RoomsRequest,
    studio: &Studio,
    folder: &Folder,
) -> Result<Option<(f64, Score)>, Failure> {
    let Some(seconds) = request.peer else { return Ok(None) };
    Ok(Some((seconds, studio.inverse(folder, seconds)?)))
}
