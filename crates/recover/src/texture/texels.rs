//! The texels that explain the reflectances of pixels best: weighted least squares over the pixels' footprints, with
//! neighbouring texels alike as far as other pixels confirm it.
//!
//! ```text
//! sum w_i (a_i . x - y_i)^2 + s (l |grad x|^2 + r |x|^2)
//! ```
//!
//! with the rows `a_i` of [`super::footprint`] and the mean weight `s` of a texel, by conjugate gradients
//! [Hestenes and Stiefel 1952] preconditioned with the diagonal. A texel that repeats is seen by many pixels, and is known better than any of them shows it.

use super::footprint::Rows;
use glam::DVec3;
use rayon::prelude::*;
use unrender_scene::Rgb;

/// Steps of the conjugate gradients at most, and the residual, relative, at which they end. At half as many smooth parts
/// of large textures are not settled; double of it, or a tenth of the residual, changes the third digit.
const STEPS: usize = 200;
const SETTLED: f64 = 1e-4;
/// Rounds in which texels are put on their bounds. One leaves a wallpaper 1 % too dark, more change nothing.
const BOUNDED: usize = 4;
/// Rows of a parallel task.
const TASK: usize = 512;

/// The texels that some pixel sees, and how.
pub(super) struct Texels {
    rows: Rows,
    columns: Rows,
    /// The four texels beside each; `u32::MAX` where no pixel sees one.
    beside: Vec<[u32; 4]>,
    /// The number of each in the lattice.
    pub(super) places: Vec<u32>,
}

/// How much alike neighbouring texels are asked to be, and how small; in units of a texel's mean weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) alike: f32,
    pub(super) small: f32,
}

impl Texels {
    /// Those of a lattice of so many columns and rows that `rows` see.
    pub(super) fn new(rows: Rows, [width, height]: [usize; 2]) -> Self {
        let mut numbers = vec![u32::MAX; width * height];
        rows.columns().for_each(|texel| numbers[texel as usize] = 0);
        let mut places = Vec::new();
        for (texel, number) in numbers.iter_mut().enumerate().filter(|(_, seen)| **seen == 0) {
            *number = places.len() as u32;
            places.push(texel as u32);
        }
        let beside = |texel: &u32| {
            let (x, y) = (*texel as usize % width, *texel as usize / width);
            let (left, right) = ((x + width - 1) % width, (x + 1) % width);
            let (up, down) = ((y + height - 1) % height, (y + 1) % height);
            [(left, y), (right, y), (x, up), (x, down)].map(|(x, y)| numbers[y * width + x])
        };
        let beside = places.iter().map(beside).collect();
        let rows = rows.renumbered(&numbers);
        let columns = rows.transposed(places.len());
        Self { rows, columns, beside, places }
    }

    /// What each pixel sees of `texels`.
    pub(super) fn seen(&self, texels: &[Rgb]) -> Vec<Rgb> {
        let row = |i: usize| {
            self.rows.row(i).iter().map(|(texel, share)| *share * texels[*texel as usize]).sum()
        };
        (0..self.rows.len()).into_par_iter().with_min_len(TASK).map(row).collect()
    }

    /// What arrives at each texel of `values` of the pixels.
    fn collected(&self, values: &[Rgb]) -> Vec<Rgb> {
        let column = |i: usize| {
            self.columns.row(i).iter().map(|(row, share)| *share * values[*row as usize]).sum()
        };
        (0..self.places.len()).into_par_iter().with_min_len(TASK).map(column).collect()
    }

    /// The same with every texel from zero to one: those that would leave that stay at the bound, and the others are solved
    /// again. Cutting them off instead makes bright textures too dark.
    pub(super) fn solve_bounded(
        &self,
        values: &[Rgb],
        weights: &[f32],
        prior: Prior,
        start: &[Rgb],
    ) -> Vec<Rgb> {
        let mut free = vec![Rgb::ONE; start.len()];
        let mut now = start.to_vec();
        for _ in 0..BOUNDED {
            now = self.solve_free(values, weights, prior, &now, &free);
            let mut is_inside = true;
            for (value, free) in now.iter_mut().zip(&mut free) {
                let bounded = value.clamp(Rgb::ZERO, Rgb::ONE);
                *free = Rgb::select(bounded.cmpeq(*value), *free, Rgb::ZERO);
                is_inside &= bounded == *value;
                *value = bounded;
            }
            if is_inside {
                break;
            }
        }
        now
    }

    /// The texels that explain `values` with these `weights`, from `start`.
    pub(super) fn solve(
        &self,
        values: &[Rgb],
        weights: &[f32],
        prior: Prior,
        start: &[Rgb],
    ) -> Vec<Rgb> {
        self.solve_free(values, weights, prior, start, &vec![Rgb::ONE; start.len()])
    }

