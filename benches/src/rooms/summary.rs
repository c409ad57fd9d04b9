//! One line a room and photograph.

use super::page::LARGE;
use super::request::RoomEffort;
use super::score::Score;
use super::{Done, Measured, Recovery};
use std::fmt::Write;

/// All lines.
pub(crate) fn all(done: &Done, label: &str, effort: RoomEffort) -> Vec<String> {
    let textures = done.textures.iter().map(|outcome| {
        format!(
            "{} ({label}, {}): error {:.4} in {:.0} s; Mitsuba {:.4} in the same time, {} iterations",
            outcome.task,
            effort.name(),
            outcome.error,
            outcome.seconds,
            outcome.mitsuba.0,
            outcome.mitsuba.1
        )
    });
    let rooms = done.rooms.iter().flat_map(|measured| lines(measured, label, effort));
    rooms.chain(textures).collect()
}

/// The lines of a room.
fn lines(measured: &Measured, label: &str, effort: RoomEffort) -> Vec<String> {
    let forward = forward(measured);
    let mut lines: Vec<String> = measured
        .recoveries
        .iter()
        .map(|recovery| {
            let name = format!(
                "{} ({label}, {}, {})",
                measured.room,
                recovery.photo.name(),
                effort.name()
            );
            format!("{name}: {}; {forward}; {:.0} s", materials(recovery), recovery.outcome.seconds)
        })
        .collect();
    if lines.is_empty() {
        lines.push(format!("{} ({label}): not recovered; {forward}", measured.room));
    }
    if let (Some((seconds, score)), Some(line)) = (&measured.inverse, lines.last_mut()) {
        let _ = write!(
            line,
            "; Mitsuba's inverse {:.1} dB, {:.1} dB in {seconds:.0} s",
            score.albedo_db, score.roughness_db
        );
    }
    lines
}

fn materials(recovery: &Recovery) -> String {
    let score = &recovery.score;
    let mut text = format!(
        "albedo {:.1} dB, roughness {:.1} dB; {:.0} % of the error in groups called recovered; {} of {} groups \
         wrong, {} told",
        score.albedo_db,
        score.roughness_db,
        100.0 * score.silent_share,
        score.wrong,
        score.groups,
        score.wrong_and_told
    );
    for (name, words) in [("new_view", "new view"), ("new_light", "new light")] {
        let psnr = |score: &Score| score.pictures.get(name).map(|picture| picture.psnr);
        let Some(found) = psnr(score) else { continue };
        let _ = write!(text, "; {words} {found:.1} dB");
        if let Some(plain) = recovery.diffuse.as_ref().and_then(psnr) {
            let _ = write!(text, " (diffuse {plain:.1})");
        }
    }
    text
}

fn forward(measured: &Measured) -> String {
    let Some(forward) = measured.forward.get("photo") else {
        return "true materials not rendered".to_owned();
    };
    let (alike, all) = forward.alike(LARGE);
    format!(
        "at the truth {:.3} of Mitsuba's light, {alike} of {all} groups within 3 %",
        forward.mean
    )
}
