//! Several recoveries side by side: their pictures, their convergence, and their groups.

use super::exhibit::{Exhibit, figure};
use super::number::{Shown, number, percent};
use super::plot::{Axis, Curve, plot};
use super::{RunFolder, head, parameters};
use crate::Error;
use crate::run::RunGroup;
use maud::{Markup, html};
use plotters::style::RGBColor;

/// Colours of the runs; they repeat.
const COLORS: [RGBColor; 6] = [
    RGBColor(66, 120, 220),
    RGBColor(220, 100, 40),
    RGBColor(46, 150, 80),
    RGBColor(190, 60, 140),
    RGBColor(130, 110, 40),
    RGBColor(90, 160, 180),
];

/// The page.
pub(super) fn page(runs: &[RunFolder<'_>]) -> Result<String, Error> {
    let cards = runs.iter().enumerate().map(|(index, source)| card(index, source));
    let cards = cards.collect::<Result<Vec<_>, _>>()?;
    let curves: Vec<Curve> = runs.iter().enumerate().map(curve).collect();
    let body = html! {
        header {
            h1 { "Recoveries side by side" }
            p class="lead" { "One column per run; curves have the colours of the headings." }
        }
        main {
            section aria-labelledby="runs" {
                h2 id="runs" { "Runs" }
                div class="columns" { @for card in &cards { (card) } }
            }
            section aria-labelledby="curves" {
                h2 id="curves" { "Convergence" }
                figure {
                    (plot(&curves, Axis::Logarithmic, (900, 280), "Worst error against iterations"))
                    figcaption { "The worst group's error against iterations; in refinement \
                    passes, the error of all groups together." }
                }
            }
            section aria-labelledby="groups" {
                h2 id="groups" { "Groups" }
                (table(runs))
            }
        }
    };
    Ok(head::page("unrender: recoveries side by side", &body))
}

fn curve((index, source): (usize, &RunFolder<'_>)) -> Curve {
    let error = |iteration: &crate::run::IterationEntry| {
        Some((iteration.iteration as f64, iteration.worst_error?))
    };
    let points = source.run.iterations.iter().filter_map(error).collect();
    Curve { points, color: COLORS[index % COLORS.len()] }
}

/// The name of a run: its folder.
fn name(index: usize, source: &RunFolder<'_>) -> Markup {
    let RGBColor(r, g, b) = COLORS[index % COLORS.len()];
    html! {
        span class="chip" aria-hidden="true" style={
            "background:rgb(" (r) " " (g) " " (b) ")" } {}
        (source.folder.display())
    }
}

fn card(index: usize, source: &RunFolder<'_>) -> Result<Markup, Error> {
    let (run, pictures) = (source.run, &source.run.pictures);
    let shown = [
        (pictures.photo.as_str(), "Photograph", "developed with this run's response"),
        (pictures.rerendered.as_str(), "Re-rendering", "with the recovered materials"),
        ("error.png", "Error", "orange where the re-rendering is too bright, blue where too dark"),
    ];
    let figures = shown.map(|(file, title, caption)| {
        let [file, title, caption] = [file, title, caption].map(str::to_owned);
        figure(source.folder, &Exhibit { file, title, caption })
    });
    let figures = figures.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(html! {
        article {
            h3 { (name(index, source)) }
            p { (run.input.project.display()) ", " (run.settings.brdf) ", ladder "
                (run.settings.ladder) ", "
                (number(&source.key.at("seconds"), run.seconds, Shown::Fixed(1))) " s, "
                (run.termination) "." }
            @for figure in &figures { (figure) }
            @for warning in &run.warnings { p class="warn" { (warning) } }
        }
    })
}

fn table(runs: &[RunFolder<'_>]) -> Markup {
    let mut names: Vec<&String> = Vec::new();
    for name in runs.iter().flat_map(|source| source.run.groups.keys()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    html! {
        div class="wide" role="region" tabindex="0" aria-label="Groups of all runs" {
            table class="many" {
                thead { tr {
                    th scope="col" { "group" }
                    @for (index, source) in runs.iter().enumerate() {
                        th scope="col" { (name(index, source)) }
                    }
                } }
                tbody { @for group in names { tr {
                    th scope="row" { (group) }
                    @for source in runs {
                        td { @match source.run.groups.get(group) {
                            Some(found) => { (cell(source, group, found)) }
                            None => { "missing" }
                        } }
                    }
                } } }
            }
        }
    }
}

fn cell(source: &RunFolder<'_>, name: &str, group: &RunGroup) -> Markup {
    let key = source.key.at("groups").at(name);
    html! {
        (group.entry.hypothesis.map_or("", |h| h.name()))
        @if let Some(status) = &group.entry.status { ", " (status) }
        (parameters::list(&key, &group.entry))
        "error " (percent(&key.at("error"), group.entry.error))
    }
}
