//! Writes `docs/validation/rooms.md`.

use super::one_texture::Outcome;
use super::room::{Published, Room, Rooms};
use super::score::{Forward, Score};
use super::{Done, Measured, Recovery, rows};
use crate::table::Table;
use crate::{Failure, machine};
use std::fmt::Write;
use std::path::Path;
use unrender::formats::atomic;

/// The text above the measurements.
const HEAD: &str = include_str!("page_head.md");

/// Groups of so many pixels are compared one by one: their means have noise below 1 %. Half: noise reaches the 3 %
/// of agreement; double: half of the groups are no longer seen.
pub(crate) const LARGE: usize = 500;

/// The heads of the tables. The first cells of a row are its key.
const RECOVERY: [&str; 10] = [
    "room",
    "program",
    "photograph",
    "albedo",
    "roughness",
    "error in groups called recovered",
    "groups wrong",
    "of these told",
    "right but told",
    "seconds",
];
const PICTURES: [&str; 7] =
    ["room", "program", "photograph", "new view", "diffuse only", "new light", "diffuse only"];
const INVERSE: [&str; 5] = ["room", "seconds", "albedo", "roughness", "groups wrong"];
const FORWARD: [&str; 5] = ["room", "program", "light", "whole picture", "groups within 3 %"];
const GROUPS: [&str; 7] =
    ["room", "program", "group", "material", "pixels", "photograph", "new light"];
const TEXTURES: [&str; 6] =
    ["task", "program", "seconds", "error", "Mitsuba's in the same time", "published with"];

/// Puts what was measured into the page at `path`; rows of other rooms and programs stay.
///
/// # Errors
/// If the page cannot be written.
pub(crate) fn write(
    path: &Path,
    rooms: &Rooms,
    done: &Done,
    program: (&str, &str),
) -> Result<(), Failure> {
    let before = std::fs::read_to_string(path).unwrap_or_default();
    let images = path.with_file_name("images");
    for measured in &done.rooms {
        if let Some(picture) = &measured.shown {
            std::fs::create_dir_all(&images)?;
            std::fs::copy(picture, images.join(image(&measured.room)))?;
        }
    }
    let is_shown = |room: &Room| images.join(image(&room.name)).is_file();
    Ok(atomic::write(path, text(&before, rooms, done, program, is_shown).as_bytes())?)
}

/// The file of a room's picture.
fn image(room: &str) -> String {
    format!("rooms-{room}.jpg")
}

/// The whole page.
fn text(
    before: &str,
    rooms: &Rooms,
    done: &Done,
    program: (&str, &str),
    is_shown: impl Fn(&Room) -> bool,
) -> String {
    let place = |room: &str| rooms.place(room);
    let mut page = Page { before, text: HEAD.trim_end().to_owned() + "\n" };
    page.section("the rooms", "The rooms", |_| sources(&rooms.all, &is_shown));
    page.section("recovery", "Materials", |old| {
        let new = each(done, |m, r| recovery(m, r, program));
        rows::merged(RECOVERY, 3, old, new, place)
    });
    page.section("new pictures", "From a new viewpoint and in new light", |old| {
        let new = each(done, |m, r| pictures(m, r, program));
        rows::merged(PICTURES, 3, old, new, place)
    });
    page.section("published", "Published by others", |_| published(&rooms.published));
    page.section("inverse", "Mitsuba's own inverse", |old| {
        rows::merged(INVERSE, 2, old, done.rooms.iter().filter_map(inverse).collect(), place)
    });
    page.section("forward", "At the true materials", |old| {
        let new = done.rooms.iter().flat_map(|m| forwards(m, program.0)).collect();
        rows::merged(FORWARD, 3, old, new, place)
    });
    page.section("groups", "At the true materials, group by group", |old| {
        let new = done.rooms.iter().flat_map(|m| groups(m, program.0)).collect();
        rows::merged(GROUPS, 2, old, new, place)
    });
    page.section("textures", "One unknown texture", |old| {
        let new = done.textures.iter().map(|outcome| texture(outcome, program)).collect();
        rows::merged(TEXTURES, 2, old, new, |_| 0)
    });
    page.text + &format!("\nThe last run: {}\n", machine::sentence(&["Mitsuba 3.9.1".to_owned()]))
}

