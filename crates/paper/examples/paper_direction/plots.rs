//! The chart.

use crate::floor::Brushed;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

const COLORS: [RGBColor; 5] = [
    RGBColor(120, 120, 120),
    RGBColor(214, 64, 64),
    RGBColor(46, 150, 80),
    RGBColor(66, 120, 220),
    RGBColor(200, 130, 30),
];

/// The mean deviation of the mirror difference along each direction, one curve a floor, relative to the
/// largest; a stroke marks each minimum.
pub(crate) fn write(
    path: &Path,
    floors: &[Brushed],
    curves: &[Vec<f32>],
) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(path, (560, 320)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(8)
        .x_label_area_size(36)
        .y_label_area_size(36)
        .build_cartesian_2d(0f32..180.0, 0f32..1.05)?;
    chart
        .configure_mesh()
        .x_desc("direction, degrees; strokes: where each is least")
        .x_labels(7)
        .draw()?;
    for ((floor, curve), color) in floors.iter().zip(curves).zip(COLORS) {
        let largest = curve.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let degrees = |i: usize| 180.0 * i as f32 / curve.len() as f32;
        let points = curve.iter().enumerate().map(|(i, value)| (degrees(i), value / largest));
        let name = floor.map_or("round".to_owned(), |degrees| format!("{degrees} degrees"));
        chart
            .draw_series(LineSeries::new(points, color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
        let least = curve.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map(|(i, _)| i);
        if let Some(at) = least.map(degrees) {
            let stroke = PathElement::new([(at, 0.0), (at, 0.06)], color.stroke_width(3));
            chart.draw_series([stroke])?;
        }
    }
    let place = SeriesLabelPosition::LowerRight;
    chart.configure_series_labels().position(place).background_style(WHITE.mix(0.8)).draw()?;
    area.present()?;
    Ok(())
}
