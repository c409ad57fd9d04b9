//! What a pixel sees of a texture: the part of it that its square covers, as a mean over texels.
//!
//! The texture coordinates of the pixels beside it tell how the square lies on the surface. The mean is over the bilinear
//! lookups at a grid of points inside it: one point in the middle sees a texture three times as wrong where its pattern is
//! a few pixels fine.

use glam::Vec2;
use rayon::prelude::*;
use unrender_render::GeometryBuffers;
use unrender_scene::Wrap;

/// Points along each side of a pixel. Half of it leaves a wallpaper whose pattern repeats every ten pixels 0.056 off
/// instead of 0.036, a quarter 0.075; double of it was not tried.
const POINTS: usize = 8;
/// A pixel that covers more texels than this sees nothing but their mean, and does not count. At half of it floors end
/// nearer than the horizon; double of it costs memory.
const TEXELS_MAX: usize = 256;
/// A step of the texture coordinates from pixel to pixel that is so many times that on the other side is a seam. Half and
/// double of it were not tried.
const SEAM: f32 = 4.0;

/// A pixel's square in texture coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    centre: Vec2,
    /// One pixel to the right, and one down.
    sides: [Vec2; 2],
}

impl Footprint {
    /// That of the pixel of this `index`.
    pub(super) fn of(geometry: &GeometryBuffers, index: usize) -> Self {
        let (x, width) = (index % geometry.width(), geometry.width());
        let here = geometry.pixels()[index];
        let at = |index: Option<usize>| {
            let there = geometry.pixels().get(index?)?;
            (there.object == here.object).then_some(there.uv)
        };
        let left = (x > 0).then(|| index - 1);
        let right = (x + 1 < width).then_some(index + 1);
        let across = step(here.uv, at(left), at(right));
        let down = step(here.uv, at(index.checked_sub(width)), at(Some(index + width)));
        Self { centre: here.uv, sides: [across, down] }
    }

    /// How far it reaches in u and v.
    pub(super) fn extent(&self) -> Vec2 {
        self.sides[0].abs() + self.sides[1].abs()
    }
}

/// The step of the coordinates from a pixel to the next: the mean of both sides, or the smaller one beside a seam; zero
/// where neither side shows the same object.
fn step(here: Vec2, before: Option<Vec2>, after: Option<Vec2>) -> Vec2 {
    match (before.map(|before| here - before), after.map(|after| after - here)) {
        (Some(a), Some(b)) => {
            let (shorter, longer) = if a.length() < b.length() { (a, b) } else { (b, a) };
            if longer.length() > SEAM * shorter.length() { shorter } else { 0.5 * (a + b) }
        }
        (a, b) => a.or(b).unwrap_or(Vec2::ZERO),
    }
}

/// For each of some pixels, the texels that it sees with their shares. A sparse matrix, row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    starts: Vec<usize>,
    entries: Vec<(u32, f32)>,
}

impl Rows {
    /// Of the `footprints` on a lattice of so many columns and rows, which repeats. Empty where one covers too many texels.
    pub(super) fn of(footprints: &[Footprint], lattice: [usize; 2]) -> Self {
        let rows: Vec<Vec<(u32, f32)>> =
            footprints.par_iter().map(|footprint| row(footprint, lattice)).collect();
        rows.into_iter().collect()
    }

