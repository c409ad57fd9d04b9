//! The normal equations of one pass.
//!
//! With the residuals `r = B - L` and Jacobians `J` of two renderings with independent noise:
//! `H = sum w sym(J_A^T J_B)` and `g = sum w (J_A^T r_B + J_B^T r_A) / 2`: the noise of a rendering
//! is never multiplied by itself, so it biases neither. The weight `w` is the inverse variance of a
//! cell's residual under the observation model ([`crate::observe::model_error`]): the photograph's noise,
//! and, measured on all cells of its group, the rendering's noise and the model error, at the
//! brightness of the model around the cell.
//!
//! `g` is a sum over cells. Its covariance comes from their spread, whatever the noise is and however it is correlated
//! within a cell: `G = sum g_b g_b^T` [Huber 1967; White 1982]. The fit makes residuals smaller than the noise, most
//! where a cell has the leverage `h_b = w J_b H^-1 J_b^T`, as the few cells of a highlight have: the residuals of `g_b`
//! are divided by `1 - h_b`, about what they would be if the cell had been left out of the fit [MacKinnon and White
//! 1985, HC3]. What is wrong with a whole group alike does not spread over its cells: in each photograph a group's light
//! may be wrong by a share of its own.

use super::means::Mean;
use super::unknowns::Unknowns;
use crate::compare::share_by;
use crate::observe::blocks::{Place, neighbours};
use crate::observe::same_place::{self, Seen};
use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use unrender_scene::Rgb;

/// The normal equations and how good the fit was where they were taken.
pub(crate) struct Normal {
    /// The curvature of half the weighted squared error.
    pub(crate) h: DMatrix<f64>,
    /// The negative of its gradient: where to go.
    pub(crate) g: DVector<f64>,
    /// The covariance of `g` if all cells were independent.
    pub(crate) g_covariance: DMatrix<f64>,
    /// The covariance of `g` with the correlation of neighbours, and the error of each group's whole light.
    pub(crate) g_dependent: DMatrix<f64>,
    /// The part of it due to the renderings' noise.
    pub(crate) g_rendering: DMatrix<f64>,
    /// The standard deviation, by the spread over the cells, of that part of each unknown's variance that is not due to
    /// the renderings' noise.
    pub(crate) doubt: DVector<f64>,
    /// The weight of each cell's residuals.
    pub(crate) weights: Vec<Rgb>,
    /// How much of each group's derivatives by each unknown is signal.
    shrinkage: DMatrix<f64>,
    /// For each group: the variance of its renderings, relative to the local radiance, times pixels and paths.
    rendering: Vec<Rgb>,
}

/// Residuals of more standard deviations than this pull as if they were of so many: a few cells
/// that the model does not describe do not dominate the rest [Huber 1964].
const HUBER: f32 = 6.0;
/// No model of a scene is better than this, relatively and squared.
const RESIDUAL_MIN: f32 = 1e-6;
/// A cell counts at most this many times the median when the noise of a group is measured: one
/// firefly is not the group's noise.
const OUTLIER: f32 = 30.0;

/// The standard deviation of a group's light as a whole in one photograph, as a share of it: two renderers' pictures of
/// the same materials differ by 0.1 to 0.4 % of a group's mean. Without it 89 % of the numbers of 14 drafted rooms lie
/// within two of their standard deviations; with two thirds of it, it, and five thirds of it 92, 92.5 and 93 %, each
/// number's own share being added afterwards. Half and double were not tried.
const LEVEL: f64 = 0.003;

/// Leverages above this count as this when a cell's residual is corrected for the fit: derivatives are noisy, and with
/// them the leverages near one.
const LEVERAGE_MAX: f64 = 0.9;

