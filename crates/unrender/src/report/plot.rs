//! Curves over iterations, as SVG in the colours of the page.

use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

/// A curve: its points in the order of iterations, and its colour.
pub(super) struct Curve {
    pub(super) points: Vec<(f64, f64)>,
    pub(super) color: RGBColor,
}

/// The vertical axis.
#[derive(Clone, Copy)]
pub(super) enum Axis {
    /// Decades; values below the last lie on the lower edge.
    Logarithmic,
    /// From zero.
    Linear,
}

/// No logarithmic axis goes further down.
const LEAST: f64 = 1e-5;

/// The colour that the page replaces by that of its text.
const INK: RGBColor = RGBColor(1, 2, 3);
const INK_IN_SVG: &str = "#010203";

/// The curves on axes of `size` pixels; `label` is their description for screen readers.
pub(super) fn plot(curves: &[Curve], axis: Axis, size: (u32, u32), label: &str) -> Markup {
    let mut svg = String::new();
    let drawn = {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        match axis {
            Axis::Logarithmic => logarithmic(&area, curves),
            Axis::Linear => linear(&area, curves),
        }
        .is_ok()
            && area.present().is_ok()
    };
    let svg = svg.replace(INK_IN_SVG, "currentColor");
    // The size is the picture's own at most.
    let svg = svg.replacen("<svg ", "<svg aria-hidden=\"true\" ", 1);
    html! {
        @if drawn { div class="plot" role="img" aria-label=(label) { (PreEscaped(svg)) } }
    }
}

type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn logarithmic<'a>(area: &Area<'a>, curves: &[Curve]) -> Drawn<'a> {
    let (iterations, [low, high]) = ranges(curves, |y| y > LEAST);
    let (low, high) = (10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil()));
    let mut chart = ChartBuilder::on(area)
        .margin(6)
        .x_label_area_size(24)
        .y_label_area_size(56)
        .build_cartesian_2d(0.5..iterations + 0.5, (low..high.max(10.0 * low)).log_scale())?;
    chart
        .configure_mesh()
        .bold_line_style(INK.mix(0.18))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.mix(0.5))
        .label_style(("sans-serif", 12, &INK))
        .x_label_formatter(&|iteration| format!("{iteration:.0}"))
        .y_label_formatter(&|error| decade(100.0 * error))
        .draw()?;
    for curve in curves {
        let points = curve.points.iter().map(|(x, y)| (*x, y.max(low)));
        chart.draw_series(LineSeries::new(points, curve.color.stroke_width(2)).point_size(2))?;
    }
    Ok(())
}

/// A power of ten in percent.
fn decade(percent: f64) -> String {
    let digits = (-percent.log10()).round().max(0.0) as usize;
    format!("{percent:.digits$} %")
}

fn linear<'a>(area: &Area<'a>, curves: &[Curve]) -> Drawn<'a> {
    let (iterations, [_, high]) = ranges(curves, |_| true);
    let mut chart = ChartBuilder::on(area)
        .margin(6)
        .x_label_area_size(20)
        .y_label_area_size(34)
        .build_cartesian_2d(0.5..iterations + 0.5, 0.0..(1.05 * high).max(0.1))?;
    chart
        .configure_mesh()
        .bold_line_style(INK.mix(0.18))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.mix(0.5))
        .label_style(("sans-serif", 11, &INK))
        .x_labels(6)
        .y_labels(5)
        .x_label_formatter(&|iteration| format!("{iteration:.0}"))
        .y_label_formatter(&|value| format!("{value:.1}"))
        .draw()?;
    for curve in curves {
        let style = curve.color.stroke_width(2);
        chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
    }
    Ok(())
}

/// The last iteration, and the least and the greatest of the values for which `counts` is true.
fn ranges(curves: &[Curve], counts: fn(f64) -> bool) -> (f64, [f64; 2]) {
    let points = || curves.iter().flat_map(|c| c.points.iter().copied());
    let values = || points().map(|p| p.1).filter(|y| counts(*y));
    let iterations = points().map(|p| p.0).fold(1.0, f64::max);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    if low.is_finite() { (iterations, [low, high]) } else { (iterations, [0.01, 1.0]) }
}
