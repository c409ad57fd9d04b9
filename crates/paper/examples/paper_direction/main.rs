//! What the paper's mirror difference says of the anisotropy direction, step by step, on the floor of its
//! Figure 8: `cargo run --release -p unrender-paper --example paper_direction -- docs/images`, from the
//! repository's root.
//!
//! The floor is rendered without a direction and with four. The example prints the direction that is read off each, for
//! every mirrored surface, in a table for `docs/method/paper.md`, and writes `paper-steps.png` and
//! `paper-directions.svg`: the difference's mean deviation against the direction.

mod cornell_box;
mod floor;
mod plots;
mod streaks;

use floor::{Brushed, Floor};
use std::error::Error;
use std::path::Path;
use unrender_paper::brushed;

/// The floors: how each is brushed, degrees.
const FLOORS: [Brushed; 5] = [None, Some(0.0), Some(30.0), Some(60.0), Some(90.0)];

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args().nth(1).ok_or("usage: paper_direction FOLDER")?;
    let scene = cornell_box::scene(&cornell_box::truth(0.0));
    let floor = Floor::of(&scene);
    let mirror = floor.as_mirror();
    let photographs = FLOORS.map(|brushed| floor.photograph(brushed));
    let differences: Vec<Vec<f32>> =
        photographs.iter().map(|photograph| floor.difference(photograph, &mirror)).collect();
    let reference = floor.reference().ok_or("the floor mirrors nothing")?;
    print_readings(&floor, &differences, reference);
    print_streaks(&floor, &photographs, &mirror, reference);
    let steps = floor.steps(&photographs[1], &mirror, &differences[1], reference);
    steps.save(Path::new(&out).join("paper-steps.png"))?;

    let around = floor.around(reference);
    let by_mirror = |values: &Vec<f32>| brushed::deviations(&floor.on_plane(&around, values));
    let deviations: Vec<Vec<f32>> = differences.iter().map(by_mirror).collect();
    plots::write(&Path::new(&out).join("paper-directions.svg"), &FLOORS, &deviations)
}

/// Prints one row for each reading of the paper's text: which surface is the reference, which pixels count, and whether
/// lines are drawn on the floor or in the picture.
fn print_readings(floor: &Floor<'_>, differences: &[Vec<f32>], reference: u32) {
    println!("| reference | pixels | lines on | round | 0 | 30 | 60 | 90 |");
    println!("|---|---|---|---|---|---|---|---|");
    let whole = ("-".to_owned(), "the floor", floor.all());
    let surfaces = floor.mirrored().into_iter().flat_map(|object| {
        let mark = if object == reference { ", largest Area/d" } else { "" };
        let name = format!("{}{mark}", floor.name(object));
        let (own, around) = (floor.mirrors(object), floor.around(object));
        [(name.clone(), "its mirror image", own), (name, "a window around it", around)]
    });
    for (name, pixels, chosen) in surfaces.chain([whole]) {
        for (lines, in_picture) in [("the floor", false), ("the picture", true)] {
            let read = |values: &Vec<f32>| {
                let points = if in_picture {
                    floor.in_picture(&chosen, values)
                } else {
                    floor.on_plane(&chosen, values)
                };
                let least = brushed::least(&brushed::deviations(&points));
                least.map_or("-".to_owned(), |theta| format!("{:.0}", theta.to_degrees()))
            };
            let row: Vec<String> = differences.iter().map(read).collect();
            println!("| {name} | {pixels} | {lines} | {} |", row.join(" | "));
        }
    }
}

/// The amplitudes of the streaks.
const AMPLITUDES: [f32; 5] = [0.0, 0.03, 0.1, 0.3, 0.9];

/// Prints one row for each amplitude and subtracted picture: the direction that is read off each brushed floor with
/// such streaks, in the window around the `reference`.
fn print_streaks(
    floor: &Floor<'_>,
    photographs: &[unrender_scene::RgbImage],
    mirror: &unrender_scene::RgbImage,
    reference: u32,
) {
    println!("\n| streaks | photograph minus | 0 | 30 | 60 | 90 |");
    println!("|---|---|---|---|---|---|");
    let (matt, round) = (floor.matt(), floor.rerendered(None));
    let own: Vec<_> = FLOORS.iter().map(|brushed| floor.rerendered(*brushed)).collect();
    let around = floor.around(reference);
    for amplitude in AMPLITUDES {
        for (name, of_all) in [
            ("a mirror", Some(mirror)),
            ("the best round lobe", Some(&round)),
            ("its own lobe", None),
        ] {
            let read = |(i, brushed): (usize, &Brushed)| {
                let streaks = (brushed.as_ref().copied()?, amplitude);
                let streaked = floor.streaked(&photographs[i], &matt, streaks);
                let values = floor.difference(&streaked, of_all.unwrap_or(&own[i]));
                let points = floor.on_plane(&around, &values);
                let least = brushed::least(&brushed::deviations(&points))?;
                Some(format!("{:.0}", least.to_degrees()))
            };
            let row: Vec<String> = FLOORS.iter().enumerate().filter_map(read).collect();
            println!("| {:.0} % | {name} | {} |", 100.0 * amplitude, row.join(" | "));
        }
    }
}
