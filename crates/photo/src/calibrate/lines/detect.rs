//! Straight lines in a photograph, as LSD finds them [von Gioi et al. 2010].
//!
//! Neighbouring pixels whose gradients point in about one direction make a region, which is grown from where the
//! gradient is steepest. The region's axis of inertia, weighted by the gradient, is the line; a region that does not fill
//! the rectangle around it is none. The cost is that of sorting the pixels.

use nalgebra::{Matrix2, Vector2};
use std::f64::consts::{PI, TAU};
use unrender_scene::Image;

/// Gradients of one region differ by less than this, radians [von Gioi et al. 2010]: 22.5 degrees. At half of it noise
/// breaks lines, at double corners join them.
const TOLERANCE: f64 = PI / 8.0;
/// The steps of 8-bit code values: weaker gradients have no direction [von Gioi et al. 2010]; twice the step there, where
/// the picture is smoothed less. At half of it noise has lines, at double the seams of floors are lost.
const QUANTISED: f64 = 1.0 / 255.0;
/// The least share of its rectangle that a region fills [von Gioi et al. 2010]. At half of it arcs count as lines.
const DENSITY: f64 = 0.7;
/// The least length, as a share of the picture's diagonal. At half of it short lines cost time, at double small
/// furniture is lost.
const LEAST_LENGTH: f64 = 0.025;
/// Pictures are made smaller to at most this many pixels along their longer side: lines are found to a twentieth of a
/// pixel, and noise is averaged away. At half of it thin lines are lost; at double it takes four times as long.
const LONGEST_SIDE: usize = 2000;

/// The straight lines of a picture of luminances, encoded for display between 0 and 1: their ends, pixels from the top
/// left corner, the longest first.
pub fn straight_lines(luminance: &Image<f32>) -> Vec<[[f64; 2]; 2]> {
    let shrink = luminance.width().max(luminance.height()).div_ceil(LONGEST_SIDE);
    let small = smoothed(&shrunk(luminance, shrink));
    if small.width() < 3 || small.height() < 3 {
        return Vec::new();
    }
    let diagonal = (small.width() as f64).hypot(small.height() as f64);
    let gradients = Gradients::of(&small);
    let mut found = Vec::new();
    let mut is_used = vec![false; gradients.size.0 * gradients.size.1];
    for seed in gradients.seeds() {
        if is_used[seed] {
            continue;
        }
        let ends = [TOLERANCE, 0.5 * TOLERANCE].into_iter().find_map(|tolerance| {
            let region = gradients.region(seed, tolerance, &mut is_used);
            let ends = gradients.line(&region);
            if ends.is_none() {
                // What a narrower region leaves may belong to another line.
                region[1..].iter().for_each(|index| is_used[*index] = false);
            }
            ends
        });
        found.extend(ends.filter(|[p, q]| (q - p).norm() >= LEAST_LENGTH * diagonal));
    }
    let length = |[p, q]: &[Vector2<f64>; 2]| (q - p).norm();
    found.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let scaled = |end: Vector2<f64>| (end * shrink as f64).into();
    found.into_iter().map(|ends| ends.map(scaled)).collect()
}

/// The means of squares of `side` pixels.
fn shrunk(picture: &Image<f32>, side: usize) -> Image<f32> {
    if side <= 1 {
        return picture.clone();
    }
    let share = 1.0 / (side * side) as f32;
    Image::from_fn(picture.width() / side, picture.height() / side, |x, y| {
        let cells = (0..side * side).map(|cell| (x * side + cell % side, y * side + cell / side));
        share * cells.map(|(x, y)| *picture.at(x, y)).sum::<f32>()
    })
}

/// The picture without the steps of slanting edges, along which gradients turn back and forth: binomial weights of five
/// pixels in both directions, a standard deviation of one pixel.
fn smoothed(picture: &Image<f32>) -> Image<f32> {
    const WEIGHTS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
    let (width, height) = (picture.width(), picture.height());
    let near = |at: usize, by: usize, side: usize| (at + by).saturating_sub(2).min(side - 1);
    let along = Image::from_fn(width, height, |x, y| {
        (0..5).map(|by| WEIGHTS[by] * picture.at(near(x, by, width), y)).sum::<f32>()
    });
    Image::from_fn(width, height, |x, y| {
        (0..5).map(|by| WEIGHTS[by] * along.at(x, near(y, by, height))).sum()
    })
}

/// The gradient between each four pixels.
struct Gradients {
    /// One less than the picture's.
    size: (usize, usize),
    /// Magnitude, and angle in radians; the magnitude is zero where it is not significant.
    each: Vec<(f64, f64)>,
}

impl Gradients {
    fn of(picture: &Image<f32>) -> Self {
        let size = (picture.width() - 1, picture.height() - 1);
        let least = QUANTISED / TOLERANCE.sin();
        let at = |x: usize, y: usize| f64::from(*picture.at(x, y));
        let gradient = |index: usize| {
            let (x, y) = (index % size.0, index / size.0);
            let rising = at(x + 1, y + 1) - at(x, y);
            let falling = at(x + 1, y) - at(x, y + 1);
            let (right, down) = (0.5 * (rising + falling), 0.5 * (rising - falling));
            let magnitude = right.hypot(down);
            (if magnitude > least { magnitude } else { 0.0 }, down.atan2(right))
        };
        Self { size, each: (0..size.0 * size.1).map(gradient).collect() }
    }

