//! A check as text for people and as JSON for programs.

use super::groups::{IGNORED, SAME_AS};
use super::{Checkup, Edges, GroupCheck};
use crate::text_table;
use serde::Serialize;
use std::path::Path;

/// The table, the edges and the warnings; `picture` is the file with the drawn edges.
pub fn table(checkup: &Checkup, picture: &Path) -> String {
    let header = ["group", "pixels", "valid", "left out", "lit", "roughness shows by", "texture"];
    let mut rows = vec![header.map(str::to_owned)];
    rows.extend(checkup.groups.iter().map(row));
    let mut text = text_table::table(&rows);
    if checkup.side > 1 {
        text.push_str(&format!("pixels are counted in squares of {0} x {0}\n", checkup.side));
    }
    text.push_str(&edges(&checkup.edges, picture));
    let (grave, notes) = checkup.warnings.0.split_at(checkup.grave);
    if grave.is_empty() {
        text.push_str("\nnothing looks wrong\n");
    }
    text.push_str(&listed("to check", grave));
    text.push_str(&listed("to know", notes));
    text
}

/// The `sentences` with their numbers, under a heading; nothing of none.
fn listed(what_for: &str, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let things = if sentences.len() == 1 { "thing" } else { "things" };
    let lines = (1..).zip(sentences).map(|(number, sentence)| format!("{number}. {sentence}\n"));
    format!("\n{} {things} {what_for}:\n{}", sentences.len(), lines.collect::<String>())
}

fn row(group: &GroupCheck) -> [String; 7] {
    let dash = || "-".to_owned();
    let percent = |share: f32| format!("{:.0} %", 100.0 * share);
    let reasons = [("edge", group.edge), ("cut off", group.clipped), ("spike", group.spike)];
    let of_pixels = |count: usize| percent(count as f32 / group.pixels.max(1) as f32);
    let reasons = reasons.into_iter().filter(|(_, count)| *count > 0);
    let left_out: Vec<String> =
        reasons.map(|(reason, count)| format!("{reason} {}", of_pixels(count))).collect();
    let name = match group.role.as_str() {
        "unknown" => group.name.clone(),
        role => format!("{} ({role})", group.name),
    };
    let is_elsewhere = group.role.starts_with(SAME_AS);
    let is_ignored = group.role == IGNORED;
    let count = |count: usize, is_none: bool| if is_none { dash() } else { count.to_string() };
    [
        name,
        count(group.pixels, is_elsewhere),
        count(group.valid, is_elsewhere || is_ignored),
        match left_out.is_empty() {
            _ if is_ignored => "by the project".to_owned(),
            true => dash(),
            false => left_out.join(", "),
        },
        group.lit.map_or_else(dash, percent),
        group.roughness.map_or_else(dash, str::to_owned),
        match group.texture_fault {
            _ if !group.texture_coordinates => "no uv",
            Some(fault) => fault,
            None => "possible",
        }
        .to_owned(),
    ]
}

fn edges(edges: &Edges, picture: &Path) -> String {
    let displacement = match edges.displacement_px {
        Some(off) => format!("they lie {off:.1} pixels from the photo's in the median"),
        None => "too few are found to measure how far they are off".to_owned(),
    };
    format!(
        "\n{:.0} % of the model's edges are found in place and {:.0} % elsewhere; {displacement}\n{}: \
         green: in place; red: off, and yellow where the photo has them; blue: not seen in the \
         photo\n",
        100.0 * edges.fit,
        100.0 * edges.off,
        picture.display()
    )
}

#[derive(Serialize)]
struct Json<'a> {
    groups: &'a [GroupCheck],
    edges: &'a Edges,
    picture: &'a Path,
    warnings: &'a [String],
    /// How many of them are grave: the first ones.
    grave: usize,
    /// As in [`Checkup`]; left out if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    side: Option<usize>,
}

/// The same as JSON.
///
/// # Errors
/// If a path is not text.
pub fn json(checkup: &Checkup, picture: &Path) -> Result<String, serde_json::Error> {
    let Checkup { groups, edges, warnings, side, grave, .. } = checkup;
    let side = (*side > 1).then_some(*side);
    serde_json::to_string_pretty(&Json {
        groups,
        edges,
        picture,
        warnings: &warnings.0,
        grave: *grave,
        side,
    })
}