/// A page that is written section by section.
struct Page<'a> {
    before: &'a str,
    text: String,
}

impl Page<'_> {
    /// Adds a section between marks; `body` is given what was between them before.
    fn section(&mut self, name: &str, heading: &str, body: impl Fn(&str) -> String) {
        let (start, end) = (format!("<!-- {name} -->"), format!("<!-- end of {name} -->"));
        let old = self.before.split_once(&start).and_then(|(_, rest)| rest.split_once(&end));
        let body = body(old.map_or("", |(body, _)| body));
        let _ = write!(self.text, "\n## {heading}\n\n{start}\n\n{}\n\n{end}\n", body.trim());
    }
}

/// A row for each recovery.
fn each<const N: usize>(
    done: &Done,
    row: impl Fn(&Measured, &Recovery) -> [String; N],
) -> Vec<[String; N]> {
    let rooms = done.rooms.iter();
    rooms.flat_map(|m| m.recoveries.iter().map(|r| row(m, r)).collect::<Vec<_>>()).collect()
}

/// Where the rooms come from, and pictures of those that may be shown.
fn sources(rooms: &[Room], is_shown: &impl Fn(&Room) -> bool) -> String {
    let mut table = Table::new(["room", "file", "scene", "licence", "photograph"]);
    let mut pictures = String::new();
    for room in rooms {
        let (width, height) = room.size;
        table.push([
            room.name.clone(),
            format!("`{}`", room.file),
            credit(room),
            room.licence.clone(),
            format!("{width} x {height}"),
        ]);
        if is_shown(room) {
            let (name, credit, licence) = (&room.name, credit(room), &room.licence);
            let _ = write!(
                pictures,
                "\n![{name}](images/{})\n\n{credit}, {licence}: the photograph, new light by Mitsuba at \
                 the true materials, and by unrender at the recovered ones.\n",
                image(name)
            );
        }
    }
    table.text().to_owned() + &pictures
}

/// A room's title and author.
fn credit(room: &Room) -> String {
    let changed = room.changed.as_ref().map_or(String::new(), |changed| format!(", {changed}"));
    format!("*{}* by {}{changed}", room.title, room.author)
}

/// The program with its effort.
fn named((label, effort): (&str, &str)) -> String {
    format!("{label}, {effort}")
}

fn recovery(measured: &Measured, recovery: &Recovery, program: (&str, &str)) -> [String; 10] {
    let score = &recovery.score;
    [
        measured.room.clone(),
        named(program),
        recovery.photo.name().to_owned(),
        format!("{:.1} dB", score.albedo_db),
        format!("{:.1} dB", score.roughness_db),
        format!("{:.0} %", 100.0 * score.silent_share),
        score.wrong_text(),
        score.told_text(),
        score.right_and_told.to_string(),
        format!("{:.0}", recovery.outcome.seconds),
    ]
}

fn pictures(measured: &Measured, recovery: &Recovery, program: (&str, &str)) -> [String; 7] {
    let cell = |score: Option<&Score>, name: &str| {
        score.and_then(|score| score.pictures.get(name)).map_or_else(
            || "-".to_owned(),
            |picture| format!("{:.1} dB ({:.1} %)", picture.psnr, 100.0 * picture.median),
        )
    };
    let (found, plain) = (Some(&recovery.score), recovery.diffuse.as_ref());
    [
        measured.room.clone(),
        named(program),
        recovery.photo.name().to_owned(),
        cell(found, "new_view"),
        cell(plain, "new_view"),
        cell(found, "new_light"),
        cell(plain, "new_light"),
    ]
}

fn published(figures: &[Published]) -> String {
    let mut table =
        Table::new(["room", "method", "albedo", "roughness", "time", "source", "what differs"]);
    for figure in figures {
        table.push([
            figure.room.clone(),
            figure.method.clone(),
            format!("{:.1} dB", figure.albedo_db),
            format!("{:.1} dB", figure.roughness_db),
            format!("{:.0} min", figure.minutes),
            figure.source.clone(),
            figure.differs.clone(),
        ]);
    }
    table.text().to_owned()
}

