//! Draws curves on logarithmic axes, as SVG.

use crate::Failure;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;

const SIZE: (u32, u32) = (720, 420);
/// Colours that differ for colour-blind readers too [Okabe and Ito 2008].
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Points that belong together, in their order.
pub(crate) struct Curve {
    pub(crate) label: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// The labels of the axes.
pub(crate) struct Axes<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
}

/// The share of an axis that the legend may take.
const LEGEND: (f64, f64) = (0.5, 0.35);
/// Points along a segment of a curve that the legend should not cover.
const PLACES: usize = 16;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The curves, with a point at each value.
///
/// # Errors
/// If there is no point to draw.
pub(crate) fn svg(axes: &Axes, curves: &[Curve]) -> Result<String, Failure> {
    let points = || curves.iter().flat_map(|curve| curve.points.iter().copied());
    if points().next().is_none() {
        return Err(format!("{}: there is nothing to draw", axes.title).into());
    }
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let x = decades(points().map(|point| point.0));
        let y = decades(points().map(|point| point.1));
        draw(&area, axes, curves, x.log_scale(), y.log_scale())?;
        area.present()?;
    }
    Ok(text)
}

fn draw<'a, X, Y>(
    area: &Area<'a>,
    axes: &Axes,
    curves: &[Curve],
    x: impl AsRangedCoord<CoordDescType = X, Value = f64>,
    y: impl AsRangedCoord<CoordDescType = Y, Value = f64>,
) -> Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .caption(axes.title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(46)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(10)
        .y_labels(10)
        .bold_line_style(BLACK.mix(0.15))
        .label_style(("sans-serif", 13))
        .x_desc(axes.x)
        .y_desc(axes.y)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .draw()?;
    for (curve, color) in curves.iter().zip(COLORS.into_iter().cycle()) {
        let line = LineSeries::new(curve.points.iter().copied(), color.stroke_width(2));
        chart
            .draw_series(line.point_size(3))?
            .label(&curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    if curves.len() > 1 {
        chart
            .configure_series_labels()
            .position(free_corner(curves))
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 13))
            .draw()?;
    }
    Ok(())
}

/// The corner in which the legend covers the least of the curves.
fn free_corner(curves: &[Curve]) -> SeriesLabelPosition {
    let points = || curves.iter().flat_map(|curve| curve.points.iter().copied());
    let (x, y) = (decades(points().map(|p| p.0)), decades(points().map(|p| p.1)));
    let share =
        |v: f64, range: &Range<f64>| (v / range.start).ln() / (range.end / range.start).ln();
    let place = |p: (f64, f64)| (share(p.0, &x), share(p.1, &y));
    let pieces = curves.iter().flat_map(|curve| curve.points.windows(2));
    let places: Vec<(f64, f64)> = pieces
        .flat_map(|ends| {
            let (from, to) = (place(ends[0]), place(ends[1]));
            (0..=PLACES).map(move |i| {
                let t = i as f64 / PLACES as f64;
                (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1))
            })
        })
        .collect();
    let covered = |right: bool, upper: bool| {
        let near = |v: f64, far: bool, reach: f64| if far { v > 1.0 - reach } else { v < reach };
        places.iter().filter(|p| near(p.0, right, LEGEND.0) && near(p.1, upper, LEGEND.1)).count()
    };
    let corners = [
        (covered(false, true), SeriesLabelPosition::UpperLeft),
        (covered(true, true), SeriesLabelPosition::UpperRight),
        (covered(false, false), SeriesLabelPosition::LowerLeft),
        (covered(true, false), SeriesLabelPosition::LowerRight),
    ];
    let least = corners.into_iter().min_by_key(|(covered, _)| *covered);
    least.map_or(SeriesLabelPosition::UpperLeft, |(_, corner)| corner)
}

/// The number without an exponent: `0.001`, `20`, `1000000`.
fn number(value: &f64) -> String {
    let rounded = format!("{value:.6}");
    rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A range with a little room beyond the values, which must be above zero.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    low / 1.5..high * 1.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_and_their_names_are_drawn() {
        let curve = |label: &str, slope: f64| Curve {
            label: label.to_owned(),
            points: (1..5).map(|i| (f64::from(i), slope * f64::from(i))).collect(),
        };
        let curves = [curve("one", 1.0), curve("two", 2.0)];
        let axes = Axes { title: "Lines", x: "steps", y: "height" };
        let text = svg(&axes, &curves).unwrap();
        for word in ["Lines", "steps", "height", "one", "two", "#000000", "#D55E00"] {
            assert!(text.contains(word), "{word} is missing");
        }
        assert!(svg(&axes, &[]).is_err());
    }

    #[test]
    fn the_legend_stays_out_of_the_curves_way() {
        let curve = |points: &[(f64, f64)]| {
            let label = String::new();
            free_corner(&[Curve { label, points: points.to_vec() }])
        };
        let is = |found: SeriesLabelPosition, wanted: SeriesLabelPosition| {
            assert_eq!(format!("{found:?}"), format!("{wanted:?}"));
        };
        is(curve(&[(1.0, 1.0), (10.0, 10.0)]), SeriesLabelPosition::UpperLeft);
        is(curve(&[(1.0, 10.0), (10.0, 1.0)]), SeriesLabelPosition::UpperRight);
        is(curve(&[(1.0, 10.0), (10.0, 10.0), (10.0, 1.0)]), SeriesLabelPosition::LowerLeft);
    }
}
