//! Convergence: every group's error and parameters against the iterations, as curves and as a table.

use super::number::{Shown, count, number, percent};
use super::plot::{Axis, Curve, plot};
use super::{RunFolder, under};
use crate::run::{GroupIterationEntry, IterationEntry, Run};
use maud::{Markup, html};
use plotters::style::RGBColor;

const ERRORS: (u32, u32) = (900, 320);
const PARAMETERS: (u32, u32) = (300, 170);
/// The parameters of a group that have curves, and their colours.
const QUANTITIES: [(&str, RGBColor); 8] = [
    ("rho_d red", RGBColor(214, 64, 64)),
    ("rho_d green", RGBColor(46, 150, 80)),
    ("rho_d blue", RGBColor(66, 120, 220)),
    ("rho_s red", RGBColor(240, 150, 150)),
    ("rho_s green", RGBColor(130, 205, 150)),
    ("rho_s blue", RGBColor(150, 185, 245)),
    ("alpha_x", RGBColor(200, 130, 30)),
    ("alpha_y", RGBColor(150, 90, 190)),
];

/// The section.
pub(super) fn section(source: &RunFolder<'_>) -> Markup {
    let run = source.run;
    let asked: Vec<&String> =
        run.groups.iter().filter(|(_, g)| g.asked).map(|(name, _)| name).collect();
    let curves: Vec<Curve> = asked.iter().map(|name| errors(run, name)).collect();
    let content = html! {
        figure {
            (plot(&curves, Axis::Logarithmic, ERRORS, "Error of every group against iterations"))
            figcaption {
                "The relative error of every group that noise does not explain, against \
                 iterations; for passes of the refinement, the error of means over blocks of \
                 pixels. At the lower edge noise explains all. Colours as in the group map: "
                @for name in &asked { (legend(&run.groups[*name].map_color, name)) " " }
            }
        }
        details {
            summary { "Parameters against iterations" }
            p { @for (name, color) in QUANTITIES {
                (legend(&format!("rgb({} {} {})", color.0, color.1, color.2), name)) " "
            } }
            div class="multiples" { @for name in &asked {
                figure {
                    (plot(&parameters(run, name), Axis::Linear, PARAMETERS,
                        &format!("Parameters of {name} against iterations")))
                    figcaption { (name) }
                }
            } }
        }
        details {
            summary { "Iteration by iteration" }
            (table(source, &asked))
        }
    };
    under("convergence", &content)
}

fn legend(color: &str, name: &str) -> Markup {
    html! { span class="legend" {
    span class="chip" aria-hidden="true" style={ "background:" (color) } {} (name) } }
}

fn errors(run: &Run, name: &str) -> Curve {
    let error = |iteration: &IterationEntry| {
        Some((iteration.iteration as f64, iteration.groups.get(name)?.error?))
    };
    let points = run.iterations.iter().filter_map(error).collect();
    Curve { points, color: parsed(&run.groups[name].map_color) }
}

fn parameters(run: &Run, name: &str) -> Vec<Curve> {
    let values = |g: &GroupIterationEntry| {
        let ([a, b, c], [d, e, f]) = (g.rho_d, g.rho_s);
        [a, b, c, d, e, f, g.alpha_x, g.alpha_y].map(f64::from)
    };
    let of_iteration = |iteration: &IterationEntry| {
        Some((iteration.iteration as f64, values(iteration.groups.get(name)?)))
    };
    let iterations: Vec<(f64, [f64; 8])> = run.iterations.iter().filter_map(of_iteration).collect();
    let curve = |(k, (_, color)): (usize, &(&str, RGBColor))| Curve {
        points: iterations.iter().map(|(iteration, values)| (*iteration, values[k])).collect(),
        color: *color,
    };
    let curves = QUANTITIES.iter().enumerate().map(curve);
    // A parameter that a group never had gets no curve.
    curves.filter(|c| c.points.iter().any(|(_, value)| *value > 0.0)).collect()
}

/// A colour `#rrggbb`; black if it is not valid.
fn parsed(color: &str) -> RGBColor {
    let code = |at: usize| color.get(at..at + 2).and_then(|c| u8::from_str_radix(c, 16).ok());
    let [r, g, b] = [1, 3, 5].map(|at| code(at).unwrap_or(0));
    RGBColor(r, g, b)
}

fn table(source: &RunFolder<'_>, asked: &[&String]) -> Markup {
    html! {
        div class="wide" role="region" tabindex="0" aria-label="Errors iteration by iteration" {
            table {
                thead { tr {
                    th scope="col" { "iteration" }
                    th scope="col" { "seconds" }
                    th scope="col" { "change" }
                    th scope="col" { "worst error" }
                    @for name in asked { th scope="col" { (name) } }
                } }
                tbody { @for (index, iteration) in source.run.iterations.iter().enumerate() {
                    (iteration_row(source, index, iteration, asked))
                } }
            }
        }
    }
}

fn iteration_row(
    source: &RunFolder<'_>,
    index: usize,
    iteration: &IterationEntry,
    asked: &[&String],
) -> Markup {
    let key = source.key.at("iterations").at(index);
    html! {
        tr {
            th scope="row" { (count(&key.at("iteration"), iteration.iteration))
                @if iteration.refining { " refining" } }
            td class="n" { (number(&key.at("seconds"), iteration.seconds, Shown::Fixed(1))) }
            td class="n" { @if let Some(change) = iteration.change {
                (number(&key.at("change"), change, Shown::Significant(2))) } }
            td class="n" { (percent(&key.at("worst_error"), iteration.worst_error)) }
            @for name in asked {
                td class="n" { @if let Some(group) = iteration.groups.get(*name) {
                    (percent(&key.at("groups").at(name).at("error"), group.error))
                    " " span class="rung" { (group.hypothesis) }
                } }
            }
        }
    }
}
