//! The colour bar under a false-colour picture, with numbers in a small raster font, so that the
//! picture can be read without run.json.

use unrender_scene::Rgb;

/// Digits and signs of 3 x 5 pixels: one number per row, the leftmost pixel is the highest of three
/// bits.
const GLYPHS: [(char, [u8; 5]); 15] = [
    ('0', [7, 5, 5, 5, 7]),
    ('1', [2, 6, 2, 2, 7]),
    ('2', [7, 1, 7, 4, 7]),
    ('3', [7, 1, 7, 1, 7]),
    ('4', [5, 5, 7, 1, 1]),
    ('5', [7, 4, 7, 1, 7]),
    ('6', [7, 4, 7, 5, 7]),
    ('7', [7, 1, 1, 1, 1]),
    ('8', [7, 5, 7, 5, 7]),
    ('9', [7, 5, 7, 1, 7]),
    ('-', [0, 0, 7, 0, 0]),
    ('+', [0, 2, 7, 2, 0]),
    ('%', [5, 1, 2, 4, 5]),
    ('<', [1, 2, 4, 2, 1]),
    ('>', [4, 2, 1, 2, 4]),
];

/// Marks on the scale, as shares of its half.
const MARKS: [f32; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// The bar's height for a picture of this width.
pub(super) fn height(width: usize) -> usize {
    12 * zoom(width)
}

fn zoom(width: usize) -> usize {
    (width / 200).clamp(1, 6)
}

/// The bar's pixel (x, y); `full` is the value at its ends, `color` maps -1 to 1 to colours.
pub(super) fn pixel(x: usize, y: usize, width: usize, full: f32, color: fn(f32) -> Rgb) -> Rgb {
    let zoom = zoom(width);
    if y < 4 * zoom {
        return color(2.0 * (x as f32 + 0.5) / width as f32 - 1.0);
    }
    let (column, row) = (x / zoom, (y / zoom).saturating_sub(6));
    let columns = width / zoom;
    let inked = y >= 6 * zoom
        && row < 5
        && MARKS.iter().any(|&mark| {
            let text = label(mark, 100.0 * full * mark);
            let length = 4 * text.chars().count();
            let place = 0.5 + 0.5 * mark;
            let centre = (place * columns as f32) as usize;
            let start = centre.saturating_sub(length / 2).min(columns.saturating_sub(length));
            column >= start && column < start + length && ink(&text, column - start, row)
        });
    if inked { Rgb::ZERO } else { Rgb::ONE }
}

/// The label of a mark; the ends stand for all that is beyond, too.
fn label(mark: f32, percent: f32) -> String {
    match mark {
        0.0 => "0".to_owned(),
        -1.0 => format!("<{percent:+.0}%"),
        1.0 => format!(">{percent:+.0}%"),
        _ => format!("{percent:+.0}%"),
    }
}

fn ink(text: &str, column: usize, row: usize) -> bool {
    let glyph = text.chars().nth(column / 4).and_then(|c| GLYPHS.iter().find(|g| g.0 == c));
    let bit = column % 4;
    bit < 3 && glyph.is_some_and(|g| g.1[row] & (4 >> bit) != 0)
}