    /// The same where the numbers that are not `free`, which is one or zero, stay as they are.
    fn solve_free(
        &self,
        values: &[Rgb],
        weights: &[f32],
        prior: Prior,
        start: &[Rgb],
        free: &[Rgb],
    ) -> Vec<Rgb> {
        let weighted: Vec<Rgb> = values.iter().zip(weights).map(|(v, w)| *w * *v).collect();
        let target = self.collected(&weighted);
        let mut diagonal: Vec<f32> = (0..self.places.len())
            .map(|i| {
                self.columns.row(i).iter().map(|(row, a)| a * a * weights[*row as usize]).sum()
            })
            .collect();
        let all: f32 = weights.iter().sum();
        let unit = (all / self.places.len().max(1) as f32).max(f32::MIN_POSITIVE);
        let (alike, small) = (unit * prior.alike, unit * prior.small.max(1e-6));
        for (value, beside) in diagonal.iter_mut().zip(&self.beside) {
            let neighbours = beside.iter().filter(|beside| **beside != u32::MAX).count();
            *value += small + alike * neighbours as f32;
        }
        let apply = |x: &[Rgb]| -> Vec<Rgb> {
            let mut seen = self.seen(x);
            seen.iter_mut().zip(weights).for_each(|(value, weight)| *value *= *weight);
            let mut sums = self.collected(&seen);
            for (i, sum) in sums.iter_mut().enumerate() {
                let beside = self.beside[i].iter().filter(|beside| **beside != u32::MAX);
                let differences: Rgb = beside.map(|beside| x[i] - x[*beside as usize]).sum();
                *sum += small * x[i] + alike * differences;
            }
            sums
        };
        conjugate_gradients(apply, (&diagonal, free), &target, start.to_vec())
    }
}

/// Solves `apply(x) = target` channel by channel, from `x`, for the numbers that are free.
fn conjugate_gradients(
    apply: impl Fn(&[Rgb]) -> Vec<Rgb>,
    (diagonal, free): (&[f32], &[Rgb]),
    target: &[Rgb],
    mut x: Vec<Rgb>,
) -> Vec<Rgb> {
    let dot = |a: &[Rgb], b: &[Rgb]| -> DVec3 {
        a.iter().zip(b).map(|(a, b)| (*a * *b).as_dvec3()).sum()
    };
    let quotient = |a: DVec3, b: DVec3| DVec3::select(b.cmpgt(DVec3::ZERO), a / b, DVec3::ZERO);
    let scaled = |r: &[Rgb]| -> Vec<Rgb> {
        r.iter().zip(diagonal).zip(free).map(|((r, d), free)| *free * *r / *d).collect()
    };
    let mut residual = apply(&x);
    residual.iter_mut().zip(target).for_each(|(r, t)| *r = *t - *r);
    let mut ahead = scaled(&residual);
    let mut direction = ahead.clone();
    let mut power = dot(&residual, &ahead);
    let enough = SETTLED * SETTLED * dot(target, &scaled(target));
    for _ in 0..STEPS {
        if power.cmple(enough).all() {
            break;
        }
        let applied = apply(&direction);
        let step = quotient(power, dot(&direction, &applied)).as_vec3();
        for i in 0..x.len() {
            x[i] += step * direction[i];
            residual[i] -= step * applied[i];
        }
        ahead = scaled(&residual);
        let next = dot(&residual, &ahead);
        let keep = quotient(next, power).as_vec3();
        direction.iter_mut().zip(&ahead).for_each(|(d, a)| *d = *a + keep * *d);
        power = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::sampler::mix;

    #[test]
    fn texels_that_repeat_are_known_better_than_pixels_show_them() {
        // 40 pixels for each of 64 texels, half of which lies in the next one, with noise of 10 %.
        let n = 64;
        let truth = |i: usize| Rgb::splat(if (i / 8).is_multiple_of(2) { 0.8 } else { 0.3 });
        let row = |i: usize| {
            let texel = i % n;
            vec![(texel as u32, 0.5), (((texel + 1) % n) as u32, 0.5)]
        };
        let count = 40 * n;
        let texels = Texels::new((0..count).map(row).collect(), [n, 1]);
        let noise = |i: usize| {
            let unit = |k: u64| (mix(7 + k * 0x1000 + i as u64) >> 40) as f32 / (1 << 24) as f32;
            (0..12).map(unit).sum::<f32>() - 6.0
        };
        let seen = |i: usize| 0.5 * (truth(i % n) + truth((i + 1) % n));
        let values: Vec<Rgb> = (0..count).map(|i| seen(i) * (1.0 + 0.1 * noise(i))).collect();
        let prior = Prior { alike: 0.003, small: 0.0 };
        let found = texels.solve(&values, &vec![1.0; count], prior, &vec![Rgb::splat(0.5); n]);
        let error = |i: usize| (found[i].x - truth(i).x).powi(2);
        let rms = ((0..n).map(error).sum::<f32>() / n as f32).sqrt();
        assert!(rms < 0.06, "{rms}");
        let again = texels.seen(&found);
        let off = (0..n).map(|i| (again[i].x - seen(i).x).powi(2)).sum::<f32>() / n as f32;
        assert!(off.sqrt() < 0.012, "{}", off.sqrt());
    }
}