impl Normal {
    /// The equations for `unknowns` of a scene with `groups` groups.
    pub(crate) fn of(means: &[Mean], unknowns: &Unknowns, groups: usize) -> Self {
        let n = unknowns.len();
        let noise: Vec<Unexplained> =
            (0..groups).map(|group| Unexplained::of(means, group)).collect();
        let shrinkage = shrinkage(means, n, groups);
        let are_specular = unknowns.are_specular();
        let specular = Highlights::of(means, &are_specular, groups);
        let mut normal = Self {
            h: DMatrix::zeros(n, n),
            g: DVector::zeros(n),
            g_covariance: DMatrix::zeros(n, n),
            g_dependent: DMatrix::zeros(n, n),
            g_rendering: DMatrix::zeros(n, n),
            doubt: DVector::zeros(n),
            weights: Vec::with_capacity(means.len()),
            shrinkage,
            rendering: noise.iter().map(|noise| noise.rendering).collect(),
        };
        for mean in means {
            let variance = noise[mean.group].variance(mean);
            let [a, b] = mean.residuals;
            let robust = if specular.may_be_highlight(mean) {
                1.0
            } else {
                let deviations = (0.5 * (a + b)).abs() / variance.map(f32::sqrt);
                (HUBER / deviations.max_element()).min(1.0)
            };
            let weight = robust * variance.recip();
            let shrink = |k: usize| normal.shrinkage[(mean.group, k)];
            let rows = mean.rows.iter().enumerate();
            rows.for_each(|(c, row)| add_row(&mut normal.h, row, shrink, f64::from(weight[c])));
            normal.g += gradient(mean, weight, &normal.shrinkage, |_, residual| residual);
            normal.weights.push(weight);
        }
        normal.h.fill_upper_triangle_with_lower_triangle();
        normal.add_covariances(means, &unknowns.deviations);
        normal
    }

    /// The covariances of `g`, with the standard deviations of the prior.
    fn add_covariances(&mut self, means: &[Mean], prior: &[f64]) {
        let shrinkage = &self.shrinkage;
        let n = self.g.len();
        let known = DVector::from_iterator(n, prior.iter().map(|std| std.powi(-2)));
        let h = &self.h + DMatrix::from_diagonal(&known);
        let inverse = h.cholesky().map_or(DMatrix::zeros(n, n), |factors| factors.inverse());
        let dependence = dependence(means, &self.weights);
        let mut levels: BTreeMap<(usize, usize), DVector<f64>> = BTreeMap::new();
        for (mean, weight) in means.iter().zip(&self.weights) {
            let shrink = |k: usize| shrinkage[(mean.group, k)];
            let left = |channel: usize, [a, b]: [f64; 2]| {
                let weight = f64::from(weight[channel]);
                let leverage = weight * leverage(&mean.rows[channel], shrink, &inverse);
                let raised = (1.0 - leverage.clamp(0.0, LEVERAGE_MAX)).recip();
                [raised * a, raised * b]
            };
            // The difference of the two has the noise of their mean and nothing else.
            let noise = |_, [a, b]: [f64; 2]| [0.5 * (a - b); 2];
            let g = gradient(mean, *weight, shrinkage, left);
            let g_rendering = gradient(mean, *weight, shrinkage, noise);
            let level = |channel, _| [f64::from(mean.light[channel]); 2];
            let of_group = levels.entry((mean.group, mean.place.photograph));
            *of_group.or_insert_with(|| DVector::zeros(n)) +=
                gradient(mean, *weight, shrinkage, level);
            let (all, rendering) = (&inverse * &g, &inverse * &g_rendering);
            let other = all.component_mul(&all) - rendering.component_mul(&rendering);
            self.doubt += other.component_mul(&other);
            self.g_covariance.syger(1.0, &g, &g, 1.0);
            self.g_dependent.syger(dependence[&mean.group], &g, &g, 1.0);
            self.g_rendering.syger(1.0, &g_rendering, &g_rendering, 1.0);
        }
        for level in levels.values() {
            self.g_dependent.syger(LEVEL * LEVEL, level, level, 1.0);
        }
        self.doubt.apply(|square| *square = square.sqrt());
        self.g_covariance.fill_upper_triangle_with_lower_triangle();
        self.g_dependent.fill_upper_triangle_with_lower_triangle();
        self.g_rendering.fill_upper_triangle_with_lower_triangle();
    }

    /// The variance that the renderings of the cell number `index` would give each unknown with one path, by its
    /// derivatives and its group's noise; `inverse` is the inverse of the curvature. The difference of the cell's own
    /// renderings says little: it is one draw.
    pub(crate) fn variance_of_path(
        &self,
        (index, mean): (usize, &Mean),
        inverse: &DMatrix<f64>,
    ) -> DVector<f64> {
        let mut variance = DVector::zeros(self.g.len());
        for channel in 0..3 {
            let weight = f64::from(self.weights[index][channel]);
            let mut derivative = DVector::zeros(self.g.len());
            for &(k, a, b) in &mean.rows[channel] {
                derivative[k] += 0.5 * weight * self.shrinkage[(mean.group, k)] * (a + b);
            }
            let by = inverse * derivative;
            let noise = self.rendering[mean.group][channel] * mean.level2[channel];
            variance += f64::from(noise) * by.component_mul(&by);
        }
        variance
    }
}

