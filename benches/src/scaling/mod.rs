//! Measures how time and memory grow with pixels, triangles, groups and bounces.
//!
//! Along each axis a scene is rendered by us, and recovered from that picture.

mod case;

use crate::command::Unrender;
use crate::page::Section;
use crate::plot::{self, Axes, Curve};
use crate::scenes::{self, Room};
use crate::table::{Table, verdict};
use crate::{Effort, Failure, machine};
use case::{Case, Cost};
use unrender::scene::{Scene, WardModel};

/// The goal for the peak memory, GiB, of a recovery from 1024 x 768 pixels of a million triangles.
const MEMORY_GOAL: f64 = 2.0;

/// Paths per pixel of the photographs.
const SPP: u32 = 64;

/// A quantity that grows.
struct Axis {
    name: &'static str,
    subject: String,
    cases: Vec<Case>,
}

/// An axis with the costs of its cases.
struct Measured {
    axis: Axis,
    costs: Vec<Cost>,
}

/// Measures, and returns the section.
///
/// # Errors
/// If our command fails.
pub(crate) fn measure(effort: Effort) -> Result<Section, Failure> {
    let command = Unrender::build()?;
    let mut measured = Vec::new();
    for axis in axes(effort)? {
        let mut costs = Vec::new();
        for case in &axis.cases {
            eprintln!("{}: {} ...", axis.name, case.value);
            let cost = case.measure(&command)?;
            eprintln!("{}: {} {cost:?}", axis.name, case.value);
            costs.push(cost);
        }
        measured.push(Measured { axis, costs });
    }
    let large = large(effort);
    eprintln!("the large one ...");
    let cost = match large.measure(&command) {
        Ok(cost) => Some(cost),
        Err(problem) => {
            eprintln!("not measured: {problem}");
            None
        }
    };
    eprintln!("the large one: {cost:?}");
    let mut plots = Vec::new();
    for one in &measured {
        let name = one.axis.name;
        plots.push((format!("performance-time-{name}.svg"), draw_time(one)?));
        if matters_to_memory(name) {
            plots.push((format!("performance-memory-{name}.svg"), draw_memory(one)?));
        }
    }
    Ok(Section { text: text(&measured, &large, cost.as_ref()), plots })
}

fn matters_to_memory(name: &str) -> bool {
    ["pixels", "triangles"].contains(&name)
}

fn axes(effort: Effort) -> Result<Vec<Axis>, Failure> {
    let fig8 = Scene { brdf: WardModel::WardGmd.into(), ..scenes::figure8()? };
    let rendered = effort.pick(32, 512);
    let box_case = |value: usize, side: usize, bounces: Option<usize>| Case {
        value,
        scene: fig8.clone(),
        known: "ceil",
        size: (side, side),
        bounces,
        spp: SPP,
        repeat: (side / rendered).max(1),
        draft: true,
    };
    let (width, height) = effort.pick((32, 24), (256, 192));
    let room_case = |value: usize, triangles: usize, panels: usize| Case {
        value,
        scene: scenes::room(Room { triangles, panels }),
        known: "front_wall",
        size: (width, height),
        bounces: None,
        spp: SPP,
        repeat: 1,
        draft: true,
    };
    let sides: &[usize] = effort.pick(&[16, 32, 64], &[200, 512, 1024, 3584]);
    let triangles: &[usize] = effort.pick(&[500, 1000], &[1000, 10_000, 100_000, 1_000_000]);
    let panels: &[usize] = effort.pick(&[1, 2], &[1, 10, 25, 55]);
    let bounces: &[usize] = effort.pick(&[1, 4], &[1, 2, 4, 8]);
    let side = effort.pick(16, 256);
    Ok(vec![
        Axis {
            name: "pixels",
            subject: "Figure 8".to_owned(),
            cases: sides.iter().map(|&s| box_case(s * s, s, None)).collect(),
        },
        Axis {
            name: "triangles",
            subject: format!("the room, {width} x {height}"),
            cases: triangles.iter().map(|&t| room_case(t, t, 1)).collect(),
        },
        Axis {
            name: "groups",
            subject: format!("the room of 20 000 triangles, {width} x {height}"),
            cases: panels.iter().map(|&p| room_case(p + 5, 20_000, p)).collect(),
        },
        Axis {
            name: "bounces",
            subject: format!("Figure 8, {side} x {side}"),
            cases: bounces.iter().map(|&b| box_case(b, side, Some(b))).collect(),
        },
    ])
}