    /// The number of rows.
    pub(super) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// One row.
    pub(super) fn row(&self, i: usize) -> &[(u32, f32)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    /// The same matrix with other columns.
    pub(super) fn renumbered(mut self, numbers: &[u32]) -> Self {
        self.entries.iter_mut().for_each(|(column, _)| *column = numbers[*column as usize]);
        self
    }

    /// Every entry's column.
    pub(super) fn columns(&self) -> impl Iterator<Item = u32> {
        self.entries.iter().map(|(column, _)| *column)
    }

    /// The matrix with rows and columns, of which there are `columns`, exchanged.
    pub(super) fn transposed(&self, columns: usize) -> Self {
        let mut starts = vec![0; columns + 1];
        self.entries.iter().for_each(|(column, _)| starts[*column as usize + 1] += 1);
        (0..columns).for_each(|column| starts[column + 1] += starts[column]);
        let (mut next, mut entries) = (starts.clone(), vec![(0, 0.0); self.entries.len()]);
        for i in 0..self.len() {
            for &(column, share) in self.row(i) {
                let place = &mut next[column as usize];
                entries[*place] = (i as u32, share);
                *place += 1;
            }
        }
        Self { starts, entries }
    }
}

impl FromIterator<Vec<(u32, f32)>> for Rows {
    fn from_iter<I: IntoIterator<Item = Vec<(u32, f32)>>>(rows: I) -> Self {
        let mut all = Self { starts: vec![0], entries: Vec::new() };
        for row in rows {
            all.entries.extend(row);
            all.starts.push(all.entries.len());
        }
        all
    }
}

/// The texels that `footprint` sees, and their shares, which sum to one; none if these are too many.
fn row(footprint: &Footprint, [width, height]: [usize; 2]) -> Vec<(u32, f32)> {
    let scale = Vec2::new(width as f32, height as f32);
    let centre = footprint.centre * scale - 0.5;
    let reach = 0.5 * footprint.extent() * scale;
    let first = (centre - reach).floor();
    let size = (centre + reach).floor() - first + 2.0;
    if !size.is_finite() || size.x * size.y > TEXELS_MAX as f32 {
        return Vec::new();
    }
    let (columns, rows) = (size.x as usize, size.y as usize);
    let mut shares = vec![0.0; columns * rows];
    for point in 0..POINTS * POINTS {
        let along = |i: usize| (i as f32 + 0.5) / POINTS as f32 - 0.5;
        let (x, y) = (along(point % POINTS), along(point / POINTS));
        let offset = x * footprint.sides[0] + y * footprint.sides[1];
        let at = (centre + offset * scale - first).clamp(Vec2::ZERO, size - 1.0);
        let low = at.floor().min(size - 2.0);
        let share = at - low;
        let corner = low.y as usize * columns + low.x as usize;
        let each = 1.0 / (POINTS * POINTS) as f32;
        shares[corner] += each * (1.0 - share.x) * (1.0 - share.y);
        shares[corner + 1] += each * share.x * (1.0 - share.y);
        shares[corner + columns] += each * (1.0 - share.x) * share.y;
        shares[corner + columns + 1] += each * share.x * share.y;
    }
    let texel = |i: usize| {
        let column = Wrap::Repeat.apply(first.x as i64 + (i % columns) as i64, width);
        let row = Wrap::Repeat.apply(first.y as i64 + (i / columns) as i64, height);
        (row * width + column) as u32
    };
    let seen = shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
    seen.map(|(i, share)| (texel(i), *share)).collect()
}

/// Texels along each side of a texture, `density` of them in a pixel of the sharper ones of `footprints`, at most `most`;
/// none without texture coordinates.
pub(super) fn lattice(footprints: &[Footprint], density: f32, most: f32) -> Option<[usize; 2]> {
    /// The sharper pixels are those below this quantile; the trial of the constants of this module had no other.
    const SHARPER: f32 = 0.3;
    let side = |of: fn(Vec2) -> f32| {
        let steps = footprints.iter().map(|footprint| of(footprint.extent()));
        let mut steps: Vec<f32> = steps.filter(|step| *step > 0.0).collect();
        let at = (SHARPER * steps.len() as f32) as usize;
        if steps.is_empty() {
            return None;
        }
        let step = *steps.select_nth_unstable_by(at, f32::total_cmp).1;
        Some((density / step).clamp(2.0, most).round() as usize)
    };
    Some([side(|extent| extent.x)?, side(|extent| extent.y)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_sees_the_mean_of_what_it_covers() {
        // Exactly the texels 2 to 5 by 1 to 2 of a lattice of 8 by 4.
        let sides = [Vec2::new(4.0 / 8.0, 0.0), Vec2::new(0.0, 2.0 / 4.0)];
        let footprint = Footprint { centre: Vec2::new(4.0 / 8.0, 2.0 / 4.0), sides };
        let seen = row(&footprint, [8, 4]);
        let sum: f32 = seen.iter().map(|(_, share)| share).sum();
        assert!((sum - 1.0).abs() < 1e-6);
        let of = |x: usize, y: usize| {
            seen.iter()
                .filter(|(i, _)| *i as usize == 8 * y + x)
                .map(|(_, share)| share)
                .sum::<f32>()
        };
        // Bilinear lookups at its edges see half of a texel beyond.
        assert!((of(3, 1) / of(4, 2) - 1.0).abs() < 1e-5 && (8.0 * of(3, 1) - 0.875).abs() < 0.01);
        assert!(of(1, 1) > 0.0 && of(1, 1) < 0.2 / 8.0 && of(0, 0) == 0.0);
    }

    #[test]
    fn a_texture_goes_on_beyond_its_edge() {
        let footprint = Footprint { centre: Vec2::new(3.0, -2.0), sides: [Vec2::ZERO; 2] };
        let mut seen: Vec<u32> = row(&footprint, [4, 4]).iter().map(|(i, _)| *i).collect();
        seen.sort_unstable();
        assert_eq!(seen, [0, 3, 12, 15]);
    }
}