/// Adds one cell in one channel to the lower triangle of `h`.
fn add_row(
    h: &mut DMatrix<f64>,
    row: &[(usize, f64, f64)],
    shrink: impl Fn(usize) -> f64,
    weight: f64,
) {
    for (k, &(i, ai, bi)) in row.iter().enumerate() {
        for &(j, aj, bj) in &row[..=k] {
            let (low, high) = (i.max(j), i.min(j));
            let shrinkage = (shrink(i) * shrink(j)).sqrt();
            h[(low, high)] += 0.5 * weight * shrinkage * (ai * bj + bi * aj);
        }
    }
}

/// For each group: how many cells count as one independent cell, by the correlation of neighbours' residuals, and of
/// those of the same place in several photographs.
fn dependence(means: &[Mean], weights: &[Rgb]) -> BTreeMap<usize, f64> {
    let mut cells: BTreeMap<usize, Vec<(Seen, DVec3)>> = BTreeMap::new();
    for (mean, weight) in means.iter().zip(weights) {
        let of_group = cells.entry(mean.group).or_default();
        if !mean.bound {
            let [a, b] = mean.residuals;
            let residual = (0.5 * (a + b) * weight.map(f32::sqrt)).as_dvec3();
            of_group.push((Seen { place: mean.place, point: mean.point }, residual));
        }
    }
    let of_group = |(group, cells): (usize, Vec<(Seen, DVec3)>)| {
        let (seen, residuals): (Vec<Seen>, Vec<DVec3>) = cells.into_iter().unzip();
        let places: Vec<Place> = seen.iter().map(|seen| seen.place).collect();
        let pairs = [neighbours(&places), same_place::pairs(&seen)];
        (group, share_by(pairs.each_ref().map(Vec::as_slice), &residuals).recip())
    };
    cells.into_iter().map(of_group).collect()
}

/// What one cell adds to `g`, with the residuals that `of` makes of the cell's in each channel.
fn gradient(
    mean: &Mean,
    weight: Rgb,
    shrinkage: &DMatrix<f64>,
    of: impl Fn(usize, [f64; 2]) -> [f64; 2],
) -> DVector<f64> {
    let mut g = DVector::zeros(shrinkage.ncols());
    for (channel, row) in mean.rows.iter().enumerate() {
        let [ra, rb] = of(channel, mean.residuals.map(|residual| f64::from(residual[channel])));
        let weight = f64::from(weight[channel]);
        for &(i, a, b) in row {
            g[i] += 0.5 * weight * shrinkage[(mean.group, i)] * (a * rb + b * ra);
        }
    }
    g
}

/// The leverage of a row over its weight: `J H^-1 J^T`.
fn leverage(
    row: &[(usize, f64, f64)],
    shrink: impl Fn(usize) -> f64,
    inverse: &DMatrix<f64>,
) -> f64 {
    let of_row = |&(i, ai, _): &(usize, f64, f64)| {
        let with =
            |&(j, _, bj): &(usize, f64, f64)| (shrink(i) * shrink(j)).sqrt() * inverse[(i, j)] * bj;
        ai * row.iter().map(with).sum::<f64>()
    };
    row.iter().map(of_row).sum()
}

/// For each group and unknown: how much of the group's derivatives by the unknown is signal.
///
/// `S / (S + N)`, with `S` the power that both renderings see and `N` that of their difference. What
/// is mostly noise says little about the unknown but would put its noise into the equations. The
/// scaled rows are instruments `z = S J`: the estimating equation is `sum z r = 0`, whose derivative
/// `sum z J` has the factor once, like `g`, so that steps and covariance are those of the unknowns
/// themselves. Off its diagonal the derivative is taken as `sqrt(S_i S_j) J_i J_j`, which keeps it
/// positive semidefinite.
fn shrinkage(means: &[Mean], n: usize, groups: usize) -> DMatrix<f64> {
    let mut signal = DMatrix::<f64>::zeros(groups, n);
    let mut noise = DMatrix::<f64>::zeros(groups, n);
    for mean in means {
        for channel in 0..3 {
            let weight = mean.pixels / f64::from(mean.level2[channel]);
            for &(k, a, b) in &mean.rows[channel] {
                signal[(mean.group, k)] += weight * a * b;
                noise[(mean.group, k)] += weight * 0.25 * (a - b).powi(2);
            }
        }
    }
    signal.zip_map(&noise, |s, n| if s > 0.0 { s / (s + n) } else { 0.0 })
}