    /// Where gradients are significant, the steepest first.
    fn seeds(&self) -> Vec<usize> {
        let mut seeds: Vec<usize> =
            (0..self.each.len()).filter(|index| self.each[*index].0 > 0.0).collect();
        seeds.sort_by(|a, b| self.each[*b].0.total_cmp(&self.each[*a].0).then(a.cmp(b)));
        seeds
    }

    /// The pixels connected to `seed` whose gradients point in about the direction of all together; they are used then.
    fn region(&self, seed: usize, tolerance: f64, is_used: &mut [bool]) -> Vec<usize> {
        let mut region = vec![seed];
        is_used[seed] = true;
        let mut angle = self.each[seed].1;
        let (mut sin, mut cos) = angle.sin_cos();
        let mut next = 0;
        while let Some(index) = region.get(next).copied() {
            next += 1;
            for near in self.around(index) {
                let (magnitude, direction) = self.each[near];
                let apart = direction - angle;
                let apart = (apart - TAU * (apart / TAU).round()).abs();
                if is_used[near] || magnitude == 0.0 || apart > tolerance {
                    continue;
                }
                is_used[near] = true;
                region.push(near);
                sin += direction.sin();
                cos += direction.cos();
                angle = sin.atan2(cos);
            }
        }
        region
    }

    /// The up to eight neighbours.
    fn around(&self, index: usize) -> impl Iterator<Item = usize> {
        let (width, height) = self.size;
        let (x, y) = (index % width, index / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |row| {
            (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column)
        })
        .filter(move |near| *near != index)
    }

    /// The ends of the line that a region is, pixels from the picture's top left corner.
    fn line(&self, region: &[usize]) -> Option<[Vector2<f64>; 2]> {
        if region.len() < 3 {
            return None;
        }
        // Four pixels meet where this gradient is.
        let place = |index: usize| {
            Vector2::new((index % self.size.0 + 1) as f64, (index / self.size.0 + 1) as f64)
        };
        let weighted = |index: &usize| (self.each[*index].0, place(*index));
        let total: f64 = region.iter().map(|index| self.each[*index].0).sum();
        let centre =
            region.iter().map(weighted).map(|(w, at)| w * at).sum::<Vector2<f64>>() / total;
        let inertia = region.iter().map(weighted).map(|(weight, at)| {
            let way = at - centre;
            weight * way * way.transpose()
        });
        let eigen = inertia.sum::<Matrix2<f64>>().symmetric_eigen();
        let (longest, _) = eigen.eigenvalues.argmax();
        let along: Vector2<f64> = eigen.eigenvectors.column(longest).into_owned();
        let across = Vector2::new(-along.y, along.x);
        let span = |direction: Vector2<f64>| {
            let ways = region.iter().map(|index| (place(*index) - centre).dot(&direction));
            ways.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), way| (a.min(way), b.max(way)))
        };
        let ((begin, end), (left, right)) = (span(along), span(across));
        let area = (end - begin + 1.0) * (right - left + 1.0);
        let fills = region.len() as f64 >= DENSITY * area;
        fills.then(|| [centre + begin * along, centre + end * along])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bright half plane, blurred over a pixel, and noise of two steps of 8 bits.
    fn edge(angle: f64, offset: f64) -> Image<f32> {
        let (sin, cos) = angle.sin_cos();
        let mut noise = 1_u32;
        Image::from_fn(120, 90, |x, y| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (noise >> 16) as f64 / 65536.0 - 0.5;
            let way = (x as f64 - 59.5) * cos + (y as f64 - 44.5) * sin - offset;
            (0.3 + 0.4 * (way + 0.5).clamp(0.0, 1.0) + noise * 4.0 / 255.0) as f32
        })
    }

    #[test]
    fn an_edge_is_found_to_a_tenth_of_a_pixel() {
        for (angle, offset) in [(0.0, 3.3), (0.7, -8.2), (2.1, 5.6), (1.6, 0.4)] {
            let lines = straight_lines(&edge(angle, offset));
            let [p, q] = lines[0];
            for [x, y] in [p, q] {
                let way = (x - 60.0) * f64::cos(angle) + (y - 45.0) * f64::sin(angle) - offset;
                assert!(way.abs() < 0.1, "angle {angle}: {way} px beside");
            }
            assert!((p[0] - q[0]).hypot(p[1] - q[1]) > 80.0, "angle {angle}");
            assert_eq!(lines.len(), 1, "angle {angle}");
        }
    }

    #[test]
    fn a_circle_is_no_line_and_nothing_has_none() {
        let disc = Image::from_fn(100, 100, |x, y| {
            let way = (x as f32 - 49.5).hypot(y as f32 - 49.5);
            (30.0 - way).clamp(0.0, 1.0)
        });
        // What is left are tangents, along which gradients turn by the tolerance to both sides.
        let longest =
            straight_lines(&disc).first().map_or(0.0, |[p, q]| (p[0] - q[0]).hypot(p[1] - q[1]));
        assert!(longest < 60.0 * TOLERANCE.sin(), "{longest}");
        assert_eq!(straight_lines(&Image::from_fn(50, 50, |_, _| 0.5)).len(), 0);
        assert_eq!(straight_lines(&Image::from_fn(1, 1, |_, _| 0.5)).len(), 0);
    }
}