fn large(effort: Effort) -> Case {
    let triangles = effort.pick(20_000, 1_000_000);
    Case {
        value: triangles,
        scene: scenes::room(Room { triangles, panels: 2 }),
        known: "front_wall",
        size: effort.pick((64, 48), (1024, 768)),
        bounces: None,
        // With many pixels, a little noise in each is enough.
        spp: 64,
        repeat: 1,
        draft: false,
    }
}

fn draw_time(measured: &Measured) -> Result<String, Failure> {
    let title = format!("Time against {}: {}", measured.axis.name, measured.axis.subject);
    draw(
        measured,
        &title,
        "seconds",
        [
            ("recovery", |cost| Some(cost.full.seconds)),
            ("recovery, --effort draft", |cost| Some(cost.draft.as_ref()?.seconds)),
            ("rendering, 64 spp", |cost| Some(cost.rendering)),
        ],
    )
}

fn draw_memory(measured: &Measured) -> Result<String, Failure> {
    let title = format!("Memory against {}: {}", measured.axis.name, measured.axis.subject);
    draw(
        measured,
        &title,
        "MiB at most",
        [
            ("recovery", |cost| cost.full.mebibytes),
            ("recovery, --effort draft", |cost| cost.draft.as_ref()?.mebibytes),
        ],
    )
}

type Quantity = fn(&Cost) -> Option<f64>;

fn draw<const N: usize>(
    measured: &Measured,
    title: &str,
    y: &str,
    quantities: [(&str, Quantity); N],
) -> Result<String, Failure> {
    let pairs = || measured.axis.cases.iter().zip(&measured.costs);
    let curve = |(label, quantity): (&str, Quantity)| Curve {
        label: label.to_owned(),
        points: pairs().filter_map(|(c, cost)| Some((c.value as f64, quantity(cost)?))).collect(),
    };
    let axes = Axes { title, x: measured.axis.name, y };
    plot::svg(&axes, &quantities.map(curve))
}

fn text(measured: &[Measured], large: &Case, cost: Option<&Cost>) -> String {
    let mut claims = Table::new(["claim", "goal", "measured", "held"]);
    let (width, height) = large.size;
    let gibibytes = cost.and_then(|cost| cost.full.mebibytes).map_or(f64::NAN, |m| m / 1024.0);
    let [found, held] = verdict(gibibytes, gibibytes < MEMORY_GOAL);
    claims.push([
        format!("GiB to recover {width} x {height} pixels of {} triangles", large.value),
        format!("< {MEMORY_GOAL}"),
        found,
        held,
    ]);
    let mut rows = Table::new([
        "",
        "",
        "rendering, s",
        "recovery, s",
        "--effort draft, s",
        "recovery, MiB",
        "--effort draft, MiB",
    ]);
    let mut row = |what: String, value: String, cost: &Cost| {
        let number = |n: Option<f64>| n.map_or("-".to_owned(), |n| format!("{n:.1}"));
        let draft = cost.draft.as_ref();
        let numbers = [
            Some(cost.rendering),
            Some(cost.full.seconds),
            draft.map(|draft| draft.seconds),
            cost.full.mebibytes,
            draft.and_then(|draft| draft.mebibytes),
        ];
        rows.push([what, value].into_iter().chain(numbers.map(number)));
    };
    let mut pictures = String::new();
    for one in measured {
        let Axis { name, subject, cases } = &one.axis;
        for (case, cost) in cases.iter().zip(&one.costs) {
            row(format!("{name} ({subject})"), case.value.to_string(), cost);
        }
        pictures
            .push_str(&format!("\n![Time against {name}](images/performance-time-{name}.svg)\n"));
        if matters_to_memory(name) {
            let file = format!("images/performance-memory-{name}.svg");
            pictures.push_str(&format!("\n![Memory against {name}]({file})\n"));
        }
    }
    if let Some(cost) = cost {
        let what = format!("the room, {width} x {height}, its photograph of 64 spp");
        row(what, large.value.to_string(), cost);
    }
    format!(
        "## Scaling\n\n`scaling`. {}\n\n{}\n{EXPLANATION}\n{}{pictures}",
        machine::sentence(&[]),
        claims.text(),
        rows.text()
    )
}

const EXPLANATION: &str =
    "`recovery` is `unrender recover` as a process, `rendering` is `unrender \
render --independent --spp 64` of the same view, which made the photograph; above 512 x 512 pixels \
of Figure 8 each rendered pixel is repeated along both sides. Memory is the peak memory of the \
recovery. Groups are the recovered ones. Figure 8 is read as ward-gmd here.
";
