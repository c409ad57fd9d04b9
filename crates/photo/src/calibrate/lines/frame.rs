//! Three perpendicular directions among straight lines [Coughlan and Yuille 2003], and which line is along which.
//!
//! Four random lines, two of each of two directions, give a camera ([`super::start`]). The one under which the most
//! length of line is along an axis is taken, and refined with the lines that are.

use super::segment::Segment;
use super::start::starts;
use crate::calibrate::model::{Free, Model, Observed};
use crate::calibrate::refine::{FINAL, refine};
use crate::calibrate::robust::{Random, distance};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// Lines are along an axis if their ends are off by less than this, as a share of the picture's diagonal: 1.4 pixels of
/// 1000 x 1000. At half of it a bent lens loses lines, at double slanting things are taken for upright ones.
const NEAR: f64 = 1e-3;
/// The longest lines, from which the random ones are drawn: half of those of a picture are along an axis, and each
/// needs two others. At half and double the same cameras come out.
const DRAWN_FROM: usize = 80;
/// How many times four are drawn. A share of 15 % of the lines along each of two axes gives one good four in 500. At
/// half of it cluttered photographs fail now and then.
const DRAWS: usize = 6000;
/// The best cameras, which are refined.
const FOLLOWED: usize = 12;
/// How often the lines are sorted to the axes and the camera is refined.
const ROUNDS: usize = 6;

/// How far from upright photographs are held, radians: seven degrees, a standard deviation. At half of it askew ones are
/// lost, at double slanting shadows are taken for what is level.
const ROLL: f64 = 0.12;
/// A direction is found if so many as good ones are expected among lines at random. At half and double the same ones
/// are: four lines more make a factor of a thousand.
const EXPECTED_BY_CHANCE: f64 = 0.01;

/// Which focal lengths are possible, pixels.
pub(super) struct Focals {
    /// Those to try if they are known, else none.
    pub(super) known: Vec<f64>,
    /// The range of the others.
    pub(super) range: std::ops::Range<f64>,
}