fn inverse(measured: &Measured) -> Option<[String; 5]> {
    let (seconds, score) = measured.inverse.as_ref()?;
    Some([
        measured.room.clone(),
        format!("{seconds:.0}"),
        format!("{:.1} dB", score.albedo_db),
        format!("{:.1} dB", score.roughness_db),
        score.wrong_text(),
    ])
}

fn forwards(measured: &Measured, label: &str) -> Vec<[String; 5]> {
    let row = |(name, forward): (&String, &Forward)| {
        let (alike, all) = forward.alike(LARGE);
        let shot = if name == "photo" { "photograph".to_owned() } else { name.replace('_', " ") };
        let (room, label) = (measured.room.clone(), label.to_owned());
        [room, label, shot, format!("{:.3}", forward.mean), format!("{alike} of {all}")]
    };
    measured.forward.iter().map(row).collect()
}

fn groups(measured: &Measured, label: &str) -> Vec<[String; 7]> {
    let Some(photo) = measured.forward.get("photo") else { return Vec::new() };
    let relit = |group: &str| {
        let rows = &measured.forward.get("new_light")?.rows;
        rows.iter().find(|row| row.group == group)
    };
    let cell = |ratio: f64, std: f64| format!("{ratio:.3} +- {std:.3}");
    let large = photo.rows.iter().filter(|row| row.pixels >= LARGE);
    large
        .map(|row| {
            [
                measured.room.clone(),
                label.to_owned(),
                row.group.clone(),
                row.kind.clone(),
                row.pixels.to_string(),
                cell(row.ratio, row.std),
                relit(&row.group).map_or_else(|| "-".to_owned(), |row| cell(row.ratio, row.std)),
            ]
        })
        .collect()
}

fn texture(outcome: &Outcome, program: (&str, &str)) -> [String; 6] {
    let (error, iterations) = outcome.mitsuba;
    [
        outcome.task.clone(),
        named(program),
        format!("{:.0}", outcome.seconds),
        format!("{:.4}", outcome.error),
        format!("{error:.4} ({iterations} iterations)"),
        outcome.published.clone(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::corpus::recover;
    use crate::rooms::request::Photo;
    use std::collections::BTreeMap;

    fn done(rooms: impl IntoIterator<Item = Measured>) -> Done {
        Done { rooms: rooms.into_iter().collect(), textures: Vec::new() }
    }

    fn measured(room: &str, albedo_db: f64) -> Measured {
        let score = Score { albedo_db, groups: 10, wrong: 2, ..Score::default() };
        let outcome = recover::Outcome { seconds: 60.0, ..recover::Outcome::default() };
        let recoveries = vec![Recovery { photo: Photo::Exr, outcome, score, diffuse: None }];
        Measured {
            room: room.to_owned(),
            forward: BTreeMap::new(),
            recoveries,
            inverse: None,
            shown: None,
        }
    }

    #[test]
    fn a_run_replaces_its_own_rows_alone() {
        let rooms = Rooms::load(false).unwrap();
        let both = [measured("staircase", 18.9), measured("kitchen", 24.2)];
        let page = text("", &rooms, &done(both), ("before", "draft"), |_| false);
        let page =
            text(&page, &rooms, &done([measured("staircase", 28.0)]), ("after", "draft"), |_| {
                false
            });
        let page =
            text(&page, &rooms, &done([measured("kitchen", 24.5)]), ("before", "draft"), |_| false);
        for (row, there) in [
            ("| staircase | before, draft | exr | 18.9 dB", true),
            ("| staircase | after, draft | exr | 28.0 dB", true),
            ("| kitchen | before, draft | exr | 24.5 dB", true),
            ("| kitchen | before, draft | exr | 24.2 dB", false),
        ] {
            assert_eq!(page.contains(row), there, "{row}");
        }
        assert!(page.starts_with(HEAD.trim_end()));
    }

    #[test]
    fn the_page_names_every_author() {
        let rooms = Rooms::load(false).unwrap();
        let page = text("", &rooms, &done([]), ("before", "draft"), |room| room.may_be_shown());
        for room in &rooms.all {
            assert!(page.contains(&room.author) && page.contains(&room.licence), "{}", room.name);
            let picture = format!("images/{})", image(&room.name));
            assert_eq!(page.contains(&picture), room.may_be_shown(), "{}", room.name);
        }
    }
}