/// Where a highlight may be: the greatest specular term of each group.
struct Highlights<'a> {
    is_specular: &'a [bool],
    greatest: Vec<f64>,
}

/// A cell may show a highlight if its specular term is this share of the greatest of its group. At
/// half of it more of what the model lacks pulls with full force, at double the feet of highlights
/// are cut.
const HIGHLIGHT: f64 = 0.1;

impl<'a> Highlights<'a> {
    fn of(means: &[Mean], is_specular: &'a [bool], groups: usize) -> Self {
        let mut all = Self { is_specular, greatest: vec![0.0; groups] };
        for mean in means {
            all.greatest[mean.group] = all.greatest[mean.group].max(all.term(mean));
        }
        all
    }

    /// The mean derivative by the group's specular reflectance.
    fn term(&self, mean: &Mean) -> f64 {
        let of_row = |row: &Vec<(usize, f64, f64)>| {
            let specular = row.iter().filter(|(k, ..)| self.is_specular[*k]);
            specular.map(|(_, a, b)| 0.5 * (a + b)).fold(0.0, f64::max)
        };
        mean.rows.iter().map(of_row).fold(0.0, f64::max)
    }

    /// Whether the photograph is brighter than the model where the group may show a highlight.
    fn may_be_highlight(&self, mean: &Mean) -> bool {
        let brighter = (mean.residuals[0] + mean.residuals[1]).element_sum() > 0.0;
        let greatest = self.greatest[mean.group];
        brighter && greatest > 0.0 && self.term(mean) >= HIGHLIGHT * greatest
    }
}

/// What is not the photograph's noise in the residuals of a group, relative to the local radiance.
struct Unexplained {
    /// Variance of the mean of both renderings, times the pixels of a cell and the paths of each.
    rendering: Rgb,
    /// Variance of what the model does not explain.
    residual: Rgb,
}

impl Unexplained {
    fn of(means: &[Mean], group: usize) -> Self {
        let of_group = || means.iter().filter(move |m| m.group == group && !m.bound);
        let rendering = |m: &Mean| {
            let [a, b] = m.residuals;
            0.25 * (a - b) * (a - b) / m.level2 * (m.pixels * m.paths) as f32
        };
        let rendering = clipped_mean(of_group().map(rendering));
        let residual = |m: &Mean| {
            let mean = 0.5 * (m.residuals[0] + m.residuals[1]);
            (mean * mean - m.variance) / m.level2 - rendering / (m.pixels * m.paths) as f32
        };
        let residual = clipped_mean(of_group().map(residual)).max(Rgb::splat(RESIDUAL_MIN));
        Self { rendering, residual }
    }

    /// The variance of a cell's mean residual.
    fn variance(&self, mean: &Mean) -> Rgb {
        let relative = self.residual + self.rendering / (mean.pixels * mean.paths) as f32;
        (mean.variance + relative * mean.level2).max(Rgb::splat(f32::MIN_POSITIVE))
    }
}

/// The mean with values beyond [`OUTLIER`] medians (of their sizes) cut down to that, by channel.
fn clipped_mean(values: impl Iterator<Item = Rgb>) -> Rgb {
    let values: Vec<Rgb> = values.collect();
    let channel = |c: usize| {
        let mut sizes: Vec<f32> = values.iter().map(|v| v[c].abs()).collect();
        let middle = sizes.len() / 2;
        if sizes.is_empty() {
            return 0.0;
        }
        let most = OUTLIER * *sizes.select_nth_unstable_by(middle, f32::total_cmp).1;
        let sum: f64 = values.iter().map(|v| f64::from(v[c].max(-most).min(most))).sum();
        (sum / values.len() as f64) as f32
    };
    Rgb::new(channel(0), channel(1), channel(2))
}