/// The axis that each line is along, if it is, with axes named as the picture shows them: y is the most upright
/// one, and the camera looks along z rather than x. None if no two directions are found.
pub(super) fn axes(
    lines: &[[Vector2<f64>; 2]],
    free: Free,
    focals: &Focals,
    size: (f64, f64),
    seed: u64,
) -> Option<Vec<Option<usize>>> {
    let near = NEAR * size.0.hypot(size.1);
    let mut random = Random::new(seed);
    let mut found: Vec<(f64, Model)> = Vec::new();
    let several = lines.len().min(DRAWN_FROM);
    if several < 4 {
        return None;
    }
    for _ in 0..DRAWS {
        let four = [0, 0, 1, 1].map(|axis| Segment { ends: lines[random.below(several)], axis });
        let is_known = !focals.known.is_empty();
        let cameras = starts(&four, &focals.known, is_known, size.0.max(size.1));
        let possible = |model: &&Model| focals.range.contains(&model.ln_focal.exp());
        if let Some(model) = cameras.iter().find(possible) {
            found.push((agreement(model, lines, near), *model));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(FOLLOWED);
    let refined = found.into_iter().map(|(_, model)| {
        let model = settled(&model, lines, free, near);
        (agreement(&model, lines, near), model)
    });
    let (_, best) = refined.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let sorted: Vec<Option<usize>> =
        lines.iter().map(|ends| along(&best, *ends, near).map(|segment| segment.axis)).collect();
    let is_found =
        [0, 1, 2].map(|axis| expected_by_chance(lines, &sorted, axis, near) < EXPECTED_BY_CHANCE);
    let names = names(&best);
    let found = sorted.into_iter().map(|axis| axis.filter(|axis| is_found[*axis]));
    Some(found.map(|axis| axis.map(|axis| names[axis])).collect())
}

/// How many directions with as many lines are expected if the lines that are along no other axis had random directions
/// [Desolneux et al. 2000]: every two of them have a vanishing point, and another line passes it as closely with the
/// probability `p`; the tail of the binomial distribution times the number of such points.
fn expected_by_chance(
    lines: &[[Vector2<f64>; 2]],
    sorted: &[Option<usize>],
    axis: usize,
    near: f64,
) -> f64 {
    let mine = lines.iter().zip(sorted).filter(|(_, of)| of.is_none_or(|of| of == axis));
    let (mut count, mut along, mut chance) = (0_usize, 0_usize, 0.0);
    for (ends, of) in mine {
        count += 1;
        along += usize::from(of.is_some());
        // Both ends are off by at most `near` together.
        let half_turn = (2.0_f64.sqrt() * near / (ends[1] - ends[0]).norm()).min(1.0).asin();
        chance += 2.0 * half_turn / PI;
    }
    if along < 3 {
        return f64::INFINITY;
    }
    let p = chance / count as f64;
    let points = (count * (count - 1) / 2) as f64;
    points * tail(count - 2, along - 2, p)
}

/// The probability of at least `k` of `n` events of probability `p` each.
fn tail(n: usize, k: usize, p: f64) -> f64 {
    let mut term = (1.0 - p).powi(n as i32);
    let mut below = 0.0;
    for i in 0..k {
        below += term;
        term *= (n - i) as f64 / (i + 1) as f64 * p / (1.0 - p);
    }
    // Far in the tail the difference is rounded away, but not the sum.
    let mut above = 0.0;
    for i in k..=n {
        above += term;
        term *= (n - i) as f64 / (i + 1) as f64 * p / (1.0 - p);
    }
    if below < 0.5 { 1.0 - below } else { above }
}

/// The line as one along the axis that it is nearest to, if it is along any.
fn along(model: &Model, ends: [Vector2<f64>; 2], near: f64) -> Option<Segment> {
    let each = [0, 1, 2].map(|axis| Segment { ends, axis });
    let of = |segment: &Segment| distance(model, segment);
    each.into_iter().min_by(|a, b| of(a).total_cmp(&of(b))).filter(|segment| of(segment) < near)
}

/// The length of line along any axis, less where it is nearly not, pixels.
fn agreement(model: &Model, lines: &[[Vector2<f64>; 2]], near: f64) -> f64 {
    let one = |ends: &[Vector2<f64>; 2]| {
        let segment = along(model, *ends, near)?;
        let off = segment.residual(model).x / near;
        Some((ends[1] - ends[0]).norm() * (1.0 - off * off))
    };
    let all: f64 = lines.iter().filter_map(one).sum();
    all * (-0.5 * (roll(model) / ROLL).powi(2)).exp()
}

/// The angle in the picture by which the most upright axis is not, radians.
fn roll(model: &Model) -> f64 {
    let axes = model.camera_from_world;
    let upright = names(model).iter().position(|name| *name == 1).unwrap_or(1);
    // What points towards or away from the camera has no direction in the picture; seen from the side, it has.
    axes[(0, upright)].atan2(axes[(1, upright)].abs())
}

/// The camera after lines and camera have been fitted to each other in turn.
fn settled(model: &Model, lines: &[[Vector2<f64>; 2]], free: Free, near: f64) -> Model {
    let mut now = *model;
    for _ in 0..ROUNDS {
        let chosen: Vec<Segment> =
            lines.iter().filter_map(|ends| along(&now, *ends, near)).collect();
        if !Segment::suffice(&chosen, free) {
            break;
        }
        now = refine(&now, &chosen, free, FINAL);
    }
    now
}

/// What the axes of `model` are called: 0, 1 or 2 for x, y or z.
fn names(model: &Model) -> [usize; 3] {
    let axes = model.camera_from_world;
    let most = |row: usize, of: &[usize]| {
        let size = |axis: &&usize| axes[(row, **axis)].abs();
        of.iter().max_by(|a, b| size(a).total_cmp(&size(b))).copied().unwrap_or(0)
    };
    let upright = most(1, &[0, 1, 2]);
    let others: Vec<usize> = (0..3).filter(|axis| *axis != upright).collect();
    let ahead = most(2, &others);
    [0, 1, 2].map(|axis| match axis {
        _ if axis == upright => 1,
        _ if axis == ahead => 2,
        _ => 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_binomial_distribution() {
        // 1 - (1 - p)^n, and p^n.
        assert!((tail(10, 1, 0.1) - (1.0 - 0.9_f64.powi(10))).abs() < 1e-12);
        assert!((tail(10, 10, 0.1) / 1e-10 - 1.0).abs() < 1e-9);
        assert!((tail(4, 2, 0.5) - 11.0 / 16.0).abs() < 1e-12);
    }
}
